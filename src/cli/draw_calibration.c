/* A calibration as a picture: corners with what is left of them, enlarged; the projection's
 * deviation over the frame, in bands; every view's rms. Colours are Okabe and Ito's, and bands go
 * from light to dark, so that readers with any colour vision can tell them apart. */
#include "draw_calibration.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
  WIDTH = 1240,
  HEIGHT = 860,
  PANEL_WIDTH = 560,
  PANEL_HEIGHT = 420,
  BANDS_MAX = 8,
  CELLS = 56
};

static const double TITLE_TEXT = 16;
static const double TEXT = 13;
static const double PANEL_TOP = 52;
static const double ARROW_TYPICAL = 9;  /* units on the sheet of a residual of one deviation */
static const double ARROW_LONGEST = 45; /* longer ones are cut */

typedef struct panel {
  double left, top, scale; /* units on the sheet a pixel */
  const hl_calibration *calibration;
} panel;

static panel panel_at(const hl_calibration *c, double left)
{
  const double scale =
      fmin((double)PANEL_WIDTH / c->camera.width, (double)PANEL_HEIGHT / c->camera.height);
  const panel p = {left + (PANEL_WIDTH - scale * c->camera.width) / 2, PANEL_TOP, scale, c};
  return p;
}

static double x_on(const panel *p, double x)
{
  return p->left + p->scale * (x + 0.5);
}

static double y_on(const panel *p, double y)
{
  return p->top + p->scale * (y + 0.5);
}

static void ink(cairo_t *cr)
{
  cairo_set_source_rgb(cr, HL_TEXT_GREY);
}

static void frame_line(const hl_canvas *canvas, const panel *p)
{
  cairo_t *cr = canvas->cr;
  cairo_rectangle(cr, p->left, p->top, p->scale * p->calibration->camera.width,
                  p->scale * p->calibration->camera.height);
  cairo_set_source_rgb(cr, 0.25, 0.25, 0.25);
  cairo_set_line_width(cr, 1.2);
  cairo_stroke(cr);
}

static void below(const hl_canvas *canvas, const panel *p, int line, const char *text)
{
  ink(canvas->cr);
  hl_canvas_text(canvas, p->left,
                 p->top + p->scale * p->calibration->camera.height + 20 + 18 * line, 0, TEXT, text);
}

/* ---- corners and residuals ---- */

/* Predicted place of a corner; false where it is not in front. */
static bool predict(const hl_calibration *c, const hl_pose *pose, int corner, double pixel[2])
{
  double board[3], at[3];
  hl_target_corner(&c->target, corner, board);
  hl_pose_apply(pose, board, at, NULL, NULL);
  return hl_camera_project(NULL, &c->camera, at, pixel) == HL_OK;
}

static void draw_corner(const hl_canvas *canvas, const panel *p, const hl_corner *seen,
                        const double predicted[2], double factor)
{
  cairo_t *cr = canvas->cr;
  const double x = x_on(p, seen->x), y = y_on(p, seen->y);
  double dx = factor * (seen->x - predicted[0]), dy = factor * (seen->y - predicted[1]);
  const double length = hypot(dx, dy);
  const bool cut = length > ARROW_LONGEST;
  if (cut) {
    dx *= ARROW_LONGEST / length;
    dy *= ARROW_LONGEST / length;
  }
  cairo_move_to(cr, x, y);
  cairo_line_to(cr, x + dx, y + dy);
  if (cut)
    cairo_set_source_rgb(cr, HL_VERMILLION);
  else
    cairo_set_source_rgba(cr, HL_BLUE, 0.75);
  cairo_set_line_width(cr, cut ? 1.8 : 0.9);
  cairo_stroke(cr);
  cairo_arc(cr, x, y, 1.1, 0, 7);
  cairo_set_source_rgb(cr, HL_TEXT_GREY);
  cairo_fill(cr);
}

