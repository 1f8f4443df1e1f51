/*
 * Corners of a board seen in one view.
 *
 * Residuals are seen minus predicted, in pixels, over the corner's relative deviation, so that
 * rows of the Jacobian are minus the projection's derivatives by chain rule:
 *
 *   r = w (q - project(theta, T(p) b)),   d(r)/d(theta) = -w dq/dtheta,  d(r)/d(p) = -w dq/dx dT/dp
 *
 * The pose alone is refined by Levenberg and Marquardt's method. From nothing it starts from both
 * poses that explain a plane (Collins and Bartoli 2014), because seen from afar the two differ by
 * less than the noise and the wrong one is a minimum of its own.
 */
#include "sightings.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/bridge_opencv_calibrate.h"
#include "halflight/vec3.h"

enum { STEPS_MAX = 60, CORNERS_MIN = 4 };

#define DAMPING_START 1e-4
#define DAMPING_LEAST 1e-12
#define DAMPING_MOST 1e8
#define ENOUGH 1e-13     /* of the cost: what a step may still gain */
#define ENOUGH_PX2 1e-22 /* a corner, where there is no noise */

int hl_sightings_of(const hl_target *target, const hl_view *view, hl_sighting *out)
{
  const int corners = hl_target_corners(target);
  int n = 0;
  for (int i = 0; i < corners; i++) {
    const hl_corner *c = &view->corner[i];
    if (!(c->sigma > 0))
      continue;
    hl_sighting *s = &out[n++];
    hl_target_corner(target, i, s->board_m);
    s->pixel[0] = c->x;
    s->pixel[1] = c->y;
    s->weight = 1 / c->sigma;
    s->used = true;
    s->index = i;
  }
  return n;
}

int hl_sightings_used(const hl_sighting *sighting, int n)
{
  int used = 0;
  for (int i = 0; i < n; i++)
    used += sighting[i].used;
  return used;
}

/* Beyond a pole of the rational model's radial factor, which no lens has. */
static bool is_beyond_pole(const hl_camera *camera, const double point[3])
{
  const double *k = camera->distortion;
  const double q = (point[0] * point[0] + point[1] * point[1]) / (point[2] * point[2]);
  return camera->model == HL_LENS_RATIONAL && !(1 + q * (k[5] + q * (k[6] + q * k[7])) > 0);
}

/* At a point of the camera's frame. */
static bool residual_at(const hl_camera *camera, const double point[3], const hl_sighting *s,
                        double out[2])
{
  double pixel[2];
  if (hl_camera_project(NULL, camera, point, pixel) != HL_OK || is_beyond_pole(camera, point))
    return false;
  for (int i = 0; i < 2; i++)
    out[i] = s->weight * (s->pixel[i] - pixel[i]);
  return true;
}

bool hl_sighting_residual(const hl_camera *camera, const hl_pose *pose, const hl_sighting *s,
                          double out[2])
{
  double point[3];
  hl_pose_apply(pose, s->board_m, point, NULL, NULL);
  return residual_at(camera, point, s, out);
}

double hl_sightings_cost(const hl_camera *camera, const hl_pose *pose, const hl_sighting *sighting,
                         int n)
{
  double sum = 0, rotation[3][3];
  hl_pose_matrix(pose, rotation);
  for (int i = 0; i < n; i++) {
    double point[3], r[2];
    if (!sighting[i].used)
      continue;
    for (int k = 0; k < 3; k++)
      point[k] = hl_dot(rotation[k], sighting[i].board_m) + pose->translation_m[k];
    if (!residual_at(camera, point, &sighting[i], r))
      return HUGE_VAL;
    sum += r[0] * r[0] + r[1] * r[1];
  }
  return isfinite(sum) ? sum : HUGE_VAL;
}

bool hl_sightings_rows(const hl_camera *camera, const hl_pose *pose, const hl_sighting *sighting,
                       int n, hl_arrow *arrow, hl_arrow_view *out)
{
  for (int c = 0; c < n; c++) {
    const hl_sighting *s = &sighting[c];
    double point[3], by_pose[3][HL_POSE_SIZE], pixel[2], by_point[2][3];
    double by_intrinsics[2][HL_INTRINSICS_MAX];
    if (!s->used)
      continue;
    hl_pose_apply(pose, s->board_m, point, by_pose, NULL);
    if (hl_camera_project_derivatives(NULL, camera, point, pixel, by_point,
                                      arrow ? by_intrinsics : NULL) != HL_OK)
      return false;
    for (int i = 0; i < 2; i++) {
      double theta[HL_INTRINSICS_MAX] = {0}, p[HL_POSE_SIZE];
      for (int k = 0; arrow && k < arrow->n; k++)
        theta[k] = -s->weight * by_intrinsics[i][k];
      for (int k = 0; k < HL_POSE_SIZE; k++)
        p[k] = -s->weight * (by_point[i][0] * by_pose[0][k] + by_point[i][1] * by_pose[1][k] +
                             by_point[i][2] * by_pose[2][k]);
      hl_arrow_add(arrow, out, theta, p, s->weight * (s->pixel[i] - pixel[i]));
    }
  }
  return true;
}

