/* LOESS along a ridge's direction (Cleveland and Devlin; the paper's 5.1): local linear regression.
 *
 *   f(u) = value at u of the line that minimises sum_i w_i K((u_i - u)/span) (y_i - line)^2,
 *   K(x) = (1 - |x|^3)^3
 *
 * Samples are first shared out to a fine grid of chords, each between its two neighbours (linear
 * binning), which one pass does; what a span of hundreds of bins sees of them is the same. The span
 * holds a fixed share of the samples' weight, chosen by generalized cross-validation. Where curves are
 * to be monotone the result is made so by pooling adjacent violators, which is its nearest monotone
 * sequence.
 */
#include <math.h>
#include <string.h>

#include "fit_work.h"
#include "halflight/notes.h"
#include "ridge_rows.h"

enum { BINS = 1024, SPANS = 7 };

/* Weights and weighted data of the bins, u = top * (bin / (BINS - 1))^2. */
typedef struct bins {
  double top;
  double w[BINS], wy[HL_CHANNELS_MAX][BINS], wyy[HL_CHANNELS_MAX];
  double below[BINS + 1]; /* weight of the bins before */
} bins;

static double chord_of(const bins *b, int bin)
{
  const double share = (double)bin / (BINS - 1);
  return b->top * share * share;
}

static void fill(const hl_fit_work *w, const hl_ridge_fit *fit, bins *b)
{
  hl_ridge_pass pass;
  hl_ridge_rows rows;
  const hl_ridge_data *d = &w->all;
  memset(b, 0, sizeof *b);
  b->top = w->free_curves ? 2 : sqrt(2.0);
  hl_ridge_pass_begin(&fit->ridges, &fit->axes, d, &pass);
  for (int first = 0; first < d->n; first += HL_RIDGE_CHUNK) {
    const int count = d->n - first < HL_RIDGE_CHUNK ? d->n - first : HL_RIDGE_CHUNK;
    hl_ridge_rows_at(&pass, first, count, false, &rows);
    for (int i = 0; i < count; i++) {
      const double u = rows.term[0].u[i], g = rows.term[0].g[i];
      const double at = (BINS - 1) * sqrt(fmin(u, b->top) / b->top);
      const int bin = at < BINS - 2 ? (int)at : BINS - 2;
      const double weight = d->w[first + i] * g * g;
      for (int side = 0; side < 2; side++) {
        const double part = weight * (side == 0 ? 1 - (at - bin) : at - bin);
        b->w[bin + side] += part;
        for (int c = 0; c < d->channels; c++)
          b->wy[c][bin + side] += part * d->y[c][first + i] / g;
      }
      for (int c = 0; c < d->channels; c++)
        b->wyy[c] += weight * d->y[c][first + i] * d->y[c][first + i] / (g * g);
    }
  }
  for (int k = 0; k < BINS; k++)
    b->below[k + 1] = b->below[k] + b->w[k];
}

/* Half width about u that holds `share` of the weight, and at least three bins with any. */
static double span_at(const bins *b, double u, double share)
{
  double low = 1e-6 * b->top, high = b->top;
  const double wanted = share * b->below[BINS];
  for (int round = 0; round < 40; round++) {
    const double middle = 0.5 * (low + high);
    double held = 0;
    int filled = 0;
    const int from = (int)ceil((BINS - 1) * sqrt(fmax(0, u - middle) / b->top));
    const int to = (int)floor((BINS - 1) * sqrt(fmin(b->top, u + middle) / b->top));
    held = to >= from ? b->below[to + 1] - b->below[from] : 0;
    for (int k = from; k <= to && filled < 3; k++)
      filled += b->w[k] > 0;
    if (held >= wanted && filled >= 3)
      high = middle;
    else
      low = middle;
  }
  return high;
}

/* Values of all channels at u; returns the weight of a datum at u on its own value, per unit w. */
static double local_line(const bins *b, int channels, double u, double span, double *out)
{
  double s0 = 0, s1 = 0, s2 = 0, y0[HL_CHANNELS_MAX] = {0}, y1[HL_CHANNELS_MAX] = {0};
  for (int k = 0; k < BINS; k++) {
    const double d = chord_of(b, k) - u, x = fabs(d) / span;
    if (!(x < 1) || b->w[k] <= 0)
      continue;
    const double kernel = (1 - x * x * x) * (1 - x * x * x) * (1 - x * x * x);
    s0 += kernel * b->w[k];
    s1 += kernel * b->w[k] * d;
    s2 += kernel * b->w[k] * d * d;
    for (int c = 0; c < channels; c++) {
      y0[c] += kernel * b->wy[c][k];
      y1[c] += kernel * b->wy[c][k] * d;
    }
  }
  const double det = s0 * s2 - s1 * s1;
  const bool line = det > 1e-12 * s0 * s2;
  for (int c = 0; c < channels; c++)
    out[c] = line ? (s2 * y0[c] - s1 * y1[c]) / det : s0 > 0 ? y0[c] / s0 : 0;
  return line ? s2 / det : s0 > 0 ? 1 / s0 : 0;
}

