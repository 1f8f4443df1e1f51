/** Internal, not installed: what the calibration asks of OpenCV, in plain C. */
#ifndef HALFLIGHT_BRIDGE_OPENCV_CALIBRATE_H
#define HALFLIGHT_BRIDGE_OPENCV_CALIBRATE_H

#include "halflight/camera.h"
#include "halflight/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Corners of a flat board seen in one view; both shape (n,2). */
typedef struct hl_opencv_view {
  int n;
  const double (*board_m)[2];
  const double (*pixel)[2];
} hl_opencv_view;

/**
 * cv::calibrateCamera, or cv::fisheye::calibrate for that model: the intrinsics and every view's
 * pose that minimise the unweighted reprojection error, as far as OpenCV goes.
 *
 * @param camera its model (pinhole or fisheye), width and height are read; written on HL_OK
 * @param cam_from_board shape (n_views), written on HL_OK
 * @return HL_OK; HL_ERR_DEGENERATE (OpenCV gave up, or its answer is not finite, with its words);
 *         HL_ERR_MEMORY; HL_ERR_UNAVAILABLE in a build without OpenCV
 */
hl_status hl_opencv_calibrate(hl_ctx *ctx, const hl_opencv_view *views, int n_views,
                              hl_camera *camera, hl_pose *cam_from_board);

/**
 * cv::solvePnPGeneric with SOLVEPNP_IPPE: the two poses that explain a plane, better one first.
 * @param at shape (n,2): where the corners are seen, as x/z and y/z of their rays
 * @return HL_OK, *found 1 or 2; HL_ERR_DEGENERATE; HL_ERR_MEMORY; HL_ERR_UNAVAILABLE
 */
hl_status hl_opencv_plane_poses(hl_ctx *ctx, const double (*board_m)[2], const double (*at)[2],
                                int n, hl_pose out[2], int *found);

#ifdef __cplusplus
}
#endif
#endif
