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

/** How a ray becomes a pixel. */
typedef enum hl_lens_model {
  HL_LENS_PINHOLE,  /* Brown-Conrady: k1 k2 p1 p2 k3 */
  HL_LENS_RATIONAL, /* k1 k2 p1 p2 k3 k4 k5 k6, OpenCV's rational model */
  HL_LENS_FISHEYE   /* Kannala-Brandt: k1 k2 k3 k4, OpenCV's fisheye model; up to 89.99 deg */
} hl_lens_model;

/** "pinhole", "rational", "fisheye", as files spell an hl_lens_model; NULL past the last. */
HL_API const char *hl_lens_name(int model);

enum { HL_DISTORTION_MAX = 8, HL_INTRINSICS_MAX = 4 + HL_DISTORTION_MAX };

/** A calibrated camera. */
typedef struct hl_camera {
  hl_lens_model model;
  int n_distortion;
  int width, height;     /* pixels */
  double fx, fy, cx, cy; /* pixels */
  double distortion[HL_DISTORTION_MAX];
  double covariance[HL_INTRINSICS_MAX * HL_INTRINSICS_MAX]; /* of (fx,fy,cx,cy,distortion...), row
                                                               by row, packed n x n */
  double rms_px;                                            /* 0 = not stated */
  int observations;                                         /* 0 = not stated */
  bool has_covariance;
} hl_camera;

/**
 * Check that every number makes sense: finite, sizes in [2, 65536], focal lengths in
 * [width/1000, 1e7] px, the centre within one frame of the frame, distortion that gives every
 * pixel a ray and, on the way to it from the axis, neither folds nor stretches the image more than
 * threefold, compared with the model's image without distortion (looked at on a grid that reaches
 * the frame's border; under a millisecond). So a fisheye's frame must end within the lens's circle.
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

/** How many intrinsics a camera has: fx, fy, cx, cy and its distortion. */
HL_API int hl_camera_intrinsics_count(const hl_camera *camera);

/** The intrinsics as one vector (fx, fy, cx, cy, distortion...), and back; shape (count). */
HL_API void hl_camera_intrinsics(const hl_camera *camera, double out[HL_INTRINSICS_MAX]);
/** The reverse of hl_camera_intrinsics; the covariance stays as it is. */
HL_API void hl_camera_set_intrinsics(hl_camera *camera, const double in[HL_INTRINSICS_MAX]);

/**
 * Point to pixel with its derivatives.
 * @param by_point      shape (2,3) [px per unit of point]; may be NULL
 * @param by_intrinsics shape (2, HL_INTRINSICS_MAX), the first `count` columns are written; may be
 *                      NULL
 * @return HL_OK; HL_ERR_DEGENERATE for z <= 0. Allocates nothing.
 */
HL_API hl_status hl_camera_project_derivatives(hl_ctx *ctx, const hl_camera *camera,
                                               const double point[3], double pixel[2],
                                               double by_point[2][3],
                                               double by_intrinsics[2][HL_INTRINSICS_MAX]);

/**
 * Pixel to unit ray with its derivatives: how the ray of a fixed pixel turns as the intrinsics or
 * the pixel change (by the implicit function: project(ray, intrinsics) = pixel).
 * @param by_pixel      shape (3,2) [per px]; may be NULL
 * @param by_intrinsics shape (3, HL_INTRINSICS_MAX); may be NULL
 * @return as hl_camera_unproject. Allocates nothing.
 */
HL_API hl_status hl_camera_unproject_derivatives(hl_ctx *ctx, const hl_camera *camera, double x,
                                                 double y, double ray[3], double by_pixel[3][2],
                                                 double by_intrinsics[3][HL_INTRINSICS_MAX]);

/**
 * Camera files. All of them put pixel (0,0) into the centre of the top-left pixel and order the
 * coefficients as hl_lens_model does.
 */
typedef enum hl_camera_format {
  HL_CAMERA_JSON,   /* CAMERA.json, the only one with everything */
  HL_CAMERA_OPENCV, /* YAML of OpenCV's FileStorage; a fisheye has `fisheye_model: 1` */
  HL_CAMERA_KALIBR, /* Kalibr's camchain YAML of one camera: fisheye, or pinhole with k3 = 0 */
  HL_CAMERA_MRCAL   /* mrcal's .cameramodel: pinhole and rational */
} hl_camera_format;

/** "json", "opencv", "kalibr", "mrcal"; NULL past the last. */
HL_API const char *hl_camera_format_name(int format);

/**
 * Read and check a camera file of any format, told apart by what it holds. Members that are not
 * known, poses among them, are ignored.
 * @return HL_OK; HL_ERR_IO; HL_ERR_FORMAT (no such format, another version, a member missing,
 *         mistyped, not finite or absurd, a lens that is none of hl_lens_model, several cameras);
 *         HL_ERR_MEMORY
 */
HL_API hl_status hl_camera_read(hl_ctx *ctx, const char *path, hl_camera *out);

/**
 * A camera as the text of a file; every number survives the round trip. *out is the caller's, release
 * it with free().
 * @return HL_OK; HL_ERR_ARG (no such format); HL_ERR_FORMAT (what hl_camera_check says, or a lens
 *         that the format has no words for); HL_ERR_MEMORY
 */
HL_API hl_status hl_camera_text(hl_ctx *ctx, const hl_camera *camera, hl_camera_format format,
                                char **out);

/** What a camera may state beside its intrinsics. */
typedef enum hl_camera_part {
  HL_CAMERA_COVARIANCE = 1,
  HL_CAMERA_RMS = 2,
  HL_CAMERA_OBSERVATIONS = 4
} hl_camera_part;

/** Parts that this camera states and the format has no place for; 0 = nothing is lost. */
HL_API unsigned hl_camera_lost(const hl_camera *camera, hl_camera_format format);

/** hl_camera_text of HL_CAMERA_JSON. */
HL_API hl_status hl_camera_json(hl_ctx *ctx, const hl_camera *camera, char **out);

/** CAMERA.json to a file, whole or not at all. @return as hl_camera_json; HL_ERR_IO */
HL_API hl_status hl_camera_write(hl_ctx *ctx, const char *path, const hl_camera *camera);

#ifdef __cplusplus
}
#endif
#endif
