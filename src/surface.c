/*
 * The seen surface.
 *
 * Ball: where a pixel's ray u meets it (ball_hit.h) is its normal, and v = -u. The ball's image is
 * convex, so a pixel whose four corners lie on it lies on it as a whole.
 *
 * Footprint: with a, b the changes of the normal across the pixel's width and height, the largest
 * singular value of [a b].
 */
#include "halflight/surface.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ball_hit.h"
#include "halflight/vec3.h"
#include "surface_look.h"

enum { COARSE = 16 };

#define SMALLEST_PX 3.0

/* A flat surface has no footprint, but edges inside a pixel are divided by it. */
#define SMALLEST_FOOTPRINT 1e-6

void hl_surface_free(hl_surface *surface)
{
  if (!surface)
    return;
  free(surface->pixel);
  free(surface->normal);
  free(surface->view);
  free(surface->footprint);
  *surface = (hl_surface){0};
}

static hl_status surface_new(hl_ctx *ctx, int width, int height, size_t room, hl_surface *out)
{
  hl_surface s = {.width = width, .height = height};
  if (room == 0)
    room = 1;
  s.pixel = malloc(room * sizeof *s.pixel);
  s.normal = malloc(room * 3 * sizeof *s.normal);
  s.view = malloc(room * 3 * sizeof *s.view);
  s.footprint = malloc(room * sizeof *s.footprint);
  *out = s;
  if (s.pixel && s.normal && s.view && s.footprint)
    return HL_OK;
  hl_surface_free(out);
  hl_fail(ctx, HL_ERR_MEMORY, "no memory for a surface of %zu pixels", room);
  return HL_ERR_MEMORY;
}

/* Give back what was not used; a smaller block is never refused. */
static void shrink(hl_surface *s)
{
  const size_t n = (size_t)s->n;
  void *p = realloc(s->pixel, n * sizeof *s->pixel);
  s->pixel = p ? p : s->pixel;
  p = realloc(s->normal, n * 3 * sizeof *s->normal);
  s->normal = p ? p : s->normal;
  p = realloc(s->view, n * 3 * sizeof *s->view);
  s->view = p ? p : s->view;
  p = realloc(s->footprint, n * sizeof *s->footprint);
  s->footprint = p ? p : s->footprint;
}

/* Largest singular value of [a b]. */
static double largest_change(const double a[3], const double b[3])
{
  const double aa = hl_dot(a, a), bb = hl_dot(b, b), ab = hl_dot(a, b);
  return sqrt((aa + bb + hypot(aa - bb, 2 * ab)) / 2);
}

static void push(hl_surface *s, int pixel, const double n[3], const double v[3], double footprint)
{
  const size_t i = (size_t)s->n++;
  s->pixel[i] = pixel;
  memcpy(s->normal + 3 * i, n, 3 * sizeof *n);
  memcpy(s->view + 3 * i, v, 3 * sizeof *v);
  s->footprint[i] = fmax(footprint, SMALLEST_FOOTPRINT);
}

/* ---- ball */

/* One place in the frame: its ray, and the ball's normal there. */
typedef struct seen {
  bool hit;
  double ray[3];
  double normal[3];
} seen;

static seen look(const hl_camera *camera, const hl_sphere *ball, double x, double y)
{
  seen s = {.hit = false};
  if (hl_camera_unproject(NULL, camera, x, y, s.ray) != HL_OK)
    return s;
  s.hit = hl_ball_hit(ball, s.ray, s.normal);
  return s;
}

bool hl_ball_look(const hl_camera *camera, const hl_sphere *ball, double x, double y,
                  double normal[3], double view[3])
{
  const seen s = look(camera, ball, x, y);
  for (int i = 0; i < 3 && s.hit; i++) {
    normal[i] = s.normal[i];
    view[i] = -s.ray[i];
  }
  return s.hit;
}

typedef struct box {
  int x0, y0, x1, y1; /* pixels x0 <= x < x1 */
} box;

