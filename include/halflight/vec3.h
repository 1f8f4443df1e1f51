/** Vectors of three, by pointer, row-major, right-handed. All inline; outputs last, may alias
 * inputs. */
#ifndef HALFLIGHT_VEC3_H
#define HALFLIGHT_VEC3_H

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

/** a . b */
static inline double hl_dot(const double a[3], const double b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** |a| */
static inline double hl_norm(const double a[3])
{
  return sqrt(hl_dot(a, a));
}

/** a x b */
static inline void hl_cross(const double a[3], const double b[3], double out[3])
{
  const double x = a[1] * b[2] - a[2] * b[1];
  const double y = a[2] * b[0] - a[0] * b[2];
  const double z = a[0] * b[1] - a[1] * b[0];
  out[0] = x;
  out[1] = y;
  out[2] = z;
}

/** out = a + t * b */
static inline void hl_add_scaled(const double a[3], double t, const double b[3], double out[3])
{
  for (int i = 0; i < 3; i++)
    out[i] = a[i] + t * b[i];
}

/** Unit vector of a; a zero vector stays zero. */
static inline void hl_unit(const double a[3], double out[3])
{
  const double n = hl_norm(a);
  const double k = n > 0 ? 1 / n : 0;
  for (int i = 0; i < 3; i++)
    out[i] = k * a[i];
}

/** Angle between two vectors [rad], accurate near 0 and near pi. */
static inline double hl_angle(const double a[3], const double b[3])
{
  double c[3];
  hl_cross(a, b, c);
  return atan2(hl_norm(c), hl_dot(a, b));
}

/** Two unit vectors that complete the unit vector s to a right-handed frame (u, w, s). */
static inline void hl_tangent_basis(const double s[3], double u[3], double w[3])
{
  const double x[3] = {1, 0, 0};
  const double y[3] = {0, 1, 0};
  hl_cross(fabs(s[0]) < 0.9 ? x : y, s, u);
  hl_unit(u, u);
  hl_cross(s, u, w);
}

#ifdef __cplusplus
}
#endif
#endif
