/* A fit as a reflectance: its terms, with axes that follow the light and the view where they are known
 * to.
 *
 * A linear term is k (n.a) by construction, so its curve is drawn to n.a = 1 whatever the samples
 * showed of it. */
#include <stdio.h>
#include <string.h>

#include "halflight/notes.h"
#include "halflight/reflectance.h"
#include "halflight/vec3.h"

static hl_status check_curve(hl_ctx *ctx, const hl_term *term, int index)
{
  if (term->n < 2 || term->n > HL_CURVE_POINTS)
    return hl_fail(ctx, HL_ERR_ARG, "terms[%d]: its curve has %d points; 2 to %d are needed", index,
                   term->n, HL_CURVE_POINTS);
  for (int i = 1; i < term->n; i++)
    if (!(term->t[i] > term->t[i - 1]))
      return hl_fail(ctx, HL_ERR_ARG,
                     "terms[%d]: t[%d] = %.9g follows %.9g; an ascending t is needed", index, i,
                     term->t[i], term->t[i - 1]);
  return HL_OK;
}

static void straighten(const hl_term *from, int channels, hl_lobe_term *out)
{
  const double t = from->t[from->n - 1];
  out->n = 2;
  out->t[0] = 0;
  out->t[1] = 1;
  for (int c = 0; c < channels; c++) {
    out->value[c][0] = 0;
    out->value[c][1] = from->value[c][from->n - 1] / t;
  }
}

static void convert(const hl_fit *fit, int index, hl_lobe_term *out)
{
  const hl_term *from = &fit->term[index];
  memset(out, 0, sizeof *out);
  if (from->name[0])
    snprintf(out->name, sizeof out->name, "%s", from->name);
  else
    snprintf(out->name, sizeof out->name, "term%d", index + 1);
  out->cs = from->cs;
  out->cv = from->cv;
  out->fixed_axis = !(fit->has_light && from->in_plane);
  hl_unit(from->direction, out->axis);
  out->foreshortened = from->foreshortened;
  if (from->role == HL_TERM_LINEAR && !fit->log_domain && from->t[from->n - 1] > 0) {
    straighten(from, fit->channels, out);
    return;
  }
  out->n = from->n;
  memcpy(out->t, from->t, sizeof out->t);
  memcpy(out->value, from->value, sizeof out->value);
}

hl_status hl_reflectance_of_fit(hl_ctx *ctx, const hl_fit *fit, hl_reflectance *out)
{
  hl_reflectance r = {.channels = fit->channels,
                      .log_domain = fit->log_domain,
                      .has_light = fit->has_light,
                      .n_terms = fit->n_terms};
  if (fit->n_terms < 1 || fit->n_terms > HL_TERMS_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "the fit has %d terms; 1 to %d are needed", fit->n_terms,
                   HL_TERMS_MAX);
  memcpy(r.light, fit->light, sizeof r.light);
  memcpy(r.view, fit->view, sizeof r.view);
  for (int i = 0; i < fit->n_terms; i++) {
    const hl_status st = check_curve(ctx, &fit->term[i], i);
    if (st != HL_OK)
      return st;
    convert(fit, i, &r.term[i]);
    if (r.term[i].fixed_axis)
      hl_notes_add(&r.notes, "fixed axis", "%s %s: it does not follow the light", r.term[i].name,
                   fit->has_light ? "is not in the plane of light and view"
                                  : "is not known in terms of light and view");
  }
  if (!fit->trusted)
    hl_notes_add(&r.notes, "untrusted fit", "the fit says not to trust it");
  *out = r;
  return HL_OK;
}
