/* LIGHT.json or FIT.json as a reflectance.
 *
 * In LIGHT.json a curve is given by angle; here by its cosine, ascending. What the file of an older
 * program does not say (the body's bend with the view) is taken as none, and noted. */
#include <math.h>
#include <string.h>

#include "halflight/notes.h"
#include "halflight/reflectance.h"
#include "halflight/vec3.h"
#include "json_read.h"

static const double rad_per_deg = 3.14159265358979323846 / 180;

/* The element of an array of objects; HL_ERR_FORMAT where it is none. */
static hl_status object_at(hl_json_source source, const json_t *root, const char *member, size_t i,
                           const json_t **out)
{
  const json_t *list = json_object_get(root, member);
  *out = json_array_get(list, i);
  if (json_is_object(*out))
    return HL_OK;
  if (!json_is_array(list))
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s is missing or no list; a list is needed",
                   source.path, member);
  return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s[%zu] is no object; one is needed", source.path,
                 member, i);
}

static hl_status read_light(hl_json_source source, const json_t *root, hl_reflectance *r)
{
  const json_t *lights = json_object_get(root, "lights"), *light = NULL, *fit = NULL;
  if (json_is_array(lights) && json_array_size(lights) == 0)
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: lights is empty: no light was found, so there is no reflectance; the file "
                   "of a frame that has one is needed",
                   source.path);
  hl_status st = object_at(source, root, "lights", 0, &light);
  if (st == HL_OK)
    st = hl_json_numbers(source, light, "direction", 3, r->light);
  fit = json_object_get(root, "fit");
  if (st == HL_OK && !json_is_object(fit))
    st = hl_fail(source.ctx, HL_ERR_FORMAT, "%s: fit is missing; an object is needed", source.path);
  if (st == HL_OK && hl_json_has(fit, "mean_view"))
    st = hl_json_numbers(source, fit, "mean_view", 3, r->view);
  else
    r->view[2] = -1;
  hl_unit(r->light, r->light);
  hl_unit(r->view, r->view);
  if (st == HL_OK && !(hl_norm(r->light) > 0.5 && hl_norm(r->view) > 0.5))
    st = hl_fail(source.ctx, HL_ERR_FORMAT,
                 "%s: lights[0].direction or fit.mean_view is 0; a direction is needed",
                 source.path);
  return st;
}

static hl_status read_diffuse(hl_json_source source, const json_t *lobe, hl_reflectance *r,
                              hl_lobe_term *term)
{
  term->cs = 1;
  if (!hl_json_has(lobe, "view_slope")) {
    hl_notes_add(&r->notes, "diffuse", "how its shading bends with the view is not in the file");
    return HL_OK;
  }
  hl_status st = hl_json_numbers(source, lobe, "view_slope", 3, term->view_slope);
  if (st == HL_OK)
    st = hl_json_number(source, lobe, "at_cos_view", 0, 1, &term->at_cos_view);
  return st;
}

static hl_status read_specular(hl_json_source source, const json_t *lobe, const json_t *fit,
                               hl_lobe_term *term)
{
  const char *form = NULL;
  term->cs = term->cv = 1;
  hl_status st = hl_json_string(source, lobe, "foreshortening", &form);
  if (st == HL_OK && strcmp(form, "none") != 0 && strcmp(form, "1/(n.v)") != 0)
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: foreshortening = '%.40s'; 'none' or '1/(n.v)' is needed", source.path,
                   form);
  if (st == HL_OK && hl_json_has(fit, "masking_exponent"))
    st = hl_json_number(source, fit, "masking_exponent", -100, 100, &term->masking_exponent);
  term->foreshortened = form && form[0] == '1';
  return st;
}

