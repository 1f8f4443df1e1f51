/* Normal equations of a banded block with a border, A = [B C'; C M].
 *
 * A cubic B-spline row touches four neighbouring columns, so B has three off-diagonals and its
 * Cholesky factor too; only the border is dense:
 *   B = Lb Lb',   C = Cl Lb',   M - Cl Cl' = Lc Lc'.
 * Own code rather than LAPACK's: at 45 unknowns a call costs more than the work, and the order of
 * the sums, and so the last bit, must not depend on which BLAS a machine has.
 */
#include "normal_equations.h"

#include <math.h>
#include <string.h>

void hl_normal_clear(hl_normal *a, int n, int m)
{
  memset(a, 0, sizeof *a);
  a->n = n;
  a->m = m;
}

void hl_normal_merge(hl_normal *a, const hl_normal *b)
{
  for (int i = 0; i < a->n; i++) {
    for (int k = 0; k < 4; k++)
      a->band[i][k] += b->band[i][k];
    for (int j = 0; j < a->m; j++)
      a->border[i][j] += b->border[i][j];
  }
  for (int i = 0; i < a->m; i++)
    for (int j = i; j < a->m; j++)
      a->corner[i][j] += b->corner[i][j];
  for (int i = 0; i < a->n + a->m; i++)
    a->rhs[i] += b->rhs[i];
  a->yy += b->yy;
}

void hl_smoothing_from(const hl_normal *a, double smooth, double ridge, hl_smoothing *out)
{
  double trace = 0;
  for (int i = 0; i < a->n; i++)
    trace += a->band[i][0];
  for (int j = 0; j < a->m; j++)
    trace += a->corner[j][j];
  const double mean = (trace > 0 ? trace : 1) / (a->n + a->m);
  for (int i = 0; i + 2 < a->n; i++) {
    const double least = fmin(a->band[i][0], fmin(a->band[i + 1][0], a->band[i + 2][0]));
    out->bend[i] = smooth * least + ridge * mean;
  }
  out->ridge = 1e-3 * ridge * mean;
}

void hl_normal_regularise(hl_normal *a, const hl_smoothing *smoothing)
{
  static const double d[3] = {1, -2, 1};
  for (int i = 0; i + 2 < a->n; i++)
    for (int k = 0; k < 3; k++)
      for (int l = k; l < 3; l++)
        a->band[i + k][l - k] += smoothing->bend[i] * d[k] * d[l];
  for (int i = 0; i < a->n; i++)
    a->band[i][0] += smoothing->ridge;
  for (int j = 0; j < a->m; j++)
    a->corner[j][j] += smoothing->ridge;
}

void hl_normal_drop(hl_normal *a, int j)
{
  for (int i = 0; i < a->n; i++)
    a->border[i][j] = 0;
  for (int i = 0; i < a->m; i++)
    a->corner[i < j ? i : j][i < j ? j : i] = 0;
  a->corner[j][j] = 1;
  a->rhs[a->n + j] = 0;
  a->dropped |= 1u << j;
}

int hl_normal_factorise(const hl_normal *a, hl_normal_factor *f)
{
  const int n = a->n;
  const int m = a->m;
  f->n = n;
  f->m = m;
  f->dropped = a->dropped;
  for (int i = 0; i < n; i++) {
    /* column i: subtract the earlier columns p = i-3 .. i-1 that reach rows i .. i+3 */
    for (int k = 0; k < 4; k++) {
      double sum = i + k < n ? a->band[i][k] : 0;
      for (int p = i > 3 ? i - 3 : 0; p < i; p++)
        if (i + k - p < 4)
          sum -= f->band[p][i - p] * f->band[p][i + k - p];
      f->band[i][k] = sum;
    }
    if (!(f->band[i][0] > 0))
      return -1;
    const double root = sqrt(f->band[i][0]);
    f->band[i][0] = root;
    for (int k = 1; k < 4; k++)
      f->band[i][k] /= root;
    for (int j = 0; j < m; j++) {
      double sum = a->border[i][j];
      for (int p = i > 3 ? i - 3 : 0; p < i; p++)
        sum -= f->band[p][i - p] * f->border[p][j];
      f->border[i][j] = sum / root;
    }
  }
  for (int j = 0; j < m; j++)
    for (int i = j; i < m; i++) {
      double sum = a->corner[j][i];
      for (int p = 0; p < n; p++)
        sum -= f->border[p][i] * f->border[p][j];
      for (int p = 0; p < j; p++)
        sum -= f->corner[i][p] * f->corner[j][p];
      if (i == j) {
        if (!(sum > 0))
          return -1;
        f->corner[j][j] = sqrt(sum);
      } else {
        f->corner[i][j] = sum / f->corner[j][j];
      }
    }
  return 0;
}

