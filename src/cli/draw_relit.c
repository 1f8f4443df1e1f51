/* Relit images, linear up to one exposure: what differs in a picture differs in radiance. */
#include "draw_relit.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum { GAP = 16, CAPTION = 56, LEAST_SIDE = 240 };

static const double below_white = 0.995;

static int ascending(const void *a, const void *b)
{
  const float x = *(const float *)a;
  const float y = *(const float *)b;
  return (x > y) - (x < y);
}

double hl_relit_white(const hl_frame *relit, const hl_surface *surface)
{
  const size_t channels = (size_t)relit->channels;
  const size_t n = (size_t)surface->n * channels;
  float *value = malloc((n ? n : 1) * sizeof *value);
  if (!value)
    return 1;
  for (size_t i = 0; i < n; i++)
    value[i] = relit->radiance[(size_t)surface->pixel[i / channels] * channels + i % channels];
  qsort(value, n, sizeof *value, ascending);
  const double white = n > 0 ? (double)value[(size_t)(below_white * (double)(n - 1))] : 0;
  const double most = n > 0 ? (double)value[n - 1] : 0;
  free(value);
  return white > 0 ? white : most > 0 ? most : 1;
}

static uint32_t srgb_code(double linear)
{
  const double x = linear > 0 ? fmin(linear, 1) : 0;
  const double v = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
  return (uint32_t)(255 * v + 0.5);
}

/* The frame times `factor` as an image; NULL without memory. */
static cairo_surface_t *encode(const hl_frame *frame, double factor)
{
  cairo_surface_t *image =
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, frame->width, frame->height);
  if (cairo_surface_status(image) != CAIRO_STATUS_SUCCESS) {
    cairo_surface_destroy(image);
    return NULL;
  }
  cairo_surface_flush(image);
  unsigned char *bytes = cairo_image_surface_get_data(image);
  const size_t stride = (size_t)cairo_image_surface_get_stride(image);
  for (int y = 0; y < frame->height; y++) {
    uint32_t *row = (uint32_t *)(void *)(bytes + (size_t)y * stride);
    for (int x = 0; x < frame->width; x++) {
      const size_t at = ((size_t)y * (size_t)frame->width + (size_t)x) * (size_t)frame->channels;
      row[x] = 0;
      for (int c = 0; c < 3; c++) {
        const size_t channel = frame->channels == 3 ? (size_t)c : 0;
        row[x] = row[x] << 8 | srgb_code(factor * (double)frame->radiance[at + channel]);
      }
    }
  }
  cairo_surface_mark_dirty(image);
  return image;
}

hl_status hl_draw_relit(hl_ctx *ctx, const char *path, const hl_frame *relit, double white)
{
  cairo_surface_t *image = encode(relit, 1 / white);
  if (!image)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for the picture", path);
  const cairo_status_t status = cairo_surface_write_to_png(image, path);
  cairo_surface_destroy(image);
  return status == CAIRO_STATUS_SUCCESS
             ? HL_OK
             : hl_fail(ctx, HL_ERR_IO, "%s: the picture cannot be written: %s", path,
                       cairo_status_to_string(status));
}

/* Paint one panel; false without memory. */
static bool paint(const hl_canvas *canvas, const hl_frame *frame, double factor, double left,
                  double zoom, const char *title)
{
  cairo_surface_t *image = encode(frame, factor);
  if (!image)
    return false;
  cairo_save(canvas->cr);
  cairo_translate(canvas->cr, left, GAP);
  cairo_scale(canvas->cr, zoom, zoom);
  cairo_set_source_surface(canvas->cr, image, 0, 0);
  cairo_pattern_set_filter(cairo_get_source(canvas->cr), CAIRO_FILTER_NEAREST);
  cairo_paint(canvas->cr);
  cairo_restore(canvas->cr);
  cairo_set_source_rgb(canvas->cr, HL_TEXT_GREY);
  hl_canvas_text(canvas, left, GAP + zoom * frame->height + 20, 0, 14, title);
  cairo_surface_destroy(image);
  return true;
}

hl_status hl_draw_comparison(hl_ctx *ctx, hl_picture_kind kind, const char *path,
                             const hl_frame *relit, const hl_frame *photo,
                             const hl_frame *difference, const hl_relit_error *error, double white)
{
  const int least = relit->width < relit->height ? relit->width : relit->height;
  const double zoom = least < LEAST_SIDE ? ceil((double)LEAST_SIDE / least) : 1;
  const double step = zoom * relit->width + GAP;
  hl_canvas canvas;
  hl_status st = hl_canvas_open(ctx, &canvas, kind, path, 3 * step + GAP,
                                zoom * relit->height + GAP + CAPTION);
  if (st != HL_OK)
    return st;
  char titles[2][80];
  snprintf(titles[0], sizeof titles[0], "photo%s", error->scale == 1 ? "" : ", exposure fitted");
  snprintf(titles[1], sizeof titles[1], "%d x difference; mean error %.2f %%", HL_ERROR_FACTOR,
           100 * error->relative_error);
  const bool painted =
      paint(&canvas, relit, 1 / white, GAP, zoom, "relit") &&
      paint(&canvas, photo, error->scale / white, GAP + step, zoom, titles[0]) &&
      paint(&canvas, difference, HL_ERROR_FACTOR / white, GAP + 2 * step, zoom, titles[1]);
  st = hl_canvas_close(ctx, &canvas);
  if (st == HL_OK && !painted)
    st = hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for the picture", path);
  return st;
}
