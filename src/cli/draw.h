/* Pictures of a result, as PNG, SVG or PDF by the name's ending. */
#ifndef HL_CLI_DRAW_H
#define HL_CLI_DRAW_H

#include <cairo.h>

#include "halflight/halflight.h"
#include "palette.h"

typedef enum hl_picture_kind { HL_PICTURE_PNG, HL_PICTURE_SVG, HL_PICTURE_PDF } hl_picture_kind;

/* HL_ERR_ARG where the ending is none of the three. */
hl_status hl_picture_kind_of(hl_ctx *ctx, const char *option, const char *path,
                             hl_picture_kind *out);

/* A sheet of width x height units on a light ground; the units are pixels, or points in a PDF. */
typedef struct hl_canvas {
  hl_picture_kind kind;
  const char *path;
  double dpi; /* of a PNG, stated in the file; 0 = not stated, as hl_canvas_open leaves it */
  cairo_surface_t *surface;
  cairo_t *cr;
} hl_canvas;

hl_status hl_canvas_open(hl_ctx *ctx, hl_canvas *canvas, hl_picture_kind kind, const char *path,
                         double width, double height);

/* Write the file and release the canvas, also after a failure inside cairo. HL_ERR_IO. */
hl_status hl_canvas_close(hl_ctx *ctx, hl_canvas *canvas);

/* Text with its baseline at y: left of x where align is 1, centred at 0.5, right of x at 0. */
void hl_canvas_text(const hl_canvas *canvas, double x, double y, double align, double size,
                    const char *text);

/* 1, 2 or 5 times a power of ten, at least `rough`: for the ticks of an axis. */
double hl_canvas_step(double rough);

/* What the photo shows; light may be NULL or not found, sphere NULL for a normal map. */
typedef struct hl_photo {
  const hl_frame *frame;
  const hl_camera *camera;
  const hl_sphere *sphere;
  const hl_surface *surface; /* may be NULL */
  const hl_light *light;
  const hl_sphere_fit *fit; /* may be NULL */
  bool bare;                /* smaller, and without the caption */
} hl_photo;

/* The photo, developed for viewing, with outline, highlight, light arrow and 95 % ellipse; `data` is an
 * hl_photo. */
hl_status hl_draw_frame(hl_ctx *ctx, hl_picture_kind kind, const char *path, const void *data);

/* So many times as large the ellipse is drawn on the photo; 0 where it is not. */
int hl_photo_ellipse_factor(const hl_photo *photo);

enum { HL_CAPTION_LINE = 27 }; /* height of one line of the caption */

/* The caption of a photo, from `top` down; the ellipse is drawn `factor` times as large, 0 = not.
 */
void hl_draw_caption(const hl_canvas *canvas, const hl_photo *photo, int factor, double width,
                     double top);

/* The curves of a fit, a panel a term, among what the samples leave for each. */
hl_status hl_draw_fit(hl_ctx *ctx, hl_picture_kind kind, const char *path, const hl_fit *fit,
                      const hl_samples *samples);

/* The projection difference over the frame, or a board's corners, with the verdict above it. */
hl_status hl_draw_drift(hl_ctx *ctx, hl_picture_kind kind, const char *path, const hl_drift *drift,
                        const char *verdict);

#endif
