/* How far two cameras see the same points apart: a heat map over the frame, or a board's corners, with
 * arrows, a scale, and the line where the difference exceeds its own 95 % uncertainty (chi-square of 2
 * degrees of freedom: 5.991).
 *
 * Colours: cividis (Nunez, Anderton and Renslow 2018, PLoS ONE 13(7) e0199239), which is even in
 * lightness and reads the same to colour-blind eyes; every tenth of matplotlib 3.6's table.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "draw.h"
#include "marks.h"

enum { LONGER_SIDE = 800, CELL = 16, SHADES = 11, BAR_STEPS = 128, LINE = HL_CAPTION_LINE };

static const double PI = 3.14159265358979323846;
static const double CHI_95 = 2.4477468306808162; /* sqrt(5.9914645471079799) */
static const double MARGIN = 14, TEXT = 15, BAR_WIDTH = 22, BAR_ROOM = 96;

static const double shades[SHADES][3] = {
    {0.0000, 0.1351, 0.3048}, {0.0321, 0.2012, 0.4408}, {0.2089, 0.2725, 0.4248},
    {0.3096, 0.3404, 0.4248}, {0.4014, 0.4118, 0.4407}, {0.4887, 0.4853, 0.4710},
    {0.5821, 0.5587, 0.4681}, {0.6839, 0.6388, 0.4443}, {0.7860, 0.7204, 0.3996},
    {0.8968, 0.8110, 0.3210}, {0.9957, 0.9093, 0.2178},
};

typedef struct heat_map {
  const hl_drift *drift;
  hl_canvas *canvas;
  double zoom, top;     /* sheet units a frame pixel; where the frame begins */
  double width, height; /* of the frame on the sheet */
  double most_px;       /* upper end of the scale */
  double arrow;         /* sheet units a pixel of difference */
} heat_map;

static void colour_of(double share, double rgb[3])
{
  const double at = fmin(fmax(share, 0), 1) * (SHADES - 1);
  const int i = (int)fmin(floor(at), SHADES - 2);
  for (int k = 0; k < 3; k++)
    rgb[k] = shades[i][k] + (at - i) * (shades[i + 1][k] - shades[i][k]);
}

static double length_at(const hl_drift *d, int k)
{
  return hypot(d->difference_px[k][0], d->difference_px[k][1]);
}

/* A plain number at or above `value`. */
static double round_up(double value)
{
  static const double plain[] = {1, 1.5, 2, 3, 4, 5, 6, 8, 10};
  const double power = pow(10, floor(log10(value)));
  int i = 0;
  while (plain[i] < value / power * (1 - 1e-9) && plain[i] < 10)
    i++;
  return power * plain[i];
}

static void to_sheet(const heat_map *m, const double at[2], double out[2])
{
  out[0] = MARGIN + (at[0] + 0.5) * m->zoom;
  out[1] = m->top + (at[1] + 0.5) * m->zoom;
}

/* ---- the map ---- */

/* Between the nodes of one cell; NaN where one of them is. */
static double between(const hl_drift *d, int column, int row, double u, double v)
{
  const int k = row * d->columns + column;
  const double upper = (1 - u) * length_at(d, k) + u * length_at(d, k + 1);
  const double lower =
      (1 - u) * length_at(d, k + d->columns) + u * length_at(d, k + d->columns + 1);
  return (1 - v) * upper + v * lower;
}

static hl_status paint_map(hl_ctx *ctx, const heat_map *m)
{
  const hl_drift *d = m->drift;
  const int width = (d->columns - 1) * CELL, height = (d->rows - 1) * CELL;
  cairo_surface_t *image = cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height);
  if (cairo_surface_status(image) != CAIRO_STATUS_SUCCESS) {
    cairo_surface_destroy(image);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the picture");
  }
  unsigned char *bytes = cairo_image_surface_get_data(image);
  const int stride = cairo_image_surface_get_stride(image);
  for (int y = 0; y < height; y++)
    for (int x = 0; x < width; x++) {
      double rgb[3] = {0.85, 0.85, 0.85}; /* seen by one of the two only */
      const double value =
          between(d, x / CELL, y / CELL, (x % CELL + 0.5) / CELL, (y % CELL + 0.5) / CELL);
      if (isfinite(value))
        colour_of(value / m->most_px, rgb);
      uint32_t *pixel = (uint32_t *)(void *)(bytes + (size_t)y * (size_t)stride) + x;
      *pixel = 0;
      for (int k = 0; k < 3; k++)
        *pixel = *pixel << 8 | (uint32_t)lround(255 * rgb[k]);
    }
  cairo_surface_mark_dirty(image);
  cairo_t *cr = m->canvas->cr;
  cairo_save(cr);
  cairo_rectangle(cr, MARGIN, m->top, m->width, m->height);
  cairo_clip(cr);
  cairo_translate(cr, MARGIN, m->top);
  cairo_scale(cr, m->width / width, m->height / height);
  cairo_set_source_surface(cr, image, 0, 0);
  cairo_pattern_set_extend(cairo_get_source(cr), CAIRO_EXTEND_PAD);
  cairo_paint(cr);
  cairo_restore(cr);
  cairo_surface_destroy(image);
  return HL_OK;
}