void hl_normal_solve(const hl_normal_factor *f, const double *rhs, double *x)
{
  const int n = f->n;
  const int m = f->m;
  for (int i = 0; i < n; i++) {
    double sum = rhs[i];
    for (int p = i > 3 ? i - 3 : 0; p < i; p++)
      sum -= f->band[p][i - p] * x[p];
    x[i] = sum / f->band[i][0];
  }
  for (int j = 0; j < m; j++) {
    double sum = f->dropped >> j & 1 ? 0 : rhs[n + j];
    for (int p = 0; p < n; p++)
      sum -= f->border[p][j] * x[p];
    for (int p = 0; p < j; p++)
      sum -= f->corner[j][p] * x[n + p];
    x[n + j] = sum / f->corner[j][j];
  }
  for (int j = m - 1; j >= 0; j--) {
    double sum = x[n + j];
    for (int p = j + 1; p < m; p++)
      sum -= f->corner[p][j] * x[n + p];
    x[n + j] = sum / f->corner[j][j];
  }
  for (int i = n - 1; i >= 0; i--) {
    double sum = x[i];
    for (int k = 1; k < 4 && i + k < n; k++)
      sum -= f->band[i][k] * x[i + k];
    for (int j = 0; j < m; j++)
      sum -= f->border[i][j] * x[n + j];
    x[i] = sum / f->band[i][0];
  }
}

void hl_normal_times(const hl_normal *a, const double *x, double *out)
{
  const int n = a->n;
  for (int i = 0; i < n + a->m; i++)
    out[i] = 0;
  for (int i = 0; i < n; i++) {
    out[i] += a->band[i][0] * x[i];
    for (int k = 1; k < 4 && i + k < n; k++) {
      out[i] += a->band[i][k] * x[i + k];
      out[i + k] += a->band[i][k] * x[i];
    }
    for (int j = 0; j < a->m; j++) {
      out[i] += a->border[i][j] * x[n + j];
      out[n + j] += a->border[i][j] * x[i];
    }
  }
  for (int i = 0; i < a->m; i++)
    for (int j = i; j < a->m; j++) {
      out[n + i] += a->corner[i][j] * x[n + j];
      if (j > i)
        out[n + j] += a->corner[i][j] * x[n + i];
    }
}

void hl_normal_dense(const hl_normal *a, double *out)
{
  const int total = a->n + a->m;
  memset(out, 0, sizeof *out * (size_t)total * (size_t)total);
  for (int i = 0; i < a->n; i++) {
    for (int k = 0; k < 4 && i + k < a->n; k++)
      out[i * total + i + k] = out[(i + k) * total + i] = a->band[i][k];
    for (int j = 0; j < a->m; j++)
      out[i * total + a->n + j] = out[(a->n + j) * total + i] = a->border[i][j];
  }
  for (int i = 0; i < a->m; i++)
    for (int j = i; j < a->m; j++)
      out[(a->n + i) * total + a->n + j] = out[(a->n + j) * total + a->n + i] = a->corner[i][j];
}
