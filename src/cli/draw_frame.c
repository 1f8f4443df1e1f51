/* The annotated photo: the ball's outline, where n = h, the way to the light, the 95 % ellipse.
 *
 * The highlight on a ball of centre C and radius R is the fixed point of n = unit(s + v(C + R n)),
 * v(p) = -p/|p|; it moves little with p, so a few rounds settle it. The ellipse is the image of
 * the light's 95 % ellipse (chi-square of 2 degrees of freedom: 5.991) in the place of that point.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "develop.h"
#include "draw.h"
#include "halflight/vec3.h"
#include "marks.h"

enum { LONGER_SIDE = 960, BARE_SIDE = 620, OUTLINE_POINTS = 240, ELLIPSE_POINTS = 72, ROUNDS = 60 };

static const double PI = 3.14159265358979323846;
static const double CHI_95 = 2.4477468306808162; /* sqrt(5.9914645471079799) */

/* What is drawn, in sheet units. */
typedef struct scene {
  const hl_photo *photo;
  hl_canvas *canvas;
  double zoom;       /* sheet units a frame pixel */
  bool has_light;    /* and a highlight */
  double point_m[3]; /* the highlight; a ray where there is no ball */
  double mark[2];
  int factor; /* the ellipse is drawn so many times as large; 0 = not drawn */
} scene;

static bool to_sheet(const scene *s, const double point[3], double at[2])
{
  if (hl_camera_project(NULL, s->photo->camera, point, at) != HL_OK)
    return false;
  at[0] = (at[0] + 0.5) * s->zoom;
  at[1] = (at[1] + 0.5) * s->zoom;
  return true;
}

static void draw_outline(const scene *s)
{
  const hl_sphere *ball = s->photo->sphere;
  const double distance = hl_norm(ball->center_m);
  const double sine = ball->radius_m / distance;
  const double cosine = sqrt(1 - sine * sine);
  double axis[3];
  double u[3];
  double w[3];
  hl_unit(ball->center_m, axis);
  hl_tangent_basis(axis, u, w);
  for (int i = 0; i < OUTLINE_POINTS; i++) {
    const double a = 2 * PI * i / OUTLINE_POINTS;
    double ray[3];
    double at[2];
    for (int k = 0; k < 3; k++)
      ray[k] = cosine * axis[k] + sine * (cos(a) * u[k] + sin(a) * w[k]);
    if (to_sheet(s, ray, at))
      cairo_line_to(s->canvas->cr, at[0], at[1]);
  }
  cairo_close_path(s->canvas->cr);
  hl_marks_stroke(s->canvas->cr, HL_INK_OUTLINE, 1.4);
}

static void highlight_on_ball(const hl_sphere *ball, const double s[3], double point[3])
{
  double n[3];
  hl_unit(ball->center_m, n);
  for (int k = 0; k < 3; k++)
    n[k] = -n[k];
  for (int i = 0; i < ROUNDS; i++) {
    double v[3];
    hl_add_scaled(ball->center_m, ball->radius_m, n, point);
    hl_unit(point, v);
    for (int k = 0; k < 3; k++)
      n[k] = s[k] - v[k];
    hl_unit(n, n);
  }
  hl_add_scaled(ball->center_m, ball->radius_m, n, point);
}

/* The pixel of a normal map whose normal comes nearest to the half vector. */
static bool highlight_on_map(const scene *s, const double light[3], double ray[3])
{
  const hl_surface *map = s->photo->surface;
  double best = -1;
  int at = -1;
  for (int i = 0; map && i < map->n; i++) {
    double h[3];
    hl_add_scaled(light, 1, map->view + 3 * (size_t)i, h);
    hl_unit(h, h);
    const double c = hl_dot(h, map->normal + 3 * (size_t)i);
    if (c > best) {
      best = c;
      at = i;
    }
  }
  for (int k = 0; at >= 0 && k < 3; k++)
    ray[k] = -map->view[3 * (size_t)at + (size_t)k];
  return at >= 0;
}

static bool find_highlight(scene *s)
{
  const double *light = s->photo->light->direction;
  if (s->photo->sphere)
    highlight_on_ball(s->photo->sphere, light, s->point_m);
  else if (!highlight_on_map(s, light, s->point_m))
    return false;
  return to_sheet(s, s->point_m, s->mark);
}

/* Place of the highlight when the light moves along the ellipse, `factor` times enlarged. */
static bool ellipse_point(const scene *s, double angle, double factor, double at[2])
{
  const hl_light *light = s->photo->light;
  const double(*c)[2] = light->covariance_rad2;
  const double l00 = sqrt(fmax(c[0][0], 0));
  const double l10 = l00 > 0 ? c[1][0] / l00 : 0;
  const double l11 = sqrt(fmax(c[1][1] - l10 * l10, 0));
  const double a = CHI_95 * factor * l00 * cos(angle);
  const double b = CHI_95 * factor * (l10 * cos(angle) + l11 * sin(angle));
  double moved[3];
  double point[3];
  hl_add_scaled(light->direction, a, light->tangent_basis[0], moved);
  hl_add_scaled(moved, b, light->tangent_basis[1], moved);
  hl_unit(moved, moved);
  highlight_on_ball(s->photo->sphere, moved, point);
  return to_sheet(s, point, at);
}

static double ellipse_reach(const scene *s, double factor)
{
  double reach = 0;
  for (int i = 0; i < ELLIPSE_POINTS; i++) {
    double at[2];
    if (ellipse_point(s, 2 * PI * i / ELLIPSE_POINTS, factor, at))
      reach = fmax(reach, hypot(at[0] - s->mark[0], at[1] - s->mark[1]));
  }
  return reach;
}