/* Does the ball come near this place? `reach` is the angle to the farthest neighbour. */
static bool comes_near(const hl_camera *camera, const hl_sphere *ball, double x, double y)
{
  double ray[3];
  if (hl_camera_unproject(NULL, camera, x, y, ray) != HL_OK)
    return true;
  double reach = 0;
  for (int i = -1; i <= 1; i += 2)
    for (int k = -1; k <= 1; k += 2) {
      double other[3];
      if (hl_camera_unproject(NULL, camera, x + i * COARSE, y + k * COARSE, other) != HL_OK)
        return true;
      reach = fmax(reach, hl_angle(ray, other));
    }
  const double half = asin(fmin(1, ball->radius_m / hl_norm(ball->center_m)));
  return hl_angle(ray, ball->center_m) <= half + 2 * reach;
}

/* Part of the frame outside of which the ball is surely not, from a coarse grid; so that a small
 * ball in a large frame costs little. */
static box find_box(const hl_camera *camera, const hl_sphere *ball)
{
  box b = {camera->width, camera->height, 0, 0};
  for (int y = 0; y < camera->height + COARSE; y += COARSE)
    for (int x = 0; x < camera->width + COARSE; x += COARSE) {
      if (!comes_near(camera, ball, x, y))
        continue;
      b.x0 = x - COARSE < b.x0 ? x - COARSE : b.x0;
      b.y0 = y - COARSE < b.y0 ? y - COARSE : b.y0;
      b.x1 = x + COARSE > b.x1 ? x + COARSE : b.x1;
      b.y1 = y + COARSE > b.y1 ? y + COARSE : b.y1;
    }
  b.x0 = b.x0 < 0 ? 0 : b.x0;
  b.y0 = b.y0 < 0 ? 0 : b.y0;
  b.x1 = b.x1 > camera->width ? camera->width : b.x1;
  b.y1 = b.y1 > camera->height ? camera->height : b.y1;
  return b;
}

static double footprint_of(const seen *top, const seen *bottom)
{
  double a[3], b[3];
  for (int i = 0; i < 3; i++) {
    a[i] = (top[1].normal[i] + bottom[1].normal[i] - top[0].normal[i] - bottom[0].normal[i]) / 2;
    b[i] = (bottom[0].normal[i] + bottom[1].normal[i] - top[0].normal[i] - top[1].normal[i]) / 2;
  }
  return largest_change(a, b);
}

/* Two rows of pixel corners at a time; each corner is looked at once. */
static void fill(const hl_camera *camera, const hl_sphere *ball, double min_cos_view, box b,
                 seen *corners, hl_surface *out)
{
  const int w = b.x1 - b.x0;
  seen *top = corners, *bottom = corners + w + 1;
  for (int x = 0; x <= w; x++)
    top[x] = look(camera, ball, b.x0 + x - 0.5, b.y0 - 0.5);
  for (int y = b.y0; y < b.y1; y++) {
    for (int x = 0; x <= w; x++)
      bottom[x] = look(camera, ball, b.x0 + x - 0.5, y + 0.5);
    for (int x = 0; x < w; x++) {
      if (!(top[x].hit && top[x + 1].hit && bottom[x].hit && bottom[x + 1].hit))
        continue;
      const seen s = look(camera, ball, b.x0 + x, y);
      const double view[3] = {-s.ray[0], -s.ray[1], -s.ray[2]};
      if (s.hit && hl_dot(s.normal, view) >= min_cos_view)
        push(out, y * camera->width + b.x0 + x, s.normal, view, footprint_of(top + x, bottom + x));
    }
    seen *other = top;
    top = bottom;
    bottom = other;
  }
}

static hl_status check_view_limit(hl_ctx *ctx, double min_cos_view)
{
  if (min_cos_view > 0 && min_cos_view < 1)
    return HL_OK;
  return hl_fail(ctx, HL_ERR_ARG, "min_cos_view = %.6g is outside (0, 1)", min_cos_view);
}

