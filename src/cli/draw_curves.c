/* The fitted curves: specular lobe against the angle from n to h, diffuse term against the angle
 * from n to the light, a panel each, a line a channel, among what the pixels leave for each. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "draw_curves.h"

enum { WIDTH = 1000, HEIGHT = 500, ALONE_WIDTH = 470, ALONE_HEIGHT = 380, PANELS_MAX = 2 };

static const double DEGREES = 180 / 3.14159265358979323846;
static const double TITLE_TEXT = 16;
static const double TEXT = 14;
static const double DOT = 2.2;
static const double LOG_FROM = 50;     /* dynamic range from which the axis is logarithmic */
static const double DECADES = 4;       /* most that a logarithmic axis shows */
static const double TAIL_SHARE = 2e-3; /* the angle axis ends where the lobe has faded to this */

typedef struct channel_style {
  const char *channel;
  const char *name;
  double r, g, b;
  double dash[4];
  int n_dash;
} channel_style;

static const channel_style styles[] = {
    {"r", "red", HL_VERMILLION, {0}, 0},
    {"g", "green", HL_GREEN, {9, 4}, 2},
    {"b", "blue", HL_BLUE, {2, 4}, 2},
    {"grey", "grey", HL_DATA_GREY, {0}, 0},
};

static const channel_style *style_of(const char *channel)
{
  for (size_t i = 0; i + 1 < sizeof styles / sizeof *styles; i++)
    if (strcmp(channel, styles[i].channel) == 0)
      return &styles[i];
  return &styles[sizeof styles / sizeof *styles - 1];
}

typedef struct panel {
  const hl_light *light;
  const hl_curve_cloud *cloud; /* may be NULL */
  const char *lobe, *title, *x_label, *y_label;
  double left, right, top, bottom; /* of the plot area, on the sheet */
  double x_max, y_min, y_max;
  bool is_log;
} panel;

static bool shows(const panel *p, const hl_curve *curve)
{
  return strcmp(curve->lobe, p->lobe) == 0 && curve->n > 0;
}

/* Of an angle axis: quarters and thirds of a right angle rather than its fifths. */
static double angle_step(double range_deg)
{
  const double rough = range_deg / 6;
  return rough <= 10 ? hl_canvas_step(rough) : rough <= 15 ? 15 : 30;
}

static void find_ranges(panel *p)
{
  double most = 0;
  double end = 0;
  double least = HUGE_VAL;
  for (int i = 0; i < p->light->n_curves; i++)
    if (shows(p, &p->light->curves[i]))
      for (int k = 0; k < p->light->curves[i].n; k++)
        most = fmax(most, p->light->curves[i].value[k]);
  for (int i = 0; i < p->light->n_curves; i++) {
    const hl_curve *c = &p->light->curves[i];
    for (int k = 0; shows(p, c) && k < c->n; k++)
      if (c->value[k] > TAIL_SHARE * most)
        end = fmax(end, c->angle_rad[k < c->n - 1 ? k + 1 : k] * DEGREES);
  }
  for (int i = 0; i < p->light->n_curves; i++) {
    const hl_curve *c = &p->light->curves[i];
    for (int k = 0; shows(p, c) && k < c->n; k++)
      if (c->value[k] > 0 && c->angle_rad[k] * DEGREES <= end)
        least = fmin(least, c->value[k]);
  }
  most = most > 0 ? most : 1;
  const double step = angle_step(fmax(end, 1));
  p->x_max = step * ceil(fmax(end, 1) / step - 1e-9);
  p->is_log = strcmp(p->lobe, "specular") == 0 && least < HUGE_VAL && most / least > LOG_FROM;
  if (p->is_log) {
    p->y_max = pow(10, ceil(log10(most) + 0.02));
    p->y_min = fmax(pow(10, floor(log10(least))), p->y_max * pow(10, -DECADES));
  } else {
    const double y_step = hl_canvas_step(most / 5);
    p->y_min = 0;
    p->y_max = y_step * ceil(most * 1.04 / y_step);
  }
}

static double x_on(const panel *p, double deg)
{
  return p->left + (p->right - p->left) * deg / p->x_max;
}

static double y_on(const panel *p, double value)
{
  const double share = p->is_log ? log(fmax(value, p->y_min) / p->y_min) / log(p->y_max / p->y_min)
                                 : (value - p->y_min) / (p->y_max - p->y_min);
  return p->bottom - (p->bottom - p->top) * share;
}

