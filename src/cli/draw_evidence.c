/* The surface's pixels, one picture a property, cut to their bounding box and brought to about SIDE:
 * small balls by whole repetitions of a pixel, large ones by the mean of a block.
 *
 * Photo and fit share one exposure and one curve (sRGB, white at the 99.5th percentile of the photo).
 * So does the residual's magnitude, around black: orange where the photo is brighter, blue where
 * the fit is. */
#include "draw_evidence.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

enum { SIDE = 232, EXPOSURE_SAMPLES = 20000, MARGIN = 2 };

typedef struct view {
  const hl_pixels *pixels;
  double white;
  int x0, y0, width, height; /* of the box, in frame pixels */
  int zoom, shrink;          /* one of them is 1 */
} view;

static int compare(const void *a, const void *b)
{
  const float x = *(const float *)a, y = *(const float *)b;
  return (x > y) - (x < y);
}

static double white_of(const hl_pixels *p)
{
  const int step = p->surface->n / EXPOSURE_SAMPLES + 1;
  float *value = malloc(((size_t)(p->surface->n / step) + 1) * sizeof *value);
  size_t n = 0;
  if (!value)
    return 1;
  for (int i = 0; i < p->surface->n; i += step)
    value[n++] = p->measured[i];
  qsort(value, n, sizeof *value, compare);
  const double white = n > 0 ? (double)value[(size_t)(0.995 * (double)(n - 1))] : 0;
  free(value);
  return white > 0 ? white : 1;
}

static void find_box(view *v)
{
  const hl_surface *s = v->pixels->surface;
  int x1 = 0, y1 = 0;
  v->x0 = s->width;
  v->y0 = s->height;
  for (int i = 0; i < s->n; i++) {
    const int x = s->pixel[i] % s->width, y = s->pixel[i] / s->width;
    v->x0 = x < v->x0 ? x : v->x0;
    v->y0 = y < v->y0 ? y : v->y0;
    x1 = x > x1 ? x : x1;
    y1 = y > y1 ? y : y1;
  }
  v->x0 -= MARGIN;
  v->y0 -= MARGIN;
  v->width = x1 + MARGIN + 1 - v->x0;
  v->height = y1 + MARGIN + 1 - v->y0;
  const int longer = v->width > v->height ? v->width : v->height;
  v->zoom = longer < SIDE ? SIDE / longer : 1;
  v->shrink = longer > SIDE ? (longer + SIDE - 1) / SIDE : 1;
}

static double encode(double linear)
{
  const double x = fmin(fmax(linear, 0), 1);
  return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}

static bool is_clipped(const hl_pixels *p, int i)
{
  const size_t at = (size_t)p->surface->pixel[i] * (size_t)p->frame->channels;
  for (int c = 0; c < p->frame->channels; c++)
    if (p->frame->state[at + (size_t)c] == HL_SAMPLE_CLIPPED)
      return true;
  return false;
}

static void mix(double rgb[3], double r, double g, double b, double share)
{
  rgb[0] += share * r;
  rgb[1] += share * g;
  rgb[2] += share * b;
}

/* The colour of one surface pixel, 0..1 a channel. */
static void colour(const view *v, int i, double rgb[3])
{
  const hl_pixels *p = v->pixels;
  const double *n = p->surface->normal + 3 * (size_t)i;
  const double photo = (double)p->measured[i] / v->white, fit = (double)p->predicted[i] / v->white;
  const bool out = !(p->weight[i] > 0);
  rgb[0] = rgb[1] = rgb[2] = 0;
  switch (p->panel) {
  case HL_PANEL_NORMALS: /* x right, y up, z to the camera, as normal maps are shown */
    mix(rgb, 0.5 + 0.5 * n[0], 0.5 - 0.5 * n[1], 0.5 - 0.5 * n[2], 1);
    break;
  case HL_PANEL_MEASURED:
    mix(rgb, encode(photo), encode(photo), encode(photo), 1);
    break;
  case HL_PANEL_FITTED:
    mix(rgb, encode(fit), encode(fit), encode(fit), 1);
    break;
  case HL_PANEL_RESIDUAL: {
    /* a clipped pixel says "at least": no residual where the fit is above it */
    const double d = HL_RESIDUAL_FACTOR * (photo - fit);
    if (d > 0)
      mix(rgb, HL_ORANGE, encode(d));
    else if (!is_clipped(p, i))
      mix(rgb, HL_SKY_BLUE, encode(-d));
    break;
  }
  case HL_PANEL_MASK:
    if (is_clipped(p, i))
      mix(rgb, HL_ORANGE, 1);
    else if (out)
      mix(rgb, HL_SKY_BLUE, 1);
    else
      mix(rgb, 0.35, 0.35, 0.35, 1);
    break;
  }
}

