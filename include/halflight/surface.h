/**
 * The seen surface: for each usable pixel its outward normal and the direction to the camera.
 *
 * A surface knows the camera and the ball it was made of, because what is uncertain about them moves
 * it, and with it the light.
 */
#ifndef HALFLIGHT_SURFACE_H
#define HALFLIGHT_SURFACE_H

#include "halflight/sphere.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Owner of its arrays; `hl_surface_free` releases them. Unit vectors, camera frame. One made by hand
 * may leave the last three members zero: its geometry is then taken as exact. */
typedef struct hl_surface {
  int n;
  int width, height; /* of the frame the pixels index */
  int *pixel;        /* shape (n): y * width + x, ascending */
  double *normal;    /* shape (n,3) outward */
  double *view;      /* shape (n,3) from the surface to the camera */
  double *footprint; /* shape (n): change of the normal across one pixel [rad], at least 1e-6, for
                        edges inside pixels */
  hl_camera camera;  /* it was seen through */
  bool is_ball;
  hl_sphere ball; /* where is_ball: the pose that the normals follow from */
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

/**
 * A normal map seen along one direction, as a drawing or an orthographic photo shows it.
 *
 * @param normals three channels in any right-handed frame; (0,0,0) means no surface
 * @param view    unit, from the surface to the viewer, in the same frame
 * @return as hl_surface_of_normals; the map has no camera whose size it must have
 */
HL_API hl_status hl_surface_of_parallel_view(hl_ctx *ctx, const hl_frame *normals,
                                             const double view[3], double min_cos_view,
                                             hl_surface *out);

/**
 * How the normal of one pixel turns as the ball's centre moves [1/m]; 0 where the surface is no ball.
 * @param i place in the surface, 0 .. n - 1
 */
HL_API void hl_surface_by_center(const hl_surface *surface, int i, double normal[3][3]);

/**
 * How the normal and the view of one pixel turn as the camera's intrinsics change (fx, fy, cx, cy,
 * distortion...), the ball's centre held; the normals of a map stay.
 *
 * @param i place in the surface, 0 .. n - 1
 * @param normal, view the first hl_camera_intrinsics_count columns are written
 * @return HL_OK; HL_ERR_ARG (a surface that knows no camera); HL_ERR_NOT_CONVERGED as
 *         hl_camera_unproject. Allocates nothing.
 */
HL_API hl_status hl_surface_by_intrinsics(hl_ctx *ctx, const hl_surface *surface, int i,
                                          double normal[3][HL_INTRINSICS_MAX],
                                          double view[3][HL_INTRINSICS_MAX]);

/** Release what it holds and zero it; NULL is accepted. */
HL_API void hl_surface_free(hl_surface *surface);

#ifdef __cplusplus
}
#endif
#endif