static void draw_residuals(const hl_canvas *canvas, const hl_calibration *c,
                           const hl_corners *corners)
{
  const panel p = panel_at(c, 40);
  const double per_px = c->noise_px > 0 ? ARROW_TYPICAL / c->noise_px : 1;
  const double times = hl_canvas_step(fmax(per_px / p.scale, 1) / 2.5);
  char text[160];
  cairo_t *cr = canvas->cr;
  ink(cr);
  hl_canvas_text(canvas, p.left, p.top - 14, 0, TITLE_TEXT,
                 "Corners used, and what is left of each");
  cairo_save(cr);
  cairo_rectangle(cr, p.left, p.top, p.scale * c->camera.width, p.scale * c->camera.height);
  cairo_clip(cr);
  for (int i = 0; i < c->n_views && i < corners->n_views; i++) {
    const hl_view *view = &corners->view[i];
    double predicted[2];
    for (int k = 0; c->view[i].used && k < hl_target_corners(&c->target); k++)
      if (view->corner[k].sigma > 0 && predict(c, &c->view[i].cam_from_board, k, predicted))
        draw_corner(canvas, &p, &view->corner[k], predicted, times * p.scale);
  }
  cairo_restore(cr);
  frame_line(canvas, &p);
  snprintf(text, sizeof text, "lines: seen minus predicted, %g times as long; orange: cut short",
           times);
  below(canvas, &p, 0, text);
  snprintf(text, sizeof text, "rms %.3g px; corners in %.0f %% of the frame's cells",
           c->camera.rms_px, 100 * c->coverage);
  below(canvas, &p, 1, text);
}

/* ---- the projection's deviation ---- */

/* The larger half axis of the one-sigma ellipse of a direction; NaN where there is none. */
static double deviation_at(const hl_calibration *c, double x, double y)
{
  const double pixel[2] = {x, y};
  double v[2][2];
  if (hl_projection_covariance(NULL, c, pixel, HUGE_VAL, v) != HL_OK)
    return NAN;
  return sqrt((v[0][0] + v[1][1]) / 2 + hypot((v[0][0] - v[1][1]) / 2, v[0][1]));
}

static void band_colour(cairo_t *cr, int band)
{
  const double t = (double)band / (BANDS_MAX - 1);
  cairo_set_source_rgb(cr, 0.95 - 0.93 * t, 0.97 - 0.70 * t, 1 - 0.55 * t);
}

/* Ends of the bands in equal, round steps from 0, the largest deviation within the last ones. */
static void band_ends(double most, double ends[BANDS_MAX])
{
  const double step = hl_canvas_step((most > 0 ? most : 1) / BANDS_MAX);
  for (int i = 0; i < BANDS_MAX; i++)
    ends[i] = (i + 1) * step;
}

static int band_of(double value, const double ends[BANDS_MAX])
{
  int band = 0;
  while (band < BANDS_MAX - 1 && value >= ends[band])
    band++;
  return band;
}

static void draw_scale(const hl_canvas *canvas, const panel *p, const double ends[BANDS_MAX])
{
  cairo_t *cr = canvas->cr;
  const double width = 50, height = 14;
  const double y = p->top + p->scale * p->calibration->camera.height + 12;
  for (int i = 0; i < BANDS_MAX; i++) {
    char text[32];
    cairo_rectangle(cr, p->left + i * width, y, width, height);
    band_colour(cr, i);
    cairo_fill_preserve(cr);
    cairo_set_source_rgb(cr, 0.6, 0.6, 0.6);
    cairo_set_line_width(cr, 0.6);
    cairo_stroke(cr);
    snprintf(text, sizeof text, "%.3g", ends[i]);
    ink(cr);
    if (i < BANDS_MAX - 1)
      hl_canvas_text(canvas, p->left + (i + 1) * width, y + height + 15, 0.5, TEXT, text);
  }
  hl_canvas_text(canvas, p->left + BANDS_MAX * width + 10, y + height - 2, 0, TEXT,
                 "px, one sigma");
}

/* Deviations at the middles of the cells; the largest. */
static double fill_cells(const hl_calibration *c, double cell[CELLS][CELLS])
{
  double most = 0;
  for (int i = 0; i < CELLS; i++)
    for (int k = 0; k < CELLS; k++) {
      cell[i][k] = deviation_at(c, (k + 0.5) * c->camera.width / CELLS - 0.5,
                                (i + 0.5) * c->camera.height / CELLS - 0.5);
      most = fmax(most, isfinite(cell[i][k]) ? cell[i][k] : 0);
    }
  return most;
}

