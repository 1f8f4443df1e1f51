/*
 * Buffers as a driver delivers them, as frames of 16-bit codes.
 *
 * Formats are known by DRM's four characters, as libcamera names them; the modifier tells samples in
 * words (0) from CSI-2 packed ones. An 8-bit value v becomes 257 v, so that full scale stays full.
 */
#include "raw_frame.h"

#include <string.h>

#define CSI2_PACKED (UINT64_C(11) << 56 | 1)

static const hl_raw_format formats[] = {
    {0, HL_BAYER_RGGB, HL_BAYER_8, 8, "RGGB", true, false},
    {0, HL_BAYER_GRBG, HL_BAYER_8, 8, "GRBG", true, false},
    {0, HL_BAYER_GBRG, HL_BAYER_8, 8, "GBRG", true, false},
    {0, HL_BAYER_BGGR, HL_BAYER_8, 8, "BA81", true, false},
    {0, HL_BAYER_RGGB, HL_BAYER_WORDS, 10, "RG10", true, false},
    {0, HL_BAYER_GRBG, HL_BAYER_WORDS, 10, "BA10", true, false},
    {0, HL_BAYER_GBRG, HL_BAYER_WORDS, 10, "GB10", true, false},
    {0, HL_BAYER_BGGR, HL_BAYER_WORDS, 10, "BG10", true, false},
    {0, HL_BAYER_RGGB, HL_BAYER_WORDS, 12, "RG12", true, false},
    {0, HL_BAYER_GRBG, HL_BAYER_WORDS, 12, "BA12", true, false},
    {0, HL_BAYER_GBRG, HL_BAYER_WORDS, 12, "GB12", true, false},
    {0, HL_BAYER_BGGR, HL_BAYER_WORDS, 12, "BG12", true, false},
    {0, HL_BAYER_RGGB, HL_BAYER_WORDS, 16, "RGB6", true, false},
    {0, HL_BAYER_GRBG, HL_BAYER_WORDS, 16, "GR16", true, false},
    {0, HL_BAYER_GBRG, HL_BAYER_WORDS, 16, "GB16", true, false},
    {0, HL_BAYER_BGGR, HL_BAYER_WORDS, 16, "BYR2", true, false},
    {CSI2_PACKED, HL_BAYER_RGGB, HL_BAYER_CSI2_10, 10, "RG10", true, false},
    {CSI2_PACKED, HL_BAYER_GRBG, HL_BAYER_CSI2_10, 10, "BA10", true, false},
    {CSI2_PACKED, HL_BAYER_GBRG, HL_BAYER_CSI2_10, 10, "GB10", true, false},
    {CSI2_PACKED, HL_BAYER_BGGR, HL_BAYER_CSI2_10, 10, "BG10", true, false},
    {CSI2_PACKED, HL_BAYER_RGGB, HL_BAYER_CSI2_12, 12, "RG12", true, false},
    {CSI2_PACKED, HL_BAYER_GRBG, HL_BAYER_CSI2_12, 12, "BA12", true, false},
    {CSI2_PACKED, HL_BAYER_GBRG, HL_BAYER_CSI2_12, 12, "GB12", true, false},
    {CSI2_PACKED, HL_BAYER_BGGR, HL_BAYER_CSI2_12, 12, "BG12", true, false},
    /* DRM names the colours from the high byte of a little-endian word, so the first in memory last */
    {0, HL_BAYER_RGGB, HL_BAYER_8, 8, "BG24", false, true},
    {0, HL_BAYER_RGGB, HL_BAYER_8, 8, "RG24", false, false},
};

const hl_raw_format *hl_raw_format_of(uint32_t fourcc, uint64_t modifier)
{
  const char text[4] = {(char)(fourcc & 0xff), (char)(fourcc >> 8 & 0xff),
                        (char)(fourcc >> 16 & 0xff), (char)(fourcc >> 24 & 0xff)};
  for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
    if (memcmp(formats[i].fourcc, text, sizeof text) == 0 && formats[i].modifier == modifier)
      return &formats[i];
  return NULL;
}

static hl_status widen(hl_ctx *ctx, const hl_raw_format *format, const uint8_t *bytes, size_t n,
                       size_t stride, int width, int height, uint16_t *codes)
{
  const size_t row = 3 * (size_t)width;
  if (stride < row || n < stride * (size_t)(height - 1) + row)
    return hl_fail(ctx, HL_ERR_ARG,
                   "frame of %d x %d in %zu bytes, %zu a row; %zu a row are needed", width, height,
                   n, stride, row);
  for (size_t y = 0; y < (size_t)height; y++)
    for (size_t x = 0; x < (size_t)width; x++)
      for (size_t k = 0; k < 3; k++) {
        const size_t at = format->red_first ? k : 2 - k;
        *codes++ = (uint16_t)(257 * bytes[stride * y + 3 * x + at]);
      }
  return HL_OK;
}

hl_status hl_raw_develop(hl_ctx *ctx, const hl_raw_format *format, hl_session_pixels pixels,
                         const uint8_t *bytes, size_t n, size_t stride, int width, int height,
                         uint16_t *samples, uint16_t *codes, hl_capture_frame *out)
{
  const bool green = pixels == HL_PIXELS_RAW_GREEN;
  if (format->bayer == (pixels == HL_PIXELS_PROCESSED))
    return hl_fail(ctx, HL_ERR_ARG, "frames of format %s are not %s", format->fourcc,
                   hl_session_pixels_text(pixels));
  hl_status st;
  if (format->bayer)
    st = hl_bayer_unpack(ctx, format->packing, format->bits, bytes, n, stride, width, height,
                         samples);
  else
    st = widen(ctx, format, bytes, n, stride, width, height, codes);
  if (st != HL_OK)
    return st;
  if (format->bayer && green)
    hl_bayer_green(format->order, samples, width, height, codes);
  else if (format->bayer)
    hl_bayer_demosaic(format->order, samples, width, height, codes);
  out->width = green ? width / 2 : width;
  out->height = green ? height / 2 : height;
  out->channels = green ? 1 : 3;
  out->bits = 16;
  out->codes = codes;
  out->codes_mean.transfer = format->bayer ? HL_TRANSFER_LINEAR : HL_TRANSFER_SRGB;
  return HL_OK;
}
