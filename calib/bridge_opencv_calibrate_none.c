/* A build without OpenCV. */
#include "halflight/bridge_opencv_calibrate.h"

static hl_status none(hl_ctx *ctx)
{
  return hl_fail(ctx, HL_ERR_UNAVAILABLE,
                 "calibration needs OpenCV, which is not in this build: build with "
                 "-DHL_WITH_OPENCV=ON");
}

hl_status hl_opencv_calibrate(hl_ctx *ctx, const hl_opencv_view *views, int n_views,
                              hl_camera *camera, hl_pose *cam_from_board)
{
  (void)views;
  (void)n_views;
  (void)camera;
  (void)cam_from_board;
  return none(ctx);
}

hl_status hl_opencv_plane_poses(hl_ctx *ctx, const double (*board_m)[2], const double (*at)[2],
                                int n, hl_pose out[2], int *found)
{
  (void)board_m;
  (void)at;
  (void)n;
  (void)out;
  (void)found;
  return none(ctx);
}
