/* Cameras drawn from a covariance, as calibrations of the same lens would give them. */
#ifndef HALFLIGHT_TESTS_CAMERA_DRAWS_H
#define HALFLIGHT_TESTS_CAMERA_DRAWS_H

#include <string.h>

#include "halflight/camera.h"
#include "near.h"

/* Deviations of a calibration from few views, ours: the focal lengths err together, the radial
 * coefficients against each other and with the focal length, the decentring with the centre. Column j is
 * what one deviation of the j-th cause does to fx, fy, cx, cy, k1, k2, p1, p2, k3. */
static const double camera_causes[9][9] = {
    {2.4, 0, 0, 0, 0, 0, 0, 0, 0},         {2.3, 0.5, 0, 0, 0, 0, 0, 0, 0},
    {0.1, 0, 1.5, 0, 0, 0, 0, 0, 0},       {0, 0.2, 0.1, 1.4, 0, 0, 0, 0, 0},
    {0.004, 0, 0, 0, 0.012, 0, 0, 0, 0},   {-0.002, 0, 0, 0, -0.05, 0.02, 0, 0, 0},
    {0, 0, 0, 4e-4, 0, 0, 3e-4, 0, 0},     {0, 0, 5e-4, 0, 0, 0, 0, 3e-4, 0},
    {0, 0, 0, 0, 0.04, -0.02, 0, 0, 0.01},
};

/* The camera with that covariance, `scale` times the deviations; pinhole with five coefficients. */
static inline void camera_uncertain(hl_camera *c, double scale)
{
  c->has_covariance = true;
  for (int i = 0; i < 9; i++)
    for (int j = 0; j < 9; j++) {
      c->covariance[i * 9 + j] = 0;
      for (int k = 0; k < 9; k++)
        c->covariance[i * 9 + j] += scale * scale * camera_causes[i][k] * camera_causes[j][k];
    }
}

static inline hl_camera camera_drawn(const hl_camera *c, double scale, test_random *random)
{
  double theta[HL_INTRINSICS_MAX];
  hl_camera out = *c;
  hl_camera_intrinsics(c, theta);
  for (int k = 0; k < 9; k++) {
    const double z = scale * random_normal(random);
    for (int i = 0; i < 9; i++)
      theta[i] += z * camera_causes[i][k];
  }
  hl_camera_set_intrinsics(&out, theta);
  return out;
}

#endif
