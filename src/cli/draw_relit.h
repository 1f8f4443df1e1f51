/* A relit image as a picture: alone, or beside the photo it should match. */
#ifndef HL_CLI_DRAW_RELIT_H
#define HL_CLI_DRAW_RELIT_H

#include "draw.h"

/* Radiance that becomes white: so that 99.5 % of the surface's samples lie below it; 1 for a black
 * image. */
double hl_relit_white(const hl_frame *relit, const hl_surface *surface);

/* 8-bit sRGB, `white` at full scale, nothing else done to it. HL_ERR_IO, HL_ERR_MEMORY. */
hl_status hl_draw_relit(hl_ctx *ctx, const char *path, const hl_frame *relit, double white);

enum { HL_ERROR_FACTOR = 3 }; /* the error is shown so many times as large (the paper's figures) */

/* Relit, photo and HL_ERROR_FACTOR times their difference side by side, at one exposure. */
hl_status hl_draw_comparison(hl_ctx *ctx, hl_picture_kind kind, const char *path,
                             const hl_frame *relit, const hl_frame *photo,
                             const hl_frame *difference, const hl_relit_error *error, double white);

#endif
