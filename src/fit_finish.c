/* From the coarse samples to all: finer curves, smoothed by cross-validation, directions refined.
 *
 * Breaks are quadratic in their index, so dense at the highlight, and closer again where the curve
 * leaves zero; those of each term are thinned until every interval holds several samples, and begin
 * at the least chord that any sample has: beyond it the curve is held, for nothing there is known.
 */
#include <math.h>
#include <string.h>

#include "fit_work.h"
#include "ridge_rows.h"

enum {
  FEW_TERMS = 3,
  PROMISE_ITERATIONS = 3,
  LEAST_SAMPLES = 2,
  MIDDLE_ITERATIONS = 3,
  LAST_ITERATIONS = 8,
  ONLY_ITERATIONS = 40
};
/* Intervals of a curve, and the power of their index that breaks follow: 2 crowds them at the highlight. */
typedef struct layout {
  int intervals;
  double power;
} layout;
static const layout few_terms = {34, 2}, many_terms = {17, 2};
static const layout exact_terms = {40, 1.4}; /* where nothing but the splines limits the fit */

static const double middle_tolerance_rad = 1e-5;
static const double last_tolerance_rad = 1e-11;
static const double form_smooth = 1e-6;
static const double promise = 4;
static const double least_residual = 0.5; /* of the mean: smaller ones weigh no more */
static const double exact = 1e-10; /* of the data's square: the splines are all that is left */
static const double from_zero[] = {0.16, 0.08, 0.04, 0.015}; /* of t */
#define FROM_ZERO ((int)(sizeof from_zero / sizeof *from_zero))

static int candidates(const layout *l, double low, double top, bool zero, double *out)
{
  int n = 0;
  const double first = zero ? sqrt(2 - 2 * from_zero[0]) : top;
  for (int i = 0; i <= l->intervals; i++) {
    const double share = (double)i / l->intervals;
    const double at = low + (top - low) * pow(share, l->power);
    if (at < first - 0.25 * (top - first) || (i == l->intervals && !zero))
      out[n++] = at;
  }
  for (int i = 0; i < FROM_ZERO && zero; i++)
    out[n++] = sqrt(2 - 2 * from_zero[i]);
  if (zero)
    out[n++] = top;
  return n;
}

/* Place of u among ascending breaks, by halving. */
static int interval_of(const double *breaks, int intervals, double u)
{
  int low = 0, high = intervals;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    if (u >= breaks[middle])
      low = middle;
    else
      high = middle;
  }
  return low;
}

/* The chords of one term, for the samples that show it. */
static int chords_of(const hl_ridge_pass *pass, int term, double *out)
{
  const hl_ridge_data *d = pass->data;
  hl_ridge_term_rows rows;
  int n = 0;
  for (int first = 0; first < d->n; first += HL_RIDGE_CHUNK) {
    const int count = d->n - first < HL_RIDGE_CHUNK ? d->n - first : HL_RIDGE_CHUNK;
    hl_ridge_rows_chords(pass, term, first, count, &rows);
    for (int i = 0; i < count; i++)
      if (rows.u[i] < pass->widest)
        out[n++] = rows.u[i];
  }
  return n;
}

static void set_spline(hl_fit_work *w, const hl_ridge_pass *pass, int term, const layout *wanted,
                       hl_spline *spline)
{
  double breaks[HL_SPLINE_MAX];
  int samples[HL_SPLINE_MAX] = {0};
  const int n = chords_of(pass, term, w->scratch);
  const double top = w->free_curves ? 2 : sqrt(2.0);
  double low = top, high = 0;
  for (int i = 0; i < n; i++) {
    low = fmin(low, w->scratch[i]);
    high = fmax(high, w->scratch[i]);
  }
  low = n > 0 && low < 0.95 * top ? low : 0;
  const int count =
      candidates(wanted, low, w->free_curves && high > low ? high : top, !w->free_curves, breaks);
  for (int i = 0; i < n; i++)
    samples[interval_of(breaks, count - 1, w->scratch[i])]++;
  hl_spline_init(spline, breaks, hl_spline_thin(breaks, samples, count - 1, LEAST_SAMPLES, breaks));
}

