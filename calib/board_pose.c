/*
 * The pose of a board that stands still, from one view of a calibrated camera.
 *
 * Least squares of the reprojection for the pose alone. With the rows of d(pixel)/d(pose) in P and of
 * d(pixel)/d(intrinsics) in Q, and s the corners' deviation,
 *
 *   covariance = s^2 (P'P)^-1,   by_intrinsics = -(P'P)^-1 P'Q
 *
 * s is the calibration's, or the view's own where that is larger.
 */
#include "board_pose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CORNERS_MIN = 12 };

hl_status hl_board_sightings(hl_ctx *ctx, const hl_camera *camera, const hl_corners *corners,
                             int view, hl_sighting **out, int *n)
{
  if (view < 0 || view >= corners->n_views)
    return hl_fail(ctx, HL_ERR_ARG, "view %d of %d views", view, corners->n_views);
  const hl_view *v = &corners->view[view];
  /* width and height are not known of corners that came from a file alone */
  if (corners->width > 0 && (corners->width != camera->width || corners->height != camera->height))
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "%.80s has %d x %d px, the camera %d x %d; a camera calibrated at the frame's "
                   "size is needed",
                   v->name, corners->width, corners->height, camera->width, camera->height);
  if (!v->used)
    return hl_fail(ctx, HL_ERR_DEGENERATE, "%.80s: %s", v->name, v->why);
  if (v->seen < CORNERS_MIN)
    return hl_fail(ctx, HL_ERR_DEGENERATE, "%.80s: %d corners of the board are seen; %d are needed",
                   v->name, v->seen, CORNERS_MIN);
  hl_sighting *sighting = malloc((size_t)v->seen * sizeof *sighting);
  if (!sighting)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d corners", v->seen);
  *n = hl_sightings_of(&corners->target, v, sighting);
  *out = sighting;
  return HL_OK;
}

double hl_board_noise(const hl_calibration *calibration)
{
  if (calibration->noise_px > 0)
    return calibration->noise_px;
  return calibration->camera.rms_px / sqrt(2); /* rms is of the distance, over both axes */
}

static hl_status fill(hl_ctx *ctx, const hl_sighting *sighting, int n, double variance,
                      hl_board_pose *out)
{
  hl_arrow arrow;
  hl_arrow_view block;
  hl_arrow_clear(&arrow, hl_camera_intrinsics_count(&out->camera));
  hl_arrow_view_clear(&block);
  if (!hl_sightings_rows(&out->camera, &out->cam_from_board, sighting, n, &arrow, &block) ||
      !hl_spd_factor(block.b, HL_POSE_SIZE, 0, &block.factor, NULL))
    return hl_fail(ctx, HL_ERR_DEGENERATE, "%d corners do not determine the board's pose", n);
  hl_spd_inverse(&block.factor, out->covariance[0]);
  for (int i = 0; i < HL_POSE_SIZE; i++)
    for (int k = 0; k < HL_POSE_SIZE; k++)
      out->covariance[i][k] *= variance;
  for (int k = 0; k < arrow.n; k++) {
    double follows[HL_POSE_SIZE];
    hl_spd_solve(&block.factor, block.e[k], follows);
    for (int i = 0; i < HL_POSE_SIZE; i++)
      out->by_intrinsics[i][k] = -follows[i];
  }
  out->has_covariance = true;
  return HL_OK;
}

hl_status hl_board_pose_fit(hl_ctx *ctx, const hl_calibration *camera, const hl_corners *corners,
                            int view, hl_board_pose *out)
{
  hl_board_pose pose = {.target = corners->target, .camera = camera->camera};
  pose.camera.has_covariance = false;
  memset(pose.camera.covariance, 0, sizeof pose.camera.covariance);
  hl_sighting *sighting = NULL;
  int n = 0;
  double cost = 0;
  hl_status st = hl_board_sightings(ctx, &camera->camera, corners, view, &sighting, &n);
  if (st == HL_OK)
    st = hl_sightings_pose(ctx, &camera->camera, sighting, n, &pose.cam_from_board, &cost);
  if (st == HL_OK) {
    const double noise = hl_board_noise(camera);
    pose.corners = n;
    pose.rms_px = sqrt(cost / n);
    st = fill(ctx, sighting, n, fmax(noise * noise, cost / (2 * n - HL_POSE_SIZE)), &pose);
  }
  free(sighting);
  if (st == HL_OK)
    *out = pose;
  return st;
}