/* The pose moved by its own step at this damping; *gain is what the linear model promises. */
static bool moved(hl_arrow_view *view, double damping, const hl_pose *from, hl_pose *to,
                  double *gain)
{
  double step[HL_POSE_SIZE];
  if (!hl_spd_factor(view->b, HL_POSE_SIZE, damping, &view->factor, NULL))
    return false;
  hl_arrow_view_step(view, 0, NULL, step);
  *gain = 0;
  for (int i = 0; i < 3; i++) {
    to->rotation_rad[i] = from->rotation_rad[i] + step[i];
    to->translation_m[i] = from->translation_m[i] + step[3 + i];
    *gain -= view->gradient[i] * step[i] + view->gradient[3 + i] * step[3 + i];
  }
  return true;
}

double hl_sightings_refine(const hl_camera *camera, const hl_sighting *sighting, int n,
                           hl_pose *pose)
{
  double cost = hl_sightings_cost(camera, pose, sighting, n);
  double damping = DAMPING_START;
  for (int i = 0; i < STEPS_MAX && isfinite(cost); i++) {
    hl_arrow_view view;
    hl_arrow_view_clear(&view);
    hl_sightings_rows(camera, pose, sighting, n, NULL, &view);
    bool better = false;
    double gain = 0;
    while (!better && damping < DAMPING_MOST) {
      hl_pose to;
      if (!moved(&view, damping, pose, &to, &gain))
        return HUGE_VAL;
      if (gain <= ENOUGH * cost + ENOUGH_PX2 * n)
        return cost;
      const double next = hl_sightings_cost(camera, &to, sighting, n);
      better = next <= cost;
      if (better) {
        cost = next;
        *pose = to;
      }
      damping = better ? fmax(damping / 10, DAMPING_LEAST) : damping * 10;
    }
    if (!better)
      break;
  }
  return cost;
}

/* Where corners are seen, as x/z and y/z of their rays; corners of pixels without a ray are left
 * out. Returns how many. */
static int on_plane(const hl_camera *camera, const hl_sighting *sighting, int n,
                    double (*board_m)[2], double (*at)[2])
{
  int found = 0;
  for (int i = 0; i < n; i++) {
    const hl_sighting *s = &sighting[i];
    double ray[3];
    if (!s->used || hl_camera_unproject(NULL, camera, s->pixel[0], s->pixel[1], ray) != HL_OK ||
        !(ray[2] > 0))
      continue;
    for (int k = 0; k < 2; k++) {
      board_m[found][k] = s->board_m[k];
      at[found][k] = ray[k] / ray[2];
    }
    found++;
  }
  return found;
}

hl_status hl_sightings_pose(hl_ctx *ctx, const hl_camera *camera, const hl_sighting *sighting,
                            int n, hl_pose *out, double *cost)
{
  double(*plane)[2] = malloc(2 * (size_t)(n > 0 ? n : 1) * sizeof *plane);
  if (!plane)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the pose of %d corners", n);
  const int found = on_plane(camera, sighting, n, plane, plane + n);
  hl_pose pose[2];
  int answers = 0;
  hl_status st = HL_OK;
  if (found < CORNERS_MIN)
    st = hl_fail(ctx, HL_ERR_DEGENERATE, "%d corners say too little about a pose; %d are needed",
                 found, CORNERS_MIN);
  else
    st = hl_opencv_plane_poses(ctx, (const double(*)[2])plane, (const double(*)[2])(plane + n),
                               found, pose, &answers);
  free(plane);
  if (st != HL_OK)
    return st;
  double least = HUGE_VAL;
  int best = 0;
  for (int i = 0; i < answers; i++) {
    const double left = hl_sightings_refine(camera, sighting, n, &pose[i]);
    if (left < least) {
      least = left;
      best = i;
    }
  }
  if (!isfinite(least))
    return hl_fail(ctx, HL_ERR_DEGENERATE, "no pose explains these %d corners", found);
  *out = pose[best];
  *cost = least;
  return HL_OK;
}
