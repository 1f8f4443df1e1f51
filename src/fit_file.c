/*
 * FIT.json: a fit as other programs read it, and read back.
 *
 * Curves are radiance (BRDF x cos) under the samples' light, before g, against t = a.n; in the log
 * domain they add up to its logarithm. A curve's `value` is one list where there is one channel, and
 * one list a channel where there are three. What a reader can do without may be absent: a file written
 * by hand needs a model and terms of role, direction and curve.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/fit.h"
#include "halflight/vec3.h"
#include "json_read.h"
#include "json_write.h"

static const double degrees = 180 / 3.14159265358979323846;
static const char *const models[] = {"ridge",   "dichromatic",      "additive",
                                     "pursuit", "torrance-sparrow", "blinn-phong"};
static const char *const roles[] = {"linear", "lobe"};
static const char *const verdicts[] = {"unique", "ambiguous", "not guaranteed"};
static const char *const domains[] = {"linear", "log"};
static const char *const foreshortenings[] = {"none", "1/(n.v)"};
#define COUNT(list) ((int)(sizeof(list) / sizeof *(list)))

/* ---- writing ---- */

static bool push(json_t *array, json_t *value)
{
  return json_array_append_new(array, value) == 0;
}

static json_t *note_list(const hl_notes *notes)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < notes->n && good; i++)
    good =
        push(list, json_pack("{s:s,s:s}", "what", notes->note[i].what, "why", notes->note[i].why));
  return hl_json_kept(list, good);
}

static json_t *reason_list(const hl_notes *notes)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < notes->n && good; i++)
    good = push(list, json_sprintf("%s: %s", notes->note[i].what, notes->note[i].why));
  return hl_json_kept(list, good);
}

static json_t *curve_object(const hl_term *term, int channels)
{
  json_t *curve = json_object();
  json_t *value = channels == 1 ? hl_json_reals(term->value[0], term->n) : json_array();
  bool good = value != NULL;
  for (int c = 0; c < channels && channels > 1 && good; c++)
    good = push(value, hl_json_reals(term->value[c], term->n));
  good = curve && good && hl_json_set(curve, "quantity", json_string("radiance")) &&
         hl_json_set(curve, "t", hl_json_reals(term->t, term->n)) &&
         hl_json_set(curve, "shown", hl_json_reals(term->shown, 2));
  if (!good) {
    json_decref(value);
    return hl_json_kept(curve, false);
  }
  return hl_json_kept(curve, hl_json_set(curve, "value", value));
}

static json_t *term_object(const hl_term *term, int channels)
{
  const double plane[2] = {term->cs, term->cv};
  json_t *t = json_object();
  const bool good =
      t && hl_json_set(t, "role", json_string(roles[term->role])) &&
      hl_json_set(t, "name", term->name[0] ? json_string(term->name) : json_null()) &&
      hl_json_set(t, "direction", hl_json_reals(term->direction, 3)) &&
      hl_json_set(t, "plane", term->in_plane ? hl_json_reals(plane, 2) : json_null()) &&
      hl_json_set(t, "foreshortening", json_string(foreshortenings[term->foreshortened])) &&
      hl_json_set(t, "strength", hl_json_reals(term->strength, channels)) &&
      hl_json_set(t, "gain", hl_json_real(term->gain)) &&
      hl_json_set(t, "off_linear", hl_json_real(term->off_linear)) &&
      hl_json_set(t, "off_quadratic", hl_json_real(term->off_quadratic)) &&
      hl_json_set(t, "curve", curve_object(term, channels));
  return hl_json_kept(t, good);
}

static json_t *term_list(const hl_fit *fit)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < fit->n_terms && good; i++)
    good = push(list, term_object(&fit->term[i], fit->channels));
  return hl_json_kept(list, good);
}

static json_t *angle_list(const hl_fit *fit)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < fit->n_terms && good; i++)
    for (int j = i + 1; j < fit->n_terms && good; j++)
      good =
          push(list, json_real(degrees * hl_angle(fit->term[i].direction, fit->term[j].direction)));
  return hl_json_kept(list, good);
}

static json_t *identifiability(const hl_fit *fit)
{
  json_t *d = json_object();
  const bool good =
      d && hl_json_set(d, "verdict", json_string(verdicts[fit->verdict])) &&
      hl_json_set(d, "proposition", json_string(fit->proposition)) &&
      hl_json_set(d, "free", json_string(fit->stays_free)) &&
      hl_json_set(d, "angles_deg", angle_list(fit)) &&
      hl_json_set(d, "coplanarity", hl_json_real(fit->coplanarity)) &&
      hl_json_set(d, "condition", hl_json_real(fit->condition)) &&
      hl_json_set(d, "direction_sigma_deg", hl_json_real(degrees * fit->direction_sigma_rad));
  return hl_json_kept(d, good);
}

