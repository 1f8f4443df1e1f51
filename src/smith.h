/* Smith's shadowing and masking of a rough surface, as one curve of a cosine:
 *
 *   G(x) = 2x / (x + sqrt(r^2 + (1 - r^2) x^2)),   r = 0.1,   M = G(n.s) G(n.v)
 *
 * It bites near the shadow's edge and the limb alone; the model raises M to a power it fits. */
#ifndef HL_SMITH_H
#define HL_SMITH_H

#include <math.h>

static const double hl_smith_width = 0.1;         /* r */
static const double hl_smith_least_cosine = 0.01; /* of n.s: below it G stays */

/* Log of G at cosine x > 0, and its slope. */
static inline double hl_smith_log(double x, double *slope)
{
  const double r2 = hl_smith_width * hl_smith_width;
  const double root = sqrt(r2 + (1 - r2) * x * x);
  *slope = 1 / x - (1 + x * (1 - r2) / root) / (x + root);
  return log(2 * x / (x + root));
}

#endif
