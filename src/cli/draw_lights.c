/* A mark a light in the session's order, on a linear axis from 0 or a logarithmic one: a disc where the
 * light is to be trusted, a square where it is not, so that colour is not needed to tell. */
#include "draw_lights.h"

#include <math.h>
#include <stdio.h>

enum { WIDTH = 460, HEIGHT = 310 };

static const double LEFT = 72, RIGHT = 448, TOP = 18, BOTTOM = 256, TEXT = 13;
static const double TAU = 6.28318530717958648;

typedef struct chart {
  const hl_canvas *canvas;
  const hl_bars *bars;
  double from, to; /* of the axis; decades where it is logarithmic */
} chart;

static double scaled(const chart *c, double value)
{
  return c->bars->logarithmic ? log10(value) : value;
}

static bool shows(const chart *c, double value)
{
  return isfinite(value) && (!c->bars->logarithmic || value > 0);
}

static double x_on(const chart *c, int i)
{
  return LEFT + (RIGHT - LEFT) * (i + 0.5) / c->bars->n;
}

static double y_on(const chart *c, double value)
{
  return BOTTOM - (BOTTOM - TOP) * (scaled(c, value) - c->from) / (c->to - c->from);
}

static void find_range(chart *c)
{
  const hl_bars *b = c->bars;
  double least = HUGE_VAL, most = -HUGE_VAL;
  for (int i = 0; i < b->n; i++) {
    const double high = b->high && shows(c, b->high[i]) ? b->high[i] : b->value[i];
    if (!shows(c, b->value[i]))
      continue;
    least = fmin(least, scaled(c, b->value[i]));
    most = fmax(most, scaled(c, fmax(high, b->value[i])));
  }
  if (!(least <= most)) {
    least = 0;
    most = 1;
  }
  if (b->logarithmic) {
    c->from = floor(least);
    c->to = fmax(ceil(most), c->from + 1);
  } else {
    const double step = hl_canvas_step((most > 0 ? most : 1) / 5);
    c->from = 0;
    c->to = step * ceil(1.02 * (most > 0 ? most : 1) / step);
  }
}

static void tick(const chart *c, double value, double y)
{
  cairo_t *cr = c->canvas->cr;
  char text[32];
  cairo_set_source_rgb(cr, HL_GRID_GREY);
  cairo_set_line_width(cr, 1);
  cairo_move_to(cr, LEFT, floor(y) + 0.5);
  cairo_line_to(cr, RIGHT, floor(y) + 0.5);
  cairo_stroke(cr);
  snprintf(text, sizeof text, "%.4g", value);
  cairo_set_source_rgb(cr, HL_TEXT_GREY);
  hl_canvas_text(c->canvas, LEFT - 8, y + 4, 1, TEXT, text);
}

static void draw_axes(const chart *c)
{
  cairo_t *cr = c->canvas->cr;
  const double step = c->bars->logarithmic ? 1 : hl_canvas_step((c->to - c->from) / 6);
  for (int i = 0; c->from + i * step <= c->to + 1e-9 * step; i++) {
    const double at = c->from + i * step, value = c->bars->logarithmic ? pow(10, at) : at;
    tick(c, value, BOTTOM - (BOTTOM - TOP) * (at - c->from) / (c->to - c->from));
  }
  const int every = (int)hl_canvas_step(fmax(c->bars->n / 8.0, 1));
  for (int i = 0; i < c->bars->n; i++) {
    char text[16];
    if ((i + 1) % every != 0 && i != 0)
      continue;
    snprintf(text, sizeof text, "%d", i + 1);
    hl_canvas_text(c->canvas, x_on(c, i), BOTTOM + 20, 0.5, TEXT, text);
  }
  hl_canvas_text(c->canvas, (LEFT + RIGHT) / 2, HEIGHT - 14, 0.5, TEXT, "frame of the session");
  cairo_save(cr);
  cairo_translate(cr, 18, (TOP + BOTTOM) / 2);
  cairo_rotate(cr, -TAU / 4);
  hl_canvas_text(c->canvas, 0, 0, 0.5, TEXT, c->bars->label);
  cairo_restore(cr);
}

static void draw_mark(const chart *c, int i)
{
  cairo_t *cr = c->canvas->cr;
  const hl_bars *b = c->bars;
  const double x = x_on(c, i), y = y_on(c, b->value[i]);
  const double size = b->n < 60 ? 4 : 2.6;
  if (b->good[i])
    cairo_set_source_rgb(cr, HL_BLUE);
  else
    cairo_set_source_rgb(cr, HL_VERMILLION);
  if (b->high && shows(c, b->high[i])) {
    cairo_set_line_width(cr, 1.4);
    cairo_move_to(cr, x, y);
    cairo_line_to(cr, x, y_on(c, b->high[i]));
    cairo_stroke(cr);
  }
  if (b->good[i])
    cairo_arc(cr, x, y, size, 0, TAU);
  else
    cairo_rectangle(cr, x - size, y - size, 2 * size, 2 * size);
  cairo_fill(cr);
}

hl_status hl_draw_bars(hl_ctx *ctx, hl_picture_kind kind, const char *path, const void *data)
{
  hl_canvas canvas;
  const hl_status st = hl_canvas_open(ctx, &canvas, kind, path, WIDTH, HEIGHT);
  if (st != HL_OK)
    return st;
  chart c = {.canvas = &canvas, .bars = data};
  find_range(&c);
  draw_axes(&c);
  for (int i = 0; i < c.bars->n; i++)
    if (shows(&c, c.bars->value[i]))
      draw_mark(&c, i);
  return hl_canvas_close(ctx, &canvas);
}
