/* What each pixel of a frame leaves for a fitted curve once the other terms are taken off. */
#ifndef HL_CLI_CURVE_CLOUD_H
#define HL_CLI_CURVE_CLOUD_H

#include "halflight/halflight.h"

enum { HL_CLOUD_BINS = 60, HL_CLOUD_A_BIN = 9, HL_CLOUD_MAX = HL_CLOUD_BINS * HL_CLOUD_A_BIN };

typedef struct hl_curve_cloud {
  int n;
  double angle_rad[HL_CLOUD_MAX];
  double value[HL_CLOUD_MAX][HL_CHANNELS_MAX]; /* what the curve should be at this angle */
} hl_curve_cloud;

/* Of the lobe "diffuse" or "specular" of a light that `reflectance` was read from: up to HL_CLOUD_A_BIN
 * pixels of each HL_CLOUD_BINS-th part of a right angle, clipped ones left out. Empty where the
 * light is near, since one direction does not describe it. */
void hl_curve_cloud_of(const hl_frame *frame, const hl_surface *surface, const hl_light *light,
                       const hl_reflectance *reflectance, const char *lobe, hl_curve_cloud *out);

#endif
