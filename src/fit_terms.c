/* Sums of ridges put together term by term. */
#include <math.h>
#include <string.h>

#include "fit_work.h"
#include "halflight/vec3.h"

static const double first_smooth = 1e-6;

void hl_fit_begin(const hl_fit_work *w, hl_ridge_fit *fit)
{
  memset(fit, 0, sizeof *fit);
  fit->ridges.free_curves = w->free_curves;
  fit->ridges.has_constant = w->log_domain;
  memcpy(fit->axes.light, w->light, sizeof fit->axes.light);
}

void hl_fit_append(hl_ridge_fit *fit, const hl_spline *spline, bool foreshortened,
                   const hl_axis *axis)
{
  const int i = fit->ridges.n++;
  fit->axes.n = fit->ridges.n;
  fit->ridges.linear[i] = !spline;
  fit->ridges.spline[i] = spline;
  fit->ridges.foreshortened[i] = foreshortened;
  fit->ridges.smooth[i] = i > 0 ? fit->ridges.smooth[0] : first_smooth;
  fit->axes.axis[i] = *axis;
  hl_curves_forget(&fit->curves);
}

void hl_fit_drop(hl_ridge_fit *fit, int term)
{
  for (int i = term; i + 1 < fit->ridges.n; i++) {
    fit->ridges.linear[i] = fit->ridges.linear[i + 1];
    fit->ridges.spline[i] = fit->ridges.spline[i + 1];
    fit->ridges.foreshortened[i] = fit->ridges.foreshortened[i + 1];
    fit->ridges.smooth[i] = fit->ridges.smooth[i + 1];
    fit->axes.axis[i] = fit->axes.axis[i + 1];
  }
  fit->axes.n = --fit->ridges.n;
  hl_curves_forget(&fit->curves);
}

hl_axis hl_fit_named(double cs, double cv)
{
  return (hl_axis){.kind = HL_AXIS_NAMED, .cs = cs, .cv = cv};
}

hl_axis hl_fit_in_plane(double cs, double cv)
{
  const double length = hypot(cs, cv);
  return (hl_axis){.kind = HL_AXIS_PLANE, .cs = cs / length, .cv = cv / length};
}

hl_axis hl_fit_axis(const hl_fit_work *w, const double a[3])
{
  hl_axis axis = {.kind = HL_AXIS_FREE};
  memcpy(axis.a, a, sizeof axis.a);
  if (!w->in_plane)
    return axis;
  /* a = cs s + cv v, dotted with s and with v */
  const double *v = w->all.mean_view;
  const double sv = hl_dot(w->light, v), as = hl_dot(a, w->light), av = hl_dot(a, v);
  return hl_fit_in_plane((as - sv * av) / (1 - sv * sv), (av - sv * as) / (1 - sv * sv));
}
