/* Cholesky's factor of a small dense matrix.
 *
 * Row after row is taken off the rows below it: the inner loop runs along a row, which a compiler can
 * make vectors of, and every element still loses its products in the order p = 0, 1, ..., so that the
 * bits are those of the textbook's sums.
 * Own code rather than LAPACK's, as normal_equations.c says.
 */
#include "cholesky.h"

#include <math.h>

static const double tiny = 1e-300;

int hl_cholesky(double *u, int n, int stride, double floor)
{
  int raised = 0;
  double least[256]; /* HL_GRAM_MAX and HL_NNLS_MAX are smaller */
  for (int i = 0; i < n; i++)
    least[i] = floor * u[(long)i * stride + i] + tiny;
  for (int j = 0; j < n; j++) {
    double *row = u + (long)j * stride;
    if (!(row[j] >= least[j])) {
      row[j] = least[j];
      raised++;
    }
    row[j] = sqrt(row[j]);
    for (int k = j + 1; k < n; k++)
      row[k] /= row[j];
    for (int i = j + 1; i < n; i++) {
      double *below = u + (long)i * stride;
      const double factor = row[i];
      for (int k = i; k < n; k++)
        below[k] -= factor * row[k];
    }
  }
  return raised;
}

void hl_cholesky_forward(const double *u, int n, int stride, double *x)
{
  for (int p = 0; p < n; p++) {
    const double *row = u + (long)p * stride;
    const double value = x[p] /= row[p];
    for (int i = p + 1; i < n; i++)
      x[i] -= row[i] * value;
  }
}

void hl_cholesky_solve(const double *u, int n, int stride, double *x)
{
  hl_cholesky_forward(u, n, stride, x);
  for (int i = n - 1; i >= 0; i--) {
    const double *row = u + (long)i * stride;
    double sum = x[i];
    for (int p = i + 1; p < n; p++)
      sum -= row[p] * x[p];
    x[i] = sum / row[i];
  }
}
