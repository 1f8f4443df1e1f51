/* A chessboard in a frame. */
#ifndef HL_CHESSBOARD_H
#define HL_CHESSBOARD_H

#include "grey.h"
#include "halflight/corners.h"

/*
 * Find the board, whole. As hl_aprilgrid_find.
 * HL_OK; HL_ERR_UNAVAILABLE without OpenCV; HL_ERR_MEMORY.
 */
hl_status hl_chessboard_find(hl_ctx *ctx, const hl_target *target, hl_grey *grey, hl_corner *corner,
                             hl_detection *detection, char why[HL_REASON_MAX]);

#endif
