/**
 * The seen surface: for each usable pixel its outward normal and the direction to the camera.
 */
#ifndef HALFLIGHT_SURFACE_H
#define HALFLIGHT_SURFACE_H

#include "halflight/sphere.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Owner of its arrays; `hl_surface_free` releases them. Unit vectors, camera frame. */
typedef struct hl_surface {
  int n;
  int width, height; /* of the frame the pixels index */
  int *pixel;        /* shape (n): y * width + x, ascending */
  double *normal;    /* shape (n,3) outward */
  double *view;      /* shape (n,3) from the surface to the camera */
  double *footprint; /* shape (n): change of the normal across one pixel [rad], at least 1e-6, for
                        edges inside pixels */
} hl_surface;

/**
 * Pixels whose whole area lies on the ball and whose normal is seen at cos >= min_cos_view.
 *
 * @param min_cos_view least n.v, above 0 and below 1; the rim's pixels say more about their
 *        neighbours than themselves
 * @return HL_OK; HL_ERR_ARG; HL_ERR_DEGENERATE (the ball is outside the frame, or smaller than
 *         3 px in radius); HL_ERR_MEMORY
 */
HL_API hl_status hl_surface_of_sphere(hl_ctx *ctx, const hl_camera *camera, const hl_sphere *sphere,
                                      double min_cos_view, hl_surface *out);

/**
 * Any other surface: a normal map of the frame's size, three channels, camera frame (x right, y
 * down, z forward); (0,0,0) or a non-finite normal means no surface. Views are the pixels' rays
 * reversed.
 * @return HL_OK; HL_ERR_ARG (min_cos_view); HL_ERR_FORMAT (size, channels, normals whose length is off by over 1 %, none
 * facing the camera); HL_ERR_MEMORY
 */
HL_API hl_status hl_surface_of_normals(hl_ctx *ctx, const hl_camera *camera,
                                       const hl_frame *normals, double min_cos_view,
                                       hl_surface *out);

HL_API void hl_surface_free(hl_surface *surface);

#ifdef __cplusplus
}
#endif
#endif
