/*
 * How sharp an edge is: the profile across it, averaged along it, passes a quarter and three
 * quarters of the step 1.349 standard deviations apart if it was blurred by a Gaussian. A pixel's
 * own width and reading between pixels add 1/12 and, on average, 1/6 of a pixel squared; the second
 * is taken off again.
 */
#include "edge_blur.h"

#include <math.h>
#include <stdbool.h>

enum { ALONG = 16, STEPS = 48, SIDES = 2 * STEPS + 1, ENDS = STEPS / 4 };

static const double quarters = 1.3489795; /* between the quarters of a normal distribution */
static const double interpolation = 1.0 / 6;
static const double clear = 0.1; /* least step, of the level */

/* Where the profile passes `level`, looked for from `from` in steps of `step`; NAN where it does
 * not. */
static double passes(const double *profile, double level, int from, int step)
{
  for (int i = from; i + step >= 0 && i + step < SIDES; i += step) {
    const double p = profile[i] - level;
    const double q = profile[i + step] - level;
    if (p * q <= 0 && p != q)
      return i + step * p / (p - q);
  }
  return NAN;
}

static void read_profile(const hl_grey *grey, const double a[2], const double b[2], double reach,
                         double profile[SIDES])
{
  const double length = hypot(b[0] - a[0], b[1] - a[1]);
  const double normal[2] = {-(b[1] - a[1]) / length, (b[0] - a[0]) / length};
  for (int i = 0; i < SIDES; i++) {
    const double away = reach * (i - STEPS) / STEPS;
    double sum = 0;
    for (int k = 0; k < ALONG; k++) {
      const double t = 0.25 + 0.5 * (k + 0.5) / ALONG;
      sum += hl_grey_at(grey, a[0] + t * (b[0] - a[0]) + away * normal[0],
                        a[1] + t * (b[1] - a[1]) + away * normal[1]);
    }
    profile[i] = sum / ALONG;
  }
}

double hl_edge_blur(const hl_grey *grey, const double a[2], const double b[2], double reach)
{
  double profile[SIDES];
  double low = 0;
  double high = 0;
  if (!(hypot(b[0] - a[0], b[1] - a[1]) > 2) || !(reach >= 1))
    return NAN;
  read_profile(grey, a, b, reach, profile);
  for (int i = 0; i < ENDS; i++) {
    low += profile[i] / ENDS;
    high += profile[SIDES - 1 - i] / ENDS;
  }
  const double step = high - low;
  if (!(fabs(step) > clear * fmax(fabs(low), fabs(high))))
    return NAN;
  /* from the middle outwards, since beyond the step other edges may follow */
  const double middle = passes(profile, low + step / 2, STEPS, 1);
  const double before = passes(profile, low + step / 2, STEPS, -1);
  const double at = isnan(middle) || (STEPS - before < middle - STEPS) ? before : middle;
  if (isnan(at))
    return NAN;
  const double quarter = passes(profile, low + step / 4, (int)ceil(at), -1);
  const double three = passes(profile, low + 3 * step / 4, (int)floor(at), 1);
  const double width = (three - quarter) * reach / STEPS / quarters;
  return isnan(width) ? NAN : sqrt(fmax(width * width - interpolation, 0));
}
