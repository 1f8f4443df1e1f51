/*
 * Tails of the chi-squared and the F distribution.
 *
 *   P(chi2_k > t)      = Q(k/2, t/2)                  incomplete gamma function
 *   P(k F(k, n) > t)   = I_x(n/2, k/2), x = n/(n + t) incomplete beta function
 *
 * Series where they converge fast, continued fractions (modified Lentz) elsewhere: Numerical Recipes,
 * 3rd edition, 6.2; DLMF 8.7.1 and 8.9.2; for the beta function Didonato and Morris 1992 (ACM TOMS
 * 18, algorithm 708, BFRAC). The factors before them are taken from Stirling's formula with its
 * remainder
 *
 *   r(a) = ln Gamma(a) - (a - 1/2) ln a + a - ln(2 pi)/2
 *
 * so that nothing large cancels where there are thousands of residuals, and so that lgamma with its
 * global sign is not needed. Good to about 1e-13 of the value.
 */
#include "significance.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

enum { TERMS_MAX = 100000, HALVINGS = 200 };

static const double half_log_2pi = 0.91893853320467274178;
static const double stirling_from = 16; /* the series' next term is below rounding from there */

static double stirling_rest(double a)
{
  if (a < stirling_from)
    return log(tgamma(a)) - (a - 0.5) * log(a) + a - half_log_2pi;
  const double q = 1 / (a * a);
  return (1.0 / 12 - q * (1.0 / 360 - q * (1.0 / 1260 - q * (1.0 / 1680 - q / 1188)))) / a;
}

/* u - ln(1 + u), given 1 + u too, since either may be the one that rounding has spared */
static double excess(double u, double ratio)
{
  if (fabs(u) > 0.1)
    return u - log(ratio);
  double sum = 0, power = u * u;
  for (int n = 2; fabs(power) > DBL_EPSILON * 1e-3 * fabs(sum) && n < 40; n++) {
    sum += power / n;
    power *= -u;
  }
  return sum;
}

/* A continued fraction b0 + a1/(b1 + a2/(b2 + ...)) from the front. */
typedef struct lentz {
  double value, c, d; /* begins with b0, b0, 0 */
} lentz;

static bool lentz_step(lentz *f, double a, double b)
{
  static const double tiny = 1e-300;
  f->d = b + a * f->d;
  f->c = b + a / f->c;
  f->d = 1 / (fabs(f->d) > tiny ? f->d : tiny);
  f->c = fabs(f->c) > tiny ? f->c : tiny;
  const double factor = f->c * f->d;
  f->value *= factor;
  return fabs(factor - 1) > DBL_EPSILON;
}

/* Q(a, x) */
static double gamma_tail(double a, double x)
{
  /* x^a e^-x / Gamma(a + 1) */
  const double front =
      exp(-a * excess((x - a) / a, x / a) - stirling_rest(a) - half_log_2pi - 0.5 * log(a));
  if (x < a + 1) {
    double term = 1, sum = 1;
    for (int n = 1; n < TERMS_MAX && term > DBL_EPSILON * sum; n++) {
      term *= x / (a + n);
      sum += term;
    }
    return 1 - front * sum;
  }
  lentz f = {x + 1 - a, x + 1 - a, 0};
  for (int n = 1; n < TERMS_MAX && lentz_step(&f, -n * (n - a), x + 1 - a + 2 * n); n++)
    ;
  return front * a / f.value;
}

/* I_x(a, b) with y = 1 - x, for x <= a/(a + b). */
static double beta_fraction(double a, double b, double x, double y)
{
  /* x^a y^b / B(a, b); with m = a + b: x = a/m (1 + u), y = b/m (1 + v), a u + b v = 0 */
  const double m = a + b;
  const double over = a > b ? m * y - b : a - m * x; /* = b v = -a u, without cancellation */
  const double front =
      exp(-a * excess(-over / a, x * m / a) - b * excess(over / b, y * m / b) - stirling_rest(a) -
          stirling_rest(b) + stirling_rest(m) - half_log_2pi + 0.5 * log(a / m * b));
  const double first = a * (over + 1) / (a + 1);
  lentz f = {first, first, 0};
  for (int n = 1; n < TERMS_MAX; n++) {
    const double at = a + 2 * n;
    const double numerator =
        (a + n - 1) / (at - 1) * ((m + n - 1) / (at - 1)) * n * (b - n) * x * x;
    const double denominator =
        n + n * (b - n) * x / (at - 1) + (a + n) * (over + 1 + n * (1 + y)) / (at + 1);
    if (!lentz_step(&f, numerator, denominator))
      break;
  }
  return front / f.value;
}

double hl_significance(double t, double dof, double noise_dof)
{
  if (isnan(t) || isnan(dof) || isnan(noise_dof))
    return NAN;
  if (t <= 0 || dof <= 0)
    return 1;
  if (isinf(t))
    return 0;
  if (isinf(noise_dof))
    return gamma_tail(dof / 2, t / 2);
  const double a = noise_dof / 2, b = dof / 2;
  const double x = noise_dof / (noise_dof + t), y = t / (noise_dof + t);
  return x <= a / (a + b) ? beta_fraction(a, b, x, y) : 1 - beta_fraction(b, a, y, x);
}

double hl_significance_limit(double rate, double dof, double noise_dof)
{
  double low = 0, high = dof + 1;
  while (hl_significance(high, dof, noise_dof) > rate && high < 1e300)
    high *= 2;
  for (int i = 0; i < HALVINGS && high - low > DBL_EPSILON * high; i++) {
    const double middle = low + (high - low) / 2;
    if (hl_significance(middle, dof, noise_dof) > rate)
      low = middle;
    else
      high = middle;
  }
  return low + (high - low) / 2;
}
