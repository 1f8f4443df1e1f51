/* Ridge, additive model and pursuit: what each seeks, on the middle samples. */
#include <math.h>
#include <string.h>

#include "fit_work.h"
#include "halflight/vec3.h"

/* A fit along the plane of light and view is kept where its residual's square is at most so many times
 * that of the fit along any directions: only the first can be asked for another light. */
static const double plane_ratio = 2.5;
static const double in_plane_rad = 1e-6; /* a given direction of the plane is so to rounding */
static const double whole_off = 1e-6;    /* so are the whole numbers of one like 2s+v */
enum { WHOLE_MOST = 4 };                 /* the largest of them */

/* ---- ridge ---- */

void hl_fit_search_ridge(hl_fit_work *w, hl_ridge_fit *fit)
{
  const hl_lobe asked = w->lobe;
  fit->ridges.n = 0;
  w->in_plane = false;
  for (int form = 0; form < 2; form++) {
    if (!hl_fit_may(w, form == 1))
      continue;
    w->lobe = form == 1 ? HL_LOBE_FORESHORTENED : HL_LOBE_PLAIN;
    hl_fit_pursue(w, 1, 1);
    w->rival = w->best[1];
    hl_fit_refine_middle(w, w->bank[form], &w->rival);
    if (fit->ridges.n == 0 || w->rival.curves.misfit < fit->curves.misfit)
      *fit = w->rival;
    w->lobe = asked;
  }
}

/* ---- additive ---- */

/* cs : cv as whole numbers, where small ones say the same: h is (1,1) however its digits were cut. */
static hl_axis whole_axis(hl_axis axis)
{
  const double most = fmax(fabs(axis.cs), fabs(axis.cv));
  for (int k = 1; k <= WHOLE_MOST; k++) {
    const double cs = k * axis.cs / most, cv = k * axis.cv / most;
    if (fabs(cs - round(cs)) < whole_off && fabs(cv - round(cv)) < whole_off)
      return hl_fit_named(round(cs), round(cv));
  }
  axis.kind = HL_AXIS_NAMED;
  return axis;
}

/* A given direction: of the plane of light and view where it lies there, so that it follows a light. */
static hl_axis given_axis(const hl_fit_work *w, const double direction[3])
{
  hl_axis axis = {.kind = HL_AXIS_FIXED};
  hl_unit(direction, axis.a);
  if (!w->in_plane)
    return axis;
  const hl_axis named = hl_fit_axis(w, axis.a);
  double back[3];
  for (int k = 0; k < 3; k++)
    back[k] = named.cs * w->light[k] + named.cv * w->all.mean_view[k];
  if (!(hl_angle(back, axis.a) < in_plane_rad))
    return axis;
  return whole_axis(named);
}

void hl_fit_search_additive(hl_fit_work *w, int n, const double *directions, hl_ridge_fit *fit)
{
  hl_fit_begin(w, fit);
  for (int i = 0; i < n; i++) {
    const hl_axis axis = given_axis(w, directions + 3 * i);
    hl_fit_append(fit, &w->coarse_spline, !hl_fit_may(w, false) && !w->log_domain, &axis);
  }
  hl_fit_refine_middle(w, w->bank[0], fit);
  hl_fit_choose_forms(w, fit);
}

/* ---- pursuit ---- */

/* The number of terms asked for, or by cross-validation; its best sum on the middle samples. */
static int best_of_size(hl_fit_work *w, int terms, int max_terms, hl_spline *bank,
                        hl_fit_sizes *sizes, hl_ridge_fit *fit)
{
  hl_fit_pursue(w, terms > 0 ? terms : 1, max_terms > terms ? max_terms : terms);
  if (terms == 0) {
    hl_fit_compare_sizes(w, max_terms, sizes);
    terms = sizes->chosen;
  }
  *fit = w->best[terms];
  hl_fit_refine_middle(w, bank, fit);
  hl_fit_choose_forms(w, fit);
  return terms;
}

void hl_fit_search_pursuit(hl_fit_work *w, int terms, int max_terms, hl_fit_sizes *sizes,
                           bool *light_found, hl_ridge_fit *fit)
{
  const bool has_plane = w->in_plane;
  *light_found = false;
  terms = best_of_size(w, terms, max_terms, w->bank[0], sizes, fit);
  if (has_plane) {
    w->in_plane = false;
    best_of_size(w, terms, terms, w->bank[1], sizes, &w->rival);
    w->in_plane = true;
    if (!hl_fit_is_near(w, fit, &w->rival, plane_ratio, 0))
      *fit = w->rival;
  } else if (!w->has_light && !w->log_domain) {
    *light_found = hl_fit_prefer_light(w, fit);
  }
}
