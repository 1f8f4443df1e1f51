/* How many terms: cross-validation.
 *
 * Samples are dealt into folds by lot. Curves are fitted to all folds but one, at the directions found
 * from all, and judged on the one left out: with the normal equations A, b of all and A_f, b_f of a
 * fold that is a solve of A - A_f, b - b_f and one quadratic form, no further pass over the samples.
 *
 * What a model of few curves leaves of a real material is structure, not noise, so further terms never
 * stop gaining a little. A larger number is taken where it explains another thousandth of the variance
 * and does better in all folds but one, or where in most folds it leaves a tenth of what the smaller
 * one leaves. Folds are compared one by one because a fold that holds the peak of a sharp highlight
 * outweighs all others, and nobody can predict that peak.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "fit_work.h"

enum { FOLDS_MAX = 20 };
static const double least_gain = 1e-3;   /* of the variance */
static const double large_gain = 0.1;    /* what is left, of what was */
static const double next_to_none = 1e-6; /* of the variance: further terms are for rounding */

/* The residual's square in each fold, left out. */
static void left_out(hl_fit_work *w, const hl_ridge_fit *fit, double off[FOLDS_MAX])
{
  hl_ridge_data fold = w->middle;
  hl_roughness roughness;
  hl_ridges_gram(&fit->ridges, &fit->axes, &w->middle, w->threads, &w->refine.ridge, &w->whole);
  hl_roughness_from(&fit->ridges, &w->whole, &roughness);
  fold.w = w->scratch;
  for (int f = 0; f < w->folds; f++) {
    for (int i = 0; i < fold.n; i++) {
      const int its = (int)(w->folds * hl_fit_lot(&w->middle, i, w->seed + 1));
      fold.w[i] = its == f ? w->middle.w[i] : 0;
    }
    hl_ridges_gram(&fit->ridges, &fit->axes, &fold, w->threads, &w->refine.ridge, &w->refine.gram);
    hl_gram_subtract(&w->whole, &w->refine.gram);
    w->trial.curves = fit->curves;
    hl_curves_solve(&fit->ridges, &w->whole, &roughness, &w->refine.curves, &w->trial.curves);
    off[f] = hl_curves_misfit(&w->refine.gram, &w->trial.curves);
    hl_gram_merge(&w->whole, &w->refine.gram);
  }
}

/* Whether the larger model is worth its terms; `square` of the data about their mean. */
static bool is_worth(const double *small, const double *large, int folds, double square)
{
  double before = 0, after = 0;
  int better = 0, much_better = 0;
  for (int f = 0; f < folds; f++) {
    before += small[f];
    after += large[f];
    better += large[f] < small[f];
    much_better += large[f] < large_gain * small[f];
  }
  if (2 * much_better > folds && before > next_to_none * square)
    return true;
  return better >= folds - 1 && before - after > least_gain * square;
}

void hl_fit_compare_sizes(hl_fit_work *w, int most, hl_fit_sizes *out)
{
  const double square = hl_ridge_square(&w->middle);
  double off[HL_TERMS_MAX][FOLDS_MAX];
  memset(out, 0, sizeof *out);
  int at = 0;
  for (int k = 1; k <= most; k++) {
    hl_fit_errors errors;
    double sum = 0;
    if (w->best[k].ridges.n == 0)
      continue;
    w->rival = w->best[k];
    hl_fit_refine_middle(w, w->bank[2], &w->rival);
    hl_fit_errors_of(w, &w->rival, &w->middle, &errors);
    left_out(w, &w->rival, off[out->n]);
    for (int f = 0; f < w->folds; f++)
      sum += off[out->n][f] / square;
    if (out->n > 0 && is_worth(off[at], off[out->n], w->folds, square))
      at = out->n;
    out->size[out->n++] = (hl_fit_size){k, errors.relative, errors.unexplained, sum};
  }
  out->chosen = out->size[at].terms;
}
