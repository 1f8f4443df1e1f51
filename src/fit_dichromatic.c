/* The dichromatic model (eq. 4): a linear part and one lobe.
 *
 * Light known by direction (Prop. 5): rho = k n.s + g f(b.n), b sought, in the plane of light and view
 * where that fits nearly as well.
 * Light unknown (Prop. 3): rho = a.n + g f(b.n), both sought. A share k b.n can be moved between the
 * two (eq. 5), so a is not determined, but b is. Where the lobe is that of a half vector, b says where
 * the light is, s = 2(b.v)b - v, and the linear part must point there: that fit has two unknowns where
 * the free one has four, and is kept where it fits nearly as well, for the free one cannot tell the
 * plain lobe from the foreshortened: a free vector hides the difference.
 */
#include <math.h>
#include <string.h>

#include "fit_work.h"
#include "halflight/vec3.h"

enum { LIGHTS = 40, STARTS = 4, ITERATIONS = 8 };
static const double structured_ratio = 1.5; /* of the residual's square */

static void begin(const hl_fit_work *w, bool foreshortened, const hl_axis *linear,
                  const hl_axis *lobe, hl_ridge_fit *out)
{
  hl_fit_begin(w, out);
  hl_fit_append(out, NULL, false, linear);
  hl_fit_append(out, &w->coarse_spline, foreshortened, lobe);
}

/* The better of `best` and w->trial, best.ridges.n == 0 standing for none. */
static void keep_better(const hl_fit_work *w, hl_ridge_fit *best)
{
  if (best->ridges.n == 0 || w->trial.curves.cost < best->curves.cost)
    *best = w->trial;
}

/* ---- light known ---- */

/* The lobe in the plane of light and view, so that it follows every sample's view, or anywhere. */
static void search_lobe(hl_fit_work *w, bool foreshortened, bool in_plane, hl_ridge_fit *best)
{
  const hl_axis light = hl_fit_named(1, 0);
  const bool has_plane = w->in_plane;
  hl_fit_start start[STARTS];
  double half[3];
  hl_ridge_fit *alone = &w->start[0];
  w->in_plane = in_plane;
  best->ridges.n = 0;
  hl_add_scaled(w->light, 1, w->all.mean_view, half);
  hl_unit(half, half);
  hl_fit_begin(w, alone);
  hl_fit_append(alone, NULL, false, &light);
  hl_fit_refine_coarse(w, 0, alone);
  const int n = hl_fit_forward(w, alone, start, STARTS);
  for (int i = -1; i < n; i++) {
    const hl_axis lobe = hl_fit_axis(w, i < 0 ? half : start[i].a);
    begin(w, foreshortened, &light, &lobe, &w->trial);
    hl_fit_refine_coarse(w, ITERATIONS, &w->trial);
    keep_better(w, best);
  }
  w->in_plane = has_plane;
}

/* ---- light unknown ---- */

/* The lobe about the half vector of a light that the linear part points to. */
static void search_tied(hl_fit_work *w, bool foreshortened, hl_ridge_fit *best)
{
  const hl_axis half = hl_fit_named(1, 1), light = hl_fit_named(1, 0);
  w->n_starts = 0;
  for (int i = -1; i < LIGHTS; i++) {
    begin(w, foreshortened, &light, &half, &w->trial);
    if (i < 0)
      hl_fit_brightest_light(w, true, w->trial.axes.light);
    else
      hl_fit_light_of(w, i, LIGHTS, w->trial.axes.light);
    hl_fit_add_start(w);
  }
  best->ridges.n = 0;
  for (int i = 0; i < w->n_starts && i < STARTS; i++) {
    w->trial = w->start[w->order[i]];
    w->trial.axes.seeks_light = true;
    hl_fit_refine_coarse(w, ITERATIONS, &w->trial);
    keep_better(w, best);
  }
}

/* Both let go. */
static void search_free(hl_fit_work *w, bool foreshortened, const hl_ridge_fit *tied,
                        hl_ridge_fit *best)
{
  hl_fit_start start[STARTS];
  best->ridges.n = 0;
  w->trial = *tied;
  w->trial.axes.seeks_light = false;
  for (int k = 0; k < 2; k++)
    w->trial.axes.axis[k].kind = HL_AXIS_FREE;
  hl_fit_refine_coarse(w, ITERATIONS, &w->trial);
  keep_better(w, best);
  /* a linear part alone, then a lobe along what it leaves, and along what there is without it */
  const hl_axis ahead = hl_fit_axis(w, w->all.mean_view);
  hl_ridge_fit *alone = &w->start[0];
  hl_fit_begin(w, alone);
  hl_fit_append(alone, NULL, false, &ahead);
  hl_fit_refine_coarse(w, ITERATIONS, alone);
  for (int pass = 0; pass < 2; pass++) {
    const int n = hl_fit_forward(w, pass == 0 ? alone : NULL, start, STARTS);
    for (int i = 0; i < n; i++) {
      const hl_axis lobe = hl_fit_axis(w, start[i].a);
      begin(w, foreshortened, pass == 0 ? &alone->axes.axis[0] : &ahead, &lobe, &w->trial);
      hl_fit_refine_coarse(w, ITERATIONS, &w->trial);
      keep_better(w, best);
    }
  }
}

void hl_fit_search_dichromatic(hl_fit_work *w, bool *light_found, hl_ridge_fit *fit)
{
  hl_ridge_fit *structured = fit, *free = &w->rival;
  hl_ridge_fit *found = &w->best[0], *found_free = &w->best[1];
  structured->ridges.n = free->ridges.n = 0;
  for (int form = 0; form < 2; form++) {
    if (!hl_fit_may(w, form == 1))
      continue;
    if (w->has_light) {
      search_lobe(w, form == 1, w->in_plane, found);
      search_lobe(w, form == 1, false, found_free);
    } else {
      search_tied(w, form == 1, found);
      search_free(w, form == 1, found, found_free);
    }
    hl_fit_refine_middle(w, w->bank[2], found);
    hl_fit_keep(found, w->bank[0], structured);
    hl_fit_refine_middle(w, w->bank[2], found_free);
    hl_fit_keep(found_free, w->bank[1], free);
  }
  const bool near = hl_fit_is_near(w, structured, free, structured_ratio, 0);
  if (!near)
    *fit = *free;
  *light_found = near && !w->has_light;
}
