/* Buffers as a driver delivers them, as frames of 16-bit codes. */
#ifndef HL_RAW_FRAME_H
#define HL_RAW_FRAME_H

#include "bayer.h"
#include "halflight/capture.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A pixel format, by the four characters and the modifier of DRM and libcamera. */
typedef struct hl_raw_format {
  uint64_t modifier;
  hl_bayer_order order;
  hl_bayer_packing packing;
  int bits;
  char fourcc[5];
  bool bayer;
  bool red_first; /* of three bytes a pixel, where it is not Bayer */
} hl_raw_format;

/* NULL where it is none that is read: Bayer of 8, 10, 12 or 16 bits in words, of 10 and 12 bits CSI-2
 * packed, and three bytes a pixel. */
const hl_raw_format *hl_raw_format_of(uint32_t fourcc, uint64_t modifier);

/*
 * Bytes of a buffer as codes: size, channels, bits, codes and transfer of *out.
 * `pixels` is processed for three bytes a pixel, else raw-green or raw-demosaiced.
 * samples: shape (height, width), not needed for processed frames; codes: (height, width, 3).
 * HL_ERR_ARG: the buffer does not hold such a frame.
 */
hl_status hl_raw_develop(hl_ctx *ctx, const hl_raw_format *format, hl_session_pixels pixels,
                         const uint8_t *bytes, size_t n, size_t stride, int width, int height,
                         uint16_t *samples, uint16_t *codes, hl_capture_frame *out);

#ifdef __cplusplus
}
#endif
#endif
