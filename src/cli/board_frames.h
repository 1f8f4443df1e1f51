/* Corners of a board in many frames. */
#ifndef HL_CLI_BOARD_FRAMES_H
#define HL_CLI_BOARD_FRAMES_H

#include "halflight/halflight.h"
#include "options.h"

/*
 * Read every frame and look for the target in it, several at a time; one view a frame, in their
 * order, whatever the number of threads (0 = as many as the machine has). `out` began as
 * hl_corners_of(target). HL_ERR_FORMAT where two frames differ in size, naming both; else the first
 * frame's failure, named.
 */
hl_status hl_board_frames(hl_ctx *ctx, const hl_words *frames, const hl_frame_settings *settings,
                          int threads, hl_corners *out);

#endif