void hl_fit_refine_near(hl_fit_work *w, hl_ridge_fit *fit)
{
  const bool two_steps = w->middle.w != w->all.w;
  hl_axes_settle(&fit->axes, w->all.mean_view);
  hl_ridge_refine(&w->middle, two_steps ? MIDDLE_ITERATIONS : ONLY_ITERATIONS,
                  two_steps ? middle_tolerance_rad : last_tolerance_rad, w->threads, &w->refine,
                  fit);
}

/* New splines for every lobe. */
static void set_splines(hl_fit_work *w, const layout *wanted, hl_spline *bank, hl_ridge_fit *fit)
{
  hl_ridge_pass pass;
  hl_axes_settle(&fit->axes, w->all.mean_view);
  hl_ridge_pass_begin(&fit->ridges, &fit->axes, &w->all, &pass);
  for (int i = 0; i < fit->ridges.n; i++)
    if (!fit->ridges.linear[i]) {
      set_spline(w, &pass, i, wanted, &bank[i]);
      fit->ridges.spline[i] = &bank[i];
    }
  hl_curves_forget(&fit->curves);
}

void hl_fit_refine_middle(hl_fit_work *w, hl_spline *bank, hl_ridge_fit *fit)
{
  set_splines(w, fit->ridges.n <= FEW_TERMS ? &few_terms : &many_terms, bank, fit);
  hl_ridge_settle(&w->middle, true, w->threads, &w->refine, fit);
  hl_fit_refine_near(w, fit);
}

void hl_fit_refine_all(hl_fit_work *w, hl_ridge_fit *fit)
{
  const bool two_steps = w->middle.w != w->all.w;
  double square = 0;
  hl_axes_settle(&fit->axes, w->all.mean_view);
  hl_ridge_refine(&w->all, two_steps ? LAST_ITERATIONS : ONLY_ITERATIONS, last_tolerance_rad,
                  w->threads, &w->refine, fit);
  for (int c = 0; c < w->all.channels; c++)
    square += w->refine.gram.yy[c];
  if (fit->ridges.n > FEW_TERMS || !(fit->curves.misfit < exact * square))
    return;
  set_splines(w, &exact_terms, w->bank[2], fit);
  hl_ridge_settle(&w->all, true, w->threads, &w->refine, fit);
  hl_ridge_refine(&w->all, ONLY_ITERATIONS, last_tolerance_rad, w->threads, &w->refine, fit);
}

/* Whether w->trial, refined on the coarse samples, comes near `fit` there: few of them, at a small part of
 * the cost, tell most wrong forms. */
static bool is_promising(hl_fit_work *w, const hl_ridge_fit *fit)
{
  hl_ridge_fit *here = &w->start[2], *there = &w->start[3];
  *here = *fit;
  *there = w->trial;
  for (int i = 0; i < fit->ridges.n; i++)
    if (!fit->ridges.linear[i])
      here->ridges.spline[i] = there->ridges.spline[i] = &w->coarse_spline;
  hl_curves_forget(&here->curves);
  hl_curves_forget(&there->curves);
  hl_fit_refine_coarse(w, 0, here);
  hl_fit_refine_coarse(w, PROMISE_ITERATIONS, there);
  return there->curves.cost < promise * here->curves.cost;
}

/* Terms of `mask` in their other form: kept where that fits better. */
static bool try_forms(hl_fit_work *w, unsigned mask, hl_ridge_fit *fit)
{
  w->trial = *fit;
  for (int i = 0; i < fit->ridges.n; i++)
    if (mask >> i & 1) {
      if (fit->ridges.linear[i])
        return false;
      w->trial.ridges.foreshortened[i] = !w->trial.ridges.foreshortened[i];
    }
  if (!is_promising(w, fit))
    return false;
  /* what was smoothed for the wrong form may be so too much for the right one */
  for (int i = 0; i < fit->ridges.n; i++)
    w->trial.ridges.smooth[i] = fmin(fit->ridges.smooth[i], form_smooth);
  hl_curves_forget(&w->trial.curves);
  hl_fit_refine_near(w, &w->trial);
  if (!(w->trial.curves.misfit < fit->curves.misfit))
    return false;
  *fit = w->trial;
  return true;
}

