/*
 * Lens models.
 *
 * Pinhole with Brown-Conrady distortion, r^2 = x^2 + y^2, g = 1 + k1 r^2 + k2 r^4 + k3 r^6:
 *
 *   u = x g + 2 p1 x y + p2 (r^2 + 2 x^2)
 *   v = y g + p1 (r^2 + 2 y^2) + 2 p2 x y
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

static void distort_pinhole(const double *k, const double at[2], double out[2],
                            double jacobian[2][2])
{
  const double k1 = k[0], k2 = k[1], p1 = k[2], p2 = k[3], k3 = k[4];
  const double x = at[0], y = at[1];
  const double r2 = x * x + y * y;
  const double g = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double dg = k1 + r2 * (2 * k2 + r2 * 3 * k3); /* dg/d(r^2) */
  out[0] = x * g + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  out[1] = y * g + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  jacobian[0][0] = g + 2 * x * x * dg + 2 * p1 * y + 6 * p2 * x;
  jacobian[0][1] = 2 * x * y * dg + 2 * p1 * x + 2 * p2 * y;
  jacobian[1][0] = jacobian[0][1];
  jacobian[1][1] = g + 2 * y * y * dg + 6 * p1 * y + 2 * p2 * x;
}

static const hl_lens lenses[] = {
    [HL_LENS_PINHOLE] = {"pinhole", 5, distort_pinhole},
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
  if (!(m.size <= ROUNDING))
    return false;
  out[0] = m.at[0];
  out[1] = m.at[1];
  return true;
}
