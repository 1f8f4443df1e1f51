/*
 * Raw Bayer frames.
 *
 * MIPI Alliance CSI-2 packs four 10-bit samples into five bytes and two 12-bit ones into three: the
 * high eight bits of each first, then a byte with what is left of them, the first sample lowest.
 * V4L2 describes the same as SRGGB10P and SRGGB12P.
 */
#include "bayer.h"

enum { FULL = 65535 };

size_t hl_bayer_row_bytes(hl_bayer_packing packing, int width)
{
  const size_t n = (size_t)width;
  switch (packing) {
  case HL_BAYER_8:
    return n;
  case HL_BAYER_WORDS:
    return 2 * n;
  case HL_BAYER_CSI2_10:
    return (n * 10 + 7) / 8;
  case HL_BAYER_CSI2_12:
    return (n * 12 + 7) / 8;
  }
  return 0;
}

static uint16_t scaled(unsigned sample, unsigned full)
{
  const unsigned within = sample > full ? full : sample;
  return (uint16_t)((within * (uint64_t)FULL + full / 2) / full);
}

static unsigned sample_at(hl_bayer_packing packing, const uint8_t *row, size_t x)
{
  const uint8_t *group;
  switch (packing) {
  case HL_BAYER_8:
    return row[x];
  case HL_BAYER_WORDS:
    return row[2 * x] | (unsigned)row[2 * x + 1] << 8;
  case HL_BAYER_CSI2_10:
    group = row + x / 4 * 5;
    return (unsigned)group[x % 4] << 2 | (group[4] >> 2 * (x % 4) & 3u);
  case HL_BAYER_CSI2_12:
    group = row + x / 2 * 3;
    return (unsigned)group[x % 2] << 4 | (group[2] >> 4 * (x % 2) & 15u);
  }
  return 0;
}

hl_status hl_bayer_unpack(hl_ctx *ctx, hl_bayer_packing packing, int bits, const uint8_t *bytes,
                          size_t n, size_t stride, int width, int height, uint16_t *out)
{
  const int group = packing == HL_BAYER_CSI2_10 ? 4 : packing == HL_BAYER_CSI2_12 ? 2 : 1;
  const int depth = packing == HL_BAYER_8         ? 8
                    : packing == HL_BAYER_CSI2_10 ? 10
                    : packing == HL_BAYER_CSI2_12 ? 12
                                                  : bits;
  if (width < 1 || height < 1 || width % group != 0)
    return hl_fail(ctx, HL_ERR_ARG,
                   "raw frame of %d x %d; a width that is a multiple of %d is needed", width,
                   height, group);
  if (depth < 8 || depth > 16)
    return hl_fail(ctx, HL_ERR_ARG, "raw samples of %d bits; 8 to 16 are accepted", depth);
  const size_t row_bytes = hl_bayer_row_bytes(packing, width);
  if (stride < row_bytes || n < stride * (size_t)(height - 1) + row_bytes)
    return hl_fail(ctx, HL_ERR_ARG,
                   "raw frame of %d x %d in %zu bytes, %zu a row; %zu a row are needed", width,
                   height, n, stride, row_bytes);
  const unsigned full = (1u << depth) - 1;
  for (int y = 0; y < height; y++)
    for (size_t x = 0; x < (size_t)width; x++)
      *out++ = scaled(sample_at(packing, bytes + stride * (size_t)y, x), full);
  return HL_OK;
}

/* 0 red, 1 green, 2 blue. */
static int colour_at(hl_bayer_order order, int x, int y)
{
  static const int cell[4][2][2] = {
      {{0, 1}, {1, 2}}, {{1, 0}, {2, 1}}, {{1, 2}, {0, 1}}, {{2, 1}, {1, 0}}};
  return cell[order][y & 1][x & 1];
}

void hl_bayer_green(hl_bayer_order order, const uint16_t *codes, int width, int height,
                    uint16_t *out)
{
  /* green lies on one diagonal of the cell or on the other */
  const int first = colour_at(order, 0, 0) == 1 ? 0 : 1;
  const size_t stride = (size_t)width;
  for (int y = 0; y + 1 < height; y += 2)
    for (int x = 0; x + 1 < width; x += 2) {
      const uint16_t *cell = codes + stride * (size_t)y + x;
      const unsigned sum = cell[first] + (unsigned)cell[stride + (size_t)(1 - first)];
      *out++ = (uint16_t)((sum + ((sum >> 1) & 1)) >> 1);
    }
}

static uint16_t mean_of(hl_bayer_order order, const uint16_t *codes, int width, int height, int x,
                        int y, int colour)
{
  unsigned sum = 0;
  unsigned n = 0;
  for (int j = y - 1; j <= y + 1; j++)
    for (int i = x - 1; i <= x + 1; i++)
      if (i >= 0 && j >= 0 && i < width && j < height && colour_at(order, i, j) == colour) {
        sum += codes[(size_t)j * (size_t)width + (size_t)i];
        n++;
      }
  return (uint16_t)(n > 0 ? (sum + n / 2) / n : 0);
}

void hl_bayer_demosaic(hl_bayer_order order, const uint16_t *codes, int width, int height,
                       uint16_t *out)
{
  for (int y = 0; y < height; y++)
    for (int x = 0; x < width; x++) {
      const int own = colour_at(order, x, y);
      for (int c = 0; c < 3; c++)
        *out++ = c == own ? codes[(size_t)y * (size_t)width + (size_t)x]
                          : mean_of(order, codes, width, height, x, y, c);
    }
}
