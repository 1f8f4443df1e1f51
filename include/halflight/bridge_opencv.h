/** Internal, not installed: what the rest of the library asks of OpenCV, in plain C. */
#ifndef HALFLIGHT_BRIDGE_OPENCV_H
#define HALFLIGHT_BRIDGE_OPENCV_H

#include "halflight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A decoded image: shape (height, width, channels), red, green, blue (alpha) order, uint8_t,
 * uint16_t or float for 8, 16, 32 bits. `codes` is the caller's (free). */
typedef struct hl_codes {
  void *codes;
  int width, height, channels, bits;
} hl_codes;

/**
 * Decode a PNG, JPEG, TIFF or EXR in memory.
 * @param path, kind  for messages: the file, and "PNG", "JPEG", "TIFF" or "EXR"
 * @return HL_OK; HL_ERR_FORMAT (damaged, too large, a kind of sample we do not read);
 *         HL_ERR_MEMORY; HL_ERR_UNAVAILABLE in a build without OpenCV
 * While it decodes, the process's standard error is held back: the codecs print there.
 */
hl_status hl_opencv_decode(hl_ctx *ctx, const char *path, const char *kind,
                           const unsigned char *bytes, size_t n, hl_codes *out);

/**
 * Encode 16-bit codes, shape (height, width, channels) with channels 1 or 3 in red, green, blue
 * order, as a PNG in memory; *bytes is the caller's (free).
 * @return HL_OK; HL_ERR_MEMORY; HL_ERR_IO (OpenCV's encoder failed); HL_ERR_UNAVAILABLE
 */
hl_status hl_opencv_png16(hl_ctx *ctx, const char *path, const unsigned short *codes, int width,
                          int height, int channels, unsigned char **bytes, size_t *n);

/** OpenCV's settings for the process, once: no text anywhere, EXR on. Every bridge calls it first; it
 * is not there in a build without OpenCV. */
void hl_opencv_prepare(void);

/** Of the library found at run time; NULL in a build without it. */
const char *hl_opencv_version(void);

#ifdef __cplusplus
}
#endif
#endif
