/*
 * Lens models.
 *
 * Pinhole with Brown-Conrady distortion, q = r^2 = x^2 + y^2, g = 1 + k1 q + k2 q^2 + k3 q^3:
 *
 *   u = x g + 2 p1 x y + p2 (q + 2 x^2)
 *   v = y g + p1 (q + 2 y^2) + 2 p2 x y
 *
 * Rational: the same with g = (1 + k1 q + k2 q^2 + k3 q^3) / (1 + k4 q + k5 q^2 + k6 q^3).
 *
 * Fisheye (Kannala and Brandt 2006, as OpenCV has it), theta = atan r:
 *
 *   (u, v) = (x, y) theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8) / r
 *
 * A polynomial is a lens only around its centre: where the determinant of d(u,v)/d(x,y) reaches
 * zero the image folds back, and beyond it the same image point belongs to several directions. The
 * inverse is Newton's, damped twice: a step is halved while it crosses a fold or while the residual
 * does not fall. So it stays on the side of the centre.
 */
#include "lens.h"

#include <float.h>
#include <math.h>

#include "halflight/lens_names.h"

enum { STEPS_MAX = 60, HALVINGS_MAX = 40, SHRINKS_MAX = 20 };

/* Radial factor at q = r^2 and its derivative by q. */
typedef struct radial {
  double g, dg;
} radial;

/* (u, v) = (x, y) g(q) + decentring by p1, p2 */
static void bend(radial f, double p1, double p2, const double at[2], double out[2],
                 double jacobian[2][2])
{
  const double x = at[0], y = at[1];
  const double q = x * x + y * y;
  out[0] = x * f.g + 2 * p1 * x * y + p2 * (q + 2 * x * x);
  out[1] = y * f.g + p1 * (q + 2 * y * y) + 2 * p2 * x * y;
  jacobian[0][0] = f.g + 2 * x * x * f.dg + 2 * p1 * y + 6 * p2 * x;
  jacobian[0][1] = 2 * x * y * f.dg + 2 * p1 * x + 2 * p2 * y;
  jacobian[1][0] = jacobian[0][1];
  jacobian[1][1] = f.g + 2 * y * y * f.dg + 6 * p1 * y + 2 * p2 * x;
}

/* 1 + a q + b q^2 + c q^3 */
static radial cubic(double q, double a, double b, double c)
{
  const radial f = {1 + q * (a + q * (b + q * c)), a + q * (2 * b + q * 3 * c)};
  return f;
}

static void distort_pinhole(const double *k, const double at[2], double out[2],
                            double jacobian[2][2])
{
  const double q = at[0] * at[0] + at[1] * at[1];
  bend(cubic(q, k[0], k[1], k[4]), k[2], k[3], at, out, jacobian);
}

/* Of k1 k2 p1 p2 k3, where the radial factor's own denominator is `below`. */
static void by_brown(const double at[2], double below, double out[2][HL_DISTORTION_MAX])
{
  const double x = at[0], y = at[1];
  const double q = x * x + y * y;
  const double power[3] = {q / below, q * q / below, q * q * q / below};
  static const int radial_at[3] = {0, 1, 4};
  for (int j = 0; j < 3; j++) {
    out[0][radial_at[j]] = x * power[j];
    out[1][radial_at[j]] = y * power[j];
  }
  out[0][2] = 2 * x * y;
  out[1][2] = q + 2 * y * y;
  out[0][3] = q + 2 * x * x;
  out[1][3] = 2 * x * y;
}

static void by_pinhole(const double *k, const double at[2], double out[2][HL_DISTORTION_MAX])
{
  (void)k;
  by_brown(at, 1, out);
}

static void distort_rational(const double *k, const double at[2], double out[2],
                             double jacobian[2][2])
{
  const double q = at[0] * at[0] + at[1] * at[1];
  const radial above = cubic(q, k[0], k[1], k[4]);
  const radial below = cubic(q, k[5], k[6], k[7]);
  const radial f = {above.g / below.g,
                    (above.dg * below.g - above.g * below.dg) / (below.g * below.g)};
  bend(f, k[2], k[3], at, out, jacobian);
  if (!(below.g > 0)) /* beyond a pole: no lens's own side, whatever the signs are there */
    jacobian[0][0] = jacobian[1][1] = -1;
}

static void by_rational(const double *k, const double at[2], double out[2][HL_DISTORTION_MAX])
{
  const double q = at[0] * at[0] + at[1] * at[1];
  const radial above = cubic(q, k[0], k[1], k[4]);
  const radial below = cubic(q, k[5], k[6], k[7]);
  by_brown(at, below.g, out);
  for (int i = 0; i < 2; i++) {
    double rate = -at[i] * above.g / (below.g * below.g);
    for (int j = 5; j < 8; j++) {
      rate *= q;
      out[i][j] = rate;
    }
  }
}

static const double fisheye_series = 1e-6; /* q below which rounding outweighs the series' rest */

