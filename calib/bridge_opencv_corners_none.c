/* A build without OpenCV: no chessboards, and corners stay where they are. */
#include "halflight/bridge_opencv_corners.h"

static hl_status unavailable(hl_ctx *ctx)
{
  return hl_fail(ctx, HL_ERR_UNAVAILABLE,
                 "OpenCV is not in this build, so no chessboard can be found: build with "
                 "-DHL_WITH_OPENCV=ON");
}

hl_status hl_opencv_chessboard(hl_ctx *ctx, const hl_opencv_bytes *image, int columns, int rows,
                               double (*corner)[2], bool *found)
{
  (void)image;
  (void)columns;
  (void)rows;
  (void)corner;
  (void)found;
  return unavailable(ctx);
}

hl_status hl_opencv_chessboard_size(hl_ctx *ctx, const hl_opencv_bytes *image, int *columns,
                                    int *rows)
{
  (void)image;
  (void)columns;
  (void)rows;
  return unavailable(ctx);
}

hl_status hl_opencv_saddles(hl_ctx *ctx, const float *linear, int width, int height,
                            const int *half, double (*corner)[2], int n)
{
  (void)linear;
  (void)width;
  (void)height;
  (void)half;
  (void)corner;
  (void)n;
  return unavailable(ctx);
}

bool hl_opencv_has_saddles(void)
{
  return false;
}
