/* Edge points of a frame, for the search for a ball. Private to calib/. */
#ifndef HALFLIGHT_CALIB_SPHERE_EDGES_H
#define HALFLIGHT_CALIB_SPHERE_EDGES_H

#include "halflight/frame.h"

typedef struct hl_edge {
  float x, y;   /* frame pixels */
  float gx, gy; /* unit, towards the brighter side */
} hl_edge;

typedef struct hl_edges {
  hl_edge *edge; /* released by hl_edges_free */
  int n;
  int found;  /* before thinning to n */
  int shrink; /* frame pixels per search pixel */

} hl_edges;

enum { HL_EDGES_MAX = 12000, HL_SEARCH_SIDE_MAX = 800 };

/*
 * Points where the frame steps by more than its noise explains, in a copy of at most
 * HL_SEARCH_SIDE_MAX pixels a side. HL_OK or HL_ERR_MEMORY.
 */
hl_status hl_edges_find(hl_ctx *ctx, const hl_frame *frame, hl_edges *out);

void hl_edges_free(hl_edges *edges);

#endif
