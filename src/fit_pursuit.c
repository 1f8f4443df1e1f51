/* Projection pursuit (5.2): terms added one at a time, dropped one at a time, refined together.
 *
 * Forward, the next direction is the best of those that fit_search.c proposes, each refined jointly
 * with all before it; backward, the term that matters least is dropped and the rest refined again.
 * What either way finds best for a number of terms is kept. Where so many terms as were asked for leave
 * a thousandth of the variance or less, no more are fitted only to be dropped again. Two terms also start from what light
 * usually does: a lobe about the half vector and one about the light, for a grid of lights where it is
 * not known (Prop. 6), for the named directions of the plane where it is.
 */
#include <math.h>
#include <string.h>

#include "fit_work.h"
#include "halflight/vec3.h"

enum { COARSE_ITERATIONS = 6, FEW_ITERATIONS = 3 };
enum { LIGHTS = 20, SPOTS = 2, LIGHTS_KEPT = 4, PAIRS_KEPT = 3, FORWARD_KEPT = 2 };
static const double coincident_rad = 0.06, coincident_price = 4;
static const double nothing_left = 1e-3; /* of the variance */
static const double pi = 3.14159265358979323846;

/* ---- keeping the best ---- */

/* Two lobes about almost one direction are one lobe (Remark 3): they must earn it. */
static double cost_of(const hl_ridge_fit *fit)
{
  double least = pi;
  for (int i = 0; i < fit->axes.n; i++)
    for (int j = 0; j < i; j++)
      least = fmin(least, hl_angle(fit->axes.axis[i].a, fit->axes.axis[j].a));
  return fit->curves.cost * (least < coincident_rad ? coincident_price : 1);
}

static void offer(hl_fit_work *w, const hl_ridge_fit *fit)
{
  hl_ridge_fit *best = &w->best[fit->ridges.n];
  if (best->ridges.n == 0 || cost_of(fit) < cost_of(best))
    *best = *fit;
}

/* The other form of each lobe, where it is allowed, kept where it fits better. */
static void try_other_forms(hl_fit_work *w, int terms)
{
  for (int i = 0; i < terms; i++) {
    w->trial = w->best[terms];
    if (w->trial.ridges.linear[i] || !hl_fit_may(w, !w->trial.ridges.foreshortened[i]))
      continue;
    w->trial.ridges.foreshortened[i] = !w->trial.ridges.foreshortened[i];
    hl_curves_forget(&w->trial.curves);
    hl_fit_refine_coarse(w, FEW_ITERATIONS, &w->trial);
    offer(w, &w->trial);
  }
}

/* Refine the best few starts. */
static void refine_starts(hl_fit_work *w, int most, int iterations)
{
  for (int i = 0; i < w->n_starts && i < most; i++) {
    hl_ridge_fit *start = &w->start[w->order[i]];
    hl_fit_refine_coarse(w, iterations, start);
    offer(w, start);
  }
}

/* ---- forward and backward ---- */

static void forward(hl_fit_work *w, int terms)
{
  hl_fit_start start[HL_FIT_STARTS_MAX];
  const hl_ridge_fit *before = terms > 1 ? &w->best[terms - 1] : NULL;
  const int n = hl_fit_forward(w, before, start, w->starts);
  w->n_starts = 0;
  for (int i = 0; i < n; i++) {
    const hl_axis axis = hl_fit_axis(w, start[i].a);
    if (before)
      w->trial = *before;
    else
      hl_fit_begin(w, &w->trial);
    hl_fit_append(&w->trial, &w->coarse_spline, start[i].foreshortened, &axis);
    hl_fit_add_start(w);
  }
  refine_starts(w, terms > 2 ? 1 : FORWARD_KEPT, terms == 2 ? COARSE_ITERATIONS : FEW_ITERATIONS);
}

static void backward(hl_fit_work *w, int terms)
{
  w->n_starts = 0;
  for (int i = 0; i < terms; i++) {
    w->trial = w->best[terms];
    hl_fit_drop(&w->trial, i);
    hl_fit_add_start(w);
  }
  refine_starts(w, 1, COARSE_ITERATIONS);
}

/* ---- what light usually does ---- */

static void start_pair(hl_fit_work *w, int form, const hl_axis *first, const hl_axis *second)
{
  hl_fit_begin(w, &w->trial);
  hl_fit_append(&w->trial, &w->coarse_spline, form & 1, first);
  hl_fit_append(&w->trial, &w->coarse_spline, form >> 1, second);
}

