/* How sharp an edge is. */
#ifndef HL_EDGE_BLUR_H
#define HL_EDGE_BLUR_H

#include "grey.h"

/*
 * Standard deviation, in pixels, of what blurred the straight step between `a` and `b`, read over
 * its middle half and up to `reach` pixels to either side. NAN where there is no clear step; where
 * it is wider than the reach lets be seen, about half the reach.
 */
double hl_edge_blur(const hl_grey *grey, const double a[2], const double b[2], double reach);

#endif
