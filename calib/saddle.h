/* Corners where two black and two white quarters meet. */
#ifndef HL_SADDLE_H
#define HL_SADDLE_H

#include "grey.h"
#include "halflight/corners.h"

/* A corner and its surroundings. */
typedef struct hl_cross {
  double at[2];
  double across[2], down[2]; /* px, along the board's x and y: as far as the quarters reach */
} hl_cross;

/* Mean radiance of the quarters: up left and down right, and the other two. */
void hl_cross_quarters(const hl_grey *grey, const hl_cross *cross, double quarter[4]);

/* Largest window about the corner, 2 half + 1 px a side, that sees nothing but its four quarters to
 * speak of; below HL_SADDLE_HALF_MIN there is no room for one. */
int hl_cross_half(const hl_cross *cross);

enum { HL_SADDLE_HALF_MIN = 2, HL_SADDLE_HALF_MAX = 16 };

/*
 * Move the crosses' corners to their saddles. moved[i] is true where one was found near by; the
 * others stay where they were. HL_OK; HL_ERR_UNAVAILABLE without OpenCV; HL_ERR_MEMORY.
 */
hl_status hl_saddles_refine(hl_ctx *ctx, const hl_grey *grey, hl_cross *cross, bool *moved, int n);

#endif
