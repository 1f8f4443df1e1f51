/*
 * A recorded frame as linear radiance with a mask.
 *
 * With x the stored value (code / full scale for integers, the value itself for floats), b the
 * black level and T the transfer function:
 *
 *   radiance = T((x - b) / (1 - b))  for integers, so that full scale is 1
 *   radiance = T(x - b)              for floats
 *
 * A sample is clipped where x reaches saturation, to half a code for integers.
 */
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "file_read.h"
#include "halflight/bridge_opencv.h"
#include "image_whole.h"
#include "pfm.h"
#include "transfer.h"

#define PIXELS_MAX ((size_t)1 << 28)
#define BYTES_MAX (PIXELS_MAX * 12 + 65536)

hl_frame_settings hl_frame_defaults(void)
{
  return (hl_frame_settings){
      .transfer = HL_TRANSFER_AUTO, .gamma = 2.2, .black = 0, .saturation = 0};
}

const hl_field_table *hl_frame_fields(void)
{
  static const hl_field fields[] = {
      {"gamma", HL_FIELD_DOUBLE, offsetof(hl_frame_settings, gamma), 0.1, 10, "",
       "exponent of the transfer function gamma", NULL},
      {"black", HL_FIELD_DOUBLE, offsetof(hl_frame_settings, black), 0, FLT_MAX, "",
       "black level, in the file's own scale (0..1 for integers)", NULL},
      {"saturation", HL_FIELD_DOUBLE, offsetof(hl_frame_settings, saturation), 0, FLT_MAX, "",
       "value from which samples are clipped, same scale; 0 = full scale, none for floats", NULL},
  };
  static const hl_field_table table = {"hl_frame_settings", fields,
                                       sizeof fields / sizeof fields[0]};
  return &table;
}

/* The rule of this file, ready to apply. */
typedef struct conversion {
  hl_transfer transfer;
  double gamma, black, scale;
  double clipped_from; /* stored value; infinite = never */
  double saturation;   /* linear */
} conversion;

static double linear_of(const conversion *c, double stored)
{
  return hl_transfer_linear(c->transfer, c->gamma, (stored - c->black) * c->scale);
}

static hl_status plan(hl_ctx *ctx, const hl_frame_settings *s, int bits, conversion *out)
{
  hl_status st = hl_fields_check(ctx, hl_frame_fields(), s);
  if (st != HL_OK)
    return st;
  if ((unsigned)s->transfer > HL_TRANSFER_GAMMA)
    return hl_fail(ctx, HL_ERR_ARG, "transfer = %d is none of auto, linear, srgb, gamma",
                   (int)s->transfer);
  const bool integer = bits != 32;
  if (integer && !(s->saturation <= 1))
    return hl_fail(ctx, HL_ERR_ARG,
                   "saturation = %.6g is outside [0, 1], the scale of a %d-bit file", s->saturation,
                   bits);
  const double top = s->saturation > 0 ? s->saturation : integer ? 1 : INFINITY;
  if (!(s->black < top))
    return hl_fail(ctx, HL_ERR_ARG, "black = %.6g is not below saturation = %.6g", s->black, top);
  conversion c = {.transfer = s->transfer, .gamma = s->gamma, .black = s->black, .scale = 1};
  if (s->transfer == HL_TRANSFER_AUTO)
    c.transfer = bits == 8 ? HL_TRANSFER_SRGB : HL_TRANSFER_LINEAR;
  if (integer)
    c.scale = 1 / (1 - s->black);
  /* a float file holds the level as the nearest float, which may lie below it */
  c.clipped_from = integer ? top - 0.5 / (bits == 8 ? 255 : 65535) : (double)(float)top;
  c.saturation = isfinite(top) ? linear_of(&c, top) : 0;
  *out = c;
  return HL_OK;
}

static void put(hl_frame *frame, size_t i, float radiance, hl_sample_state state)
{
  frame->radiance[i] = radiance;
  frame->state[i] = (uint8_t)state;
  frame->n_clipped += state == HL_SAMPLE_CLIPPED;
  frame->n_unusable += state == HL_SAMPLE_UNUSABLE;
}

static void put_stored(hl_frame *frame, size_t i, const conversion *c, double stored)
{
  const float radiance = (float)linear_of(c, stored);
  if (!isfinite(radiance))
    put(frame, i, 0, HL_SAMPLE_UNUSABLE);
  else
    put(frame, i, radiance, stored >= c->clipped_from ? HL_SAMPLE_CLIPPED : HL_SAMPLE_OK);
}

/* Every code's radiance once, in `table`, then look-ups. */
static void fill_table(const conversion *c, size_t full, float *table)
{
  for (size_t code = 0; code <= full; code++)
    table[code] = (float)linear_of(c, (double)code / (double)full);
}

/* The first code that is clipped; full + 1 for none. */
static size_t first_clipped(const conversion *c, size_t full)
{
  size_t code = full + 1;
  while (code > 0 && (double)(code - 1) / (double)full >= c->clipped_from)
    code--;
  return code;
}

/* One loop a width of code, so that it can be vectorized; returns how many are clipped. */
#define CONVERT(name, code_type)                                                                   \
  static long name(const code_type *codes, size_t pixels, size_t stored, size_t channels,          \
                   size_t clipped, const float *table, float *radiance, uint8_t *state)            \
  {                                                                                                \
    long n = 0;                                                                                    \
    for (size_t p = 0; p < pixels; p++)                                                            \
      for (size_t k = 0; k < channels; k++) {                                                      \
        const size_t code = codes[p * stored + k];                                                 \
        const bool is = code >= clipped;                                                           \
        radiance[p * channels + k] = table[code];                                                  \
        state[p * channels + k] = is ? HL_SAMPLE_CLIPPED : HL_SAMPLE_OK;                           \
        n += is;                                                                                   \
      }                                                                                            \
    return n;                                                                                      \
  }
