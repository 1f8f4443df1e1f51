/* A board that stands still, seen by a calibrated camera. */
#ifndef HL_BOARD_POSE_H
#define HL_BOARD_POSE_H

#include "halflight/drift.h"
#include "sightings.h"

/* The corners of one view, ready to be fitted; *out is the caller's (free). HL_ERR_ARG (no such
 * view); HL_ERR_FORMAT (frame and camera of different size); HL_ERR_DEGENERATE (view left out, too
 * few corners); HL_ERR_MEMORY. */
hl_status hl_board_sightings(hl_ctx *ctx, const hl_camera *camera, const hl_corners *corners,
                             int view, hl_sighting **out, int *n);

/* Deviation of a corner along one axis as the calibration states it; 0: not stated. */
double hl_board_noise(const hl_calibration *calibration);

#endif
