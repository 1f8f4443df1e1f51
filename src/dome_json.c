/*
 * "dome": {"shape":"rings"|"grid"|"sphere"|null,"of":"directions"|"positions","unit":"rad"|"m","lights":n,
 *          "shapes":[{"shape","log_odds","rms","sigma","on","off",...its geometry}],
 *          "distance":[one a light of "lights", null where it was not found],
 *          "outliers":[{"light":place in "lights","file","label","off"}]}
 */
#include "dome_json.h"

#include <string.h>

#include "json_notes.h"
#include "json_write.h"

enum { WHERE_MAX = 4200 };
static const double LARGEST = 1e300;

static bool set_geometry(json_t *o, const hl_dome_fit *f, bool positions)
{
  if (f->shape == HL_DOME_GRID)
    return hl_json_set(o, "corner", hl_json_reals(f->corner, 3)) &&
           hl_json_set(o, "step", hl_json_rows(f->step[0], 2, 3, 3)) &&
           hl_json_set(o, "first", json_pack("[i,i]", f->first[0], f->first[1])) &&
           hl_json_set(o, "size", json_pack("[i,i]", f->size[0], f->size[1]));
  if (f->shape == HL_DOME_RINGS && !hl_json_set(o, "axis", hl_json_reals(f->axis, 3)))
    return false;
  if (positions)
    return hl_json_set(o, "center_m", hl_json_reals(f->center_m, 3)) &&
           hl_json_set(o, "radius_m", hl_json_real(f->radius_m));
  return hl_json_set(o, "half_angle_rad", hl_json_reals(f->half_angle_rad, f->n_rings)) &&
         hl_json_set(o, "pole", json_boolean(f->pole));
}

static json_t *fit_document(const hl_dome_fit *f, bool positions)
{
  json_t *o = json_pack("{s:s,s:o,s:o,s:o,s:i,s:i}", "shape", hl_dome_shape_text(f->shape),
                        "log_odds", hl_json_real(f->evidence), "rms", hl_json_real(f->rms), "sigma",
                        hl_json_real(f->sigma), "on", f->n_on, "off", f->n_off);
  return hl_json_kept(o, o && set_geometry(o, f, positions));
}

static json_t *shape_list(const hl_dome *dome)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int s = 1; s < HL_DOME_SHAPES && good; s++)
    if (dome->fit[s].fitted)
      good = json_array_append_new(list, fit_document(&dome->fit[s], dome->positions)) == 0;
  return hl_json_kept(list, good);
}

static json_t *distance_list(const hl_lights *lights)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < lights->n && good; i++)
    good =
        json_array_append_new(list, lights->light[i].found ? hl_json_real(lights->light[i].dome_off)
                                                           : json_null()) == 0;
  return hl_json_kept(list, good);
}

static json_t *outlier_list(const hl_lights *lights)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < lights->n && good; i++) {
    const hl_rig_light *l = &lights->light[i];
    if (l->off_dome)
      good = json_array_append_new(list, json_pack("{s:i,s:s,s:s,s:o}", "light", i, "file", l->file,
                                                   "label", l->label, "off",
                                                   hl_json_real(l->dome_off))) == 0;
  }
  return hl_json_kept(list, good);
}

json_t *hl_dome_document(const hl_lights *lights)
{
  const hl_dome *d = &lights->dome;
  const bool claimed = d->shape != HL_DOME_NONE;
  json_t *root = json_pack("{s:o,s:s,s:s,s:i,s:o}", "shape",
                           claimed ? json_string(hl_dome_shape_text(d->shape)) : json_null(), "of",
                           d->positions ? "positions" : "directions", "unit",
                           d->positions ? "m" : "rad", "lights", d->n, "shapes", shape_list(d));
  return hl_json_kept(root,
                      root && (!claimed || (hl_json_set(root, "distance", distance_list(lights)) &&
                                            hl_json_set(root, "outliers", outlier_list(lights)))));
}

/* ---- read */

static bool shape_of(const char *text, hl_dome_shape *out)
{
  for (int s = 1; s < HL_DOME_SHAPES; s++)
    if (strcmp(text, hl_dome_shape_text((hl_dome_shape)s)) == 0) {
      *out = (hl_dome_shape)s;
      return true;
    }
  return false;
}

static hl_status read_shape(hl_json_source s, const json_t *o, hl_dome_shape *out)
{
  const char *text;
  const hl_status st = hl_json_string(s, o, "shape", &text);
  if (st != HL_OK || shape_of(text, out))
    return st;
  return hl_fail(s.ctx, HL_ERR_FORMAT, "%s: shape = \"%.40s\"; sphere, rings or grid is needed",
                 s.path, text);
}

static hl_status pair_of(hl_json_source s, const json_t *o, const char *member, int out[2])
{
  double two[2];
  const hl_status st = hl_json_numbers(s, o, member, 2, two);
  for (int k = 0; k < 2 && st == HL_OK; k++) {
    if (!(two[k] >= -1e6 && two[k] <= 1e6 && two[k] == (int)two[k]))
      return hl_fail(s.ctx, HL_ERR_FORMAT, "%s: %s[%d] = %g; a whole number is needed", s.path,
                     member, k, two[k]);
    out[k] = (int)two[k];
  }
  return st;
}

