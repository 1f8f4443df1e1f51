/* One light of lights.json: read, checked, written. Where no direction was found only its place, what
 * was recorded and the reasons are there. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/vec3.h"
#include "json_notes.h"
#include "json_write.h"
#include "lights_json.h"
#include "psd.h"

static const double LARGEST = 1e300;
static const double UNIT = 1e-6; /* what rounding may leave of a unit vector's length */

static bool set_direction(json_t *one, const hl_rig_light *l, int columns)
{
  return hl_json_set(one, "direction", hl_json_reals(l->direction, 3)) &&
         hl_json_set(one, "tangent_basis", hl_json_rows(l->tangent_basis[0], 2, 3, 3)) &&
         hl_json_set(one, "covariance_rad2", hl_json_rows(l->covariance_rad2[0], 2, 2, 2)) &&
         hl_json_set(one, "ellipse_95_rad", hl_json_reals(l->ellipse_95_rad, 2)) &&
         hl_json_set(one, "own_rad2", hl_json_rows(l->own_rad2[0], 2, 2, 2)) &&
         hl_json_set(one, "by_center", hl_json_rows(l->by_center[0], 2, 3, 3)) &&
         hl_json_set(one, "by_intrinsics",
                     hl_json_rows(l->by_intrinsics[0], 2, columns, HL_INTRINSICS_MAX)) &&
         hl_json_set(one, "color", hl_json_reals(l->color, 3)) &&
         hl_json_set(one, "intensity", hl_json_reals(l->intensity, 3)) &&
         hl_json_set(one, "intensity_sigma", hl_json_real(l->intensity_sigma)) &&
         hl_json_set(one, "position_m", l->near ? hl_json_reals(l->position_m, 3) : json_null()) &&
         (!l->near || hl_json_set(one, "position_covariance_m2",
                                  hl_json_rows(l->position_covariance_m2[0], 3, 3, 3)));
}

json_t *hl_rig_light_document(const hl_rig_light *l, int columns)
{
  json_t *one = json_pack("{s:i,s:s,s:s,s:i,s:b,s:b,s:o,s:f,s:f}", "frame", l->frame, "file",
                          l->file, "label", l->label, "ball", l->ball, "found", (int)l->found,
                          "trusted", (int)l->trusted, "reasons", hl_json_note_list(&l->reasons),
                          "exposure_us", l->exposure_us, "gain", l->gain);
  if (one && (!l->found || set_direction(one, l, columns)))
    return one;
  json_decref(one);
  return NULL;
}

static hl_status read_text(hl_json_source source, const json_t *object, const char *member,
                           char **out)
{
  const char *text;
  const hl_status st = hl_json_string(source, object, member, &text);
  if (st != HL_OK)
    return st;
  *out = strdup(text);
  return *out ? HL_OK : hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for a text", source.path);
}

static hl_status read_bool(hl_json_source source, const json_t *object, const char *member,
                           bool *out)
{
  const json_t *value = json_object_get(object, member);
  if (!json_is_boolean(value))
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s is not true or false; one of them is needed",
                   source.path, member);
  *out = json_is_true(value);
  return HL_OK;
}

static hl_status read_place(hl_json_source s, const json_t *o, int n_balls, hl_rig_light *l)
{
  hl_status st = read_text(s, o, "file", &l->file);
  if (st == HL_OK)
    st = read_text(s, o, "label", &l->label);
  if (st == HL_OK)
    st = hl_json_int(s, o, "frame", 0, 1 << 30, &l->frame);
  if (st == HL_OK)
    st = hl_json_int(s, o, "ball", 0, n_balls > 0 ? n_balls - 1 : 0, &l->ball);
  if (st == HL_OK)
    st = read_bool(s, o, "found", &l->found);
  if (st == HL_OK)
    st = read_bool(s, o, "trusted", &l->trusted);
  if (st == HL_OK)
    st = hl_json_note_list_read(s, o, "reasons", &l->reasons);
  if (st == HL_OK)
    st = hl_json_number(s, o, "exposure_us", 0, LARGEST, &l->exposure_us);
  if (st == HL_OK)
    st = hl_json_number(s, o, "gain", 0, LARGEST, &l->gain);
  return st;
}

