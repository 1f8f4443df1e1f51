/* Curves of a sum of ridges from its normal equations.
 *
 * Eq. 17, with the integral in the discrete form of Eilers and Marx (1996): differences of the
 * coefficients instead of s''. They are taken against t, so that what is straight in t = a.n (Lambert)
 * costs nothing: with tau the coefficients of u^2 = 2 - 2t,
 *   D_j c = 2 [h1 (c_{j+2} - c_{j+1}) - h2 (c_{j+1} - c_j)] / (h1 + h2),  h1 = tau_{j+1} - tau_j, ...
 * Differs: breaks are dense at the highlight and each difference counts the same there, which is a
 * lambda that falls towards the highlight; one lambda for all of a curve would round off a sharp one.
 *
 * Constraints (L1-L4). Fritsch and Carlson's conditions for a cubic on an interval, in Bezier form: it
 * is monotone where its control points are. A spline's control points lie in order where its
 * coefficients do, so with
 *   c_j = sum_{i >= j} d_i,  d >= 0,  c_{n-1} = 0
 * every interval meets them, and the curve is non-negative and zero at t = 0. Wolberg and Alfy's
 * penalty on jumps of the second derivative is infinite here: knots are simple, there are none.
 * That is non-negative least squares in the normal equations.
 */
#include "ridge_curves.h"

#include <math.h>
#include <string.h>

#include "cholesky.h"
#include "nnls.h"

enum { PIVOT_ROUNDS = 4 };
static const double pivot_floor = 1e-12;
static const double least_smooth = 1e-15, most_smooth = 10, smooth_step = 10;

/* ---- roughness ---- */

/* Coefficient j of u^2: the mean product of two of its three inner knots. */
static double square_coefficient(const hl_spline *s, int j)
{
  double knot[3];
  for (int k = 0; k < 3; k++) {
    const int at = j + k - 2;
    knot[k] = at <= 0 ? s->low : at >= s->intervals ? s->high : s->left[at];
  }
  return (knot[0] * knot[1] + knot[0] * knot[2] + knot[1] * knot[2]) / 3;
}

static void difference(const hl_spline *s, int j, double d[3])
{
  const double tau = square_coefficient(s, j + 1);
  const double h1 = tau - square_coefficient(s, j), h2 = square_coefficient(s, j + 2) - tau;
  d[0] = 2 * h2 / (h1 + h2);
  d[2] = 2 * h1 / (h1 + h2);
  d[1] = -d[0] - d[2];
}

void hl_roughness_from(const hl_ridges *ridges, const hl_gram *gram, hl_roughness *out)
{
  const long n = gram->n;
  double all = 0;
  for (int i = 0; i < ridges->n; i++) {
    const int first = hl_ridges_first(ridges, i);
    const int count = ridges->linear[i] ? 1 : ridges->spline[i]->n;
    double trace = 0;
    for (int k = 0; k < count; k++)
      trace += gram->a[(first + k) * n + first + k];
    all += trace;
    out->weight[i] = ridges->smooth[i] * trace / count;
  }
  out->ridge = 1e-14 * all / (double)n;
}

static void add_roughness(const hl_ridges *ridges, const hl_roughness *r, double *a, int n)
{
  for (int i = 0; i < ridges->n; i++) {
    const int first = hl_ridges_first(ridges, i);
    if (ridges->linear[i])
      continue;
    for (int j = 0; j + 2 < ridges->spline[i]->n; j++) {
      double d[3];
      difference(ridges->spline[i], j, d);
      for (int k = 0; k < 3; k++)
        for (int l = k; l < 3; l++)
          a[(long)(first + j + k) * n + first + j + l] += r->weight[i] * d[k] * d[l];
    }
  }
  for (int i = 0; i < n; i++)
    a[(long)i * n + i] += r->ridge;
}

static double roughness_of(const hl_ridges *ridges, const hl_roughness *r, const double *x, int n)
{
  double sum = 0;
  for (int i = 0; i < ridges->n; i++) {
    const double *c = x + hl_ridges_first(ridges, i);
    for (int j = 0; !ridges->linear[i] && j + 2 < ridges->spline[i]->n; j++) {
      double d[3];
      difference(ridges->spline[i], j, d);
      const double bend = d[0] * c[j] + d[1] * c[j + 1] + d[2] * c[j + 2];
      sum += r->weight[i] * bend * bend;
    }
  }
  for (int i = 0; i < n; i++)
    sum += r->ridge * x[i] * x[i];
  return sum;
}

/* ---- unknowns ---- */

/* A term's columns and the unknowns behind them. */
typedef struct span {
  int column, columns, unknown, unknowns;
  bool stacked; /* c is the sum of the d from j on */
} span;

