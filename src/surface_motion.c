/*
 * How a pixel's geometry moves with the camera and the ball.
 *
 * The point seen lies at t u = C + R n, u the pixel's ray. It stays on the ball (n . dn = 0), so
 *
 *   R dn = dt u + t du - dC,   dt = n . (dC - t du) / (n . u),
 *
 * and the view is -u. The ray of a fixed pixel turns with the intrinsics alone
 * (hl_camera_unproject_derivatives).
 */
#include <string.h>

#include "halflight/surface.h"
#include "halflight/vec3.h"

/* R dn, with `moved` = t du - dC. */
static void slide_back(const double n[3], const double view[3], const double moved[3],
                       double out[3])
{
  const double along = hl_dot(n, moved) / hl_dot(n, view);
  hl_add_scaled(moved, -along, view, out);
}

void hl_surface_by_center(const hl_surface *surface, int i, double normal[3][3])
{
  const double *n = surface->normal + 3 * (size_t)i, *v = surface->view + 3 * (size_t)i;
  memset(normal, 0, 3 * sizeof *normal);
  for (int j = 0; surface->is_ball && j < 3; j++) {
    const double moved[3] = {-(j == 0), -(j == 1), -(j == 2)};
    double turn[3];
    slide_back(n, v, moved, turn);
    for (int k = 0; k < 3; k++)
      normal[k][j] = turn[k] / surface->ball.radius_m;
  }
}

hl_status hl_surface_by_intrinsics(hl_ctx *ctx, const hl_surface *surface, int i,
                                   double normal[3][HL_INTRINSICS_MAX],
                                   double view[3][HL_INTRINSICS_MAX])
{
  const hl_camera *camera = &surface->camera;
  if (camera->width != surface->width || camera->height != surface->height)
    return hl_fail(
        ctx, HL_ERR_ARG,
        "the surface is of a frame of %d x %d, its camera of %d x %d; one made through a "
        "camera is needed",
        surface->width, surface->height, camera->width, camera->height);
  const int x = surface->pixel[i] % surface->width, y = surface->pixel[i] / surface->width;
  const double *n = surface->normal + 3 * (size_t)i, *v = surface->view + 3 * (size_t)i;
  const double radius = surface->ball.radius_m;
  double ray[3], point[3], by[3][HL_INTRINSICS_MAX];
  const hl_status st = hl_camera_unproject_derivatives(ctx, camera, x, y, ray, NULL, by);
  if (st != HL_OK)
    return st;
  hl_add_scaled(surface->ball.center_m, radius, n, point);
  const double distance = hl_norm(point);
  for (int j = 0; j < hl_camera_intrinsics_count(camera); j++) {
    const double moved[3] = {distance * by[0][j], distance * by[1][j], distance * by[2][j]};
    double turn[3] = {0};
    if (surface->is_ball)
      slide_back(n, v, moved, turn);
    for (int k = 0; k < 3; k++) {
      normal[k][j] = surface->is_ball ? turn[k] / radius : 0;
      view[k][j] = -by[k][j];
    }
  }
  return HL_OK;
}
