/* Among fits of nearly equal error, the one that means something.
 *
 * Directions of the plane of light and view are those that light is reflected about; a fit along them
 * can be asked for another light, one along others cannot. So a direction near a named one of the plane
 * (h, s, 2s+v ...) becomes it where the residual hardly grows, and where the light is not known but
 * two directions are h and s of one, both follow that one light (Prop. 6).
 */
#include <math.h>
#include <string.h>

#include "fit_work.h"
#include "halflight/vec3.h"

static const double name_ratio = 1.1;    /* of the residual's square, for a name */
static const double name_share = 2e-4;   /* or of the data's rms: two hundredths of a percent */
static const double light_ratio = 1.25;  /* for a light from two lobes */
static const double name_rad = 0.035;    /* a direction this near a named one may be it */
static const double bisector_rad = 0.12; /* lobe and bisector of light and view */
static const double rounding = 1e-13;    /* of the data's square: a residual below it is none */

bool hl_fit_is_near(const hl_fit_work *w, const hl_ridge_fit *structured, const hl_ridge_fit *free,
                    double ratio, double share)
{
  double square = 0;
  for (int c = 0; c < w->middle.channels; c++)
    square += w->refine.gram.yy[c];
  return structured->curves.misfit <=
         ratio * free->curves.misfit + (share * share + rounding) * square;
}

/* The named direction nearest to a; how far it is. */
static double nearest_name(const double a[3], const double light[3], const double view[3],
                           double named[2])
{
  static const double plane[][2] = {{1, 0}, {0, 1}, {1, 1}, {2, 1}, {1, 2}, {3, 1}, {1, 3},
                                    {3, 2}, {2, 3}, {4, 1}, {1, 4}, {4, 3}, {3, 4}};
  double least = HUGE_VAL;
  for (size_t i = 0; i < sizeof plane / sizeof *plane; i++) {
    double d[3];
    for (int k = 0; k < 3; k++)
      d[k] = plane[i][0] * light[k] + plane[i][1] * view[k];
    /* simpler names first: a later one must be clearly nearer */
    const double off = hl_angle(a, d) + (i > 2 ? 0.2 * name_rad : 0);
    if (off < least) {
      least = off;
      memcpy(named, plane[i], sizeof plane[i]);
    }
  }
  return least;
}

void hl_fit_prefer_names(hl_fit_work *w, const double light[3], hl_ridge_fit *fit)
{
  for (int i = 0; i < fit->axes.n; i++) {
    const hl_axis_kind kind = fit->axes.axis[i].kind;
    double named[2] = {0};
    if (kind != HL_AXIS_FREE && kind != HL_AXIS_PLANE)
      continue;
    if (!(nearest_name(fit->axes.axis[i].a, light, w->all.mean_view, named) < name_rad))
      continue;
    w->trial = *fit;
    memcpy(w->trial.axes.light, light, sizeof w->trial.axes.light);
    w->trial.axes.axis[i] = hl_fit_named(named[0], named[1]);
    hl_fit_refine_near(w, &w->trial);
    if (hl_fit_is_near(w, &w->trial, fit, name_ratio, name_share))
      *fit = w->trial;
  }
}

/* Terms i about h and j about s of one light. */
static bool try_light(hl_fit_work *w, int i, int j, hl_ridge_fit *fit)
{
  const double *v = w->all.mean_view;
  const double *h = fit->axes.axis[i].a;
  w->trial = *fit;
  /* the sharper lobe says more: the light is h's mirror image of the view */
  const double hv = hl_dot(h, v);
  for (int k = 0; k < 3; k++)
    w->trial.axes.light[k] = 2 * hv * h[k] - v[k];
  w->trial.axes.seeks_light = true;
  w->trial.axes.axis[i] = hl_fit_named(1, 1);
  w->trial.axes.axis[j] = hl_fit_named(1, 0);
  hl_fit_refine_near(w, &w->trial);
  if (!hl_fit_is_near(w, &w->trial, fit, light_ratio, 0))
    return false;
  *fit = w->trial;
  return true;
}

bool hl_fit_prefer_light(hl_fit_work *w, hl_ridge_fit *fit)
{
  const double *v = w->all.mean_view;
  for (int i = 0; i < fit->axes.n; i++)
    for (int j = 0; j < fit->axes.n; j++) {
      double bisector[3];
      if (i == j || fit->ridges.linear[i])
        continue;
      hl_add_scaled(fit->axes.axis[j].a, 1, v, bisector);
      const bool apart = hl_angle(fit->axes.axis[j].a, v) > 2 * bisector_rad;
      if (apart && hl_angle(fit->axes.axis[i].a, bisector) < bisector_rad &&
          try_light(w, i, j, fit))
        return true;
    }
  return false;
}