static json_t *size_list(const hl_fit *fit)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < fit->n_sizes && good; i++) {
    const hl_fit_size *size = &fit->size[i];
    good = push(list, json_pack("{s:i,s:o,s:o,s:o}", "terms", size->terms, "relative_error",
                                hl_json_real(size->relative_error), "unexplained_variance",
                                hl_json_real(size->unexplained_variance), "cross_validated",
                                hl_json_real(size->cross_validated)));
  }
  return hl_json_kept(list, good);
}

static json_t *light_object(const hl_fit *fit)
{
  if (!fit->has_light)
    return json_null();
  return json_pack("{s:o,s:b}", "direction", hl_json_reals(fit->light, 3), "given",
                   fit->light_given);
}

hl_status hl_fit_json(hl_ctx *ctx, const hl_fit *fit, char **out)
{
  json_t *d = json_object();
  const bool good =
      d && hl_json_set(d, "format", json_string("halflight-fit")) &&
      hl_json_set(d, "version", json_integer(1)) &&
      hl_json_set(d, "status", json_string(fit->trusted ? "ok" : "untrusted")) &&
      hl_json_set(d, "reasons", reason_list(&fit->reasons)) &&
      hl_json_set(d, "model", json_string(models[fit->model])) &&
      hl_json_set(d, "domain", json_string(domains[fit->log_domain])) &&
      hl_json_set(d, "curves", json_string(fit->free_curves ? "free" : "monotone")) &&
      hl_json_set(d, "channels", json_integer(fit->channels)) &&
      hl_json_set(d, "samples", json_integer(fit->n_samples)) &&
      hl_json_set(d, "light", light_object(fit)) &&
      hl_json_set(d, "view", hl_json_reals(fit->view, 3)) &&
      hl_json_set(d, "terms", term_list(fit)) &&
      hl_json_set(d, "relative_error", hl_json_real(fit->relative_error)) &&
      hl_json_set(d, "unexplained_variance", hl_json_real(fit->unexplained_variance)) &&
      hl_json_set(d, "identifiability", identifiability(fit)) &&
      hl_json_set(d, "sizes", size_list(fit)) && hl_json_set(d, "used", note_list(&fit->used)) &&
      hl_json_set(d, "left_out", note_list(&fit->left_out)) &&
      hl_json_set(d, "timing_ms",
                  json_pack("{s:f,s:f}", "read", fit->read_ms, "estimate", fit->estimate_ms));
  return hl_json_text(ctx, hl_json_kept(d, good), out);
}

/* ---- reading ---- */

/* One of the words of a list; *out its place. */
static hl_status read_word(hl_json_source source, const json_t *object, const char *member,
                           const char *const *words, int n, int *out)
{
  const char *found = NULL;
  char known[128] = "";
  const hl_status st = hl_json_string(source, object, member, &found);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < n; i++) {
    if (strcmp(found, words[i]) == 0) {
      *out = i;
      return HL_OK;
    }
    if (i > 0)
      strncat(known, ", ", sizeof known - strlen(known) - 1);
    strncat(known, words[i], sizeof known - strlen(known) - 1);
  }
  return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s = '%.40s' is none of: %s", source.path, member,
                 found, known);
}

/* As read_word, where the member may be absent: *out then stays. */
static hl_status read_word_if(hl_json_source source, const json_t *object, const char *member,
                              const char *const *words, int n, int *out)
{
  return hl_json_has(object, member) ? read_word(source, object, member, words, n, out) : HL_OK;
}

static hl_status read_unit(hl_json_source source, const json_t *object, const char *member,
                           double out[3])
{
  const hl_status st = hl_json_numbers(source, object, member, 3, out);
  if (st == HL_OK && !(fabs(hl_norm(out) - 1) <= 1e-3))
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s has length %.6g; a unit vector is needed",
                   source.path, member, hl_norm(out));
  if (st == HL_OK)
    hl_unit(out, out);
  return st;
}

