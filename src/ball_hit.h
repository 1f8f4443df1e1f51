/* Where a ray meets a ball. Private. */
#ifndef HL_BALL_HIT_H
#define HL_BALL_HIT_H

#include <stdbool.h>

#include "halflight/sphere.h"
#include "halflight/vec3.h"

/* A unit ray u from the camera, with m = C - (C.u) u the part of the centre C across it, meets the ball
 * where |m| < R, first at t = C.u - sqrt(R^2 - m.m); there n = (t u - C) / R. False where it passes. */
static inline bool hl_ball_hit(const hl_sphere *ball, const double ray[3], double normal[3])
{
  const double along = hl_dot(ball->center_m, ray);
  double across[3];
  hl_add_scaled(ball->center_m, -along, ray, across);
  const double under = ball->radius_m * ball->radius_m - hl_dot(across, across);
  if (!(under > 0 && along > 0))
    return false;
  /* t u - C = -(m + sqrt(under) u): no difference of large numbers */
  const double deep = sqrt(under);
  for (int i = 0; i < 3; i++)
    normal[i] = -(across[i] + deep * ray[i]) / ball->radius_m;
  hl_unit(normal, normal);
  return true;
}

#endif