/* Generalized cross-validation of one span, over the bins. */
static double score_of(const bins *b, int channels, int samples, double share)
{
  double off = 0, freedom = 0;
  for (int c = 0; c < channels; c++)
    off += b->wyy[c];
  for (int k = 0; k < BINS; k++) {
    double value[HL_CHANNELS_MAX];
    if (b->w[k] <= 0)
      continue;
    const double u = chord_of(b, k);
    freedom += b->w[k] * local_line(b, channels, u, span_at(b, u, share), value);
    for (int c = 0; c < channels; c++)
      off += b->w[k] * value[c] * value[c] - 2 * value[c] * b->wy[c][k];
  }
  const double left = 1 - freedom / samples;
  return left > 0 ? fmax(0, off) / (left * left) : HUGE_VAL;
}

/* Ascending in t, with the weights of the points (pool adjacent violators). */
static void make_monotone(double *value, const double *weight, int n)
{
  double mean[HL_CURVE_POINTS], held[HL_CURVE_POINTS];
  int size[HL_CURVE_POINTS], blocks = 0;
  for (int i = 0; i < n; i++) {
    mean[blocks] = fmax(0, value[i]);
    held[blocks] = weight[i] + 1e-12;
    size[blocks++] = 1;
    while (blocks > 1 && mean[blocks - 2] > mean[blocks - 1]) {
      const double sum = held[blocks - 2] + held[blocks - 1];
      mean[blocks - 2] =
          (held[blocks - 2] * mean[blocks - 2] + held[blocks - 1] * mean[blocks - 1]) / sum;
      held[blocks - 2] = sum;
      size[blocks - 2] += size[blocks - 1];
      blocks--;
    }
  }
  for (int k = 0, i = 0; k < blocks; k++)
    for (int j = 0; j < size[k]; j++)
      value[i++] = mean[k];
}

static void set_curve(const hl_fit_work *w, const bins *b, double share, hl_fit *out)
{
  hl_term *term = &out->term[0];
  double weight[HL_CURVE_POINTS];
  const double low = sqrt(fmax(0, 2 - 2 * term->shown[1]));
  const double high = sqrt(2 - 2 * fmax(w->free_curves ? -1 : 0, term->shown[0]));
  for (int k = 0; k < term->n; k++) {
    const double u = sqrt(fmax(0, 2 - 2 * term->t[k]));
    const double inside = fmin(fmax(u, low), high);
    double value[HL_CHANNELS_MAX];
    const double span = span_at(b, inside, share);
    weight[k] = 1 / fmax(local_line(b, out->channels, inside, span, value), 1e-300);
    for (int c = 0; c < out->channels; c++)
      term->value[c][k] =
          (w->log_domain ? 1 : w->level) * value[c] + (w->log_domain ? log(w->level) : 0);
  }
  for (int c = 0; c < out->channels; c++) {
    if (!w->free_curves && !w->log_domain) {
      /* towards zero where nothing is shown */
      for (int k = 0; k < term->n && term->t[k] < term->shown[0]; k++)
        term->value[c][k] *= fmax(0, term->t[k] / term->shown[0]);
      term->value[c][0] = 0;
      make_monotone(term->value[c], weight, term->n);
      term->value[c][0] = 0;
    }
    term->strength[c] = hl_term_value(term, c, 1);
  }
}

/* Errors of the table itself. */
static void set_errors(const hl_fit_work *w, const hl_ridge_fit *fit, hl_fit *out)
{
  hl_ridge_pass pass;
  hl_ridge_rows rows;
  const hl_ridge_data *d = &w->all;
  double off = 0, data = 0, residual = 0, square = 0;
  hl_ridge_pass_begin(&fit->ridges, &fit->axes, d, &pass);
  for (int c = 0; c < d->channels; c++) {
    double sum = 0, squares = 0;
    for (int first = 0; first < d->n; first += HL_RIDGE_CHUNK) {
      const int count = d->n - first < HL_RIDGE_CHUNK ? d->n - first : HL_RIDGE_CHUNK;
      hl_ridge_rows_at(&pass, first, count, false, &rows);
      for (int i = 0; i < count; i++) {
        double y = d->y[c][first + i];
        double f = hl_term_value(&out->term[0], c, rows.term[0].t[i]);
        if (w->log_domain) {
          const double by = w->divided ? 1 / d->nv[first + i] : 1;
          y = by * w->level * exp(y);
          f = by * exp(f);
        } else {
          y *= w->level;
          f *= rows.term[0].g[i];
        }
        off += fabs(f - y);
        sum += y;
        squares += y * y;
        residual += (f - y) * (f - y);
      }
    }
    data += sum;
    square += squares - sum * sum / d->n;
  }
  out->relative_error = data > 0 ? off / data : 0;
  out->unexplained_variance = square > 0 ? residual / square : 0;
}

void hl_fit_loess(hl_fit_work *w, const hl_ridge_fit *fit, hl_fit *out)
{
  static const double shares[SPANS] = {0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32};
  bins b;
  double best = HUGE_VAL, share = shares[SPANS - 1];
  fill(w, fit, &b);
  for (int k = 0; k < SPANS; k++) {
    const double score = score_of(&b, out->channels, w->all.n, shares[k]);
    if (score < best) {
      best = score;
      share = shares[k];
    }
  }
  set_curve(w, &b, share, out);
  set_errors(w, fit, out);
  hl_notes_add(&out->used, "loess", "span %.3g %% of the samples, by cross-validation",
               100 * share);
}
