/* What the pixels of one frame say about the ball's pose. Private. */
#ifndef HL_LIGHT_POSE_H
#define HL_LIGHT_POSE_H

#include "halflight/light.h"

/* The residual's cost, in units of its own variance, as the ball's centre moves by d while direction
 * and curves follow: cost(d) = cost(0) - 2 gradient.d + d' information d. */
typedef struct hl_light_pose {
  double gradient[3], information[3][3]; /* [1/m], [1/m^2] */
  double by_center[2][3];                /* how the direction follows [rad/m] */
} hl_light_pose;

typedef struct hl_light_pose_work hl_light_pose_work;

/* HL_OK; HL_ERR_MEMORY. The caller frees `out`. */
hl_status hl_light_pose_new(hl_ctx *ctx, int max_pixels, int channels, hl_light_pose_work **out);
void hl_light_pose_free(hl_light_pose_work *work);

/* After hl_light_estimate with the same `light` and `surface`, a ball's. False where the curves cannot
 * be had. Allocates nothing. O(pixels). */
bool hl_light_pose_score(hl_light_work *light, const hl_surface *surface, hl_light_pose_work *work,
                         hl_light_pose *out);

/* After hl_light_pose_score: covariance, in radiance squared, of the body's strength and of the lobe at
 * `angle_rad` [1 .. n - 1], the direction held; shape (n, n). `angle_rad[0]` stands for the body. A body and a lobe that are alike
 * in this frame are told apart by nothing, and this says so. */
void hl_light_pose_profile(const hl_light_work *light, const hl_light_pose_work *work, int channel,
                           double mean_cos_view, const double *angle_rad, int n,
                           double *covariance);

#endif
