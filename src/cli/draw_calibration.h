/* A calibration as a picture. */
#ifndef HL_CLI_DRAW_CALIBRATION_H
#define HL_CLI_DRAW_CALIBRATION_H

#include "draw.h"

/* Where the corners were and what is left of each, how sure the projection is over the frame, and
 * every view's rms. `corners` are those the calibration was made from. */
hl_status hl_draw_calibration(hl_ctx *ctx, hl_picture_kind kind, const char *path,
                              const hl_calibration *calibration, const hl_corners *corners);

#endif
