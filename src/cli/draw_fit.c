/* The fitted curves of a sum of ridges, a panel a term, among their data: what each sample leaves for the
 * term once the others are taken off, (y - sum of the others) / g, against a.n. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "draw.h"
#include "halflight/vec3.h"

enum { PANEL = 480, HEIGHT = 460, DOTS = 4000, COLUMNS = 4, ROW = 380 };

static const double TITLE_TEXT = 16;
static const double TEXT = 14;

typedef struct channel_style {
  const char *name;
  double r, g, b;
  double dash[4];
  int n_dash;
} channel_style;

static const channel_style colours[] = {
    {"red", HL_VERMILLION, {0}, 0},
    {"green", HL_GREEN, {9, 4}, 2},
    {"blue", HL_BLUE, {2, 4}, 2},
};
static const channel_style grey = {"grey", HL_DATA_GREY, {0}, 0};

static const channel_style *style_of(int channels, int c)
{
  return channels == 1 ? &grey : &colours[c];
}

typedef struct panel {
  const hl_fit *fit;
  const hl_samples *samples;
  int term;
  double left, right, top, bottom; /* of the plot area, on the sheet */
  double x_min, x_max, y_min, y_max;
} panel;

/* 1, 2 or 5 times a power of ten, at least `rough`. */
static double round_step(double rough)
{
  const double base = pow(10, floor(log10(rough)));
  const double m = rough / base;
  return base * (m <= 1 ? 1 : m <= 2 ? 2 : m <= 5 ? 5 : 10);
}

static double x_on(const panel *p, double t)
{
  return p->left + (p->right - p->left) * (t - p->x_min) / (p->x_max - p->x_min);
}

static double y_on(const panel *p, double value)
{
  return p->bottom - (p->bottom - p->top) * (value - p->y_min) / (p->y_max - p->y_min);
}

/* A sample's a.n, and what it leaves for the term, a channel; false where there is nothing to show. */
static bool datum(const panel *p, int i, double *t, double value[HL_CHANNELS_MAX])
{
  static const double ahead[3] = {0, 0, 1};
  const hl_samples *s = p->samples;
  const hl_term *term = &p->fit->term[p->term];
  const double *n = s->normal + 3 * (size_t)i, *v = s->view ? s->view + 3 * (size_t)i : ahead;
  const double nv = hl_dot(n, v), g = term->foreshortened ? 1 / nv : 1;
  double fit[HL_CHANNELS_MAX];
  bool shown = nv > 0 && (!p->fit->light_given || hl_dot(n, p->fit->light) > 0);
  if (!shown)
    return false;
  hl_fit_at(p->fit, n, v, fit);
  *t = hl_term_argument(p->fit, term, n, v);
  for (int c = 0; c < p->fit->channels; c++) {
    const double own = hl_term_value(term, c, *t), y = s->value[c][i];
    shown = shown && y > 0;
    value[c] = p->fit->log_domain ? own + log(y / fit[c]) : own + (y - fit[c]) / g;
  }
  return shown && *t >= p->x_min;
}

static void find_ranges(panel *p)
{
  const hl_term *term = &p->fit->term[p->term];
  double least = 0, most = 0;
  p->x_min = fmin(0, floor(10 * term->t[0]) / 10);
  p->x_max = 1;
  if (p->fit->log_domain) {
    least = HUGE_VAL;
    most = -HUGE_VAL;
  }
  for (int c = 0; c < p->fit->channels; c++)
    for (int k = 0; k < term->n; k++) {
      least = fmin(least, term->value[c][k]);
      most = fmax(most, term->value[c][k]);
    }
  const double step = round_step(fmax(most - least, 1e-300) / 5);
  p->y_min = step * floor(least / step + 1e-9);
  p->y_max = step * ceil((most + 0.02 * (most - least)) / step);
}

static void line(cairo_t *cr, double x0, double y0, double x1, double y1)
{
  cairo_set_source_rgb(cr, HL_GRID_GREY);
  cairo_set_line_width(cr, 1);
  cairo_move_to(cr, floor(x0) + 0.5, floor(y0) + 0.5);
  cairo_line_to(cr, floor(x1) + 0.5, floor(y1) + 0.5);
  cairo_stroke(cr);
}

