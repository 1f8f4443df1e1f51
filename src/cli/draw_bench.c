/* Error against time, both logarithmic. Ours and others differ by colour (Okabe and Ito's) and by
 * shape; the Pareto front is a staircase. Labels move until they meet nothing drawn before. */
#include <math.h>
#include <stdio.h>

#include "bench_measure.h"

enum { WIDTH = 1200, HEIGHT = 800, BOXES_MAX = 128 };

static const double LEFT = 90, RIGHT = 1160, TOP = 60, BOTTOM = 720;
static const double TEXT = 14, MARK = 6;
static const double TAU = 6.28318530717958648;

typedef struct box {
  double x0, y0, x1, y1;
} box;

typedef struct chart {
  const hl_canvas *canvas;
  const hl_bench_table *table;
  double x_from, x_to, y_from, y_to; /* decades */
  box taken[BOXES_MAX];
  int n_taken;
} chart;

static double x_on(const chart *c, double ms)
{
  return LEFT + (RIGHT - LEFT) * (log10(fmax(ms, 1e-4)) - c->x_from) / (c->x_to - c->x_from);
}

static double y_on(const chart *c, double deg)
{
  return BOTTOM - (BOTTOM - TOP) * (log10(fmax(deg, 1e-4)) - c->y_from) / (c->y_to - c->y_from);
}

static void draw_axes(const chart *c)
{
  cairo_t *cr = c->canvas->cr;
  char text[32];
  for (int d = (int)c->x_from; d <= (int)c->x_to; d++) {
    const double x = floor(x_on(c, pow(10, d))) + 0.5;
    cairo_set_source_rgb(cr, HL_GRID_GREY);
    cairo_move_to(cr, x, TOP);
    cairo_line_to(cr, x, BOTTOM);
    cairo_stroke(cr);
    cairo_set_source_rgb(cr, 0.15, 0.15, 0.15);
    snprintf(text, sizeof text, "%g", pow(10, d));
    hl_canvas_text(c->canvas, x, BOTTOM + 22, 0.5, TEXT, text);
  }
  for (int d = (int)c->y_from; d <= (int)c->y_to; d++) {
    const double y = floor(y_on(c, pow(10, d))) + 0.5;
    cairo_set_source_rgb(cr, HL_GRID_GREY);
    cairo_move_to(cr, LEFT, y);
    cairo_line_to(cr, RIGHT, y);
    cairo_stroke(cr);
    cairo_set_source_rgb(cr, 0.15, 0.15, 0.15);
    snprintf(text, sizeof text, "%g", pow(10, d));
    hl_canvas_text(c->canvas, LEFT - 8, y + 5, 1, TEXT, text);
  }
  hl_canvas_text(c->canvas, (LEFT + RIGHT) / 2, BOTTOM + 52, 0.5, TEXT + 1,
                 "time of the estimate, one thread [ms]");
  snprintf(text, sizeof text, "%d scenes", c->table->n_scenes);
  hl_canvas_text(c->canvas, RIGHT, 30, 1, TEXT, text);
  hl_canvas_text(
      c->canvas, 20, 30, 0, TEXT + 1,
      "median error of the light [deg]; circles ours, squares others, line: Pareto front");
}

/* Each step goes on at the front's error until the next method of the front is reached. */
static void draw_front(const chart *c)
{
  cairo_t *cr = c->canvas->cr;
  double reached = -1, level = 0;
  cairo_set_source_rgb(cr, 0.6, 0.6, 0.6);
  cairo_set_line_width(cr, 2);
  for (;;) {
    const hl_bench_row *next = NULL;
    for (int m = 0; m < c->table->n_methods; m++) {
      const hl_bench_row *r = c->table->row + m;
      if (r->front && r->time_ms > reached && (!next || r->time_ms < next->time_ms))
        next = r;
    }
    if (!next)
      break;
    if (reached < 0)
      cairo_move_to(cr, x_on(c, next->time_ms), TOP);
    else
      cairo_line_to(cr, x_on(c, next->time_ms), y_on(c, level));
    cairo_line_to(cr, x_on(c, next->time_ms), y_on(c, next->median_deg));
    reached = next->time_ms;
    level = next->median_deg;
  }
  cairo_line_to(cr, RIGHT, y_on(c, level));
  cairo_stroke(cr);
}

