/** Internal, not installed: corners and saddles through OpenCV, in plain C. */
#ifndef HALFLIGHT_BRIDGE_OPENCV_CORNERS_H
#define HALFLIGHT_BRIDGE_OPENCV_CORNERS_H

#include <stdbool.h>
#include <stdint.h>

#include "halflight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** An 8-bit image; rows of `stride` bytes. */
typedef struct hl_opencv_bytes {
  int width, height, stride;
  const uint8_t *pixel;
} hl_opencv_bytes;

/**
 * Find a chessboard of columns x rows inner corners, to about half a pixel.
 * @param corner shape (rows, columns, 2), written where *found; from any of its corners, and a
 *               square board along either side
 * @return HL_OK, also where there is none; HL_ERR_MEMORY; HL_ERR_UNAVAILABLE without OpenCV
 */
hl_status hl_opencv_chessboard(hl_ctx *ctx, const hl_opencv_bytes *image, int columns, int rows,
                               double (*corner)[2], bool *found);

/** How many corners any chessboard there shows, roughly; 0 x 0 where none is seen. As above. */
hl_status hl_opencv_chessboard_size(hl_ctx *ctx, const hl_opencv_bytes *image, int *columns,
                                    int *rows);

/**
 * Move each corner to the saddle near it, looked for in a window of 2 half + 1 pixels a side; one
 * that leaves its window stays where it was.
 * @param linear shape (height, width)
 * @param half   shape (n), 1 or more
 * @param corner shape (n,2), inside the image
 * @return HL_OK; HL_ERR_MEMORY; HL_ERR_UNAVAILABLE without OpenCV
 */
hl_status hl_opencv_saddles(hl_ctx *ctx, const float *linear, int width, int height,
                            const int *half, double (*corner)[2], int n);

/** Is hl_opencv_saddles in this build? */
bool hl_opencv_has_saddles(void);

#ifdef __cplusplus
}
#endif
#endif
