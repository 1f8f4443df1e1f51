/**
 * Drawing a fitted reflectance under another light: of a ball, a normal map, or a mesh.
 *
 * Everything drawn is a normal map first; hl_surface_of_parallel_view (or, through a real camera,
 * hl_surface_of_sphere) turns it into pixels with normals and views, and hl_relight gives each its
 * radiance. Attached shadows fall (n.s <= 0 is dark); cast shadows and interreflection do not.
 */
#ifndef HALFLIGHT_RELIGHT_H
#define HALFLIGHT_RELIGHT_H

#include "halflight/reflectance.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Axes of a drawing: unit, orthogonal; `right` and `down` are those of the image. */
typedef struct hl_viewing {
  double right[3], down[3];
  double view[3]; /* towards the viewer */
} hl_viewing;

/**
 * Axes of a drawing seen along `view` with the frame's own up upwards: y in the frame of FIT.json
 * and SAMPLES.csv (x right, y up, z to the viewer), -y in the camera's.
 * @param view any length, not 0; NULL: straight from the front
 * @return HL_OK; HL_ERR_ARG (no direction)
 */
HL_API hl_status hl_viewing_along(hl_ctx *ctx, const double *view, bool camera_frame,
                                  hl_viewing *out);

/**
 * Normals of a ball that fills an image of 2R x 2R pixels, at the pixels' centres.
 * @param out three channels; the caller's, hl_frame_free
 * @return HL_OK; HL_ERR_ARG (radius_px outside [1, 8192]); HL_ERR_MEMORY
 */
HL_API hl_status hl_normals_of_ball(hl_ctx *ctx, int radius_px, const hl_viewing *viewing,
                                    hl_frame *out);

/** A triangle mesh; hl_mesh_free releases it. */
typedef struct hl_mesh {
  int n_vertices, n_faces;
  double *position; /* shape (n_vertices, 3) */
  double *normal;   /* shape (n_vertices, 3) unit; those of the file, else smooth below 60 deg */
  int *face;        /* shape (n_faces, 3) */
} hl_mesh;

/**
 * Read a mesh (OBJ and what else assimp reads), polygons cut into triangles.
 * @return HL_OK; HL_ERR_IO; HL_ERR_FORMAT (damaged, no faces, a vertex that is not finite);
 *         HL_ERR_UNAVAILABLE in a build without assimp; HL_ERR_MEMORY
 */
HL_API hl_status hl_mesh_read(hl_ctx *ctx, const char *path, hl_mesh *out);
/** Release what it holds and zero it; NULL is accepted. */
HL_API void hl_mesh_free(hl_mesh *mesh);

/**
 * Normals of a mesh in an orthographic drawing of width x height pixels that it fills up to a margin
 * of 2 %, hidden surfaces removed (z-buffer, samples at the pixels' centres). Normals that the
 * interpolation turns away from the viewer are turned to the silhouette.
 * @return HL_OK; HL_ERR_ARG (size outside [1, 16384]); HL_ERR_DEGENERATE (no face covers a pixel);
 *         HL_ERR_MEMORY
 */
HL_API hl_status hl_normals_of_mesh(hl_ctx *ctx, const hl_mesh *mesh, const hl_viewing *viewing,
                                    int width, int height, hl_frame *out);

/**
 * Radiance of every pixel of a surface under a light.
 * @param light unit, from the surface to the light, in the reflectance's frame
 * @param out   three channels (grey repeated), 0 off the surface; the caller's, hl_frame_free
 * @return HL_OK; HL_ERR_ARG (light no direction); HL_ERR_MEMORY
 */
HL_API hl_status hl_relight(hl_ctx *ctx, const hl_reflectance *reflectance,
                            const hl_surface *surface, const double light[3], hl_frame *out);

/** How a relit image differs from a photo of the same. */
typedef struct hl_relit_error {
  double scale;          /* the photo was multiplied by it, where asked for; else 1 */
  double relative_error; /* mean |relit - photo| / mean photo over the lit pixels compared */
  double rms;            /* in the relit image's units */
  int n_pixels;          /* compared: lit, usable and not clipped in the photo */
} hl_relit_error;

/**
 * Compare with ground truth of the same size.
 * @param light     pixels with n.light <= 0.02 are not compared
 * @param fit_scale multiply the photo by the factor that fits it best first: for photos whose
 *                  exposure is not the fit's
 * @param difference may be NULL; |relit - photo| of the pixels compared, three channels; the
 *                  caller's
 * @return HL_OK; HL_ERR_FORMAT (size, or nothing to compare); HL_ERR_MEMORY
 */
HL_API hl_status hl_relit_compare(hl_ctx *ctx, const hl_frame *relit, const hl_surface *surface,
                                  const double light[3], const hl_frame *photo, bool fit_scale,
                                  hl_relit_error *out, hl_frame *difference);

/* ---- editing */

/** Multiply a term's curve. A factor below 0 is noted as not physical; HL_ERR_ARG (no such term, which
 * there are; not finite). */
HL_API hl_status hl_reflectance_scale(hl_ctx *ctx, hl_reflectance *reflectance, const char *term,
                                      double factor);

/**
 * Aim a term along (cs s + cv v)/|.|: h is (1,1), the light (1,0), backscatter leans to v. Whatever
 * is not symmetric in s and v, other than the light's own direction, is noted as not reciprocal.
 * HL_ERR_ARG (no such term; both 0; not finite).
 */
HL_API hl_status hl_reflectance_aim(hl_ctx *ctx, hl_reflectance *reflectance, const char *term,
                                    double cs, double cv);

/**
 * Replace a term's curve by one from a CSV `t,value` or `t,r,g,b`, t = cosine from the axis, ascending
 * within [-1, 1], up to HL_CURVE_POINTS rows, header optional. A curve that falls with t, or is below
 * 0, is noted as not physical. HL_ERR_ARG (no such term); HL_ERR_IO; HL_ERR_FORMAT.
 */
HL_API hl_status hl_reflectance_replace(hl_ctx *ctx, hl_reflectance *reflectance, const char *term,
                                        const char *path);

#ifdef __cplusplus
}
#endif
#endif