/* Smoothing for the forms that were chosen. */
static void smooth_again(hl_fit_work *w, hl_ridge_fit *fit)
{
  hl_curves_forget(&fit->curves);
  hl_ridge_settle(&w->middle, true, w->threads, &w->refine, fit);
}

/* All combinations of a few terms; of many, one term after another until none changes. */
void hl_fit_choose_forms(hl_fit_work *w, hl_ridge_fit *fit)
{
  const int most = hl_axes_parameters(&fit->axes) > 0 ? 2 : 4;
  const int n = fit->ridges.n;
  if (w->lobe != HL_LOBE_AUTO || w->log_domain)
    return;
  bool changed = false;
  if (n <= most) {
    const hl_ridge_fit *start = &w->start[0];
    w->start[0] = *fit;
    for (unsigned mask = 1; mask < 1u << n; mask++) {
      w->start[1] = *start;
      if (try_forms(w, mask, &w->start[1]) && w->start[1].curves.misfit < fit->curves.misfit)
        *fit = w->start[1];
    }
    changed = fit->ridges.smooth[0] != start->ridges.smooth[0] ||
              memcmp(fit->ridges.foreshortened, start->ridges.foreshortened,
                     sizeof start->ridges.foreshortened) != 0;
  }
  for (int round = 0, more = n > most; round < n && more; round++) {
    more = 0;
    for (int i = 0; i < n; i++)
      more = try_forms(w, 1u << i, fit) || more;
    changed = changed || more;
  }
  if (changed)
    smooth_again(w, fit);
}

/* Mean absolute residual of a sample, its channels together, into w->scratch; the mean of all. */
static double absolute_residuals(hl_fit_work *w, const hl_ridge_fit *fit)
{
  const hl_ridge_data *d = &w->all;
  hl_ridge_pass pass;
  hl_ridge_rows rows;
  double sum = 0;
  hl_ridge_pass_begin(&fit->ridges, &fit->axes, d, &pass);
  for (int first = 0; first < d->n; first += HL_RIDGE_CHUNK) {
    const int count = d->n - first < HL_RIDGE_CHUNK ? d->n - first : HL_RIDGE_CHUNK;
    double predicted[HL_RIDGE_CHUNK];
    memset(w->scratch + first, 0, (size_t)count * sizeof *w->scratch);
    hl_ridge_rows_at(&pass, first, count, false, &rows);
    for (int c = 0; c < d->channels; c++) {
      hl_ridge_rows_predict(&pass, &rows, fit->curves.x[c], predicted);
      for (int i = 0; i < count; i++)
        w->scratch[first + i] += fabs(predicted[i] - d->y[c][first + i]) / d->channels;
    }
    for (int i = 0; i < count; i++)
      sum += w->scratch[first + i];
  }
  return sum / d->n;
}

void hl_fit_reweigh(hl_fit_work *w, hl_ridge_fit *fit)
{
  const double mean = absolute_residuals(w, fit);
  if (!(mean > 0))
    return;
  for (int i = 0; i < w->all.n; i++)
    w->all.w[i] = mean / (w->scratch[i] + least_residual * mean);
  hl_ridge_settle(&w->all, false, w->threads, &w->refine, fit);
}

void hl_fit_keep(const hl_ridge_fit *fit, hl_spline *bank, hl_ridge_fit *best)
{
  if (best->ridges.n > 0 && !(fit->curves.misfit < best->curves.misfit))
    return;
  *best = *fit;
  for (int i = 0; i < fit->ridges.n; i++)
    if (!fit->ridges.linear[i]) {
      bank[i] = *fit->ridges.spline[i];
      best->ridges.spline[i] = &bank[i];
    }
}