static hl_status read_lobes(hl_json_source source, const json_t *root, hl_reflectance *r)
{
  const json_t *list = json_object_get(root, "lobes");
  for (size_t i = 0; i < json_array_size(list) || i == 0; i++) {
    const json_t *lobe = NULL;
    const char *name = NULL;
    hl_lobe_term *term = &r->term[i];
    hl_status st = object_at(source, root, "lobes", i, &lobe);
    if (st == HL_OK && i >= 2)
      st = hl_fail(source.ctx, HL_ERR_FORMAT, "%s: lobes has %zu elements; 1 or 2 are needed",
                   source.path, json_array_size(list));
    if (st == HL_OK)
      st = hl_json_string(source, lobe, "name", &name);
    if (st != HL_OK)
      return st;
    if (strcmp(name, "diffuse") == 0)
      st = read_diffuse(source, lobe, r, term);
    else if (strcmp(name, "specular") == 0)
      st = read_specular(source, lobe, json_object_get(root, "fit"), term);
    else
      st = hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: lobes[%zu].name = '%.40s'; 'diffuse' or 'specular' is needed", source.path,
                   i, name);
    if (st != HL_OK)
      return st;
    memcpy(term->name, name, strlen(name) + 1);
    r->n_terms++;
  }
  return HL_OK;
}

/* The term and channel a curve belongs to. */
static hl_status place_of(hl_json_source source, const json_t *curve, hl_reflectance *r, int *at,
                          int *channel)
{
  static const char *const channels[] = {"r", "g", "b", "grey"};
  const char *lobe = NULL, *name = NULL;
  hl_status st = hl_json_string(source, curve, "lobe", &lobe);
  if (st == HL_OK)
    st = hl_json_string(source, curve, "channel", &name);
  if (st != HL_OK)
    return st;
  int i = 0;
  while (i < r->n_terms && strcmp(r->term[i].name, lobe) != 0)
    i++;
  if (i == r->n_terms)
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: curve of lobe '%.40s', which lobes has not",
                   source.path, lobe);
  int c = 0;
  while (c < 4 && strcmp(channels[c], name) != 0)
    c++;
  const int count = c == 3 ? 1 : HL_CHANNELS_MAX;
  if (c == 4 || (r->channels != 0 && r->channels != count))
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: channel = '%.40s'; 'r', 'g' and 'b', or 'grey' alone, are needed",
                   source.path, name);
  r->channels = count;
  *at = i;
  *channel = c == 3 ? 0 : c;
  return HL_OK;
}

static hl_status read_curve(hl_json_source source, const json_t *curve, hl_lobe_term *term,
                            int channel)
{
  double angle[HL_CURVE_POINTS], value[HL_CURVE_POINTS];
  const size_t n = json_array_size(json_object_get(curve, "angle_deg"));
  if (n < 2 || n > HL_CURVE_POINTS || (term->n != 0 && term->n != (int)n))
    return hl_fail(
        source.ctx, HL_ERR_FORMAT,
        "%s: angle_deg of a curve has %zu numbers; 2 to %d are needed, as many for every "
        "channel",
        source.path, n, HL_CURVE_POINTS);
  hl_status st = hl_json_numbers(source, curve, "angle_deg", (int)n, angle);
  if (st == HL_OK)
    st = hl_json_numbers(source, curve, "value", (int)n, value);
  if (st != HL_OK)
    return st;
  term->n = (int)n;
  for (int i = 0; i < term->n; i++) {
    const int from = term->n - 1 - i;
    term->t[i] = angle[from] == 90 ? 0 : cos(rad_per_deg * angle[from]);
    term->value[channel][i] = value[from];
    if (!(angle[from] >= 0 && angle[from] <= 90 && (i == 0 || term->t[i] > term->t[i - 1])))
      return hl_fail(source.ctx, HL_ERR_FORMAT,
                     "%s: angle_deg[%d] = %.9g; ascending angles in [0, 90] are needed",
                     source.path, from, angle[from]);
  }
  return HL_OK;
}