static void draw_axes(const hl_canvas *canvas, const panel *p)
{
  cairo_t *cr = canvas->cr;
  char text[48];
  const double x_step = p->x_max - p->x_min > 1.3 ? 0.5 : 0.2;
  const double y_step = round_step((p->y_max - p->y_min) / 6);
  for (int i = (int)ceil(p->x_min / x_step); i * x_step <= p->x_max + 1e-9; i++) {
    const double x = x_on(p, i * x_step);
    line(cr, x, p->top, x, p->bottom);
    snprintf(text, sizeof text, "%.3g", i * x_step);
    cairo_set_source_rgb(cr, 0.15, 0.15, 0.15);
    hl_canvas_text(canvas, x, p->bottom + 20, 0.5, TEXT, text);
  }
  for (int i = 0; p->y_min + i * y_step <= p->y_max * (1 + 1e-9); i++) {
    const double value = p->y_min + i * y_step, y = y_on(p, value);
    line(cr, p->left, y, p->right, y);
    snprintf(text, sizeof text, "%.4g", fabs(value) < 1e-9 * y_step ? 0 : value);
    cairo_set_source_rgb(cr, 0.15, 0.15, 0.15);
    hl_canvas_text(canvas, p->left - 8, y + 5, 1, TEXT, text);
  }
  hl_canvas_text(canvas, 0.5 * (p->left + p->right), p->bottom + 42, 0.5, TEXT, "a\302\267n");
}

static void draw_cloud(const hl_canvas *canvas, const panel *p)
{
  cairo_t *cr = canvas->cr;
  const int stride = p->samples->n / DOTS + 1;
  for (int i = 0; i < p->samples->n; i += stride) {
    double t, value[HL_CHANNELS_MAX];
    if (!datum(p, i, &t, value))
      continue;
    for (int c = 0; c < p->fit->channels; c++) {
      const channel_style *style = style_of(p->fit->channels, c);
      cairo_rectangle(cr, x_on(p, t) - 0.6, y_on(p, value[c]) - 0.6, 1.2, 1.2);
      cairo_set_source_rgba(cr, style->r, style->g, style->b, 0.35);
      cairo_fill(cr);
    }
  }
}

static void draw_curves(const hl_canvas *canvas, const panel *p)
{
  cairo_t *cr = canvas->cr;
  const hl_term *term = &p->fit->term[p->term];
  for (int c = 0; c < p->fit->channels; c++) {
    const channel_style *style = style_of(p->fit->channels, c);
    for (int k = 0; k < term->n; k++)
      cairo_line_to(cr, x_on(p, term->t[k]), y_on(p, term->value[c][k]));
    cairo_set_source_rgb(cr, style->r, style->g, style->b);
    cairo_set_dash(cr, style->dash, style->n_dash, 0);
    cairo_set_line_width(cr, 2.2);
    cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
    cairo_stroke(cr);
  }
  cairo_set_dash(cr, NULL, 0, 0);
}

static void draw_title(const hl_canvas *canvas, const panel *p)
{
  const hl_term *term = &p->fit->term[p->term];
  const double *a = term->direction;
  char text[160];
  const char *by = term->foreshortened ? ", over n\302\267v" : "";
  if (term->name[0])
    snprintf(text, sizeof text, "%s about %s%s", term->role == HL_TERM_LINEAR ? "Linear" : "Lobe",
             term->name, by);
  else
    snprintf(text, sizeof text, "%s about (%.3f, %.3f, %.3f)%s",
             term->role == HL_TERM_LINEAR ? "Linear" : "Lobe", a[0], a[1], a[2], by);
  cairo_set_source_rgb(canvas->cr, HL_TEXT_GREY);
  hl_canvas_text(canvas, p->left, p->top - 14, 0, TITLE_TEXT, text);
}

static void draw_panel(const hl_canvas *canvas, panel *p)
{
  cairo_t *cr = canvas->cr;
  find_ranges(p);
  draw_axes(canvas, p);
  cairo_save(cr);
  cairo_rectangle(cr, p->left, p->top, p->right - p->left, p->bottom - p->top);
  cairo_clip(cr);
  draw_cloud(canvas, p);
  draw_curves(canvas, p);
  cairo_restore(cr);
  draw_title(canvas, p);
}

hl_status hl_draw_fit(hl_ctx *ctx, hl_picture_kind kind, const char *path, const hl_fit *fit,
                      const hl_samples *samples)
{
  const int columns = fit->n_terms < COLUMNS ? fit->n_terms : COLUMNS;
  const int rows = (fit->n_terms + COLUMNS - 1) / COLUMNS;
  hl_canvas canvas;
  const hl_status st = hl_canvas_open(ctx, &canvas, kind, path, PANEL * columns,
                                      rows == 1 ? HEIGHT : ROW * rows + 40);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < fit->n_terms; i++) {
    const int row = i / COLUMNS;
    const double top = row * ROW, height = rows == 1 ? HEIGHT : ROW;
    panel p = {.fit = fit, .samples = samples, .term = i};
    p.left = i % COLUMNS * PANEL + 82;
    p.right = (i % COLUMNS + 1) * PANEL - 20;
    p.top = top + 48;
    p.bottom = top + height - 62;
    draw_panel(&canvas, &p);
  }
  return hl_canvas_close(ctx, &canvas);
}
