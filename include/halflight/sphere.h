/**
 * The ball: its pose from its outline.
 *
 * Rays u that graze a sphere lie on a circular cone about the direction of its centre: u.w = 1 with
 * axis w/|w|, cos(half-angle) = 1/|w|, distance = radius / sin(half-angle).
 */
#ifndef HALFLIGHT_SPHERE_H
#define HALFLIGHT_SPHERE_H

#include "halflight/camera.h"
#include "halflight/frame.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Where a ball is, and how sure that is. */
typedef struct hl_sphere {
  double center_m[3]; /* camera frame */
  double radius_m;
  bool has_covariance;
  double covariance_m2[3][3]; /* of center_m, radius taken as exact: all that is known of it */
  int n_intrinsics; /* of the camera it was found through, where that camera states a covariance; 0:
                       how the centre depends on a camera is not known */
  double held_covariance_m2[3][3]; /* of center_m with that camera held: the outline's own */
  double by_intrinsics[3][HL_INTRINSICS_MAX]; /* d(center_m)/d(fx, fy, cx, cy, distortion...) with
                                                 the outline's pixels held; `n_intrinsics` columns */
} hl_sphere;

/** How to look for a ball. */
typedef struct hl_sphere_settings {
  double min_radius_px; /* smallest image radius searched for */
  double max_radius_px; /* largest, above the smallest; 0 = 0.75 of the frame's longer side */
  double min_arc;       /* least share of the outline that must be seen, 0..1 */
  double max_rms_px;    /* largest accepted rms of the outline points; half of it beyond noise */
  double hint_x_px, hint_y_px, hint_radius_px; /* hint_radius_px > 0: look near this circle only */
  double
      blur_px; /* of the outline beyond the pixel's own square, as another frame of the same view had
                     it (hl_sphere_fit); 0 = found in this one, at several times the cost */
} hl_sphere_settings;

/** The defaults; they pass their own check. */
HL_API hl_sphere_settings hl_sphere_defaults(void);
/** Name, unit, bounds and text of every setting. */
HL_API const hl_field_table *hl_sphere_fields(void);

/** What the outline said beside the pose. */
typedef struct hl_sphere_fit {
  double center_px[2]; /* of the outline's centre: the projected direction of the ball's centre */
  double radius_px;    /* mean radius of the outline about it */
  double rms_px;       /* of the outline points that were used */
  double arc;          /* share of the outline that was seen, 0..1 */
  int n_points;        /* outline points used */
  double blur_px;      /* of the outline, beyond the pixel's own square */
} hl_sphere_fit;

/**
 * Fit the cone of rays that graze a ball of known radius: linear least squares for a start, then
 * robust (Tukey) reweighting of the angular residual. Closed form start, no guess needed.
 *
 * @param rays      shape (n,3), unit, camera frame
 * @param sigma_rad standard deviation of one ray's angle to the cone; 0 = from the residuals
 * @param rms_rad   may be NULL; angular rms of the rays that were kept
 * @return HL_OK; HL_ERR_ARG (n < 3, radius, rays not finite or not unit); HL_ERR_DEGENERATE (rays
 * do not span a cone); HL_ERR_MEMORY. Allocates one reading a ray; O(n). No covariance is given
 * for fewer than six rays of unstated sigma.
 */
HL_API hl_status hl_sphere_from_rays(hl_ctx *ctx, const double *rays, int n, double radius_m,
                                     double sigma_rad, hl_sphere *out, double *rms_rad);

/**
 * Find one ball in a frame without being told where it is.
 *
 * Where the camera states a covariance, the centre's holds the camera's share too, and the members
 * that keep it apart are filled.
 *
 * @param fit may be NULL
 * @return HL_OK; HL_ERR_ARG (radius, settings, camera and frame of different size); HL_ERR_FORMAT
 * (the camera, as hl_camera_check has it); HL_ERR_DEGENERATE (no outline, too short an arc, several
 * equally good balls, a ball that hl_sphere_check refuses); HL_ERR_RESIDUAL (the best outline is no
 * ball's); HL_ERR_MEMORY. Deterministic. Cost O(pixels) + O(candidates x
 * outline points).
 */
HL_API hl_status hl_sphere_locate(hl_ctx *ctx, const hl_frame *frame, const hl_camera *camera,
                                  double radius_m, const hl_sphere_settings *settings,
                                  hl_sphere *out, hl_sphere_fit *fit);

/**
 * Read the outline about a known pose again, without searching the frame for it: for a ball that was
 * found in another frame of the same view. It follows by a few pixels at most. With settings->blur_px a ball
 * that stands within a third of a pixel of `near` is read at a quarter of the cost.
 *
 * @param near its radius is kept; `settings` as for hl_sphere_locate, whose hint is not looked at
 * @return as hl_sphere_locate; HL_ERR_DEGENERATE also where no outline is near. Allocates nothing.
 * Cost O(outline points).
 */
HL_API hl_status hl_sphere_relocate(hl_ctx *ctx, const hl_frame *frame, const hl_camera *camera,
                                    const hl_sphere *near, const hl_sphere_settings *settings,
                                    hl_sphere *out, hl_sphere_fit *fit);

/** Finite numbers, radius > 0, the ball wholly in front of the camera. HL_OK or HL_ERR_FORMAT. */
HL_API hl_status hl_sphere_check(hl_ctx *ctx, const hl_sphere *sphere);

/** Read and check SPHERE.json; same statuses as hl_camera_read. */
HL_API hl_status hl_sphere_read(hl_ctx *ctx, const char *path, hl_sphere *out);

/** SPHERE.json as text; *out is the caller's, release it with free(). `fit` may be NULL. */
HL_API hl_status hl_sphere_json(hl_ctx *ctx, const hl_sphere *sphere, const hl_sphere_fit *fit,
                                char **out);

/** Write SPHERE.json, whole or not at all. `fit` may be NULL. */
HL_API hl_status hl_sphere_write(hl_ctx *ctx, const char *path, const hl_sphere *sphere,
                                 const hl_sphere_fit *fit);

#ifdef __cplusplus
}
#endif
#endif
