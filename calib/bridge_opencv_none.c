/* A build without OpenCV. */
#include "halflight/bridge_opencv.h"

hl_status hl_opencv_decode(hl_ctx *ctx, const char *path, const char *kind,
                           const unsigned char *bytes, size_t n, hl_codes *out)
{
  (void)bytes;
  (void)n;
  (void)out;
  return hl_fail(ctx, HL_ERR_UNAVAILABLE,
                 "%s: %s frame needs OpenCV: build with -DHL_WITH_OPENCV=ON, or give a PFM", path,
                 kind);
}

hl_status hl_opencv_png16(hl_ctx *ctx, const char *path, const unsigned short *codes, int width,
                          int height, int channels, unsigned char **bytes, size_t *n)
{
  (void)codes;
  (void)width;
  (void)height;
  (void)channels;
  (void)bytes;
  (void)n;
  return hl_fail(ctx, HL_ERR_UNAVAILABLE,
                 "%s: a PNG needs OpenCV: build with -DHL_WITH_OPENCV=ON, or write a PFM", path);
}

const char *hl_opencv_version(void)
{
  return NULL;
}
