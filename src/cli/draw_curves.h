/* The curves of a light's reflectance. */
#ifndef HL_CLI_DRAW_CURVES_H
#define HL_CLI_DRAW_CURVES_H

#include "curve_cloud.h"
#include "draw.h"

typedef struct hl_curve_sheet {
  const hl_light *light;
  const char *lobe;                         /* that panel alone; NULL: all, side by side */
  const hl_curve_cloud *diffuse, *specular; /* may be NULL */
} hl_curve_sheet;

/* The fitted curves against their angles; `data` is an hl_curve_sheet. HL_ERR_IO. */
hl_status hl_draw_curves(hl_ctx *ctx, hl_picture_kind kind, const char *path, const void *data);

#endif
