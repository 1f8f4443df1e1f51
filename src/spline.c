/* Cubic B-splines as piecewise polynomials.
 *
 * Cox-de Boor, carried out on polynomials in x = u - left of each interval:
 *   B_{i,d}(u) = (u - t_i)/(t_{i+d} - t_i) B_{i,d-1}(u)
 *              + (t_{i+d+1} - u)/(t_{i+d+1} - t_{i+1}) B_{i+1,d-1}(u),
 * with the end knots repeated four times, so that the functions sum to one.
 * Evaluation is then four Horner schemes instead of a recursion for every pixel.
 */
#include "spline.h"

#include <assert.h>
#include <string.h>

static void add_times_linear(double out[4], const double p[4], double constant, double slope)
{
  for (int k = 0; k < 4; k++) {
    out[k] += constant * p[k];
    if (k > 0)
      out[k] += slope * p[k - 1];
  }
}

/* Functions j .. j+3 on interval j, whose knots are t[0..7] about it (the interval is t[3], t[4]).
 */
static void interval_polynomials(const double t[8], double poly[4][4])
{
  double b[5][4] = {{0}}; /* function, power; b[4] stays zero */
  b[3][0] = 1;
  for (int d = 1; d <= 3; d++) {
    double next[5][4] = {{0}};
    for (int i = 3 - d; i <= 3; i++) {
      const double rise = t[i + d] - t[i];
      const double fall = t[i + d + 1] - t[i + 1];
      if (i > 3 - d && rise > 0)
        add_times_linear(next[i], b[i], (t[3] - t[i]) / rise, 1 / rise);
      if (i < 3 && fall > 0)
        add_times_linear(next[i], b[i + 1], (t[i + d + 1] - t[3]) / fall, -1 / fall);
    }
    memcpy(b, next, sizeof b);
  }
  for (int power = 0; power < 4; power++)
    for (int k = 0; k < 4; k++)
      poly[power][k] = b[k][power];
}

void hl_spline_init(hl_spline *spline, const double *breaks, int n_breaks)
{
  assert(n_breaks >= 2 && n_breaks + 2 <= HL_SPLINE_MAX);
  spline->intervals = n_breaks - 1;
  spline->n = n_breaks + 2;
  spline->low = breaks[0];
  spline->high = breaks[n_breaks - 1];
  for (int i = 0; i < spline->intervals; i++) {
    double t[8];
    for (int k = 0; k < 8; k++) {
      int at = i + k - 3;
      at = at < 0 ? 0 : at > n_breaks - 1 ? n_breaks - 1 : at;
      t[k] = breaks[at];
    }
    spline->left[i] = breaks[i];
    interval_polynomials(t, spline->poly[i]);
  }
  spline->bins_per_unit = HL_SPLINE_BINS / (spline->high - spline->low);
  for (int b = 0, i = 0; b < HL_SPLINE_BINS; b++) {
    const double u = spline->low + b / spline->bins_per_unit;
    while (i + 1 < spline->intervals && spline->left[i + 1] <= u)
      i++;
    spline->bin[b] = (unsigned char)i;
  }
}

int hl_spline_thin(const double *candidate, const int *samples, int intervals, int least,
                   double *out)
{
  const double last = candidate[intervals];
  int left = 0, n = 1, held = 0;
  for (int j = 0; j < intervals; j++)
    left += samples[j];
  out[0] = candidate[0];
  for (int j = 0; j < intervals - 1; j++) {
    held += samples[j];
    left -= samples[j];
    if (held >= least && left >= least) {
      out[n++] = candidate[j + 1];
      held = 0;
    }
  }
  out[n++] = last;
  return n;
}