static bool is_free(const chart *c, const box *b)
{
  if (b->x0 < LEFT || b->x1 > RIGHT + 30 || b->y0 < TOP || b->y1 > BOTTOM)
    return false;
  for (int i = 0; i < c->n_taken; i++) {
    const box *t = c->taken + i;
    if (b->x0 < t->x1 && b->x1 > t->x0 && b->y0 < t->y1 && b->y1 > t->y0)
      return false;
  }
  return true;
}

static void take(chart *c, box b)
{
  if (c->n_taken < BOXES_MAX)
    c->taken[c->n_taken++] = b;
}

/* Beside the mark where there is room, else further up or down at the end of a thin line. */
static void label(chart *c, const hl_bench_row *r)
{
  cairo_t *cr = c->canvas->cr;
  cairo_text_extents_t extents;
  const double x = x_on(c, r->time_ms), y = y_on(c, r->median_deg);
  cairo_set_font_size(cr, TEXT);
  cairo_text_extents(cr, r->method->name, &extents);
  for (int k = 0; k < 160; k++) {
    const int steps = (k / 2 + 1) / 2;
    const double dy = (k / 2) % 2 ? -9 * steps : 9 * steps;
    const double x0 = k % 2 ? x - 12 - extents.x_advance : x + 12;
    const box b = {x0, y + dy - 8, x0 + extents.x_advance, y + dy + 8};
    if (!is_free(c, &b))
      continue;
    take(c, b);
    if (fabs(dy) > 10) {
      cairo_set_line_width(cr, 0.7);
      cairo_move_to(cr, x, y);
      cairo_line_to(cr, k % 2 ? b.x1 + 2 : b.x0 - 2, y + dy);
      cairo_stroke(cr);
    }
    hl_canvas_text(c->canvas, x0, y + dy + 5, 0, TEXT, r->method->name);
    return;
  }
}

static void draw_marks(chart *c)
{
  cairo_t *cr = c->canvas->cr;
  for (int m = 0; m < c->table->n_methods; m++) {
    const hl_bench_row *r = c->table->row + m;
    const double x = x_on(c, r->time_ms), y = y_on(c, r->median_deg);
    take(c, (box){x - MARK, y - MARK, x + MARK, y + MARK});
    if (r->method->ours) {
      cairo_set_source_rgb(cr, HL_BLUE);
      cairo_arc(cr, x, y, MARK, 0, TAU);
    } else {
      cairo_set_source_rgb(cr, HL_VERMILLION);
      cairo_rectangle(cr, x - MARK, y - MARK, 2 * MARK, 2 * MARK);
    }
    cairo_fill(cr);
  }
  cairo_set_source_rgb(cr, 0.15, 0.15, 0.15);
  for (int m = 0; m < c->table->n_methods; m++)
    label(c, c->table->row + m);
}

hl_status hl_draw_bench(hl_ctx *ctx, hl_picture_kind kind, const char *path,
                        const hl_bench_table *table)
{
  hl_canvas canvas;
  const hl_status st = hl_canvas_open(ctx, &canvas, kind, path, WIDTH, HEIGHT);
  if (st != HL_OK)
    return st;
  chart c = {.canvas = &canvas, .table = table, .x_from = 9, .x_to = -9, .y_from = 9, .y_to = -9};
  for (int m = 0; m < table->n_methods; m++) {
    const double x = log10(fmax(table->row[m].time_ms, 1e-4));
    const double y = log10(fmax(table->row[m].median_deg, 1e-4));
    c.x_from = fmin(c.x_from, floor(x));
    c.x_to = fmax(c.x_to, ceil(x + 0.3));
    c.y_from = fmin(c.y_from, floor(y));
    c.y_to = fmax(c.y_to, ceil(y));
  }
  cairo_set_line_width(canvas.cr, 1);
  draw_axes(&c);
  draw_front(&c);
  draw_marks(&c);
  return hl_canvas_close(ctx, &canvas);
}
