/* What `drift --json` prints. */
#include <stdbool.h>

#include "halflight/drift.h"
#include "json_notes.h"
#include "json_write.h"

static json_t *cause_of(const hl_drift_cause *c)
{
  json_t *out = json_pack("{s:s,s:s,s:b,s:o,s:o,s:s,s:o}", "what", c->what, "part", c->part,
                          "moved", (int)c->moved, "figure", hl_json_real(c->figure), "threshold",
                          hl_json_real(c->threshold), "unit", c->unit, "significance",
                          hl_json_real(c->significance));
  if (out && (c->n == 0 || (hl_json_set(out, "change", hl_json_reals(c->change, c->n)) &&
                            hl_json_set(out, "deviation", hl_json_reals(c->sigma, c->n)))))
    return out;
  json_decref(out);
  return NULL;
}

static json_t *causes_of(const hl_drift *d)
{
  json_t *list = json_array();
  for (int i = 0; i < d->n_causes; i++)
    if (json_array_append_new(list, cause_of(&d->cause[i])) != 0) {
      json_decref(list);
      return NULL;
    }
  return list;
}

hl_status hl_drift_json(hl_ctx *ctx, const hl_drift *drift, char **out)
{
  json_t *root = json_pack(
      "{s:s,s:i,s:s,s:o,s:o,s:o,s:{s:o,s:o},s:{s:o,s:o},s:o}", "format", "halflight-drift",
      "version", 1, "verdict", drift->drifted ? "drifted" : "same", "significance",
      hl_json_real(drift->significance), "false_alarm", hl_json_real(drift->false_alarm), "causes",
      causes_of(drift), "projection_difference_px", "mean", hl_json_real(drift->mean_px), "max",
      hl_json_real(drift->max_px), "implied_motion", "rotation_rad",
      hl_json_reals(drift->implied.rotation_rad, 3), "translation_m",
      hl_json_reals(drift->implied.translation_m, 3), "notes", hl_json_notes(&drift->notes));
  return hl_json_text(ctx, root, out);
}