/* 1 where the ellipse can be seen as it is, else the first of 2, 5, 10, 20 ... that shows. */
static int choose_factor(const scene *s)
{
  const double least = 16;
  const double turn = s->photo->light->ellipse_95_rad[0];
  if (!s->photo->sphere || !(turn > 0) || ellipse_reach(s, 1) >= 5)
    return s->photo->sphere && turn > 0 && turn < 0.5;
  static const int steps[] = {2, 5, 10};
  int scale = 1;
  for (int i = 0; scale < 100000; i++) {
    const int factor = scale * steps[i % 3];
    if (factor * turn > 0.5)
      return 0;
    if (ellipse_reach(s, factor) >= least)
      return factor;
    if (i % 3 == 2)
      scale *= 10;
  }
  return 0;
}

static void draw_ellipse(scene *s)
{
  s->factor = choose_factor(s);
  if (s->factor == 0)
    return;
  for (int i = 0; i < ELLIPSE_POINTS; i++) {
    double at[2];
    if (ellipse_point(s, 2 * PI * i / ELLIPSE_POINTS, s->factor, at))
      cairo_line_to(s->canvas->cr, at[0], at[1]);
  }
  cairo_close_path(s->canvas->cr);
  hl_marks_stroke(s->canvas->cr, HL_INK_ELLIPSE, 1.4);
}

/* From the highlight towards the light, in perspective, as long as it stays within the photo. */
static void draw_way_to_light(const scene *s)
{
  const hl_frame *frame = s->photo->frame;
  const double *light = s->photo->light->direction;
  const double size =
      s->photo->sphere ? s->photo->sphere->radius_m : 0.1 * hl_norm(s->point_m); /* of the ray: 1 */
  double from[2];
  double to[2];
  double start[3];
  double end[3];
  hl_add_scaled(s->point_m, 0.1 * size, light, start);
  if (!to_sheet(s, start, from))
    return;
  for (int i = 0; i < 20; i++) {
    hl_add_scaled(s->point_m, 1.6 * pow(0.9, i) * size, light, end);
    if (end[2] > 0.4 * s->point_m[2] && to_sheet(s, end, to) && to[0] > 8 && to[1] > 8 &&
        to[0] < frame->width * s->zoom - 8 && to[1] < frame->height * s->zoom - 8) {
      hl_marks_arrow(s->canvas->cr, from, to);
      return;
    }
  }
}

static hl_status paint_photo(hl_ctx *ctx, const scene *s, int shrink)
{
  cairo_surface_t *image = hl_develop(s->photo->frame, s->photo->surface, shrink);
  if (!image)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the picture");
  cairo_t *cr = s->canvas->cr;
  cairo_save(cr);
  cairo_rectangle(cr, 0, 0, s->photo->frame->width * s->zoom, s->photo->frame->height * s->zoom);
  cairo_clip(cr);
  cairo_scale(cr, s->zoom * shrink, s->zoom * shrink);
  cairo_set_source_surface(cr, image, 0, 0);
  cairo_pattern_set_extend(cairo_get_source(cr), CAIRO_EXTEND_PAD);
  cairo_pattern_set_filter(cairo_get_source(cr), CAIRO_FILTER_GOOD);
  cairo_paint(cr);
  cairo_restore(cr);
  cairo_surface_destroy(image);
  return HL_OK;
}

static int longer_side(const hl_photo *photo)
{
  return photo->frame->width > photo->frame->height ? photo->frame->width : photo->frame->height;
}

static double zoom_of(const hl_photo *photo)
{
  return (double)(photo->bare ? BARE_SIDE : LONGER_SIDE) / longer_side(photo);
}

int hl_photo_ellipse_factor(const hl_photo *photo)
{
  scene s = {.photo = photo, .zoom = zoom_of(photo)};
  return photo->light && photo->light->found && find_highlight(&s) ? choose_factor(&s) : 0;
}

static void draw_marks(scene *s, double width, double height)
{
  cairo_t *cr = s->canvas->cr;
  cairo_save(cr);
  cairo_rectangle(cr, 0, 0, width, height);
  cairo_clip(cr);
  if (s->photo->sphere)
    draw_outline(s);
  s->has_light = s->photo->light && s->photo->light->found && find_highlight(s);
  if (s->has_light) {
    draw_way_to_light(s);
    draw_ellipse(s);
    hl_marks_cross(cr, s->mark[0], s->mark[1]);
  }
  cairo_restore(cr);
}

hl_status hl_draw_frame(hl_ctx *ctx, hl_picture_kind kind, const char *path, const void *data)
{
  const hl_photo *photo = data;
  const double zoom = zoom_of(photo);
  const double width = ceil(photo->frame->width * zoom);
  const double height = ceil(photo->frame->height * zoom);
  const double sheet_width = photo->bare ? width : fmax(width, 640);
  const bool lit = photo->light && photo->light->found;
  const int legend_lines = lit && sheet_width < 930 ? 2 : 1;
  const int lines = 1 + (lit && !photo->light->trusted) + legend_lines;
  const double below = photo->bare ? 0 : lines * HL_CAPTION_LINE + 14;
  hl_canvas canvas;
  hl_status st = hl_canvas_open(ctx, &canvas, kind, path, sheet_width, height + below);
  if (st != HL_OK)
    return st;
  scene s = {.photo = photo, .canvas = &canvas, .zoom = zoom};
  const int doubled = photo->bare ? BARE_SIDE : 2 * LONGER_SIDE;
  st = paint_photo(ctx, &s, (longer_side(photo) + doubled - 1) / doubled);
  draw_marks(&s, width, height);
  if (!photo->bare)
    hl_draw_caption(&canvas, photo, s.factor, sheet_width, height);
  const hl_status closed = hl_canvas_close(st == HL_OK ? ctx : NULL, &canvas);
  return st == HL_OK ? closed : st;
}
