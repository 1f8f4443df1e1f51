/* Developing: exposure from the bright parts of the ball, a shoulder that keeps the highlight's
 * flanks apart (Reinhard's curve with a white point), then sRGB. The hue of a pixel is kept. */
#include "develop.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

enum { SAMPLES_MAX = 50000 };

static const double BRIGHT = 0.98;     /* this share of the pixels lies below the shoulder */
static const double WHITE_POINT = 3.5; /* of the shoulder, in units of BRIGHT's radiance */

static int compare(const void *a, const void *b)
{
  const double x = *(const double *)a;
  const double y = *(const double *)b;
  return (x > y) - (x < y);
}

static double brightness(const hl_frame *frame, size_t pixel)
{
  const float *p = frame->radiance + pixel * (size_t)frame->channels;
  double sum = 0;
  for (int c = 0; c < frame->channels; c++)
    sum += (double)p[c];
  return sum > 0 ? sum / frame->channels : 0;
}

/* Radiance that becomes a light grey; 1 for a black frame. */
static double exposure(const hl_frame *frame, const hl_surface *surface)
{
  const bool use_surface = surface && surface->n > 0;
  const size_t total =
      use_surface ? (size_t)surface->n : (size_t)frame->width * (size_t)frame->height;
  const size_t step = total / SAMPLES_MAX + 1;
  double *value = malloc((total / step + 1) * sizeof *value);
  if (!value)
    return 1;
  size_t n = 0;
  for (size_t i = 0; i < total; i += step)
    value[n++] = brightness(frame, use_surface ? (size_t)surface->pixel[i] : i);
  qsort(value, n, sizeof *value, compare);
  const double bright = value[(size_t)(BRIGHT * (double)(n - 1))];
  const double most = value[n - 1];
  free(value);
  if (bright > 0)
    return bright;
  return most > 0 ? most : 1;
}

static uint32_t code(double linear)
{
  const double x = linear < 0 ? 0 : linear > 1 ? 1 : linear;
  const double v = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
  return (uint32_t)(255 * v + 0.5);
}

static uint32_t tone(const double rgb[3], double level)
{
  const double x = (rgb[0] + rgb[1] + rgb[2]) / (3 * level);
  const double k = (1 + x / (WHITE_POINT * WHITE_POINT)) / (1 + 0.6 * x) / level;
  return code(k * rgb[0]) << 16 | code(k * rgb[1]) << 8 | code(k * rgb[2]);
}

/* Mean of a block of shrink x shrink pixels; a grey frame gives three equal channels. */
static void block_mean(const hl_frame *frame, int x0, int y0, int shrink, double rgb[3])
{
  int n = 0;
  rgb[0] = rgb[1] = rgb[2] = 0;
  for (int y = y0; y < y0 + shrink && y < frame->height; y++) {
    for (int x = x0; x < x0 + shrink && x < frame->width; x++) {
      const size_t pixel = (size_t)y * (size_t)frame->width + (size_t)x;
      const float *p = frame->radiance + pixel * (size_t)frame->channels;
      for (int c = 0; c < 3; c++)
        rgb[c] += fmax((double)p[frame->channels == 3 ? c : 0], 0);
      n++;
    }
  }
  for (int c = 0; c < 3; c++)
    rgb[c] /= n > 0 ? n : 1;
}

cairo_surface_t *hl_develop(const hl_frame *frame, const hl_surface *surface, int shrink)
{
  const int width = (frame->width + shrink - 1) / shrink;
  const int height = (frame->height + shrink - 1) / shrink;
  cairo_surface_t *image = cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height);
  if (cairo_surface_status(image) != CAIRO_STATUS_SUCCESS) {
    cairo_surface_destroy(image);
    return NULL;
  }
  const double level = exposure(frame, surface);
  cairo_surface_flush(image);
  unsigned char *bytes = cairo_image_surface_get_data(image);
  const int stride = cairo_image_surface_get_stride(image);
  for (int y = 0; y < height; y++) {
    uint32_t *row = (uint32_t *)(void *)(bytes + (size_t)y * (size_t)stride);
    for (int x = 0; x < width; x++) {
      double rgb[3];
      block_mean(frame, x * shrink, y * shrink, shrink, rgb);
      row[x] = tone(rgb, level);
    }
  }
  cairo_surface_mark_dirty(image);
  return image;
}
