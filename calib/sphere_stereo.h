/* The stereographic picture of a camera's rays. Private to calib/. */
#ifndef HALFLIGHT_CALIB_SPHERE_STEREO_H
#define HALFLIGHT_CALIB_SPHERE_STEREO_H

#include "halflight/camera.h"

/* Nodes over the frame, interpolated between: a lens inversion a node, not a point. */
typedef struct hl_stereo {
  int nx, ny; /* cells */
  double dx, dy;
  double *at; /* (ny + 1) x (nx + 1) x 2 */
} hl_stereo;

/* `focal` scales the picture. HL_OK, HL_ERR_MEMORY or what the lens refuses. */
hl_status hl_stereo_make(hl_ctx *ctx, const hl_camera *camera, double focal, hl_stereo *g);

void hl_stereo_free(hl_stereo *g);

/* Place in the picture of a frame pixel, and its Jacobian, by bilinear interpolation. */
void hl_stereo_at(const hl_stereo *g, double x, double y, double out[2], double jac[2][2]);

#endif