CONVERT(convert_8, uint8_t)
CONVERT(convert_16, uint16_t)

static void convert_integers(hl_frame *frame, const void *codes, int stored_channels,
                             const conversion *c, float *table)
{
  const size_t full = frame->bits == 8 ? 255 : 65535;
  const size_t clipped = first_clipped(c, full);
  const size_t pixels = (size_t)frame->width * (size_t)frame->height;
  const size_t stored = (size_t)stored_channels, channels = (size_t)frame->channels;
  fill_table(c, full, table);
  const long n = frame->bits == 8 ? convert_8(codes, pixels, stored, channels, clipped, table,
                                              frame->radiance, frame->state)
                                  : convert_16(codes, pixels, stored, channels, clipped, table,
                                               frame->radiance, frame->state);
  frame->n_clipped = n;
}

static void convert_floats(hl_frame *frame, const float *codes, int stored_channels,
                           const conversion *c)
{
  const size_t channels = (size_t)frame->channels;
  const size_t pixels = (size_t)frame->width * (size_t)frame->height;
  for (size_t p = 0; p < pixels; p++)
    for (size_t k = 0; k < channels; k++)
      put_stored(frame, p * channels + k, c, codes[p * (size_t)stored_channels + k]);
}

static hl_status check_shape(hl_ctx *ctx, const void *codes, int width, int height, int channels,
                             int bits)
{
  if (!codes)
    return hl_fail(ctx, HL_ERR_ARG, "codes = NULL; pixels are needed");
  if (width < 1 || height < 1 || (size_t)width > PIXELS_MAX / (size_t)height)
    return hl_fail(ctx, HL_ERR_FORMAT, "size %d x %d; 1 to 2^28 pixels are accepted", width,
                   height);
  if (channels != 1 && channels != 3 && channels != 4)
    return hl_fail(ctx, HL_ERR_FORMAT, "channels = %d; 1, 3 or 4 are accepted", channels);
  if (bits != 8 && bits != 16 && bits != 32)
    return hl_fail(ctx, HL_ERR_ARG, "bits = %d; 8, 16 or 32 are accepted", bits);
  return HL_OK;
}

hl_status hl_frame_from_codes(hl_ctx *ctx, const void *codes, int width, int height, int channels,
                              int bits, const hl_frame_settings *settings, hl_frame *out)
{
  const hl_frame_settings defaults = hl_frame_defaults();
  conversion c = {0};
  hl_status st = check_shape(ctx, codes, width, height, channels, bits);
  if (st == HL_OK)
    st = plan(ctx, settings ? settings : &defaults, bits, &c);
  if (st != HL_OK)
    return st;
  hl_frame frame = {.width = width,
                    .height = height,
                    .channels = channels == 1 ? 1 : 3,
                    .bits = bits,
                    .saturation = c.saturation};
  const size_t samples = (size_t)width * (size_t)height * (size_t)frame.channels;
  float *table = bits == 32 ? NULL : malloc(sizeof *table << bits);
  frame.radiance = malloc(samples * sizeof *frame.radiance);
  frame.state = malloc(samples * sizeof *frame.state);
  if (!frame.radiance || !frame.state || (bits != 32 && !table)) {
    hl_frame_free(&frame);
    free(table);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a frame of %d x %d pixels", width, height);
  }
  if (bits == 32)
    convert_floats(&frame, codes, channels, &c);
  else
    convert_integers(&frame, codes, channels, &c, table);
  free(table);
  *out = frame;
  return HL_OK;
}

void hl_frame_free(hl_frame *frame)
{
  if (!frame)
    return;
  free(frame->radiance);
  free(frame->state);
  *frame = (hl_frame){0};
}

static hl_status decode(hl_ctx *ctx, const char *path, const unsigned char *bytes, size_t n,
                        hl_codes *out)
{
  if (hl_pfm_is(bytes, n)) {
    float *pixels = NULL;
    const hl_status st =
        hl_pfm_decode(ctx, path, bytes, n, &pixels, &out->width, &out->height, &out->channels);
    out->codes = pixels;
    out->bits = 32;
    return st;
  }
  const char *kind = NULL;
  const hl_status st = hl_image_whole(ctx, path, bytes, n, &kind);
  return st == HL_OK ? hl_opencv_decode(ctx, path, kind, bytes, n, out) : st;
}

hl_status hl_frame_read(hl_ctx *ctx, const char *path, const hl_frame_settings *settings,
                        hl_frame *out)
{
  unsigned char *bytes = NULL;
  size_t n = 0;
  hl_status st = hl_file_read(ctx, path, BYTES_MAX, &bytes, &n);
  if (st != HL_OK)
    return st;
  hl_codes codes = {0};
  st = decode(ctx, path, bytes, n, &codes);
  free(bytes);
  hl_ctx inner = {0};
  if (st == HL_OK) {
    st = hl_frame_from_codes(&inner, codes.codes, codes.width, codes.height, codes.channels,
                             codes.bits, settings, out);
    if (st != HL_OK)
      hl_fail(ctx, st, "%s: %s", path, inner.msg);
  }
  free(codes.codes);
  return st;
}