/* By how much a node exceeds its uncertainty. */
static double excess(const hl_drift *d, int k)
{
  return length_at(d, k) - CHI_95 * d->sigma_px[k];
}

/* Where the excess is 0 on the way between two nodes; false where it has one sign. */
static bool crossing(const heat_map *m, int a, int b, double out[2])
{
  const double from = excess(m->drift, a), to = excess(m->drift, b);
  double at[2];
  if (!((from > 0) != (to > 0)) || isnan(from) || isnan(to))
    return false;
  for (int i = 0; i < 2; i++)
    at[i] = m->drift->at_px[a][i] +
            from / (from - to) * (m->drift->at_px[b][i] - m->drift->at_px[a][i]);
  to_sheet(m, at, out);
  return true;
}

/* Marching triangles: two a cell, which leaves no ambiguous case. */
static void draw_limit(const heat_map *m)
{
  const hl_drift *d = m->drift;
  cairo_t *cr = m->canvas->cr;
  for (int row = 0; row + 1 < d->rows; row++)
    for (int column = 0; column + 1 < d->columns; column++) {
      const int k = row * d->columns + column;
      const int corner[2][3] = {{k, k + 1, k + d->columns},
                                {k + 1, k + d->columns, k + d->columns + 1}};
      for (int t = 0; t < 2; t++) {
        double at[2];
        int found = 0;
        for (int e = 0; e < 3; e++)
          if (crossing(m, corner[t][e], corner[t][(e + 1) % 3], at)) {
            if (found++ == 0)
              cairo_move_to(cr, at[0], at[1]);
            else
              cairo_line_to(cr, at[0], at[1]);
          }
      }
    }
  hl_marks_stroke(cr, HL_INK_OUTLINE, 1.8);
}

/* ---- arrows and discs ---- */

/* Broad where the difference exceeds its uncertainty. */
static void draw_arrow(cairo_t *cr, const double from[2], const double to[2], bool sure)
{
  const double length = hypot(to[0] - from[0], to[1] - from[1]);
  const double head = fmin(7, 0.5 * length);
  const double a = atan2(to[1] - from[1], to[0] - from[0]);
  cairo_move_to(cr, from[0], from[1]);
  cairo_line_to(cr, to[0], to[1]);
  for (int side = -1; side <= 1; side += 2) {
    cairo_move_to(cr, to[0] - head * cos(a + side * 0.45), to[1] - head * sin(a + side * 0.45));
    cairo_line_to(cr, to[0], to[1]);
  }
  hl_marks_stroke(cr, HL_INK_HIGHLIGHT, sure ? 1.8 : 0.7);
}

static void arrow_at(const heat_map *m, int k)
{
  double from[2], to[2];
  const double *by = m->drift->difference_px[k];
  if (isnan(by[0]))
    return;
  to_sheet(m, m->drift->at_px[k], from);
  for (int i = 0; i < 2; i++)
    to[i] = from[i] + m->arrow * by[i];
  draw_arrow(m->canvas->cr, from, to, excess(m->drift, k) > 0);
}

static void draw_corner(const heat_map *m, int k)
{
  double rgb[3], at[2];
  cairo_t *cr = m->canvas->cr;
  if (isnan(m->drift->difference_px[k][0]))
    return;
  to_sheet(m, m->drift->at_px[k], at);
  colour_of(length_at(m->drift, k) / m->most_px, rgb);
  cairo_new_sub_path(cr);
  cairo_arc(cr, at[0], at[1], 5, 0, 2 * PI);
  cairo_set_source_rgb(cr, rgb[0], rgb[1], rgb[2]);
  cairo_fill(cr);
}

/* Every so many nodes, so that arrows do not touch. */
static int arrow_step(const hl_drift *d)
{
  return d->columns > 0 ? 2 : 1 + d->n_nodes / 200;
}

static void draw_arrows(const heat_map *m)
{
  const hl_drift *d = m->drift;
  const int step = arrow_step(d);
  for (int k = 0; k < d->n_nodes; k++) {
    const bool on =
        d->columns > 0 ? k % d->columns % step == 1 && k / d->columns % step == 1 : k % step == 0;
    if (on)
      arrow_at(m, k);
  }
}

/* ---- scale and captions ---- */

static void draw_scale(const heat_map *m)
{
  cairo_t *cr = m->canvas->cr;
  const double x = 2 * MARGIN + m->width;
  char text[40];
  for (int i = 0; i < BAR_STEPS; i++) {
    double rgb[3];
    colour_of((i + 0.5) / BAR_STEPS, rgb);
    cairo_set_source_rgb(cr, rgb[0], rgb[1], rgb[2]);
    cairo_rectangle(cr, x, m->top + m->height * (1 - (i + 1.0) / BAR_STEPS), BAR_WIDTH,
                    m->height / BAR_STEPS + 0.5);
    cairo_fill(cr);
  }
  cairo_set_source_rgb(cr, HL_TEXT_GREY);
  for (int i = 0; i <= 5; i++) {
    snprintf(text, sizeof text, "%.3g", m->most_px * i / 5);
    hl_canvas_text(m->canvas, x + BAR_WIDTH + 6,
                   m->top + m->height * (1 - i / 5.0) + (i < 5 ? 0 : 11), 0, TEXT, text);
  }
  hl_canvas_text(m->canvas, x + BAR_WIDTH / 2, m->top - 8, 0.5, TEXT, "px");
}