static hl_status read_curves(hl_json_source source, const json_t *root, hl_reflectance *r)
{
  const json_t *list = json_object_get(root, "curves");
  bool seen[HL_TERMS_MAX][HL_CHANNELS_MAX] = {{false}};
  for (size_t i = 0; i < json_array_size(list) || i == 0; i++) {
    const json_t *curve = NULL;
    int at = 0, channel = 0;
    hl_status st = object_at(source, root, "curves", i, &curve);
    if (st == HL_OK)
      st = place_of(source, curve, r, &at, &channel);
    if (st == HL_OK)
      st = read_curve(source, curve, &r->term[at], channel);
    if (st != HL_OK)
      return st;
    seen[at][channel] = true;
  }
  for (int i = 0; i < r->n_terms; i++)
    for (int c = 0; c < r->channels; c++)
      if (!seen[i][c])
        return hl_fail(source.ctx, HL_ERR_FORMAT,
                       "%s: lobe '%s' has no curve of channel %d; a curve for each of %d is needed",
                       source.path, r->term[i].name, c, r->channels);
  return HL_OK;
}

static hl_status note_light(hl_json_source source, const json_t *root, hl_reflectance *r)
{
  const char *status = NULL;
  const json_t *fit = json_object_get(root, "fit");
  double ambient[HL_CHANNELS_MAX] = {0};
  hl_status st = hl_json_string(source, root, "status", &status);
  if (st == HL_OK && strcmp(status, "ok") != 0)
    hl_notes_add(&r->notes, "untrusted light", "the file says not to trust it");
  if (st == HL_OK && hl_json_has(fit, "ambient"))
    st = hl_json_numbers(source, fit, "ambient", HL_CHANNELS_MAX, ambient);
  if (st == HL_OK && hl_norm(ambient) > 0)
    hl_notes_add(&r->notes, "ambient", "the frame's constant part is no reflectance: left out");
  double backscatter[HL_CHANNELS_MAX][2] = {{0}};
  if (st == HL_OK && hl_json_has(fit, "backscatter"))
    st = hl_json_matrix(source, fit, "backscatter", HL_CHANNELS_MAX, 2, backscatter[0]);
  for (int c = 0; c < HL_CHANNELS_MAX; c++)
    if (st == HL_OK && (backscatter[c][0] != 0 || backscatter[c][1] != 0)) {
      hl_notes_add(&r->notes, "backscatter",
                   "its columns in n.v are no curve about an axis: left out, so what is drawn is "
                   "darker towards the light's own side");
      break;
    }
  return st;
}

static hl_status read_light_json(hl_json_source source, const json_t *root, hl_reflectance *out)
{
  hl_reflectance r = {.camera_frame = true, .has_light = true};
  hl_status st = read_light(source, root, &r);
  if (st == HL_OK)
    st = read_lobes(source, root, &r);
  if (st == HL_OK)
    st = read_curves(source, root, &r);
  if (st == HL_OK)
    st = note_light(source, root, &r);
  for (int i = 0; i < r.n_terms; i++) {
    hl_lobe_term *term = &r.term[i];
    for (int k = 0; k < 3; k++)
      term->axis[k] = term->cs * r.light[k] + term->cv * r.view[k];
    hl_unit(term->axis, term->axis);
  }
  if (st == HL_OK)
    *out = r;
  return st;
}

static hl_status read_fit_json(hl_json_source source, hl_reflectance *out)
{
  hl_fit fit;
  hl_status st = hl_fit_read(source.ctx, source.path, &fit);
  if (st != HL_OK)
    return st;
  hl_ctx inner = {0};
  st = hl_reflectance_of_fit(&inner, &fit, out);
  return st == HL_OK ? st : hl_json_blame(source, HL_ERR_FORMAT, inner.msg);
}

hl_status hl_reflectance_read(hl_ctx *ctx, const char *path, hl_reflectance *out)
{
  static const char *const formats[] = {"halflight-light", "halflight-fit"};
  const hl_json_source source = {ctx, path};
  json_t *root = NULL;
  int which = 0;
  hl_status st = hl_json_open_one_of(source, formats, 2, 1, &which, &root);
  if (st != HL_OK)
    return st;
  if (which == 0)
    st = read_light_json(source, root, out);
  json_decref(root);
  return which == 0 ? st : read_fit_json(source, out);
}