static void grid_line(cairo_t *cr, double x0, double y0, double x1, double y1)
{
  cairo_set_source_rgb(cr, HL_GRID_GREY);
  cairo_set_line_width(cr, 1);
  cairo_move_to(cr, floor(x0) + 0.5, floor(y0) + 0.5);
  cairo_line_to(cr, floor(x1) + 0.5, floor(y1) + 0.5);
  cairo_stroke(cr);
}

static void y_tick(const hl_canvas *canvas, const panel *p, double value)
{
  char text[32];
  const double y = y_on(p, value);
  grid_line(canvas->cr, p->left, y, p->right, y);
  snprintf(text, sizeof text, "%.4g", value);
  cairo_set_source_rgb(canvas->cr, 0.15, 0.15, 0.15);
  hl_canvas_text(canvas, p->left - 8, y + 5, 1, TEXT, text);
}

static void draw_axes(const hl_canvas *canvas, const panel *p)
{
  cairo_t *cr = canvas->cr;
  const double x_step = angle_step(p->x_max);
  for (int i = 0; i * x_step <= p->x_max * (1 + 1e-9); i++) {
    char text[32];
    const double x = x_on(p, i * x_step);
    grid_line(cr, x, p->top, x, p->bottom);
    snprintf(text, sizeof text, "%.4g", i * x_step);
    cairo_set_source_rgb(cr, 0.15, 0.15, 0.15);
    hl_canvas_text(canvas, x, p->bottom + 20, 0.5, TEXT, text);
  }
  if (p->is_log) {
    const int decades = (int)lround(log10(p->y_max / p->y_min));
    for (int i = 0; i <= decades; i++)
      y_tick(canvas, p, p->y_min * pow(10, i));
  } else {
    const double y_step = hl_canvas_step(p->y_max / 6);
    for (int i = 0; i * y_step <= p->y_max * (1 + 1e-9); i++)
      y_tick(canvas, p, i * y_step);
  }
  cairo_set_source_rgb(cr, 0.25, 0.25, 0.25);
  cairo_set_line_width(cr, 1.2);
  cairo_rectangle(cr, p->left, p->top, p->right - p->left, p->bottom - p->top);
  cairo_stroke(cr);
  cairo_set_source_rgb(cr, HL_TEXT_GREY);
  hl_canvas_text(canvas, (p->left + p->right) / 2, p->bottom + 44, 0.5, TEXT, p->x_label);
  cairo_save(cr);
  cairo_translate(cr, p->left - 62, (p->top + p->bottom) / 2);
  cairo_rotate(cr, -acos(0));
  hl_canvas_text(canvas, 0, 0, 0.5, TEXT, p->y_label);
  cairo_restore(cr);
}

static void draw_line(const hl_canvas *canvas, const panel *p, const hl_curve *curve)
{
  cairo_t *cr = canvas->cr;
  const channel_style *style = style_of(curve->channel);
  cairo_save(cr);
  cairo_rectangle(cr, p->left, p->top, p->right - p->left, p->bottom - p->top);
  cairo_clip(cr);
  for (int k = 0; k < curve->n; k++)
    cairo_line_to(cr, x_on(p, curve->angle_rad[k] * DEGREES), y_on(p, curve->value[k]));
  cairo_set_source_rgb(cr, style->r, style->g, style->b);
  cairo_set_dash(cr, style->dash, style->n_dash, 0);
  cairo_set_line_width(cr, 2.2);
  cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
  cairo_stroke(cr);
  cairo_restore(cr);
}

static void draw_cloud(const hl_canvas *canvas, const panel *p)
{
  static const char *const color[] = {"r", "g", "b"};
  cairo_t *cr = canvas->cr;
  const int channels = p->light->channels;
  if (p->cloud->n == 0)
    return;
  cairo_save(cr);
  cairo_rectangle(cr, p->left, p->top, p->right - p->left, p->bottom - p->top);
  cairo_clip(cr);
  cairo_set_line_width(cr, DOT);
  cairo_set_line_cap(cr, CAIRO_LINE_CAP_ROUND);
  for (int c = 0; c < channels && c < HL_CHANNELS_MAX; c++) {
    const channel_style *style = style_of(channels == 1 ? "grey" : color[c]);
    for (int i = 0; i < p->cloud->n; i++) {
      const double deg = p->cloud->angle_rad[i] * DEGREES, value = p->cloud->value[i][c];
      if (deg > p->x_max || value > p->y_max || value < p->y_min)
        continue;
      cairo_move_to(cr, x_on(p, deg), y_on(p, value));
      cairo_line_to(cr, x_on(p, deg), y_on(p, value));
    }
    cairo_set_source_rgba(cr, style->r, style->g, style->b, 0.4);
    cairo_stroke(cr);
  }
  cairo_restore(cr);
}