hl_status hl_surface_of_sphere(hl_ctx *ctx, const hl_camera *camera, const hl_sphere *sphere,
                               double min_cos_view, hl_surface *out)
{
  hl_status st = check_view_limit(ctx, min_cos_view);
  hl_ctx inner = {0};
  if (st == HL_OK && hl_sphere_check(&inner, sphere) != HL_OK)
    st = hl_fail(ctx, HL_ERR_ARG, "sphere: %s", inner.msg);
  if (st != HL_OK)
    return st;
  const double distance = hl_norm(sphere->center_m);
  const double radius_px = fmin(camera->fx, camera->fy) * sphere->radius_m /
                           sqrt(distance * distance - sphere->radius_m * sphere->radius_m);
  if (!(radius_px >= SMALLEST_PX))
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "the ball's image is %.3g px in radius; at least %g px are needed", radius_px,
                   SMALLEST_PX);
  const box b = find_box(camera, sphere);
  const size_t w = b.x1 > b.x0 ? (size_t)(b.x1 - b.x0) : 0;
  const size_t h = b.y1 > b.y0 ? (size_t)(b.y1 - b.y0) : 0;
  hl_surface surface;
  st = surface_new(ctx, camera->width, camera->height, w * h, &surface);
  if (st != HL_OK)
    return st;
  seen *corners = malloc(2 * (w + 1) * sizeof *corners);
  if (!corners) {
    hl_surface_free(&surface);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %zu pixel corners", 2 * (w + 1));
  }
  if (w > 0 && h > 0)
    fill(camera, sphere, min_cos_view, b, corners, &surface);
  free(corners);
  if (surface.n == 0) {
    hl_surface_free(&surface);
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "no pixel of the %d x %d frame lies on the ball at (%.6g, %.6g, %.6g) m",
                   camera->width, camera->height, sphere->center_m[0], sphere->center_m[1],
                   sphere->center_m[2]);
  }
  shrink(&surface);
  surface.camera = *camera;
  surface.is_ball = true;
  surface.ball = *sphere;
  *out = surface;
  return HL_OK;
}

/* ---- any other surface */

/* The unit normal of a pixel; false where the map has none. */
static bool normal_at(const hl_frame *map, int x, int y, double n[3])
{
  if (x < 0 || y < 0 || x >= map->width || y >= map->height)
    return false;
  const size_t at = 3 * ((size_t)y * (size_t)map->width + (size_t)x);
  for (size_t i = 0; i < 3; i++) {
    if (map->state[at + i] == HL_SAMPLE_UNUSABLE)
      return false;
    n[i] = map->radiance[at + i];
  }
  const double length = hl_norm(n);
  hl_unit(n, n);
  return length > 0;
}

/* Change of the normal along one axis: from both neighbours, from one, or unknown (0). */
static void change_along(const hl_frame *map, int x, int y, int dx, int dy, const double n[3],
                         double change[3])
{
  double before[3], after[3];
  const bool has_before = normal_at(map, x - dx, y - dy, before);
  const bool has_after = normal_at(map, x + dx, y + dy, after);
  const double *from = has_before ? before : n;
  const double *to = has_after ? after : n;
  const double share = has_before && has_after ? 0.5 : 1;
  for (int i = 0; i < 3; i++)
    change[i] = share * (to[i] - from[i]);
}

static hl_status check_map(hl_ctx *ctx, const hl_frame *map)
{
  if (map->channels != 3)
    return hl_fail(ctx, HL_ERR_FORMAT, "normal map has %d channel; 3 are needed", map->channels);
  const size_t pixels = (size_t)map->width * (size_t)map->height;
  for (size_t p = 0; p < pixels; p++) {
    const float *r = map->radiance + 3 * p;
    const double n[3] = {r[0], r[1], r[2]};
    double ignored[3];
    const int x = (int)(p % (size_t)map->width), y = (int)(p / (size_t)map->width);
    if (normal_at(map, x, y, ignored) && !(fabs(hl_norm(n) - 1) <= 0.01))
      return hl_fail(
          ctx, HL_ERR_FORMAT,
          "normal at pixel (%d, %d) has length %.6g; 1 to 1 %% is needed, or (0,0,0) for "
          "no surface",
          x, y, hl_norm(n));
  }
  return HL_OK;
}

