/* LIGHT.json: what one frame said about its light.
 *
 * Curves are radiance (BRDF x cos x light) against an angle in degrees, the diffuse one where n.v is
 * `at_cos_view`: elsewhere add view_slope (n.s) (n.v - at_cos_view). Everything else that is an angle
 * and not named *_deg is in radians. Members keep one order, numbers 17 digits. Where no direction was
 * found the lists are empty and the figures null; the reasons remain. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/export.h"
#include "json_notes.h"
#include "json_write.h"
#include "light_json.h"

/* M_PI is not C11 */
static const double degrees = 180 / 3.14159265358979323846;

static bool push(json_t *array, json_t *value)
{
  return json_array_append_new(array, value) == 0;
}

/* One value for red, green and blue where the frame is grey. */
static json_t *rgb(const double value[3], int channels)
{
  const double grey[3] = {value[0], value[0], value[0]};
  return hl_json_reals(channels == 1 ? grey : value, 3);
}

static json_t *used_list(const hl_notes *notes)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < notes->n && good; i++)
    good = push(list, json_string(notes->note[i].what));
  return hl_json_kept(list, good);
}

static json_t *half_axes(const double rad[2])
{
  const double deg[2] = {rad[0] * degrees, rad[1] * degrees};
  return hl_json_reals(deg, 2);
}

/* What each part would leave alone; null where nothing is known of it. */
static json_t *ellipse_parts(const hl_light *light)
{
  static const char *const names[HL_PARTS] = {"noise", "model", "pose", "camera"};
  json_t *parts = json_object();
  bool good = parts != NULL;
  for (int i = 0; i < HL_PARTS && good; i++)
    good = hl_json_set(parts, names[i],
                       light->part_stated[i] ? half_axes(light->part_95_rad[i]) : json_null());
  return hl_json_kept(parts, good);
}

static json_t *light_list(const hl_light *light)
{
  json_t *list = json_array();
  if (!list || !light->found)
    return list;
  json_t *one = json_object();
  const bool good =
      one && hl_json_set(one, "direction", hl_json_reals(light->direction, 3)) &&
      hl_json_set(one, "tangent_basis", hl_json_rows(light->tangent_basis[0], 2, 3, 3)) &&
      hl_json_set(one, "covariance_rad2", hl_json_rows(light->covariance_rad2[0], 2, 2, 2)) &&
      hl_json_set(one, "ellipse_95_deg", half_axes(light->ellipse_95_rad)) &&
      hl_json_set(one, "ellipse_parts_deg", ellipse_parts(light)) &&
      hl_json_set(one, "bound_rad2", hl_json_rows(light->bound_rad2[0], 2, 2, 2)) &&
      hl_json_set(one, "efficiency", hl_json_real(light->efficiency)) &&
      hl_json_set(one, "by_center_rad_per_m", hl_json_rows(light->by_center[0], 2, 3, 3)) &&
      hl_json_set(one, "color", rgb(light->color, light->channels)) &&
      hl_json_set(one, "position_m",
                  light->near ? hl_json_reals(light->position_m, 3) : json_null()) &&
      hl_json_set(one, "position_covariance_m2",
                  light->near ? hl_json_rows(light->position_covariance_m2[0], 3, 3, 3)
                              : json_null());
  one = hl_json_kept(one, good);
  return hl_json_kept(list, good && push(list, one));
}

static bool has_curve(const hl_light *light, const char *lobe)
{
  for (int i = 0; i < light->n_curves; i++)
    if (strcmp(light->curves[i].lobe, lobe) == 0)
      return true;
  return false;
}

static json_t *lobe_list(const hl_light *light)
{
  json_t *list = json_array();
  bool good = list != NULL;
  if (light->found && good && has_curve(light, "diffuse"))
    good = push(list, json_pack("{s:s,s:s,s:o,s:o,s:f}", "name", "diffuse", "axis", "light",
                                "strength", rgb(light->diffuse_strength, light->channels),
                                "view_slope", rgb(light->diffuse_view_slope, light->channels),
                                "at_cos_view", light->mean_cos_view));
  if (light->found && good && light->lobe != HL_LOBE_AUTO)
    good =
        push(list, json_pack("{s:s,s:s,s:o,s:o,s:s}", "name", "specular", "axis", "half-angle",
                             "direction", hl_json_reals(light->half_angle_direction, 3), "strength",
                             rgb(light->lobe_strength, light->channels), "foreshortening",
                             light->lobe == HL_LOBE_FORESHORTENED ? "1/(n.v)" : "none"));
  return hl_json_kept(list, good);
}

static json_t *curve_list(const hl_light *light)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; light->found && i < light->n_curves && good; i++) {
    const hl_curve *curve = &light->curves[i];
    double angle_deg[HL_CURVE_POINTS];
    for (int k = 0; k < curve->n; k++)
      angle_deg[k] = curve->angle_rad[k] * degrees;
    good = push(list,
                json_pack("{s:s,s:s,s:s,s:o,s:o}", "lobe", curve->lobe, "channel", curve->channel,
                          "quantity", "radiance", "angle_deg", hl_json_reals(angle_deg, curve->n),
                          "value", hl_json_reals(curve->value, curve->n)));
  }
  return hl_json_kept(list, good);
}

