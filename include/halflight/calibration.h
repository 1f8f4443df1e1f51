/**
 * A camera from views of a target, and how sure every number of it is.
 *
 * OpenCV minimises the reprojection error; everything that is said about the answer is computed
 * here, from the Jacobian of all parameters (intrinsics and one pose a view):
 *
 *   H = J' J,   Cov = s^2 H^-1,   s^2 = SSR / (2 N - p)
 *
 * H is an arrow: one block of the intrinsics A, one of each view B_i, and E_i between them. So, with
 * S = A - sum E_i B_i^-1 E_i' the intrinsics' Schur complement,
 *
 *   Cov(theta)         = s^2 S^-1
 *   pose_i             = own_i + G_i theta,  G_i = -B_i^-1 E_i'
 *   Cov(pose_i, theta) = G_i Cov(theta),     Cov(pose_i) = s^2 B_i^-1 + G_i Cov(theta) G_i'
 *
 * and a camera with its views' (s^2 B_i^-1, G_i) holds the joint covariance of everything.
 */
#ifndef HALFLIGHT_CALIBRATION_H
#define HALFLIGHT_CALIBRATION_H

#include "halflight/camera.h"
#include "halflight/corners.h"
#include "halflight/light.h"
#include "halflight/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How far a pixel may really be from where the camera says it is. */
typedef struct hl_projection {
  double pixel[2];
  double distance_m; /* along the ray; HUGE_VAL for a direction */
  double covariance_px2[2][2];
} hl_projection;

enum { HL_PROJECTIONS_MAX = 64 };

/** Where a view's board was, and how sure that is. */
typedef struct hl_view_pose {
  char name[HL_VIEW_NAME_MAX];
  bool used;               /* false: left out, `why` says; the numbers below may be 0 */
  char why[HL_REASON_MAX]; /* "" where used */
  int corners;             /* used in the fit, of those seen */
  int seen;
  double rms_px; /* of the distance from seen to predicted, over the corners */
  hl_pose cam_from_board;
  double own_covariance[HL_POSE_SIZE][HL_POSE_SIZE];     /* s^2 B^-1: the camera held */
  double by_intrinsics[HL_POSE_SIZE][HL_INTRINSICS_MAX]; /* G: how the pose follows the camera */
} hl_view_pose;

/** Which lens model to fit. */
typedef enum hl_model_choice {
  HL_MODEL_AUTO, /* the smallest model that explains the corners */
  HL_MODEL_PINHOLE,
  HL_MODEL_RATIONAL,
  HL_MODEL_FISHEYE
} hl_model_choice;

/** How to calibrate. */
typedef struct hl_calibration_settings {
  hl_model_choice model;
  int min_views;         /* fewer are refused */
  double outlier_sigmas; /* corners off by so many deviations are left out; 0 = never */
  double view_ratio;     /* views whose rms is so many times the median are left out; 0 = never */
  double model_gain;     /* least cross-validated gain for a larger model */
} hl_calibration_settings;

/** The defaults; they pass their own check. */
HL_API hl_calibration_settings hl_calibration_defaults(void);
/** Name, unit, bounds and text of every setting. */
HL_API const hl_field_table *hl_calibration_fields(void);

/** Owner of `view`; hl_calibration_free releases it. */
typedef struct hl_calibration {
  bool trusted; /* false: reasons say why */
  hl_notes reasons, used, left_out;
  hl_camera camera; /* with covariance, rms_px and observations */
  hl_target target; /* columns 0: not stated (a camera file without views) */
  int n_views;
  hl_view_pose *view;
  double noise_px;  /* s: of a corner of relative deviation 1, along one axis */
  double coverage;  /* share of the frame's cells (10 x 10) that hold a corner, 0..1 */
  double tilt_deg;  /* largest angle between two boards */
  double condition; /* of the intrinsics' information, scaled to a unit diagonal, 1-norm */
  double scatter; /* how much more than white noise the views pull the intrinsics apart: 1 where the
                       corners' errors are independent; the stated deviations are too small by its
                       square root where they are not */
  int corners_used, corners_left_out;
  int n_projections;
  hl_projection projection[HL_PROJECTIONS_MAX]; /* centre and corners of the frame, as directions
                                                   and at the boards' mean distance, then others */
} hl_calibration;

/** Release what it holds and zero it; NULL is accepted. */
HL_API void hl_calibration_free(hl_calibration *calibration);

/**
 * Calibrate from corners.
 *
 * Views that cannot be used (left out before, too few corners, corners in a row, seen mirrored) and
 * views and corners that stand out are left out, with the reason in out->view. The rational model
 * is solved with its denominator held within a factor e of 1 (calib/intrinsics_solve.c): its
 * coefficients mean little one by one, what it projects and how sure that is holds.
 *
 * @param settings NULL means hl_calibration_defaults()
 * @param out      written only on HL_OK; the caller releases it with hl_calibration_free
 * @return HL_OK, also where the answer is not to be trusted (out->trusted says);
 *         HL_ERR_ARG (settings, target, frame size unknown); HL_ERR_FORMAT (corners outside the
 *         frame); HL_ERR_DEGENERATE (too few views, parallel boards, corners that fit no camera or
 *         one that does not see its own frame); HL_ERR_NOT_CONVERGED; HL_ERR_UNAVAILABLE without
 *         OpenCV; HL_ERR_MEMORY
 * Deterministic. Cost O(corners) an iteration, some tens of them; OpenCV's start O(views^3) up to
 * 60 views. Source: Zhang, A Flexible New Technique for Camera Calibration, 2000; what is said about
 * the answer is derived above and in calib/intrinsics.c.
 */
HL_API hl_status hl_calibrate(hl_ctx *ctx, const hl_corners *corners,
                              const hl_calibration_settings *settings, hl_calibration *out);

/**
 * How far a pixel may really be from where the camera says it is: covariance of the projection of
 * the point that the camera sees at `pixel` at `distance_m`, with the camera's own place in the
 * world taken from the boards it saw (as mrcal does: the point is fixed to every board, and the
 * boards' poses move with the intrinsics).
 * @param distance_m > 0, or HUGE_VAL for a direction
 * @return HL_OK; HL_ERR_DEGENERATE (no views or no covariance); what unprojection says
 */
HL_API hl_status hl_projection_covariance(hl_ctx *ctx, const hl_calibration *calibration,
                                          const double pixel[2], double distance_m,
                                          double out_px2[2][2]);

/**
 * The same, appended to the calibration's own list.
 * @return also HL_ERR_ARG where the list is full
 */
HL_API hl_status hl_calibration_project(hl_ctx *ctx, hl_calibration *calibration,
                                        const double pixel[2], double distance_m);

/** CAMERA.json with everything above; *out is the caller's, release it with free(). */
HL_API hl_status hl_calibration_json(hl_ctx *ctx, const hl_calibration *calibration, char **out);

/** CAMERA.json to a file, whole or not at all. */
HL_API hl_status hl_calibration_write(hl_ctx *ctx, const char *path,
                                      const hl_calibration *calibration);

/** Read CAMERA.json with its views where it has them; as hl_camera_read otherwise. */
HL_API hl_status hl_calibration_read(hl_ctx *ctx, const char *path, hl_calibration *out);

#ifdef __cplusplus
}
#endif
#endif