static uint32_t code(const double sum[3], double n)
{
  uint32_t out = 0;
  for (int c = 0; c < 3; c++)
    out = out << 8 | (uint32_t)(255 * fmin(fmax(sum[c] / n, 0), 1) + 0.5);
  return out;
}

/* Means of the pixels that fall into each cell; `sum` has 4 doubles a cell. */
static void gather(const view *v, int columns, double *sum)
{
  const hl_surface *s = v->pixels->surface;
  for (int i = 0; i < s->n; i++) {
    const int x = (s->pixel[i] % s->width - v->x0) / v->shrink;
    const int y = (s->pixel[i] / s->width - v->y0) / v->shrink;
    double rgb[3], *cell = sum + 4 * ((size_t)y * (size_t)columns + (size_t)x);
    colour(v, i, rgb);
    for (int c = 0; c < 3; c++)
      cell[c] += rgb[c];
    cell[3] += 1;
  }
}

static void paint(const view *v, const double *sum, int columns, int rows, cairo_surface_t *image)
{
  unsigned char *bytes = cairo_image_surface_get_data(image);
  const size_t stride = (size_t)cairo_image_surface_get_stride(image);
  for (int y = 0; y < rows * v->zoom; y++)
    for (int x = 0; x < columns * v->zoom; x++) {
      const double *cell =
          sum + 4 * ((size_t)(y / v->zoom) * (size_t)columns + (size_t)(x / v->zoom));
      uint32_t *at = (uint32_t *)(void *)(bytes + (size_t)y * stride) + x;
      *at = cell[3] > 0 ? code(cell, cell[3]) : 0;
    }
  cairo_surface_mark_dirty(image);
}

hl_status hl_draw_pixels(hl_ctx *ctx, hl_picture_kind kind, const char *path, const void *data)
{
  view v = {.pixels = data};
  (void)kind;
  find_box(&v);
  v.white = white_of(v.pixels);
  const int columns = (v.width + v.shrink - 1) / v.shrink,
            rows = (v.height + v.shrink - 1) / v.shrink;
  double *sum = calloc(4 * (size_t)columns * (size_t)rows, sizeof *sum);
  cairo_surface_t *image =
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, columns * v.zoom, rows * v.zoom);
  hl_status st = HL_OK;
  if (!sum || cairo_surface_status(image) != CAIRO_STATUS_SUCCESS) {
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for the picture");
  } else {
    gather(&v, columns, sum);
    cairo_surface_flush(image);
    paint(&v, sum, columns, rows, image);
    const cairo_status_t written = cairo_surface_write_to_png(image, path);
    if (written != CAIRO_STATUS_SUCCESS)
      st = hl_fail(ctx, HL_ERR_IO, "%s: the picture cannot be written: %s", path,
                   cairo_status_to_string(written));
  }
  cairo_surface_destroy(image);
  free(sum);
  return st;
}

void hl_pixels_count(const hl_pixels *pixels, int *used, int *clipped, int *left_out)
{
  *used = *clipped = *left_out = 0;
  for (int i = 0; i < pixels->surface->n; i++) {
    if (is_clipped(pixels, i))
      ++*clipped;
    else if (pixels->weight[i] > 0)
      ++*used;
    else
      ++*left_out;
  }
}
