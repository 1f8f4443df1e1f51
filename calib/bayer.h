/* Raw Bayer frames: from packed bytes to codes, from codes to green planes or colours. */
#ifndef HL_BAYER_H
#define HL_BAYER_H

#include <stddef.h>
#include <stdint.h>

#include "halflight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How the samples of a row lie in memory. */
typedef enum hl_bayer_packing {
  HL_BAYER_8,       /* a byte each */
  HL_BAYER_WORDS,   /* 16-bit little-endian words, the low `bits` of each are used */
  HL_BAYER_CSI2_10, /* MIPI CSI-2 RAW10: four high bytes, then one with the low two bits of each */
  HL_BAYER_CSI2_12  /* MIPI CSI-2 RAW12: two high bytes, then one with the low four bits of each */
} hl_bayer_packing;

/* Colour of the top-left sample and its right neighbour. */
typedef enum hl_bayer_order {
  HL_BAYER_RGGB,
  HL_BAYER_GRBG,
  HL_BAYER_GBRG,
  HL_BAYER_BGGR
} hl_bayer_order;

/* Bytes that a row of `width` samples takes. */
size_t hl_bayer_row_bytes(hl_bayer_packing packing, int width);

/*
 * Samples as 16-bit codes whose full scale is 65535: code = round(sample * 65535 / (2^bits - 1)).
 * `bits` of HL_BAYER_WORDS is 8 to 16; the others have their own. out: shape (height, width).
 * HL_ERR_ARG (stride below hl_bayer_row_bytes, n below the rows' bytes, a CSI-2 width that is no
 * multiple of 4 or 2, bits, a size below 1).
 */
hl_status hl_bayer_unpack(hl_ctx *ctx, hl_bayer_packing packing, int bits, const uint8_t *bytes,
                          size_t n, size_t stride, int width, int height, uint16_t *out);

/* Mean of the two green samples of each 2 x 2 cell, rounded to even; out: (height/2, width/2). Its
 * pixel (x, y) has its centre at (2x + 0.5, 2y + 0.5) of the sensor's. */
void hl_bayer_green(hl_bayer_order order, const uint16_t *codes, int width, int height,
                    uint16_t *out);

/* Bilinear: the missing colours of a sample are the means of the nearest ones of that colour; at
 * the border of those that exist. out: (height, width, 3), red, green, blue. Linear in the codes. */
void hl_bayer_demosaic(hl_bayer_order order, const uint16_t *codes, int width, int height,
                       uint16_t *out);

#ifdef __cplusplus
}
#endif
#endif