static int spans_of(const hl_ridges *ridges, span out[HL_TERMS_MAX + 1], bool signs[HL_GRAM_MAX])
{
  int column = 0, unknown = 0, n = 0;
  for (int i = 0; i < ridges->n; i++) {
    span *s = &out[n++];
    s->column = column;
    s->unknown = unknown;
    s->columns = ridges->linear[i] ? 1 : ridges->spline[i]->n;
    s->stacked = !ridges->linear[i] && !ridges->free_curves;
    s->unknowns = s->columns - (s->stacked ? 1 : 0);
    for (int k = 0; k < s->unknowns; k++)
      signs[unknown + k] = ridges->free_curves;
    column += s->columns;
    unknown += s->unknowns;
  }
  if (ridges->has_constant) {
    out[n++] = (span){column, 1, unknown, 1, false};
    signs[unknown] = true;
  }
  return n;
}

static int unknowns_of(const span *s, int n)
{
  return s[n - 1].unknown + s[n - 1].unknowns;
}

/* out = T' in, of a vector over the columns. */
static void contract(const span *s, int n, const double *in, double *out)
{
  for (int i = 0; i < n; i++) {
    double sum = 0;
    for (int k = 0; k < s[i].unknowns; k++) {
      const double value = in[s[i].column + k];
      sum = s[i].stacked ? sum + value : value;
      out[s[i].unknown + k] = sum;
    }
  }
}

/* x = T d */
static void expand(const span *s, int n, const double *d, double *x)
{
  for (int i = 0; i < n; i++) {
    double sum = 0;
    if (s[i].stacked)
      x[s[i].column + s[i].columns - 1] = 0;
    for (int k = s[i].unknowns - 1; k >= 0; k--) {
      const double value = d[s[i].unknown + k];
      sum = s[i].stacked ? sum + value : value;
      x[s[i].column + k] = sum;
    }
  }
}

/* out (m x m) = T' A T of the upper triangle a (p x p); half: p x m. */
static void contract_matrix(const span *s, int n, double *a, int p, int m, double *half,
                            double *out)
{
  for (int i = 0; i < p; i++)
    for (int j = 0; j < i; j++)
      a[(long)i * p + j] = a[(long)j * p + i];
  for (int i = 0; i < p; i++)
    contract(s, n, a + (long)i * p, half + (long)i * m);
  for (int i = 0; i < n; i++)
    for (int k = 0; k < s[i].unknowns; k++) {
      const double *row = half + (long)(s[i].column + k) * m;
      double *to = out + (long)(s[i].unknown + k) * m;
      const double *before = s[i].stacked && k > 0 ? to - m : NULL;
      for (int j = 0; j < m; j++)
        to[j] = before ? before[j] + row[j] : row[j];
    }
}

/* ---- solving ---- */

void hl_curves_forget(hl_curves *curves)
{
  memset(curves, 0, sizeof *curves);
}

/* Nothing is free yet: hold what the unconstrained answer makes negative, a few times over. */
static void guess(const double *a, const double *b, int m, const bool *signs, double *factor,
                  bool *is_free, double *d)
{
  int index[HL_GRAM_MAX];
  double y[HL_GRAM_MAX];
  for (int i = 0; i < m; i++)
    is_free[i] = a[(long)i * m + i] > 0;
  for (int round = 0; round < PIVOT_ROUNDS; round++) {
    int k = 0;
    bool negative = false;
    for (int i = 0; i < m; i++)
      if (is_free[i])
        index[k++] = i;
    for (int i = 0; i < k; i++) {
      for (int j = i; j < k; j++)
        factor[(long)i * m + j] = a[(long)index[i] * m + index[j]];
      y[i] = b[index[i]];
    }
    hl_cholesky(factor, k, m, pivot_floor);
    hl_cholesky_solve(factor, k, m, y);
    memset(d, 0, (size_t)m * sizeof *d);
    for (int i = 0; i < k; i++) {
      if (!(y[i] > 0) && !signs[index[i]]) {
        is_free[index[i]] = false;
        negative = true;
      } else {
        d[index[i]] = y[i];
      }
    }
    if (!negative)
      break;
  }
}

static bool knows_nothing(const bool *is_free, int m)
{
  for (int i = 0; i < m; i++)
    if (is_free[i])
      return false;
  return true;
}

void hl_curves_solve(const hl_ridges *ridges, const hl_gram *gram, const hl_roughness *roughness,
                     hl_curves_work *work, hl_curves *curves)
{
  span s[HL_TERMS_MAX + 1] = {{0}};
  bool signs[HL_GRAM_MAX] = {false};
  const int n = spans_of(ridges, s, signs);
  const int p = gram->n, m = unknowns_of(s, n);
  double *a = work->factor[0]; /* not needed before the solves */
  memcpy(a, gram->a, (size_t)p * (size_t)p * sizeof *a);
  add_roughness(ridges, roughness, a, p);
  contract_matrix(s, n, a, p, m, work->half, work->system);
  curves->cost = curves->misfit = 0;
  for (int c = 0; c < gram->channels; c++) {
    double b[HL_GRAM_MAX] = {0};
    contract(s, n, gram->b[c], b);
    if (knows_nothing(curves->is_free[c], m))
      guess(work->system, b, m, signs, work->factor[c], curves->is_free[c], curves->d[c]);
    (void)hl_nnls_from(work->system, b, m, signs, curves->is_free[c], curves->d[c],
                       work->factor[c]);
    expand(s, n, curves->d[c], curves->x[c]);
    curves->misfit += hl_gram_cost(gram, c, curves->x[c]);
    curves->cost += roughness_of(ridges, roughness, curves->x[c], p);
  }
  curves->cost += curves->misfit;
}