static const char *verdict_text(hl_identifiability verdict)
{
  switch (verdict) {
  case HL_UNIQUE:
    return "unique";
  case HL_AMBIGUOUS:
    return "ambiguous";
  case HL_NOT_GUARANTEED:
    break;
  }
  return "not guaranteed";
}

static json_t *text_or_null(const char *text)
{
  return text ? json_string(text) : json_null();
}

static const char *lobe_text(hl_lobe lobe)
{
  if (lobe == HL_LOBE_AUTO)
    return "none";
  return lobe == HL_LOBE_PLAIN ? "plain" : "foreshortened";
}

static json_t *identifiability(const hl_light *light)
{
  const bool known = light->found;
  return json_pack("{s:s,s:o,s:o}", "verdict",
                   known ? verdict_text(light->verdict) : "not guaranteed", "proposition",
                   text_or_null(known ? light->proposition : NULL), "free",
                   text_or_null(known ? light->stays_free : NULL));
}

static json_t *fit_object(const hl_light *light)
{
  const double no = NAN;
  const bool known = light->found;
  json_t *fit = json_object();
  json_t *evidence = json_object();
  const double highlight = known ? light->evidence_highlight : no;
  const bool told = evidence && hl_json_set(evidence, "highlight", hl_json_real(highlight)) &&
                    hl_json_set(evidence, "shading", hl_json_real(1 - highlight));
  evidence = hl_json_kept(evidence, told);
  const bool good =
      fit && hl_json_set(fit, "pixels", json_integer(known ? light->n_pixels : 0)) &&
      hl_json_set(fit, "clipped", json_integer(known ? light->n_clipped : 0)) &&
      hl_json_set(fit, "outliers", json_integer(known ? light->n_outliers : 0)) &&
      hl_json_set(fit, "iterations", json_integer(known ? light->iterations : 0)) &&
      hl_json_set(fit, "rms", hl_json_real(known ? light->rms : no)) &&
      hl_json_set(fit, "relative_error", hl_json_real(known ? light->relative_error : no)) &&
      hl_json_set(fit, "condition", hl_json_real(known ? light->condition : no)) &&
      hl_json_set(fit, "masking_exponent", hl_json_real(known ? light->masking_exponent : no)) &&
      hl_json_set(fit, "mean_cos_view", hl_json_real(known ? light->mean_cos_view : no)) &&
      hl_json_set(fit, "mean_view", known ? hl_json_reals(light->mean_view, 3) : json_null()) &&
      hl_json_set(fit, "ambient", known ? rgb(light->ambient, light->channels) : json_null()) &&
      hl_json_set(fit, "backscatter",
                  known ? hl_json_rows(light->backscatter[0], 3, 2, 2) : json_null()) &&
      hl_json_set(fit, "lobe", known ? json_string(lobe_text(light->lobe)) : json_null());
  /* `evidence` is taken over only by a call that is reached */
  if (!good) {
    json_decref(evidence);
    return hl_json_kept(fit, false);
  }
  return hl_json_kept(fit, hl_json_set(fit, "evidence", evidence) &&
                               hl_json_set(fit, "identifiability", identifiability(light)));
}

static json_t *timing_object(const hl_timing *timing)
{
  if (!timing)
    return json_null();
  return json_pack("{s:f,s:f,s:f,s:f}", "read", timing->read_ms, "locate", timing->locate_ms,
                   "estimate", timing->estimate_ms, "export", timing->export_ms);
}

json_t *hl_light_json_document(const hl_light *light, const hl_timing *timing)
{
  const hl_notes none = {0};
  const bool trusted = light->found && light->trusted;
  json_t *d = json_object();
  const bool good =
      d && hl_json_set(d, "format", json_string("halflight-light")) &&
      hl_json_set(d, "version", json_integer(1)) &&
      hl_json_set(d, "status", json_string(trusted ? "ok" : "untrusted")) &&
      hl_json_set(d, "reasons", hl_json_reasons(&light->reasons)) &&
      hl_json_set(d, "lights", light_list(light)) && hl_json_set(d, "lobes", lobe_list(light)) &&
      hl_json_set(d, "curves", curve_list(light)) && hl_json_set(d, "fit", fit_object(light)) &&
      hl_json_set(d, "used", used_list(light->found ? &light->used : &none)) &&
      hl_json_set(d, "left_out", hl_json_notes(light->found ? &light->left_out : &none)) &&
      hl_json_set(d, "timing_ms", timing_object(timing));
  return hl_json_kept(d, good);
}

hl_status hl_light_json(hl_ctx *ctx, const hl_light *light, const hl_timing *timing, char **out)
{
  return hl_json_text(ctx, hl_light_json_document(light, timing), out);
}

hl_status hl_light_json_write(hl_ctx *ctx, const char *path, const hl_light *light,
                              const hl_timing *timing)
{
  char *text = NULL;
  hl_status st = hl_light_json(ctx, light, timing, &text);
  if (st == HL_OK)
    st = hl_file_write(ctx, path, text, strlen(text));
  free(text);
  return st;
}
