/* POSITION.json. */
#include <stdbool.h>

#include "halflight/position.h"
#include "json_notes.h"
#include "json_write.h"

static const double degrees = 57.29577951308232;

static json_t *sight_list(const hl_position *p, const char *const *names)
{
  json_t *list = json_array();
  for (int i = 0; i < p->n; i++) {
    const hl_sight_fit *g = &p->sight[i];
    json_t *one = json_pack("{s:s,s:b,s:f,s:f}", "name", names[i], "used", (int)g->used, "off_deg",
                            degrees * g->off_rad, "chi_squared", g->chi_squared);
    if (json_array_append_new(list, one) != 0) {
      json_decref(list);
      return NULL;
    }
  }
  return list;
}

hl_status hl_position_json(hl_ctx *ctx, const hl_position *p, const char *const *names, char **out)
{
  const bool found = p->found;
  json_t *d = json_object();
  const bool good =
      d && hl_json_set(d, "format", json_string("halflight-position")) &&
      hl_json_set(d, "version", json_integer(1)) &&
      hl_json_set(d, "status", json_string(found && p->trusted ? "ok" : "untrusted")) &&
      hl_json_set(d, "reasons", hl_json_reasons(&p->reasons)) &&
      hl_json_set(d, "position_m", found ? hl_json_reals(p->position_m, 3) : json_null()) &&
      hl_json_set(d, "covariance_m2",
                  found ? hl_json_rows(p->covariance_m2[0], 3, 3, 3) : json_null()) &&
      hl_json_set(d, "from_m", hl_json_reals(p->from_m, 3)) &&
      hl_json_set(d, "direction", hl_json_reals(p->direction, 3)) &&
      hl_json_set(d, "distance_m", hl_json_real(p->distance_m)) &&
      hl_json_set(d, "distance_95_m",
                  json_pack("[o,o]", hl_json_real(p->distance_95_m[0]),
                            hl_json_real(p->distance_95_m[1]))) &&
      hl_json_set(d, "least_distance_m", hl_json_real(p->least_distance_m)) &&
      hl_json_set(d, "chi_squared", hl_json_real(p->chi_squared)) &&
      hl_json_set(d, "degrees_of_freedom", json_integer(p->dof)) &&
      hl_json_set(d, "probability", hl_json_real(p->probability)) &&
      hl_json_set(d, "sights", sight_list(p, names)) &&
      hl_json_set(d, "left_out", hl_json_notes(&p->left_out));
  if (!good) {
    json_decref(d);
    d = NULL;
  }
  return hl_json_text(ctx, d, out);
}