/* Smaller letters where a line would not fit. */
static void caption(const heat_map *m, double y, const char *text)
{
  const double room = m->width + BAR_ROOM;
  cairo_text_extents_t extents;
  cairo_set_font_size(m->canvas->cr, TEXT);
  cairo_text_extents(m->canvas->cr, text, &extents);
  const double size = extents.x_advance > room ? TEXT * room / extents.x_advance : TEXT;
  hl_canvas_text(m->canvas, MARGIN, y, 0, size, text);
}

static void draw_legend(const heat_map *m, double y)
{
  const hl_drift *d = m->drift;
  cairo_t *cr = m->canvas->cr;
  const double unit = round_up(24 / m->arrow);
  const double from[2] = {MARGIN, y - 5}, to[2] = {MARGIN + unit * m->arrow, y - 5};
  char text[120];
  draw_arrow(cr, from, to, true);
  cairo_set_source_rgb(cr, HL_TEXT_GREY);
  snprintf(text, sizeof text, "arrows: this is %.3g px; broad beyond the 95 %% uncertainty%s", unit,
           d->columns > 0 ? "," : "");
  hl_canvas_text(m->canvas, to[0] + 10, y, 0, TEXT, text);
  if (d->columns == 0)
    return;
  cairo_text_extents_t extents;
  cairo_text_extents(cr, text, &extents);
  const double x = to[0] + 10 + extents.x_advance + 10;
  cairo_move_to(cr, x, y - 5);
  cairo_line_to(cr, x + 26, y - 5);
  hl_marks_stroke(cr, HL_INK_OUTLINE, 1.8);
  cairo_set_source_rgb(cr, HL_TEXT_GREY);
  hl_canvas_text(m->canvas, x + 34, y, 0, TEXT, "where that begins");
}

static void draw_captions(const heat_map *m, const char *verdict)
{
  const hl_drift *d = m->drift;
  char text[240];
  double y = m->top + m->height + LINE;
  int sure = 0, seen = 0;
  for (int k = 0; k < d->n_nodes; k++) {
    seen += !isnan(d->sigma_px[k]);
    sure += excess(d, k) > 0;
  }
  cairo_set_source_rgb(m->canvas->cr, HL_TEXT_GREY);
  caption(m, MARGIN + TEXT, verdict);
  snprintf(text, sizeof text,
           "%s: mean %.3g px, largest %.3g px; beyond its 95 %% uncertainty at %d of %d points",
           d->columns > 0 ? "Current minus reference, the implied motion taken out"
                          : "Corners as seen minus as predicted",
           d->mean_px, d->max_px, sure, seen);
  caption(m, y, text);
  draw_legend(m, y + LINE);
}

hl_status hl_draw_drift(hl_ctx *ctx, hl_picture_kind kind, const char *path, const hl_drift *drift,
                        const char *verdict)
{
  hl_canvas canvas;
  const int longer = drift->width > drift->height ? drift->width : drift->height;
  heat_map m = {.drift = drift, .canvas = &canvas, .zoom = (double)LONGER_SIDE / longer};
  m.top = 2 * MARGIN + LINE;
  m.width = fmax(drift->width * m.zoom, 1);
  m.height = fmax(drift->height * m.zoom, 1);
  m.most_px = round_up(fmax(drift->max_px, 1e-6));
  const double spacing =
      drift->columns > 1 ? arrow_step(drift) * m.width / (drift->columns - 1) : 30;
  m.arrow = 0.9 * spacing / fmax(drift->max_px, 1e-6);
  hl_status st = hl_canvas_open(ctx, &canvas, kind, path, ceil(m.width + BAR_ROOM + 2 * MARGIN),
                                ceil(m.top + m.height + 2 * LINE + MARGIN));
  if (st != HL_OK)
    return st;
  if (drift->columns > 0) {
    st = paint_map(ctx, &m);
  } else {
    cairo_set_source_rgb(canvas.cr, 0.85, 0.85, 0.85);
    cairo_rectangle(canvas.cr, MARGIN, m.top, m.width, m.height);
    cairo_fill(canvas.cr);
    for (int k = 0; k < drift->n_nodes; k++)
      draw_corner(&m, k);
  }
  cairo_save(canvas.cr);
  cairo_rectangle(canvas.cr, MARGIN, m.top, m.width, m.height);
  cairo_clip(canvas.cr);
  draw_arrows(&m);
  if (drift->columns > 0)
    draw_limit(&m);
  cairo_restore(canvas.cr);
  draw_scale(&m);
  draw_captions(&m, verdict);
  const hl_status closed = hl_canvas_close(st == HL_OK ? ctx : NULL, &canvas);
  return st == HL_OK ? closed : st;
}