static void distort_fisheye(const double *k, const double at[2], double out[2],
                            double jacobian[2][2])
{
  const double q = at[0] * at[0] + at[1] * at[1];
  radial f = {1 + q * (k[0] - 1.0 / 3 + q * (0.2 - k[0] + k[1])),
              k[0] - 1.0 / 3 + 2 * q * (0.2 - k[0] + k[1])};
  if (q > fisheye_series) {
    const double r = sqrt(q);
    const double theta = atan(r), t2 = theta * theta;
    const double seen = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
    const double rate = 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
    f.g = seen / r;
    f.dg = (rate / (1 + q) - f.g) / (2 * q);
  }
  bend(f, 0, 0, at, out, jacobian);
}

static void by_fisheye(const double *k, const double at[2], double out[2][HL_DISTORTION_MAX])
{
  const double q = at[0] * at[0] + at[1] * at[1];
  const double r = sqrt(q), theta = atan(r);
  const double t2 = theta * theta;
  double power = q > 0 ? theta / r : 0;
  (void)k;
  for (int j = 0; j < 4; j++) {
    power *= t2;
    for (int i = 0; i < 2; i++)
      out[i][j] = at[i] * power;
  }
}

static const hl_lens lenses[] = {
    [HL_LENS_PINHOLE] = {"pinhole", 5, distort_pinhole, by_pinhole},
    [HL_LENS_RATIONAL] = {"rational", 8, distort_rational, by_rational},
    [HL_LENS_FISHEYE] = {"fisheye", 4, distort_fisheye, by_fisheye},
};

enum { N_LENSES = sizeof lenses / sizeof lenses[0] };

const hl_lens *hl_lens_of(hl_lens_model model)
{
  return (unsigned)model < N_LENSES ? &lenses[model] : NULL;
}

const char *hl_lens_name(int model)
{
  return model >= 0 && model < N_LENSES ? lenses[model].name : NULL;
}

int hl_lens_coefficients(int model)
{
  return model >= 0 && model < N_LENSES ? lenses[model].n_coefficients : 0;
}

#define ROUNDING 1e-13 /* of the focal length */
#define FARTHEST 1e4   /* tan of 89.994 deg: beyond, (x, y, 1) holds a direction to few digits */

/* One evaluation: what is left to the image point, its size, and the derivative. */
typedef struct miss {
  double at[2];
  double left[2];
  double size;
  double jacobian[2][2];
  double determinant;
  bool upright; /* neither folded nor, beyond two folds, turned upside down */
} miss;

static miss evaluate(const hl_lens *lens, const double *k, const double image[2], double x,
                     double y)
{
  miss m = {.at = {x, y}};
  double out[2];
  lens->distort(k, m.at, out, m.jacobian);
  m.left[0] = image[0] - out[0];
  m.left[1] = image[1] - out[1];
  m.size = sqrt(m.left[0] * m.left[0] + m.left[1] * m.left[1]);
  m.determinant = m.jacobian[0][0] * m.jacobian[1][1] - m.jacobian[0][1] * m.jacobian[1][0];
  m.upright = m.determinant > 0 && m.jacobian[0][0] + m.jacobian[1][1] > 0;
  return m;
}

/* Newton's step from m, halved until it is an improvement on the same side of a fold. */
static bool improve(const hl_lens *lens, const double *k, const double image[2], miss *m)
{
  const double dx =
      (m->jacobian[1][1] * m->left[0] - m->jacobian[0][1] * m->left[1]) / m->determinant;
  const double dy =
      (m->jacobian[0][0] * m->left[1] - m->jacobian[1][0] * m->left[0]) / m->determinant;
  /* at the level of rounding a smaller step is no better than the full one */
  const int halvings = m->size > ROUNDING ? HALVINGS_MAX : 1;
  double step = 1;
  for (int i = 0; i < halvings; i++) {
    const miss next = evaluate(lens, k, image, m->at[0] + step * dx, m->at[1] + step * dy);
    if (next.upright && next.size < m->size) {
      *m = next;
      return true;
    }
    step /= 2;
  }
  return false;
}

bool hl_lens_undistort(const hl_lens *lens, const double *coefficients, const double image[2],
                       double out[2])
{
  miss m = evaluate(lens, coefficients, image, image[0], image[1]);
  double shrink = 1;
  for (int i = 0; i < SHRINKS_MAX && !m.upright; i++) {
    shrink /= 2;
    m = evaluate(lens, coefficients, image, shrink * image[0], shrink * image[1]);
  }
  if (!m.upright)
    return false;
  /* as small as the image point's own rounding allows */
  const double enough = 4 * DBL_EPSILON * (hypot(image[0], image[1]) + DBL_EPSILON);
  for (int i = 0; i < STEPS_MAX && m.size > enough; i++)
    if (!improve(lens, coefficients, image, &m))
      break;
  if (!(m.size <= ROUNDING && hypot(m.at[0], m.at[1]) <= FARTHEST))
    return false;
  out[0] = m.at[0];
  out[1] = m.at[1];
  return true;
}