/* Upper right of the panel: every curve falls from its left. */
static void draw_legend(const hl_canvas *canvas, const panel *p)
{
  cairo_t *cr = canvas->cr;
  int rows = 0;
  for (int i = 0; i < p->light->n_curves; i++)
    rows += shows(p, &p->light->curves[i]);
  const double x = p->right - 108;
  double y = p->top + 26;
  cairo_rectangle(cr, x - 12, p->top + 8, 112, rows * 22 + 8);
  cairo_set_source_rgba(cr, 1, 1, 1, 0.88);
  cairo_fill(cr);
  for (int i = 0; i < p->light->n_curves; i++) {
    if (!shows(p, &p->light->curves[i]))
      continue;
    const channel_style *style = style_of(p->light->curves[i].channel);
    cairo_save(cr);
    cairo_set_source_rgb(cr, style->r, style->g, style->b);
    cairo_set_dash(cr, style->dash, style->n_dash, 0);
    cairo_set_line_width(cr, 2.2);
    cairo_move_to(cr, x, y - 5);
    cairo_line_to(cr, x + 36, y - 5);
    cairo_stroke(cr);
    cairo_restore(cr);
    cairo_set_source_rgb(cr, HL_TEXT_GREY);
    hl_canvas_text(canvas, x + 46, y, 0, TEXT, style->name);
    y += 22;
  }
}

static void draw_panel(const hl_canvas *canvas, panel *p)
{
  find_ranges(p);
  draw_axes(canvas, p);
  if (p->cloud)
    draw_cloud(canvas, p);
  for (int i = 0; i < p->light->n_curves; i++)
    if (shows(p, &p->light->curves[i]))
      draw_line(canvas, p, &p->light->curves[i]);
  draw_legend(canvas, p);
  cairo_set_source_rgb(canvas->cr, HL_TEXT_GREY);
  hl_canvas_text(canvas, p->left, p->top - 14, 0, TITLE_TEXT, p->title);
}

/* The panels that have curves, and the lobe asked for. */
static int choose(const hl_curve_sheet *sheet, panel shown[PANELS_MAX + 1])
{
  const bool divided = sheet->light->lobe == HL_LOBE_FORESHORTENED;
  const panel both[PANELS_MAX] = {
      {.lobe = "specular",
       .title = divided ? "Specular lobe, before its factor 1/(n\302\267v)" : "Specular lobe",
       .x_label = "angle between n and h [deg]",
       .cloud = sheet->specular},
      {.lobe = "diffuse",
       .title = "Diffuse term",
       .x_label = "angle between n and light [deg]",
       .cloud = sheet->diffuse},
  };
  int n = 0;
  for (int i = 0; i < PANELS_MAX; i++) {
    bool any = false;
    shown[n] = both[i];
    shown[n].light = sheet->light;
    for (int k = 0; k < sheet->light->n_curves; k++)
      any = any || shows(&shown[n], &sheet->light->curves[k]);
    n += any && (!sheet->lobe || strcmp(sheet->lobe, both[i].lobe) == 0);
  }
  return n;
}

hl_status hl_draw_curves(hl_ctx *ctx, hl_picture_kind kind, const char *path, const void *data)
{
  const hl_curve_sheet *sheet = data;
  const double width = sheet->lobe ? ALONE_WIDTH : WIDTH;
  const double height = sheet->lobe ? ALONE_HEIGHT : HEIGHT;
  panel shown[PANELS_MAX + 1] = {{0}};
  const int n = choose(sheet, shown);
  hl_canvas canvas;
  const hl_status st = hl_canvas_open(ctx, &canvas, kind, path, width, height);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < n; i++) {
    const double share = width / n;
    shown[i].left = i * share + 92;
    shown[i].right = (i + 1) * share - 24;
    shown[i].top = 48;
    shown[i].bottom = height - 66;
    shown[i].y_label = "radiance [frame's linear units]";
    draw_panel(&canvas, &shown[i]);
  }
  if (n == 0) {
    cairo_set_source_rgb(canvas.cr, HL_TEXT_GREY);
    hl_canvas_text(&canvas, width / 2, height / 2, 0.5, TITLE_TEXT, "no curves were fitted");
  }
  return hl_canvas_close(ctx, &canvas);
}
