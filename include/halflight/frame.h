/**
 * A recorded frame as linear radiance with a mask.
 *
 * Whatever the file holds (8-bit sRGB, 16-bit, float), radiance leaves this room linear, in float,
 * black level subtracted, scaled so that an integer file's full scale is 1. Pixels are row-major,
 * top row first; pixel (0,0) is the centre of the top-left pixel.
 *
 * With x the stored value (code / full scale for integers, the value itself for floats), b the
 * black level and T the transfer function:
 *
 *   radiance = T((x - b) / (1 - b))   integers
 *   radiance = T(x - b)               floats
 *
 * T is odd: what lies below black stays, negative, so that noise about black keeps its mean.
 */
#ifndef HALFLIGHT_FRAME_H
#define HALFLIGHT_FRAME_H

#include <stdint.h>

#include "halflight/settings.h"

#ifdef __cplusplus
extern "C" {
#endif

/** State of one sample (one channel of one pixel). */
typedef enum hl_sample_state {
  HL_SAMPLE_OK = 0,
  HL_SAMPLE_CLIPPED = 1, /* at or above saturation: the radiance is at least this much */
  HL_SAMPLE_UNUSABLE = 2 /* not a number, infinite, or masked out */
} hl_sample_state;

/** How stored values become linear. */
typedef enum hl_transfer {
  HL_TRANSFER_AUTO, /* 8-bit files are sRGB, 16-bit and float files linear */
  HL_TRANSFER_LINEAR,
  HL_TRANSFER_SRGB, /* IEC 61966-2-1 */
  HL_TRANSFER_GAMMA /* value^gamma */
} hl_transfer;

/** Physical description of how a file's codes become radiance. */
typedef struct hl_frame_settings {
  hl_transfer transfer;
  double gamma;      /* used by HL_TRANSFER_GAMMA only, [0.1, 10] */
  double black;      /* in the file's own scale: 0..1 of full scale for integers, raw for floats */
  double saturation; /* same scale; 0 = default: full scale for integers, none for floats. An
                        integer sample is clipped from half a code below it */
} hl_frame_settings;

/** The defaults; they pass their own check. */
HL_API hl_frame_settings hl_frame_defaults(void);
/** Name, unit, bounds and text of every setting. */
HL_API const hl_field_table *hl_frame_fields(void);

/** Owner of its two arrays; `hl_frame_free` releases them. Channels are interleaved. */
typedef struct hl_frame {
  int width, height;
  int channels;      /* 1 or 3 (red, green, blue) */
  int bits;          /* 8 or 16 for integer files, 32 for float files */
  double saturation; /* linear radiance at which samples are marked clipped; 0 = none */
  float *radiance;   /* shape (height, width, channels); unusable samples are 0 */
  uint8_t *state;    /* same shape, hl_sample_state */
  long n_clipped;    /* samples */
  long n_unusable;   /* samples */
} hl_frame;

/**
 * Read a frame: PFM always; PNG, JPEG, TIFF and EXR where the build has OpenCV. The kind is taken
 * from the file's first bytes, not its name. Alpha is dropped. No file-given gamma, colour profile
 * or orientation is applied: a measuring camera writes none.
 *
 * While OpenCV decodes, under a lock of the library, standard error of the whole process goes to a
 * temporary file: the codecs print their complaints there and nowhere else, and what other threads
 * print meanwhile is lost. The first decoding also silences OpenCV's log and error output for the
 * process and sets OPENCV_IO_ENABLE_OPENEXR=1 where it is not set. PFM does none of this.
 *
 * @return HL_OK; HL_ERR_IO (missing, unreadable); HL_ERR_FORMAT (not an image, truncated, more than
 *         2^28 pixels, a channel count other than 1, 3 or 4); HL_ERR_UNAVAILABLE (needs OpenCV);
 *         HL_ERR_ARG (settings out of bounds, black >= saturation); HL_ERR_MEMORY
 * Cost O(pixels). Ownership: the caller frees `out` with hl_frame_free.
 */
HL_API hl_status hl_frame_read(hl_ctx *ctx, const char *path, const hl_frame_settings *settings,
                               hl_frame *out);

/**
 * The same from memory: `codes` has shape (height, width, channels), uint8_t for bits 8, uint16_t
 * for bits 16, float for bits 32, channels 1, 3 or 4 (alpha dropped) in red, green, blue order.
 */
HL_API hl_status hl_frame_from_codes(hl_ctx *ctx, const void *codes, int width, int height,
                                     int channels, int bits, const hl_frame_settings *settings,
                                     hl_frame *out);

/** Release what it holds and zero it; NULL is accepted. */
HL_API void hl_frame_free(hl_frame *frame);

/** Write channels 1 or 3 of float pixels, top row first, as little-endian PFM; whole or not at all.
 */
HL_API hl_status hl_pfm_write(hl_ctx *ctx, const char *path, const float *pixels, int width,
                              int height, int channels);

#ifdef __cplusplus
}
#endif
#endif
