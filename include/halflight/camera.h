/**
 * A calibrated camera: pixels to rays and back.
 *
 * Camera frame: x right, y down, z forward. Pixel (0,0) is the centre of the top-left pixel.
 * Every lens model sits behind one small table (calib/lens.h); the struct's layout is the same for
 * all.
 */
#ifndef HALFLIGHT_CAMERA_H
#define HALFLIGHT_CAMERA_H

#include <stdbool.h>

#include "halflight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum hl_lens_model {
  HL_LENS_PINHOLE /* Brown-Conrady: k1 k2 p1 p2 k3 */
} hl_lens_model;

enum { HL_DISTORTION_MAX = 8, HL_INTRINSICS_MAX = 4 + HL_DISTORTION_MAX };

typedef struct hl_camera {
  hl_lens_model model;
  int width, height;     /* pixels */
  double fx, fy, cx, cy; /* pixels */
  int n_distortion;
  double distortion[HL_DISTORTION_MAX];
  bool has_covariance;
  double covariance[HL_INTRINSICS_MAX * HL_INTRINSICS_MAX]; /* of (fx,fy,cx,cy,distortion...), row
                                                               by row, packed n x n */
  double rms_px;                                            /* 0 = not stated */
  int observations;                                         /* 0 = not stated */
} hl_camera;

/**
 * Check that every number makes sense: finite, sizes in [2, 65536], focal lengths in
 * [width/1000, 1e7] px, the centre within one frame of the frame, distortion that gives every
 * pixel a ray and, on the way to it from the axis, neither folds nor stretches the image more than
 * threefold (looked at on a grid that reaches the frame's border; under a millisecond).
 * @return HL_OK; HL_ERR_FORMAT naming the field, its value and what would be accepted
 */
HL_API hl_status hl_camera_check(hl_ctx *ctx, const hl_camera *camera);

/**
 * Pixel to unit ray, undistorted.
 * @return HL_OK; HL_ERR_NOT_CONVERGED where the lens model cannot be inverted at that pixel
 * Allocates nothing; Newton on the distortion, to 1e-13 of the focal length.
 */
HL_API hl_status hl_camera_unproject(hl_ctx *ctx, const hl_camera *camera, double x, double y,
                                     double ray[3]);

/**
 * Point or direction [any scale] to pixel.
 * @return HL_OK; HL_ERR_DEGENERATE for z <= 0
 */
HL_API hl_status hl_camera_project(hl_ctx *ctx, const hl_camera *camera, const double point[3],
                                   double pixel[2]);

/**
 * Read and check CAMERA.json.
 * @return HL_OK; HL_ERR_IO; HL_ERR_FORMAT (not JSON, wrong format or version, a member missing,
 *         mistyped, not finite or absurd)
 */
HL_API hl_status hl_camera_read(hl_ctx *ctx, const char *path, hl_camera *out);

#ifdef __cplusplus
}
#endif
#endif