/* From where the map's pixels are seen: through a camera, or along one view. */
typedef struct seen_from {
  const hl_camera *camera; /* NULL: along `view` */
  double view[3];
} seen_from;

static bool view_of(const seen_from *from, int x, int y, double view[3])
{
  double ray[3];
  memcpy(view, from->view, sizeof from->view);
  if (!from->camera)
    return true;
  if (hl_camera_unproject(NULL, from->camera, x, y, ray) != HL_OK)
    return false;
  for (int i = 0; i < 3; i++)
    view[i] = -ray[i];
  return true;
}

static void fill_from_map(const seen_from *from, const hl_frame *map, double min_cos_view,
                          hl_surface *out)
{
  for (int y = 0; y < map->height; y++)
    for (int x = 0; x < map->width; x++) {
      double n[3], view[3], a[3], b[3];
      if (!normal_at(map, x, y, n) || !view_of(from, x, y, view) ||
          !(hl_dot(n, view) >= min_cos_view))
        continue;
      change_along(map, x, y, 1, 0, n, a);
      change_along(map, x, y, 0, 1, n, b);
      push(out, y * map->width + x, n, view, largest_change(a, b));
    }
}

static hl_status surface_of_map(hl_ctx *ctx, const seen_from *from, const hl_frame *map,
                                double min_cos_view, const char *frame, hl_surface *out)
{
  hl_surface surface;
  hl_status st =
      surface_new(ctx, map->width, map->height, (size_t)map->width * (size_t)map->height, &surface);
  if (st != HL_OK)
    return st;
  if (from->camera)
    surface.camera = *from->camera;
  fill_from_map(from, map, min_cos_view, &surface);
  if (surface.n == 0) {
    hl_surface_free(&surface);
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "no normal of the map faces the %s; n.v >= %.3g is needed (%s)",
                   from->camera ? "camera" : "viewer", min_cos_view, frame);
  }
  shrink(&surface);
  *out = surface;
  return HL_OK;
}

hl_status hl_surface_of_normals(hl_ctx *ctx, const hl_camera *camera, const hl_frame *normals,
                                double min_cos_view, hl_surface *out)
{
  const seen_from from = {.camera = camera};
  hl_status st = check_view_limit(ctx, min_cos_view);
  if (st == HL_OK && (normals->width != camera->width || normals->height != camera->height))
    st = hl_fail(ctx, HL_ERR_FORMAT, "normal map is %d x %d px; the camera's %d x %d is needed",
                 normals->width, normals->height, camera->width, camera->height);
  if (st == HL_OK)
    st = check_map(ctx, normals);
  if (st == HL_OK)
    st = surface_of_map(ctx, &from, normals, min_cos_view,
                        "camera frame: x right, y down, z forward", out);
  return st;
}

hl_status hl_surface_of_parallel_view(hl_ctx *ctx, const hl_frame *normals, const double view[3],
                                      double min_cos_view, hl_surface *out)
{
  seen_from from = {.camera = NULL};
  char frame[80];
  hl_unit(view, from.view);
  snprintf(frame, sizeof frame, "the view is (%.4g, %.4g, %.4g)", view[0], view[1], view[2]);
  hl_status st = check_view_limit(ctx, min_cos_view);
  if (st == HL_OK && !(hl_norm(from.view) > 0.5))
    st = hl_fail(ctx, HL_ERR_ARG, "%s; a direction is needed", frame);
  if (st == HL_OK)
    st = check_map(ctx, normals);
  if (st == HL_OK)
    st = surface_of_map(ctx, &from, normals, min_cos_view, frame, out);
  return st;
}
