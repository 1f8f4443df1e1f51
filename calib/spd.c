/*
 * Small symmetric positive definite matrices.
 *
 * Intrinsics mix pixels with k3 and differ by ten orders of magnitude, so a matrix is scaled to a
 * unit diagonal first: R = D A D, D = diag(A)^-1/2, R = L L'. Then a pivot of L is the share of a
 * column that the columns before it do not explain, and one below `singular` is rounding alone.
 *
 * Own code rather than LAPACK's: at 6 and 12 unknowns a call costs more than the work, and the
 * order of the sums, and so the last bit, must not depend on which BLAS a machine has.
 */
#include "spd.h"

#include <math.h>

static const double singular = 1e-13; /* of a pivot, whose rounding is n times 1e-16 */

bool hl_spd_factor(const double *matrix, int n, double damping, hl_spd *out, int *weakest)
{
  out->n = n;
  for (int i = 0; i < n; i++) {
    const double diagonal = matrix[i * n + i];
    const bool good = diagonal > 0 && isfinite(diagonal);
    if (weakest)
      *weakest = i;
    if (!good)
      return false;
    out->scale[i] = 1 / sqrt(diagonal);
  }
  for (int i = 0; i < n; i++)
    for (int k = 0; k <= i; k++) {
      double sum = i == k ? 1 + damping : matrix[i * n + k] * out->scale[i] * out->scale[k];
      for (int j = 0; j < k; j++)
        sum -= out->l[i * n + j] * out->l[k * n + j];
      if (k < i) {
        out->l[i * n + k] = sum / out->l[k * n + k];
        continue;
      }
      if (weakest)
        *weakest = i;
      if (!(sum > singular))
        return false;
      out->l[i * n + i] = sqrt(sum);
    }
  return true;
}

/* y = L'^-1 L^-1 y */
static void back_and_forth(const hl_spd *f, double *y)
{
  const int n = f->n;
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < i; j++)
      y[i] -= f->l[i * n + j] * y[j];
    y[i] /= f->l[i * n + i];
  }
  for (int i = n - 1; i >= 0; i--) {
    for (int j = i + 1; j < n; j++)
      y[i] -= f->l[j * n + i] * y[j];
    y[i] /= f->l[i * n + i];
  }
}

void hl_spd_solve(const hl_spd *factor, const double *b, double *x)
{
  for (int i = 0; i < factor->n; i++)
    x[i] = factor->scale[i] * b[i];
  back_and_forth(factor, x);
  for (int i = 0; i < factor->n; i++)
    x[i] *= factor->scale[i];
}

/* Column k of R^-1. */
static void scaled_column(const hl_spd *f, int k, double y[HL_SPD_MAX])
{
  for (int i = 0; i < f->n; i++)
    y[i] = i == k;
  back_and_forth(f, y);
}

void hl_spd_inverse(const hl_spd *factor, double *out)
{
  const int n = factor->n;
  double y[HL_SPD_MAX];
  for (int k = 0; k < n; k++) {
    scaled_column(factor, k, y);
    for (int i = k; i < n; i++)
      out[i * n + k] = out[k * n + i] = factor->scale[i] * factor->scale[k] * y[i];
  }
}

double hl_spd_condition(const double *matrix, const hl_spd *factor, int *weakest, double *own)
{
  const int n = factor->n;
  double norm = 0, inverse_norm = 0, inflation = 0, y[HL_SPD_MAX];
  for (int k = 0; k < n; k++) {
    double sum = 0, inverse_sum = 0;
    scaled_column(factor, k, y);
    for (int i = 0; i < n; i++) {
      sum += fabs(matrix[i * n + k]) * factor->scale[i] * factor->scale[k];
      inverse_sum += fabs(y[i]);
    }
    norm = fmax(norm, sum);
    inverse_norm = fmax(inverse_norm, inverse_sum);
    if (y[k] > inflation) {
      inflation = y[k];
      if (weakest)
        *weakest = k;
    }
  }
  if (own)
    *own = 1 / inflation;
  return norm * inverse_norm;
}
