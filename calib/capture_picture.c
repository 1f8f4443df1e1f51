/* Frames as pictures: 16-bit PNG where OpenCV is there to encode it, else PFM of the same values. */
#include <stdlib.h>

#include "capture_work.h"
#include "halflight/bridge_opencv.h"
#include "halflight/export.h"

#define FULL_16 65535.0f

const char *hl_capture_picture_ending(int bits)
{
  return bits == 16 && hl_opencv_version() ? "png" : "pfm";
}

static hl_status write_png(hl_ctx *ctx, const char *path, const hl_capture_frame *f)
{
  unsigned char *bytes = NULL;
  size_t n = 0;
  hl_status st = hl_opencv_png16(ctx, path, f->codes, f->width, f->height, f->channels, &bytes, &n);
  if (st == HL_OK)
    st = hl_file_write(ctx, path, (const char *)bytes, n);
  free(bytes);
  return st;
}

static hl_status write_pfm16(hl_ctx *ctx, const char *path, const hl_capture_frame *f)
{
  const size_t n = (size_t)f->width * (size_t)f->height * (size_t)f->channels;
  const uint16_t *codes = f->codes;
  float *pixels = malloc(n * sizeof *pixels);
  if (!pixels)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %d x %d pixels", path, f->width,
                   f->height);
  for (size_t i = 0; i < n; i++)
    pixels[i] = (float)codes[i] / FULL_16;
  const hl_status st = hl_pfm_write(ctx, path, pixels, f->width, f->height, f->channels);
  free(pixels);
  return st;
}

hl_status hl_capture_picture_write(hl_ctx *ctx, const char *path, const hl_capture_frame *frame)
{
  if (frame->bits == 32)
    return hl_pfm_write(ctx, path, frame->codes, frame->width, frame->height, frame->channels);
  return hl_opencv_version() ? write_png(ctx, path, frame) : write_pfm16(ctx, path, frame);
}
