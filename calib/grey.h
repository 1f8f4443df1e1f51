/* One plane of a frame: linear, and coded to 8 bits for detectors. */
#ifndef HL_GREY_H
#define HL_GREY_H

#include <stdint.h>

#include "halflight/frame.h"

enum { HL_GREY_SIDE_MIN = 128 };

/* Owner of its arrays; hl_grey_free releases them. */
typedef struct hl_grey {
  int width, height;
  float *linear; /* shape (height, width), mean of the channels */
  float white;   /* level that is coded as 255 */
  int stride;    /* bytes a row of the two below; both are at least HL_GREY_SIDE_MIN, */
  int rows;      /* what lies beyond the frame is 0 */
  uint8_t *code;
  uint8_t *spare;
} hl_grey;

hl_status hl_grey_of(hl_ctx *ctx, const hl_frame *frame, hl_grey *out);
void hl_grey_free(hl_grey *grey);

/* Between pixels, bilinear; beyond the frame as at its rim. */
double hl_grey_at(const hl_grey *grey, double x, double y);

/* Fill `code` as 8-bit sRGB does it, 255 at grey->white. */
void hl_grey_code_curved(hl_grey *grey);

/* Fill `code` in proportion to radiance, 255 at `white`. */
void hl_grey_code_linear(hl_grey *grey, float white);

/* White grows by a pixel to every side: `code` becomes its maximum over 3 x 3. */
void hl_grey_widen(hl_grey *grey);

/* `code` left to right. */
void hl_grey_mirror(hl_grey *grey);

#endif
