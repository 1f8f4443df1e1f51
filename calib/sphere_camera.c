/*
 * What a camera's uncertainty does to a ball found through it.
 *
 * The outline's pixels stay where they were read while their rays u turn with the intrinsics theta, and
 * with them the angles phi to the cone's axis. The robust fit minimises sum rho(offset - row . step), so
 *
 *   d step / d theta = (sum psi' row row')^-1 sum psi' row d phi / d theta,
 *   d phi / d theta = e . du / d theta,   e = cos(phi) a - sin(phi) axis,
 *
 * a the unit vector across the axis at the reading's azimuth. The centre follows the step.
 */
#include "sphere_camera.h"

#include <string.h>

#include "halflight/vec3.h"

/* The pixel of a reading and the rates at which its angle to the axis changes. */
static bool turn_of(const hl_camera *camera, const hl_cone *cone, const hl_cone_offset *r,
                    double out[HL_INTRINSICS_MAX])
{
  const double phi = cone->half_angle_rad + r->offset_rad;
  double ray[3], across[3], pixel[2], turn[3][HL_INTRINSICS_MAX];
  for (int k = 0; k < 3; k++) {
    const double a = cos(r->azimuth_rad) * cone->e1[k] + sin(r->azimuth_rad) * cone->e2[k];
    ray[k] = cos(phi) * cone->axis[k] + sin(phi) * a;
    across[k] = cos(phi) * a - sin(phi) * cone->axis[k];
  }
  if (hl_camera_project(NULL, camera, ray, pixel) != HL_OK ||
      hl_camera_unproject_derivatives(NULL, camera, pixel[0], pixel[1], ray, NULL, turn) != HL_OK)
    return false;
  for (int j = 0; j < hl_camera_intrinsics_count(camera); j++)
    out[j] = across[0] * turn[0][j] + across[1] * turn[1][j] + across[2] * turn[2][j];
  return true;
}

bool hl_cone_by_intrinsics(const hl_camera *camera, const hl_cone *cone,
                           const hl_cone_offset *readings, int n, const hl_cone_fit *fit,
                           double out[3][HL_INTRINSICS_MAX])
{
  const int count = hl_camera_intrinsics_count(camera);
  double pull[3][HL_INTRINSICS_MAX] = {{0}};
  for (int i = 0; i < n; i++) {
    double turn[HL_INTRINSICS_MAX] = {0};
    if (readings[i].slope == 0)
      continue;
    if (!turn_of(camera, cone, &readings[i], turn))
      return false;
    for (int k = 0; k < 3; k++)
      for (int j = 0; j < count; j++)
        pull[k][j] += readings[i].slope * readings[i].row[k] * turn[j];
  }
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < count; j++) {
      out[k][j] = 0;
      for (int l = 0; l < 3; l++)
        out[k][j] += fit->bread[k][l] * pull[l][j];
    }
  return true;
}

void hl_sphere_add_camera(const hl_camera *camera, const hl_cone *cone,
                          const double by_intrinsics[3][HL_INTRINSICS_MAX], hl_sphere *ball)
{
  const int n = hl_camera_intrinsics_count(camera);
  double by_step[3][3];
  hl_cone_center_by_step(cone, ball->radius_m, by_step);
  memcpy(ball->held_covariance_m2, ball->covariance_m2, sizeof ball->covariance_m2);
  ball->n_intrinsics = n;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < n; j++)
      for (int k = 0; k < 3; k++)
        ball->by_intrinsics[i][j] += by_step[i][k] * by_intrinsics[k][j];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      for (int k = 0; k < n; k++)
        for (int l = 0; l < n; l++)
          ball->covariance_m2[i][j] +=
              ball->by_intrinsics[i][k] * camera->covariance[k * n + l] * ball->by_intrinsics[j][l];
}