static hl_status read_position(hl_json_source s, const json_t *o, hl_rig_light *l)
{
  l->near = hl_json_has(o, "position_m");
  if (!l->near)
    return HL_OK;
  const hl_status st = hl_json_numbers(s, o, "position_m", 3, l->position_m);
  return st == HL_OK
             ? hl_json_matrix(s, o, "position_covariance_m2", 3, 3, l->position_covariance_m2[0])
             : st;
}

static hl_status check_direction(hl_json_source s, const hl_rig_light *l)
{
  const double *d = l->direction;
  if (!(fabs(hl_norm(d) - 1) <= UNIT))
    return hl_fail(s.ctx, HL_ERR_FORMAT, "%s: direction has length %.9g; 1 is needed", s.path,
                   hl_norm(d));
  for (int u = 0; u < 2; u++)
    if (!(fabs(hl_norm(l->tangent_basis[u]) - 1) <= UNIT) ||
        !(fabs(hl_dot(l->tangent_basis[u], d)) <= UNIT))
      return hl_fail(s.ctx, HL_ERR_FORMAT,
                     "%s: tangent_basis[%d] is not a unit vector across direction; one is needed",
                     s.path, u);
  if (!hl_psd_check(l->covariance_rad2[0], 2) || !hl_psd_check(l->own_rad2[0], 2))
    return hl_fail(s.ctx, HL_ERR_FORMAT,
                   "%s: covariance_rad2 or own_rad2 is no covariance; symmetric 2 x 2 matrices "
                   "without negative eigenvalues are needed",
                   s.path);
  return HL_OK;
}

static hl_status read_direction(hl_json_source s, const json_t *o, int columns, hl_rig_light *l)
{
  double by[2 * HL_INTRINSICS_MAX];
  hl_status st = hl_json_numbers(s, o, "direction", 3, l->direction);
  if (st == HL_OK)
    st = hl_json_matrix(s, o, "tangent_basis", 2, 3, l->tangent_basis[0]);
  if (st == HL_OK)
    st = hl_json_matrix(s, o, "covariance_rad2", 2, 2, l->covariance_rad2[0]);
  if (st == HL_OK)
    st = hl_json_numbers(s, o, "ellipse_95_rad", 2, l->ellipse_95_rad);
  if (st == HL_OK)
    st = hl_json_matrix(s, o, "own_rad2", 2, 2, l->own_rad2[0]);
  if (st == HL_OK)
    st = hl_json_matrix(s, o, "by_center", 2, 3, l->by_center[0]);
  if (st == HL_OK)
    st = hl_json_matrix(s, o, "by_intrinsics", 2, columns, by);
  if (st == HL_OK)
    st = hl_json_numbers(s, o, "color", 3, l->color);
  if (st == HL_OK)
    st = hl_json_numbers(s, o, "intensity", 3, l->intensity);
  if (st == HL_OK)
    st = hl_json_number(s, o, "intensity_sigma", 0, LARGEST, &l->intensity_sigma);
  if (st == HL_OK)
    st = read_position(s, o, l);
  if (st != HL_OK)
    return st;
  for (int u = 0; u < 2; u++)
    memcpy(l->by_intrinsics[u], by + u * columns, (size_t)columns * sizeof *by);
  return check_direction(s, l);
}

hl_status hl_rig_light_members(hl_json_source source, const json_t *object, int n_balls,
                               int columns, hl_rig_light *out)
{
  const hl_status st = read_place(source, object, n_balls, out);
  return st == HL_OK && out->found ? read_direction(source, object, columns, out) : st;
}