static hl_status read_grid(hl_json_source s, const json_t *o, hl_dome_fit *f)
{
  hl_status st = hl_json_numbers(s, o, "corner", 3, f->corner);
  if (st == HL_OK)
    st = hl_json_matrix(s, o, "step", 2, 3, f->step[0]);
  if (st == HL_OK)
    st = pair_of(s, o, "first", f->first);
  return st == HL_OK ? pair_of(s, o, "size", f->size) : st;
}

static hl_status read_angles(hl_json_source s, const json_t *o, hl_dome_fit *f)
{
  const size_t n = json_array_size(json_object_get(o, "half_angle_rad"));
  if (n < 1 || n > HL_DOME_RINGS_MAX)
    return hl_fail(s.ctx, HL_ERR_FORMAT, "%s: half_angle_rad is no list of 1 to %d angles", s.path,
                   HL_DOME_RINGS_MAX);
  f->n_rings = (int)n;
  f->pole = json_is_true(json_object_get(o, "pole"));
  return hl_json_numbers(s, o, "half_angle_rad", f->n_rings, f->half_angle_rad);
}

static hl_status read_geometry(hl_json_source s, const json_t *o, bool positions, hl_dome_fit *f)
{
  hl_status st = HL_OK;
  if (f->shape == HL_DOME_GRID)
    return read_grid(s, o, f);
  if (f->shape == HL_DOME_RINGS)
    st = hl_json_numbers(s, o, "axis", 3, f->axis);
  if (st != HL_OK || !positions)
    return st == HL_OK ? read_angles(s, o, f) : st;
  f->n_rings = f->shape == HL_DOME_RINGS;
  st = hl_json_numbers(s, o, "center_m", 3, f->center_m);
  return st == HL_OK ? hl_json_number(s, o, "radius_m", 0, LARGEST, &f->radius_m) : st;
}

static hl_status read_fit(hl_json_source s, const json_t *o, hl_dome *dome)
{
  hl_dome_fit f = {.fitted = true};
  hl_status st = read_shape(s, o, &f.shape);
  if (st == HL_OK)
    st = hl_json_number(s, o, "log_odds", -LARGEST, LARGEST, &f.evidence);
  if (st == HL_OK)
    st = hl_json_number(s, o, "rms", 0, LARGEST, &f.rms);
  if (st == HL_OK)
    st = hl_json_number(s, o, "sigma", 0, LARGEST, &f.sigma);
  if (st == HL_OK)
    st = hl_json_int(s, o, "on", 0, 1 << 30, &f.n_on);
  if (st == HL_OK)
    st = hl_json_int(s, o, "off", 0, 1 << 30, &f.n_off);
  if (st == HL_OK)
    st = read_geometry(s, o, dome->positions, &f);
  if (st == HL_OK)
    dome->fit[f.shape] = f;
  return st;
}

static hl_status read_lights(hl_json_source s, const json_t *o, hl_lights *lights)
{
  const json_t *distance = json_object_get(o, "distance");
  const json_t *outliers = json_object_get(o, "outliers");
  if (json_array_size(distance) != (size_t)lights->n || !json_is_array(outliers))
    return hl_fail(s.ctx, HL_ERR_FORMAT,
                   "%s: distance and outliers are no lists for %d lights; they are needed", s.path,
                   lights->n);
  for (int i = 0; i < lights->n; i++)
    lights->light[i].dome_off = json_number_value(json_array_get(distance, (size_t)i));
  for (size_t i = 0; i < json_array_size(outliers); i++) {
    int at;
    const hl_status st =
        hl_json_int(s, json_array_get(outliers, i), "light", 0, lights->n - 1, &at);
    if (st != HL_OK)
      return st;
    lights->light[at].off_dome = true;
  }
  return HL_OK;
}

hl_status hl_dome_members(hl_json_source source, const json_t *root, hl_lights *lights)
{
  char where[WHERE_MAX];
  const json_t *o = json_object_get(root, "dome");
  hl_dome *dome = &lights->dome;
  const char *of;
  if (!hl_json_has(root, "dome"))
    return HL_OK;
  snprintf(where, sizeof where, "%.4096s: dome", source.path);
  const hl_json_source s = {source.ctx, where};
  hl_status st = hl_json_string(s, o, "of", &of);
  if (st == HL_OK) {
    dome->positions = strcmp(of, "positions") == 0;
    st = hl_json_int(s, o, "lights", 0, 1 << 30, &dome->n);
  }
  const json_t *shapes = json_object_get(o, "shapes");
  for (size_t i = 0; i < json_array_size(shapes) && st == HL_OK; i++)
    st = read_fit(s, json_array_get(shapes, i), dome);
  if (st == HL_OK && hl_json_has(o, "shape")) {
    st = read_shape(s, o, &dome->shape);
    if (st == HL_OK && !dome->fit[dome->shape].fitted)
      st = hl_fail(s.ctx, HL_ERR_FORMAT, "%s: shape = \"%s\" is not among its shapes", s.path,
                   hl_dome_shape_text(dome->shape));
    if (st == HL_OK)
      st = read_lights(s, o, lights);
  }
  return st;
}
