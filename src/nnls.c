/* Lawson and Hanson's active set method on normal equations.
 *
 * Unknowns are either free (passive set P) or held at zero. While some held unknown would lower the
 * cost (gradient w = b - Ax > 0) the best of them is freed, the free ones are solved for together,
 * and those that turned negative on the way are held again at the point where they reach zero.
 * C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, 1974, chapter 23.
 */
#include "nnls.h"

#include <math.h>
#include <string.h>

#include "cholesky.h"

static const double ridge = 1e-12;

/* Solve for the free unknowns alone; returns how many they are. */
static int solve_free(const double *a, const double *b, int n, const bool *is_free, double *z,
                      double *u)
{
  int index[HL_NNLS_LARGEST], k = 0;
  double y[HL_NNLS_LARGEST];
  for (int i = 0; i < n; i++) {
    z[i] = 0;
    if (is_free[i])
      index[k++] = i;
  }
  for (int j = 0; j < k; j++) {
    const double *row = a + (long)index[j] * n;
    for (int i = 0; i <= j; i++)
      u[(long)i * n + j] = row[index[i]];
    y[j] = b[index[j]];
  }
  hl_cholesky(u, k, n, ridge);
  hl_cholesky_solve(u, k, n, y);
  for (int i = 0; i < k; i++)
    z[index[i]] = y[i];
  return k;
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

static bool is_bound(const bool *signs, int i)
{
  return !signs || !signs[i];
}

/* Solve for the free unknowns, holding those that turn negative on the way from x. */
static void settle_free(const double *a, const double *b, int n, const bool *signs, bool *is_free,
                        bool *refused, int next, double *x, double *u)
{
  double z[HL_NNLS_LARGEST];
  for (int inner = 0; inner <= n; inner++) {
    solve_free(a, b, n, is_free, z, u);
    double step = 1;
    int stop = -1;
    for (int i = 0; i < n; i++)
      if (is_free[i] && is_bound(signs, i) && z[i] <= 0) {
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
      if (is_free[i] && is_bound(signs, i) && (i == stop || x[i] <= 0)) {
        x[i] = 0;
        is_free[i] = false;
        refused[i] = i == next; /* rounding alone wanted it: not again in this round */
      }
  }
}

int hl_nnls_from(const double *a, const double *b, int n, const bool *signs, bool *is_free,
                 double *x, double *work)
{
  bool refused[HL_NNLS_LARGEST] = {false};
  bool any = false;
  for (int i = 0; i < n; i++) {
    is_free[i] = is_free[i] || !is_bound(signs, i);
    any = any || is_free[i];
  }
  if (any)
    settle_free(a, b, n, signs, is_free, refused, -1, x, work);
  memset(refused, 0, sizeof refused);
  for (int round = 0; round < 3 * n + 8; round++) {
    const int next = most_wanted(a, b, n, is_free, refused, x);
    if (next < 0)
      return 0;
    is_free[next] = true;
    settle_free(a, b, n, signs, is_free, refused, next, x, work);
    if (is_free[next])
      memset(refused, 0, sizeof refused);
  }
  return -1;
}

int hl_nnls(const double *a, const double *b, int n, double *x)
{
  bool is_free[HL_NNLS_MAX] = {false};
  double work[HL_NNLS_MAX * HL_NNLS_MAX];
  memset(x, 0, sizeof *x * (size_t)n);
  return hl_nnls_from(a, b, n, NULL, is_free, x, work);
}
