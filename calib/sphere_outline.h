/* Sub-pixel readings of a ball's outline. Private to calib/. */
#ifndef HALFLIGHT_CALIB_SPHERE_OUTLINE_H
#define HALFLIGHT_CALIB_SPHERE_OUTLINE_H

#include "sphere_pose.h"

enum { HL_OUTLINE_SECTORS_MAX = 96, HL_OUTLINE_BLURS_MAX = 8 };

/* What a rim sector turned out to be. */
typedef enum hl_outline_kind {
  HL_OUTLINE_OUTSIDE, /* outside the frame, clipped or unusable */
  HL_OUTLINE_NO_EDGE, /* nothing to see there */
  HL_OUTLINE_ASTRAY,  /* an edge, but not within reach */
  HL_OUTLINE_EDGE
} hl_outline_kind;

typedef struct hl_outline_sector {
  hl_outline_kind kind;
  double azimuth_rad;
  double offset_px; /* the edge lies this far outside the cone's image */
  double sigma_px;
  double rad_per_px; /* across the outline */
} hl_outline_sector;

/* How to look at the outline. */
typedef struct hl_outline_look {
  double reach_px; /* pixels within about this distance of the outline */
  double blur_px;  /* standard deviation beyond the pixel's own square */
  bool wide;       /* the outline may be off by a pixel or more: look for the best valley first */
} hl_outline_look;

/*
 * Read the outline of `cone` in `n` equal sectors. Allocates nothing; O(n x pixels of a sector).
 */
void hl_outline_read(const hl_frame *frame, const hl_camera *camera, const hl_cone *cone, int n,
                     const hl_outline_look *look, hl_outline_sector *out);

/* The likeliest of a few ascending blurs, refined between them. `look->blur_px` is not used. */
double hl_outline_blur(const hl_frame *frame, const hl_camera *camera, const hl_cone *cone, int n,
                       const hl_outline_look *look, const double *blurs, int n_blurs);

#endif
