/*
 * Whether a small matrix can be a covariance.
 *
 * Scaled to a unit diagonal first, since intrinsics mix pixels with k3 and differ by ten orders of
 * magnitude; then Cholesky of the correlation matrix plus a small multiple of the identity, which
 * exists exactly where no eigenvalue is below minus that multiple.
 */
#include "psd.h"

#include <math.h>

#include "halflight/camera.h"

#define TOLERANCE 1e-6

static bool scale(const double *matrix, int n, double *correlation)
{
  double s[HL_INTRINSICS_MAX];
  for (int i = 0; i < n; i++) {
    const double variance = matrix[i * n + i];
    if (!(variance >= 0 && isfinite(variance)))
      return false;
    s[i] = sqrt(variance);
  }
  for (int i = 0; i < n; i++)
    for (int k = 0; k < n; k++) {
      const double a = matrix[i * n + k];
      const double unit = s[i] * s[k];
      if (!(fabs(a - matrix[k * n + i]) <= TOLERANCE * unit) || !(fabs(a) <= 2 * unit))
        return false;
      correlation[i * n + k] = unit > 0 ? a / unit : 0;
    }
  return true;
}

bool hl_psd_check(const double *matrix, int n)
{
  double a[HL_INTRINSICS_MAX * HL_INTRINSICS_MAX];
  if (n < 1 || n > HL_INTRINSICS_MAX || !scale(matrix, n, a))
    return false;
  for (int i = 0; i < n; i++) {
    a[i * n + i] += TOLERANCE;
    for (int k = 0; k <= i; k++) {
      double sum = a[i * n + k];
      for (int j = 0; j < k; j++)
        sum -= a[i * n + j] * a[k * n + j];
      if (k < i)
        a[i * n + k] = sum / a[k * n + k];
      else if (!(sum > 0))
        return false;
      else
        a[i * n + i] = sqrt(sum);
    }
  }
  return true;
}
