/* What moved in a rig: its lights as the camera sees their dome from the ball, the angle from the view
 * as the distance from the middle, arrows where lights moved, as many times longer as the scale says,
 * rings with the change where the brightness changed, and the balls. Marks differ in shape as
 * well as in colour (Okabe and Ito's, which colour-blind eyes tell apart). */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "drift_rig.h"

#include "halflight/vec3.h"

static const double PI = 3.14159265358979323846;
static const double SHEET = 640, TOP = 40, MIDDLE = 320, RADIUS = 280, LINE = 24;

typedef struct rig_map {
  hl_canvas *canvas;
  const hl_rig_drift *drift;
  const hl_lights *reference;
  double arrow; /* lengths of arrows beside true ones */
} rig_map;

static void blue(cairo_t *cr)
{
  cairo_set_source_rgb(cr, HL_BLUE);
}

static void vermilion(cairo_t *cr)
{
  cairo_set_source_rgb(cr, HL_VERMILLION);
}

static void grey(cairo_t *cr, double level)
{
  cairo_set_source_rgb(cr, level, level, level);
}

/* Equidistant azimuthal projection; 90 degrees from the view at RADIUS. */
static void place(const double s[3], double out[2])
{
  const double view[3] = {0, 0, -1}, across = hypot(s[0], s[1]);
  const double r = RADIUS * hl_angle(s, view) / (PI / 2);
  out[0] = MIDDLE + (across > 0 ? r * s[0] / across : 0);
  out[1] = TOP + RADIUS + (across > 0 ? r * s[1] / across : 0);
}

static void circle(cairo_t *cr, const double at[2], double radius)
{
  cairo_new_path(cr);
  cairo_arc(cr, at[0], at[1], radius, 0, 2 * PI);
}

static void draw_grid(const rig_map *m)
{
  const double centre[2] = {MIDDLE, TOP + RADIUS};
  cairo_t *cr = m->canvas->cr;
  cairo_set_line_width(cr, 1);
  for (int k = 1; k <= 3; k++) {
    char text[32];
    grey(cr, 0.75);
    circle(cr, centre, RADIUS * k / 3);
    cairo_stroke(cr);
    snprintf(text, sizeof text, "%d deg", 30 * k);
    grey(cr, 0.45);
    hl_canvas_text(m->canvas, MIDDLE, TOP + RADIUS - RADIUS * k / 3 - 3, 0.5, 11, text);
  }
}

static void draw_arrow(cairo_t *cr, const double from[2], const double to[2])
{
  const double angle = atan2(to[1] - from[1], to[0] - from[0]);
  cairo_set_line_width(cr, 2.5);
  cairo_move_to(cr, from[0], from[1]);
  cairo_line_to(cr, to[0], to[1]);
  for (int k = -1; k <= 1; k += 2) {
    cairo_move_to(cr, to[0], to[1]);
    cairo_line_to(cr, to[0] - 9 * cos(angle + 0.45 * k), to[1] - 9 * sin(angle + 0.45 * k));
  }
  cairo_stroke(cr);
}

static void draw_light(const rig_map *m, const hl_rig_cause *c)
{
  const double *s = m->reference->light[c->reference].direction;
  double at[2];
  cairo_t *cr = m->canvas->cr;
  place(s, at);
  if (c->part == HL_RIG_DIRECTION) {
    grey(cr, 0.35);
    circle(cr, at, 4);
    cairo_fill(cr);
  }
  if (!c->moved)
    return;
  char text[80];
  snprintf(text, sizeof text, "%.40s", c->name);
  if (c->part == HL_RIG_DIRECTION) {
    double end[3], tip[2];
    hl_add_scaled(s, m->arrow, c->change, end);
    hl_unit(end, end);
    place(end, tip);
    vermilion(cr);
    draw_arrow(cr, at, tip);
  } else {
    blue(cr);
    cairo_set_line_width(cr, 2.5);
    circle(cr, at, 9);
    cairo_stroke(cr);
    snprintf(text, sizeof text, "%.40s %+.0f %%", c->name, 100 * (c->change[0] - 1));
  }
  hl_canvas_text(m->canvas, at[0] + 12, at[1] - 8, 0, 13, text);
}

/* The ball's outline about the middle, and where it went. */
static void draw_ball(const rig_map *m, const hl_rig_cause *c)
{
  const double radius = 30, from[2] = {MIDDLE, TOP + RADIUS};
  const double scale = radius / m->reference->ball[c->reference].radius_m;
  const double to[2] = {from[0] + scale * c->change[0] * m->arrow,
                        from[1] + scale * c->change[1] * m->arrow};
  cairo_t *cr = m->canvas->cr;
  const double dash[2] = {5, 4};
  cairo_set_line_width(cr, 1.5);
  grey(cr, 0.35);
  circle(cr, from, radius);
  cairo_stroke(cr);
  if (!c->moved)
    return;
  vermilion(cr);
  cairo_set_dash(cr, dash, 2, 0);
  circle(cr, to, radius);
  cairo_stroke(cr);
  cairo_set_dash(cr, NULL, 0, 0);
  draw_arrow(cr, from, to);
}

/* The furthest arrow of a light becomes about a sixth of the map. */
static double arrow_scale(const hl_rig_drift *drift)
{
  double most = 0;
  for (int i = 0; i < drift->n_causes; i++)
    if (drift->cause[i].part == HL_RIG_DIRECTION && drift->cause[i].moved)
      most = fmax(most, drift->cause[i].figure);
  return most > 0 ? fmax(1, floor(fmin(15 / most, 1000))) : 10;
}

hl_status hl_draw_rig_drift(hl_ctx *ctx, hl_picture_kind kind, const char *path,
                            const hl_rig_drift *drift, const hl_lights *reference,
                            const char *verdict)
{
  hl_canvas canvas;
  char text[160];
  hl_status st = hl_canvas_open(ctx, &canvas, kind, path, SHEET, TOP + 2 * RADIUS + 3 * LINE);
  if (st != HL_OK)
    return st;
  const rig_map m = {&canvas, drift, reference, arrow_scale(drift)};
  draw_grid(&m);
  for (int i = 0; i < drift->n_causes; i++) {
    if (drift->cause[i].part == HL_RIG_SPHERE)
      draw_ball(&m, &drift->cause[i]);
    if (drift->cause[i].part == HL_RIG_DIRECTION || drift->cause[i].part == HL_RIG_INTENSITY)
      draw_light(&m, &drift->cause[i]);
  }
  grey(canvas.cr, 0.1);
  snprintf(text, sizeof text, "%.90s%s", verdict, strlen(verdict) > 90 ? "..." : "");
  hl_canvas_text(&canvas, 12, TOP + 2 * RADIUS + LINE, 0, 13, text);
  snprintf(text, sizeof text,
           "arrows: moved, drawn %g times as far; rings: brightness changed; dashed: ball moved",
           m.arrow);
  hl_canvas_text(&canvas, 12, TOP + 2 * RADIUS + 2 * LINE, 0, 12, text);
  return hl_canvas_close(ctx, &canvas);
}