/* Named pairs of directions of the plane, in each form. */
static void pairs_of_plane(hl_fit_work *w)
{
  static const double pair[][4] = {
      {1, 1, 1, 0}, {1, 1, 0, 1}, {2, 1, 0, 1}, {4, 3, 3, 4}, {1, 0, 0, 1}};
  w->n_starts = 0;
  for (size_t p = 0; p < sizeof pair / sizeof *pair; p++) {
    const hl_axis first = hl_fit_in_plane(pair[p][0], pair[p][1]),
                  second = hl_fit_in_plane(pair[p][2], pair[p][3]);
    for (int form = 0; form < 4; form++) {
      if (!hl_fit_may(w, form & 1) || !hl_fit_may(w, form >> 1))
        continue;
      start_pair(w, form, &first, &second);
      hl_fit_add_start(w);
    }
  }
  refine_starts(w, 2 * PAIRS_KEPT, COARSE_ITERATIONS);
}

/* The light of the best pair about h and s in this form, refined; of `n` lights at `from`, or of a grid of
 * them and the brightest samples' where there are none, of which the best are left there. */
static int best_light(hl_fit_work *w, int form, double from[LIGHTS_KEPT][3], int n, double out[3])
{
  const hl_axis half = hl_fit_named(1, 1), light = hl_fit_named(1, 0);
  w->n_starts = 0;
  for (int i = 0; i < (n > 0 ? n : LIGHTS + SPOTS); i++) {
    start_pair(w, form, &half, &light);
    if (n > 0)
      memcpy(w->trial.axes.light, from[i], sizeof from[i]);
    else if (i < SPOTS)
      hl_fit_brightest_light(w, i == 1, w->trial.axes.light);
    else
      hl_fit_light_of(w, i - SPOTS, LIGHTS, w->trial.axes.light);
    hl_fit_add_start(w);
  }
  const int kept = w->n_starts < LIGHTS_KEPT ? w->n_starts : LIGHTS_KEPT;
  for (int i = 0; i < kept && n == 0; i++)
    memcpy(from[i], w->start[w->order[i]].axes.light, sizeof from[i]);
  w->trial = w->start[w->order[0]];
  w->trial.axes.seeks_light = true;
  hl_fit_refine_coarse(w, FEW_ITERATIONS, &w->trial);
  memcpy(out, w->trial.axes.light, sizeof w->trial.axes.light);
  return kept;
}

/* h and s of a light that is sought, then let go. */
static void pairs_of_lights(hl_fit_work *w)
{
  static const int forms[] = {0, 1, 3}; /* plain; the lobe about h foreshortened; both */
  const hl_axis half = hl_fit_named(1, 1), light = hl_fit_named(1, 0);
  double from[LIGHTS_KEPT][3], found[3][3];
  int lights = 0, kept = 0;
  for (int k = 0; k < 3; k++) {
    const bool may = hl_fit_may(w, forms[k] & 1) && hl_fit_may(w, forms[k] >> 1);
    if (may && (k < 2 || lights == 0))
      kept = best_light(w, forms[k], from, kept, found[lights++]);
  }
  w->n_starts = 0;
  for (int i = 0; i < lights; i++)
    for (int k = 0; k < 3; k++) {
      if (!hl_fit_may(w, forms[k] & 1) || !hl_fit_may(w, forms[k] >> 1))
        continue;
      start_pair(w, forms[k], &half, &light);
      memcpy(w->trial.axes.light, found[i], sizeof found[i]);
      hl_axes_settle(&w->trial.axes, w->all.mean_view);
      for (int j = 0; j < 2; j++)
        w->trial.axes.axis[j].kind = HL_AXIS_FREE;
      hl_fit_add_start(w);
    }
  refine_starts(w, PAIRS_KEPT, COARSE_ITERATIONS);
}

/* The best two from what light usually does, or by going forward where that leaves something. */
static void first_two(hl_fit_work *w, bool wants_one)
{
  if (w->in_plane)
    pairs_of_plane(w);
  else
    pairs_of_lights(w);
  if (!wants_one && w->best[2].curves.misfit < nothing_left * hl_ridge_square(&w->coarse))
    return;
  forward(w, 1);
  forward(w, 2);
}

void hl_fit_pursue(hl_fit_work *w, int least, int most)
{
  for (int k = 0; k <= HL_TERMS_MAX; k++)
    memset(&w->best[k], 0, sizeof w->best[k]);
  const double enough = nothing_left * hl_ridge_square(&w->coarse);
  for (int k = 1; k <= most; k++) {
    if (least > 1 && k > least && w->best[least].curves.misfit < enough) {
      most = least;
      break;
    }
    if (most == 1)
      forward(w, 1);
    else if (k == 2)
      first_two(w, least == 1);
    else if (k > 2)
      forward(w, k);
    if (k >= least && k != 1)
      try_other_forms(w, k);
    if (k == 2 && least == 1)
      try_other_forms(w, 1);
  }
  if (most == 1)
    try_other_forms(w, 1);
  for (int k = most; k > least; k--)
    backward(w, k);
}
