/* What a camera's uncertainty does to a ball found through it. Private to calib/. */
#ifndef HALFLIGHT_CALIB_SPHERE_CAMERA_H
#define HALFLIGHT_CALIB_SPHERE_CAMERA_H

#include "sphere_pose.h"

/*
 * How the cone's steps (turn1, turn2, open) follow the camera's intrinsics while the outline's pixels
 * stay: from the n readings of its last fit, `rad_per_px` apart. False where a reading's pixel cannot
 * be had.
 */
bool hl_cone_by_intrinsics(const hl_camera *camera, const hl_cone *cone,
                           const hl_cone_offset *readings, int n, const hl_cone_fit *fit,
                           double out[3][HL_INTRINSICS_MAX]);

/* Add the camera's share to a ball whose covariance is the outline's own, and keep the two apart. */
void hl_sphere_add_camera(const hl_camera *camera, const hl_cone *cone,
                          const double by_intrinsics[3][HL_INTRINSICS_MAX], hl_sphere *ball);

#endif