double hl_curves_misfit(const hl_gram *gram, const hl_curves *curves)
{
  double sum = 0;
  for (int c = 0; c < gram->channels; c++)
    sum += hl_gram_cost(gram, c, curves->x[c]);
  return sum;
}

void hl_curves_profile(const hl_ridges *ridges, const hl_curves *curves, const hl_curves_work *work,
                       int channels, const hl_ridge_slopes *slopes,
                       double hessian[HL_AXES_MAX][HL_AXES_MAX])
{
  span s[HL_TERMS_MAX + 1] = {{0}};
  bool signs[HL_GRAM_MAX];
  const int n = spans_of(ridges, s, signs);
  const int m = unknowns_of(s, n), q = slopes->q;
  for (int k = 0; k < q; k++)
    for (int l = 0; l < q; l++)
      hessian[k][l] = slopes->inner[k][l];
  for (int c = 0; c < channels; c++) {
    double free_part[HL_AXES_MAX][HL_GRAM_MAX], solved[HL_GRAM_MAX];
    int count = 0;
    for (int k = 0; k < q; k++) {
      double all[HL_GRAM_MAX] = {0};
      contract(s, n, slopes->cross[c][k], all);
      count = 0;
      for (int i = 0; i < m; i++)
        if (curves->is_free[c][i])
          free_part[k][count++] = all[i];
    }
    for (int k = 0; k < q; k++) {
      memcpy(solved, free_part[k], (size_t)count * sizeof *solved);
      hl_cholesky_solve(work->factor[c], count, m, solved);
      for (int l = 0; l < q; l++)
        for (int i = 0; i < count; i++)
          hessian[k][l] -= solved[i] * free_part[l][i];
    }
  }
}

/* ---- smoothing ---- */

/* Trace of the smoother, of A (A + R)^-1 over the k free unknowns of a channel: as R = sum of w dd' that
 * is k less the w d'(A + R)^-1 d. */
static double degrees_of_freedom(const hl_ridges *ridges, const hl_roughness *r, int c,
                                 const hl_curves_work *work, const hl_curves *curves)
{
  span s[HL_TERMS_MAX + 1] = {{0}};
  bool signs[HL_GRAM_MAX];
  const int n = spans_of(ridges, s, signs), m = unknowns_of(s, n);
  double freedom = 0;
  for (int i = 0; i < m; i++)
    freedom += curves->is_free[c][i];
  for (int i = 0; i < ridges->n; i++)
    for (int j = 0; !ridges->linear[i] && j + 2 < ridges->spline[i]->n; j++) {
      double column[HL_GRAM_MAX] = {0}, all[HL_GRAM_MAX] = {0}, part[HL_GRAM_MAX];
      int k = 0;
      difference(ridges->spline[i], j, column + s[i].column + j);
      contract(s, n, column, all);
      for (int l = 0; l < m; l++)
        if (curves->is_free[c][l])
          part[k++] = all[l];
      hl_cholesky_forward(work->factor[c], k, m, part);
      for (int l = 0; l < k; l++)
        freedom -= r->weight[i] * part[l] * part[l];
    }
  return freedom;
}

static double gcv_score(hl_ridges *ridges, const hl_gram *gram, double samples, double smooth,
                        hl_curves_work *work, hl_curves *curves)
{
  hl_roughness roughness;
  for (int i = 0; i < ridges->n; i++)
    ridges->smooth[i] = smooth;
  hl_roughness_from(ridges, gram, &roughness);
  hl_curves_solve(ridges, gram, &roughness, work, curves);
  /* channels smooth alike but for what is held: one stands for all */
  const double left = 1 - degrees_of_freedom(ridges, &roughness, 0, work, curves) / samples;
  return left > 0 ? curves->misfit / (left * left) : HUGE_VAL;
}

void hl_curves_smooth(hl_ridges *ridges, const hl_gram *gram, double samples, hl_curves_work *work,
                      hl_curves *curves)
{
  double at = ridges->smooth[0] > 0 ? ridges->smooth[0] : 1e-6;
  double best = gcv_score(ridges, gram, samples, at, work, curves);
  bool moved = false;
  for (int way = 0; way < 2 && !moved; way++)
    for (;;) {
      const double next = way == 0 ? at / smooth_step : at * smooth_step;
      if (!(next >= least_smooth && next <= most_smooth))
        break;
      const double score = gcv_score(ridges, gram, samples, next, work, curves);
      if (!(score < best * (1 - 1e-4)))
        break;
      best = score;
      at = next;
      moved = true;
    }
  for (int i = 0; i < ridges->n; i++)
    ridges->smooth[i] = at;
}