static hl_status read_values(hl_json_source source, const json_t *curve, hl_fit *fit, hl_term *term)
{
  const json_t *first = json_array_get(json_object_get(curve, "value"), 0);
  const int channels = json_is_array(first) ? HL_CHANNELS_MAX : 1;
  double rows[HL_CHANNELS_MAX * HL_CURVE_POINTS];
  hl_status st = channels == 1 ? hl_json_numbers(source, curve, "value", term->n, rows)
                               : hl_json_matrix(source, curve, "value", channels, term->n, rows);
  if (st != HL_OK)
    return st;
  if (fit->channels != 0 && fit->channels != channels)
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: value has %d channels, but a term before it has %d", source.path, channels,
                   fit->channels);
  fit->channels = channels;
  for (int c = 0; c < channels; c++)
    memcpy(term->value[c], rows + (size_t)c * (size_t)term->n, (size_t)term->n * sizeof *rows);
  return HL_OK;
}

static hl_status read_curve(hl_json_source source, const json_t *object, hl_fit *fit, hl_term *term)
{
  const json_t *curve = json_object_get(object, "curve");
  const size_t n = json_array_size(json_object_get(curve, "t"));
  if (n < 2 || n > HL_CURVE_POINTS)
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: curve.t has %zu numbers; 2 to %d are needed",
                   source.path, n, HL_CURVE_POINTS);
  term->n = (int)n;
  hl_status st = hl_json_numbers(source, curve, "t", term->n, term->t);
  for (int k = 1; k < term->n && st == HL_OK; k++)
    if (!(term->t[k] > term->t[k - 1]))
      st = hl_fail(source.ctx, HL_ERR_FORMAT, "%s: curve.t[%d] = %.6g does not ascend from %.6g",
                   source.path, k, term->t[k], term->t[k - 1]);
  if (st == HL_OK)
    st = read_values(source, curve, fit, term);
  term->shown[0] = term->t[0];
  term->shown[1] = term->t[term->n - 1];
  if (st == HL_OK && hl_json_has(curve, "shown"))
    st = hl_json_numbers(source, curve, "shown", 2, term->shown);
  for (int c = 0; c < fit->channels; c++)
    term->strength[c] = hl_term_value(term, c, 1);
  return st;
}

static hl_status read_figure(hl_json_source source, const json_t *object, const char *member,
                             double *out)
{
  return hl_json_has(object, member)
             ? hl_json_number(source, object, member, -HUGE_VAL, HUGE_VAL, out)
             : HL_OK;
}

static hl_status read_term(hl_json_source source, const json_t *object, hl_fit *fit, hl_term *term)
{
  int role = HL_TERM_LOBE, divided = 0;
  double plane[2] = {0, 0};
  hl_status st = read_word(source, object, "role", roles, COUNT(roles), &role);
  if (st == HL_OK)
    st = read_unit(source, object, "direction", term->direction);
  if (st == HL_OK)
    st = read_word_if(source, object, "foreshortening", foreshortenings, 2, &divided);
  term->role = (hl_term_role)role;
  term->foreshortened = divided == 1;
  if (st == HL_OK && hl_json_has(object, "plane")) {
    st = hl_json_numbers(source, object, "plane", 2, plane);
    term->in_plane = true;
    if (st == HL_OK && !(fabs(plane[0]) + fabs(plane[1]) > 0))
      st = hl_fail(source.ctx, HL_ERR_FORMAT, "%s: plane = [0, 0] is no direction", source.path);
  }
  term->cs = plane[0];
  term->cv = plane[1];
  const char *name = "";
  if (st == HL_OK && hl_json_has(object, "name"))
    st = hl_json_string(source, object, "name", &name);
  snprintf(term->name, sizeof term->name, "%s", name);
  if (st == HL_OK)
    st = read_figure(source, object, "gain", &term->gain);
  if (st == HL_OK)
    st = read_figure(source, object, "off_linear", &term->off_linear);
  if (st == HL_OK)
    st = read_figure(source, object, "off_quadratic", &term->off_quadratic);
  return st == HL_OK ? read_curve(source, object, fit, term) : st;
}

static hl_status read_terms(hl_json_source source, const json_t *root, hl_fit *fit)
{
  const json_t *terms = json_object_get(root, "terms");
  const size_t n = json_array_size(terms);
  if (!json_is_array(terms) || n < 1 || n > HL_TERMS_MAX)
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: terms has %zu members; 1 to %d are needed",
                   source.path, n, HL_TERMS_MAX);
  fit->n_terms = (int)n;
  for (int i = 0; i < fit->n_terms; i++) {
    hl_ctx inner = {0};
    const hl_json_source term = {&inner, source.path};
    const hl_status st = read_term(term, json_array_get(terms, (size_t)i), fit, &fit->term[i]);
    const size_t prefix = strlen(source.path) + 2;
    if (st != HL_OK)
      return hl_fail(source.ctx, st, "%s: terms[%d].%s", source.path, i,
                     strlen(inner.msg) > prefix ? inner.msg + prefix : inner.msg);
  }
  return HL_OK;
}