static void draw_uncertainty(const hl_canvas *canvas, const hl_calibration *c)
{
  const panel p = panel_at(c, 40 + PANEL_WIDTH + 40);
  double cell[CELLS][CELLS], ends[BANDS_MAX];
  cairo_t *cr = canvas->cr;
  band_ends(fill_cells(c, cell), ends);
  ink(cr);
  hl_canvas_text(canvas, p.left, p.top - 14, 0, TITLE_TEXT,
                 "Deviation of the projection of a direction");
  cairo_set_antialias(cr, CAIRO_ANTIALIAS_NONE);
  for (int i = 0; i < CELLS; i++)
    for (int k = 0; k < CELLS; k++) {
      const double w = p.scale * c->camera.width / CELLS, h = p.scale * c->camera.height / CELLS;
      if (!isfinite(cell[i][k]))
        continue;
      cairo_rectangle(cr, p.left + k * w, p.top + i * h, w + 0.5, h + 0.5);
      band_colour(cr, band_of(cell[i][k], ends));
      cairo_fill(cr);
    }
  cairo_set_antialias(cr, CAIRO_ANTIALIAS_DEFAULT);
  frame_line(canvas, &p);
  draw_scale(canvas, &p, ends);
}

/* ---- views ---- */

static void draw_axis(const hl_canvas *canvas, double left, double right, double top, double bottom,
                      double most)
{
  cairo_t *cr = canvas->cr;
  const double step = hl_canvas_step(most / 4);
  for (int i = 0; i * step <= most * (1 + 1e-9); i++) {
    char text[32];
    const double y = bottom - (bottom - top) * i * step / most;
    cairo_move_to(cr, left, floor(y) + 0.5);
    cairo_line_to(cr, right, floor(y) + 0.5);
    cairo_set_source_rgb(cr, HL_GRID_GREY);
    cairo_set_line_width(cr, 1);
    cairo_stroke(cr);
    snprintf(text, sizeof text, "%.3g", i * step);
    ink(cr);
    hl_canvas_text(canvas, left - 8, y + 4, 1, TEXT, text);
  }
}

static void draw_views(const hl_canvas *canvas, const hl_calibration *c)
{
  const double left = 92, right = WIDTH - 40, top = HEIGHT - 250, bottom = HEIGHT - 62;
  cairo_t *cr = canvas->cr;
  double most = 0;
  for (int i = 0; i < c->n_views; i++)
    most = fmax(most, c->view[i].rms_px);
  most = most > 0 ? 1.08 * most : 1;
  ink(cr);
  hl_canvas_text(canvas, 40, top - 16, 0, TITLE_TEXT, "rms of every view [px]");
  draw_axis(canvas, left, right, top, bottom, most);
  const double room = (right - left) / fmax(c->n_views, 1);
  const int every = (int)ceil(26 / room);
  for (int i = 0; i < c->n_views; i++) {
    const hl_view_pose *v = &c->view[i];
    const double height = (bottom - top) * v->rms_px / most;
    char text[16];
    cairo_rectangle(cr, left + (i + 0.15) * room, bottom - height, 0.7 * room, height);
    if (v->used)
      cairo_set_source_rgb(cr, HL_BLUE);
    else
      cairo_set_source_rgb(cr, HL_VERMILLION);
    cairo_fill(cr);
    snprintf(text, sizeof text, "%d", i + 1);
    ink(cr);
    if (i % every == 0)
      hl_canvas_text(canvas, left + (i + 0.5) * room, bottom + 18, 0.5, TEXT, text);
  }
  hl_canvas_text(canvas, (left + right) / 2, bottom + 42, 0.5, TEXT,
                 "view, in the order given; orange: left out");
}

hl_status hl_draw_calibration(hl_ctx *ctx, hl_picture_kind kind, const char *path,
                              const hl_calibration *calibration, const hl_corners *corners)
{
  hl_canvas canvas;
  const hl_status st = hl_canvas_open(ctx, &canvas, kind, path, WIDTH, HEIGHT);
  if (st != HL_OK)
    return st;
  draw_residuals(&canvas, calibration, corners);
  draw_uncertainty(&canvas, calibration);
  draw_views(&canvas, calibration);
  return hl_canvas_close(ctx, &canvas);
}
