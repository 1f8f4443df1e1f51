/*
 * One plane of a frame: linear, and coded to 8 bits for detectors.
 *
 * Detectors decide at half way between the darkest and the brightest code around. Coded as sRGB,
 * that is a fifth of the way in radiance: a board lies in shade and light at once and keeps its
 * black below and its white above, and where two black squares meet at a corner, a saddle at half
 * the radiance is white, so they stay apart. The price is that edges move towards the dark, by half
 * a pixel at a blur of 0.7: what is measured is measured on the linear plane.
 */
#include "grey.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { TABLE = 4096, SAMPLES = 1 << 14 };

static const float none = 1e-20f; /* a frame that is black throughout is coded as 0 */

/* An unusable pixel takes its left neighbour's value: 0 would be an edge. */
static void average(const hl_frame *frame, float *out)
{
  const size_t pixels = (size_t)frame->width * (size_t)frame->height;
  const int channels = frame->channels;
  float last = 0;
  for (size_t i = 0; i < pixels; i++) {
    const float *value = frame->radiance + i * (size_t)channels;
    const uint8_t *state = frame->state + i * (size_t)channels;
    float sum = 0;
    int used = 0;
    for (int c = 0; c < channels; c++)
      if (state[c] != HL_SAMPLE_UNUSABLE) {
        sum += value[c];
        used++;
      }
    last = used > 0 ? sum / (float)used : last;
    out[i] = last;
  }
}

static int ascending(const void *a, const void *b)
{
  const float p = *(const float *)a;
  const float q = *(const float *)b;
  return (p > q) - (p < q);
}

/* The 99.9th percentile of a sample, so that lamps and hot pixels do not set the scale; saturation
 * where that is not far above, since then the file's own scale is a good one. */
static float white_of(const hl_frame *frame, const float *linear)
{
  static const float far = 4;
  float sample[SAMPLES];
  const size_t n = (size_t)frame->width * (size_t)frame->height;
  const size_t stride = n / SAMPLES + 1;
  int m = 0;
  for (size_t i = stride / 2; i < n && m < SAMPLES; i += stride)
    sample[m++] = linear[i];
  if (m == 0)
    return none;
  qsort(sample, (size_t)m, sizeof *sample, ascending);
  const float white = sample[m - 1 - m / 1000];
  const float saturation = (float)frame->saturation;
  if (saturation > 0 && far * white > saturation)
    return saturation;
  return white > none ? white : none;
}

hl_status hl_grey_of(hl_ctx *ctx, const hl_frame *frame, hl_grey *out)
{
  hl_grey grey = {.width = frame->width, .height = frame->height};
  grey.stride = grey.width > HL_GREY_SIDE_MIN ? grey.width : HL_GREY_SIDE_MIN;
  grey.rows = grey.height > HL_GREY_SIDE_MIN ? grey.height : HL_GREY_SIDE_MIN;
  const size_t pixels = (size_t)grey.width * (size_t)grey.height;
  const size_t bytes = (size_t)grey.stride * (size_t)grey.rows;
  grey.linear = malloc(pixels * sizeof *grey.linear);
  grey.code = calloc(bytes, 1);
  grey.spare = calloc(bytes, 1);
  if (!grey.linear || !grey.code || !grey.spare) {
    hl_grey_free(&grey);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory to search %d x %d pixels", frame->width,
                   frame->height);
  }
  average(frame, grey.linear);
  grey.white = white_of(frame, grey.linear);
  *out = grey;
  return HL_OK;
}

void hl_grey_free(hl_grey *grey)
{
  free(grey->linear);
  free(grey->code);
  free(grey->spare);
  *grey = (hl_grey){0};
}

double hl_grey_at(const hl_grey *grey, double x, double y)
{
  const double cx = fmin(fmax(x, 0), grey->width - 1);
  const double cy = fmin(fmax(y, 0), grey->height - 1);
  const int ix = cx < grey->width - 1 ? (int)cx : grey->width - 2;
  const int iy = cy < grey->height - 1 ? (int)cy : grey->height - 2;
  const double u = cx - ix;
  const double v = cy - iy;
  const float *p = grey->linear + (size_t)iy * (size_t)grey->width + (size_t)ix;
  const float *q = p + grey->width;
  return (1 - v) * ((1 - u) * (double)p[0] + u * (double)p[1]) +
         v * ((1 - u) * (double)q[0] + u * (double)q[1]);
}

/* IEC 61966-2-1 */
static double curve(double linear)
{
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

void hl_grey_code_curved(hl_grey *grey)
{
  uint8_t table[TABLE + 1]; /* over the root of radiance, whose steps are even enough */
  for (int i = 0; i <= TABLE; i++)
    table[i] = (uint8_t)lrint(255 * curve((double)i * i / ((double)TABLE * TABLE)));
  const float scale = 1 / grey->white;
  for (int y = 0; y < grey->height; y++) {
    const float *in = grey->linear + (size_t)y * (size_t)grey->width;
    uint8_t *out = grey->code + (size_t)y * (size_t)grey->stride;
    for (int x = 0; x < grey->width; x++) {
      const float v = in[x] * scale;
      out[x] = v <= 0 ? 0 : v >= 1 ? 255 : table[(int)(TABLE * sqrtf(v) + 0.5f)];
    }
  }
}

void hl_grey_code_linear(hl_grey *grey, float white)
{
  const float scale = 255 / (white > none ? white : none);
  for (int y = 0; y < grey->height; y++) {
    const float *in = grey->linear + (size_t)y * (size_t)grey->width;
    uint8_t *out = grey->code + (size_t)y * (size_t)grey->stride;
    for (int x = 0; x < grey->width; x++) {
      const float v = in[x] * scale;
      out[x] = (uint8_t)(v <= 0 ? 0 : v >= 255 ? 255 : v + 0.5f);
    }
  }
}

static inline uint8_t largest(uint8_t a, uint8_t b, uint8_t c)
{
  const uint8_t ab = a > b ? a : b;
  return ab > c ? ab : c;
}

/* Rows into `spare`, then columns back; the frame's rim takes part once. */
void hl_grey_widen(hl_grey *grey)
{
  const int w = grey->width;
  const int h = grey->height;
  for (int y = 0; y < h; y++) {
    const uint8_t *in = grey->code + (size_t)y * (size_t)grey->stride;
    uint8_t *out = grey->spare + (size_t)y * (size_t)grey->stride;
    for (int x = 0; x < w; x++)
      out[x] = largest(in[x > 0 ? x - 1 : 0], in[x], in[x < w - 1 ? x + 1 : x]);
  }
  for (int y = 0; y < h; y++) {
    const uint8_t *in = grey->spare + (size_t)y * (size_t)grey->stride;
    const uint8_t *above = y > 0 ? in - grey->stride : in;
    const uint8_t *below = y < h - 1 ? in + grey->stride : in;
    uint8_t *out = grey->code + (size_t)y * (size_t)grey->stride;
    for (int x = 0; x < w; x++)
      out[x] = largest(above[x], in[x], below[x]);
  }
}

void hl_grey_mirror(hl_grey *grey)
{
  for (int y = 0; y < grey->height; y++) {
    uint8_t *row = grey->code + (size_t)y * (size_t)grey->stride;
    for (int x = 0; x < grey->width / 2; x++) {
      const uint8_t kept = row[x];
      row[x] = row[grey->width - 1 - x];
      row[grey->width - 1 - x] = kept;
    }
  }
}
