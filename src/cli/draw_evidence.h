/* What a light's fit did pixel by pixel, as pictures of the ball alone. */
#ifndef HL_CLI_DRAW_EVIDENCE_H
#define HL_CLI_DRAW_EVIDENCE_H

#include "draw.h"

typedef enum hl_panel {
  HL_PANEL_NORMALS,
  HL_PANEL_MEASURED,
  HL_PANEL_FITTED,
  HL_PANEL_RESIDUAL, /* HL_RESIDUAL_FACTOR times photo less fit */
  HL_PANEL_MASK
} hl_panel;

enum { HL_RESIDUAL_FACTOR = 3 }; /* as the paper shows it */

/* Arrays of shape (surface->n): mean radiance over the channels, and 1 where a pixel was used. */
typedef struct hl_pixels {
  const hl_frame *frame;
  const hl_surface *surface;
  const float *predicted, *measured, *weight;
  hl_panel panel;
} hl_pixels;

/* `data` is an hl_pixels; PNG only. HL_ERR_IO, HL_ERR_MEMORY. */
hl_status hl_draw_pixels(hl_ctx *ctx, hl_picture_kind kind, const char *path, const void *data);

/* How many of the surface's pixels are used, have a clipped channel, and are left out. */
void hl_pixels_count(const hl_pixels *pixels, int *used, int *clipped, int *left_out);

#endif
