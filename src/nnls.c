/* Lawson and Hanson's active set method on normal equations.
 *
 * Unknowns are either free (passive set P) or held at zero. While some held unknown would lower the
 * cost (gradient w = b - Ax > 0) the best of them is freed, the free ones are solved for together,
 * and those that turned negative on the way are held again at the point where they reach zero.
 * C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, 1974, chapter 23.
 */
#include "nnls.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

static const double ridge = 1e-12;

/* Solve for the free unknowns alone. */
static void solve_free(const double *a, const double *b, int n, const bool *is_free, double *z)
{
  double l[HL_NNLS_MAX][HL_NNLS_MAX];
  int index[HL_NNLS_MAX], k = 0;
  for (int i = 0; i < n; i++) {
    z[i] = 0;
    if (is_free[i])
      index[k++] = i;
  }
  double y[HL_NNLS_MAX];
  for (int i = 0; i < k; i++) {
    const double *row = a + (long)index[i] * n;
    for (int j = 0; j <= i; j++) {
      double sum = row[index[j]];
      for (int p = 0; p < j; p++)
        sum -= l[i][p] * l[j][p];
      if (i == j)
        l[i][i] = sqrt(fmax(sum, ridge * row[index[i]] + 1e-300));
      else
        l[i][j] = sum / l[j][j];
    }
    double sum = b[index[i]];
    for (int p = 0; p < i; p++)
      sum -= l[i][p] * y[p];
    y[i] = sum / l[i][i];
  }
  for (int i = k - 1; i >= 0; i--) {
    double sum = y[i];
    for (int p = i + 1; p < k; p++)
      sum -= l[p][i] * z[index[p]];
    z[index[i]] = sum / l[i][i];
  }
}

/* The held unknown whose release lowers the cost most for its scale; -1: none. */
static int most_wanted(const double *a, const double *b, int n, const bool *is_free,
                       const bool *refused, const double *x)
{
  int best = -1;
  double most = 0;
  for (int i = 0; i < n; i++) {
    const double diagonal = a[(long)i * n + i];
    if (is_free[i] || refused[i] || !(diagonal > 0))
      continue;
    double w = b[i];
    for (int j = 0; j < n; j++)
      w -= a[(long)i * n + j] * x[j];
    w /= sqrt(diagonal);
    if (w > most && w > 1e-10 * fabs(b[i]) / sqrt(diagonal)) {
      most = w;
      best = i;
    }
  }
  return best;
}

int hl_nnls(const double *a, const double *b, int n, double *x)
{
  bool is_free[HL_NNLS_MAX] = {false}, refused[HL_NNLS_MAX] = {false};
  double z[HL_NNLS_MAX];
  memset(x, 0, sizeof *x * (size_t)n);
  for (int round = 0; round < 3 * n + 8; round++) {
    const int next = most_wanted(a, b, n, is_free, refused, x);
    if (next < 0)
      return 0;
    is_free[next] = true;
    for (int inner = 0; inner <= n; inner++) {
      solve_free(a, b, n, is_free, z);
      double step = 1;
      int stop = -1;
      for (int i = 0; i < n; i++)
        if (is_free[i] && z[i] <= 0) {
          const double t = x[i] / (x[i] - z[i]);
          if (!(t >= step)) {
            step = t >= 0 ? t : 0;
            stop = i;
          }
        }
      for (int i = 0; i < n; i++)
        x[i] += step * (z[i] - x[i]);
      if (stop < 0)
        break;
      for (int i = 0; i < n; i++)
        if (is_free[i] && (i == stop || x[i] <= 0)) {
          x[i] = 0;
          is_free[i] = false;
          refused[i] = i == next; /* rounding alone wanted it: not again in this round */
        }
    }
    if (is_free[next])
      memset(refused, 0, sizeof refused);
  }
  return -1;
}
