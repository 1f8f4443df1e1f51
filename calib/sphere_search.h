/* Circles among edge points: where a ball may be. Private to calib/. */
#ifndef HALFLIGHT_CALIB_SPHERE_SEARCH_H
#define HALFLIGHT_CALIB_SPHERE_SEARCH_H

#include "sphere_edges.h"
#include "sphere_pose.h"

typedef struct hl_candidate {
  hl_cone cone;
  double x, y, radius; /* in the stereographic picture, search pixels */
  double coverage;     /* share of the circle with edge points along it, 0..1 */
  double score;
} hl_candidate;

enum { HL_CANDIDATES_MAX = 24 };

typedef struct hl_search_range {
  double min_radius_px, max_radius_px;
  double hint[3]; /* x, y, radius [px]; radius > 0: only near it */
} hl_search_range;

/* Candidates, best first. HL_OK (with n = 0 where there is none) or HL_ERR_MEMORY. */
hl_status hl_search_circles(hl_ctx *ctx, const hl_edges *edges, const hl_camera *camera,
                            const hl_search_range *range, hl_candidate *out, int *n);

#endif