static hl_status read_light(hl_json_source source, const json_t *root, hl_fit *fit)
{
  const json_t *light = json_object_get(root, "light");
  fit->view[2] = 1;
  hl_status st = hl_json_has(root, "view") ? read_unit(source, root, "view", fit->view) : HL_OK;
  if (st != HL_OK || !hl_json_has(root, "light"))
    return st;
  fit->has_light = true;
  fit->light_given = json_is_true(json_object_get(light, "given"));
  return read_unit(source, light, "direction", fit->light);
}

static hl_status read_verdict(hl_json_source source, const json_t *root, hl_fit *fit)
{
  const json_t *d = json_object_get(root, "identifiability");
  const char *text = "";
  int verdict = HL_NOT_GUARANTEED;
  hl_status st = HL_OK;
  if (d)
    st = read_word(source, d, "verdict", verdicts, COUNT(verdicts), &verdict);
  fit->verdict = (hl_identifiability)verdict;
  if (st == HL_OK && hl_json_has(d, "proposition"))
    st = hl_json_string(source, d, "proposition", &text);
  snprintf(fit->proposition, sizeof fit->proposition, "%s", text);
  text = "";
  if (st == HL_OK && hl_json_has(d, "free"))
    st = hl_json_string(source, d, "free", &text);
  snprintf(fit->stays_free, sizeof fit->stays_free, "%s", text);
  if (st == HL_OK)
    st = read_figure(source, d, "condition", &fit->condition);
  if (st == HL_OK)
    st = read_figure(source, d, "coplanarity", &fit->coplanarity);
  if (st == HL_OK)
    st = read_figure(source, d, "direction_sigma_deg", &fit->direction_sigma_rad);
  fit->direction_sigma_rad /= degrees;
  return st;
}

/* The smallest angle follows from the directions. */
static void set_least_angle(hl_fit *fit)
{
  fit->least_angle_rad = 180 / degrees;
  for (int i = 0; i < fit->n_terms; i++)
    for (int j = 0; j < i; j++)
      fit->least_angle_rad =
          fmin(fit->least_angle_rad, hl_angle(fit->term[i].direction, fit->term[j].direction));
}

static hl_status read_members(hl_json_source source, const json_t *root, hl_fit *fit)
{
  static const char *const curves[] = {"monotone", "free"};
  static const char *const statuses[] = {"ok", "untrusted"};
  int model = 0, domain = 0, curve = 0, status = 0;
  hl_status st = read_word(source, root, "model", models, COUNT(models), &model);
  if (st == HL_OK)
    st = read_word_if(source, root, "domain", domains, 2, &domain);
  if (st == HL_OK)
    st = read_word_if(source, root, "curves", curves, 2, &curve);
  if (st == HL_OK)
    st = read_word_if(source, root, "status", statuses, 2, &status);
  fit->model = (hl_fit_model)model;
  fit->log_domain = domain == 1;
  fit->free_curves = curve == 1;
  fit->trusted = status == 0;
  if (st == HL_OK)
    st = read_terms(source, root, fit);
  if (st == HL_OK)
    st = read_light(source, root, fit);
  if (st == HL_OK)
    st = read_verdict(source, root, fit);
  if (st == HL_OK)
    st = read_figure(source, root, "relative_error", &fit->relative_error);
  if (st == HL_OK)
    st = read_figure(source, root, "unexplained_variance", &fit->unexplained_variance);
  if (st == HL_OK && hl_json_has(root, "samples"))
    st = hl_json_int(source, root, "samples", 0, 1 << 30, &fit->n_samples);
  for (int i = 0; i < fit->n_terms && st == HL_OK; i++)
    if (fit->term[i].in_plane && !fit->has_light)
      st = hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: terms[%d].plane is relative to a light, but light is missing", source.path,
                   i);
  set_least_angle(fit);
  return st;
}

hl_status hl_fit_read(hl_ctx *ctx, const char *path, hl_fit *out)
{
  const hl_json_source source = {ctx, path};
  json_t *root = NULL;
  hl_status st = hl_json_open(source, "halflight-fit", 1, &root);
  if (st != HL_OK)
    return st;
  hl_fit *fit = calloc(1, sizeof *fit);
  st = fit ? read_members(source, root, fit)
           : hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for the fit", path);
  json_decref(root);
  if (st == HL_OK)
    *out = *fit;
  free(fit);
  return st;
}
