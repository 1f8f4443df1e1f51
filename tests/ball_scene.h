/* A shaded ball before a background, rendered by 4 x 4 samples a pixel: truth for the pose tests.
 */
#ifndef HALFLIGHT_TESTS_BALL_SCENE_H
#define HALFLIGHT_TESTS_BALL_SCENE_H

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "halflight/sphere.h"
#include "halflight/vec3.h"
#include "near.h"

typedef struct ball_scene {
  hl_camera camera;
  hl_sphere ball;
  double light[3];
  double background, slope; /* level in the middle, change across the frame */
  double noise;             /* standard deviation */
  unsigned seed;
  int channels;
} ball_scene;

/* Seeds that differ by one must not start alike. */
static inline test_random scene_random(uint64_t seed)
{
  return (test_random){(seed + 1) * 0x9E3779B97F4A7C15u};
}

/* A ball whose centre is seen at (x,y) with about `radius_px` radius, under an oblique light. */
static inline ball_scene scene_through(double focal_px, double x, double y, double radius_px)
{
  ball_scene s = {.background = 0.2, .noise = 0.001, .seed = 1, .channels = 1};
  s.camera = (hl_camera){.width = 240,
                         .height = 200,
                         .fx = focal_px,
                         .fy = focal_px,
                         .cx = 119.5,
                         .cy = 99.5,
                         .n_distortion = 5,
                         .distortion = {-0.2, 0.05, 0.001, -0.001, 0}};
  double axis[3];
  if (hl_camera_unproject(NULL, &s.camera, x, y, axis) != HL_OK)
    abort();
  s.ball.radius_m = 0.025;
  const double distance = s.ball.radius_m / sin(atan(radius_px / s.camera.fx));
  for (int i = 0; i < 3; i++)
    s.ball.center_m[i] = distance * axis[i];
  const double light[3] = {0.4, -0.5, -0.77};
  hl_unit(light, s.light);
  return s;
}

static inline ball_scene scene_of(double x, double y, double radius_px)
{
  return scene_through(600, x, y, radius_px);
}

/* Diffuse shade and a broad highlight where the ray meets the ball; false where it passes by. */
static inline bool scene_shade(const ball_scene *s, const double ray[3], double *out)
{
  const double *c = s->ball.center_m, r = s->ball.radius_m;
  const double along = hl_dot(ray, c), inside = along * along - hl_dot(c, c) + r * r;
  if (!(inside > 0))
    return false;
  double n[3], h[3];
  for (int i = 0; i < 3; i++)
    n[i] = (ray[i] * (along - sqrt(inside)) - c[i]) / r;
  hl_add_scaled(s->light, -1, ray, h);
  hl_unit(h, h);
  const double cosine = hl_dot(n, s->light);
  *out = cosine > 0 ? 0.5 * cosine + 0.3 * pow(fmax(hl_dot(n, h), 0), 60) : 0;
  return true;
}

static inline double scene_pixel(const ball_scene *s, int x, int y)
{
  double sum = 0;
  const double behind = s->background + s->slope * (x / (double)s->camera.width - 0.5);
  for (int k = 0; k < 16; k++) {
    double ray[3], v;
    const double px = x + (k % 4 + 0.5) / 4 - 0.5, py = y + (k / 4 + 0.5) / 4 - 0.5;
    if (hl_camera_unproject(NULL, &s->camera, px, py, ray) != HL_OK)
      abort();
    sum += scene_shade(s, ray, &v) ? v : behind;
  }
  return sum / 16;
}

/* Far from the ball, by a tenth of its size and five pixels, one sample is enough, and saves most of
 * the time. */
static inline bool scene_is_far(const ball_scene *s, int x, int y)
{
  double ray[3], next[3];
  const double *c = s->ball.center_m;
  if (hl_camera_unproject(NULL, &s->camera, x, y, ray) != HL_OK ||
      hl_camera_unproject(NULL, &s->camera, x + 1, y + 1, next) != HL_OK)
    abort();
  return hl_angle(ray, c) > 1.1 * asin(s->ball.radius_m / hl_norm(c)) + 5 * hl_angle(ray, next);
}

static inline hl_frame scene_frame(const ball_scene *s)
{
  hl_frame f = {
      .width = s->camera.width, .height = s->camera.height, .channels = s->channels, .bits = 32};
  const size_t n = (size_t)f.width * (size_t)f.height * (size_t)f.channels;
  f.radiance = malloc(n * sizeof *f.radiance);
  f.state = calloc(n, 1);
  if (!f.radiance || !f.state)
    abort();
  test_random random = scene_random(s->seed);
  size_t at = 0;
  for (int y = 0; y < f.height; y++)
    for (int x = 0; x < f.width; x++) {
      const double v = scene_is_far(s, x, y)
                           ? s->background + s->slope * (x / (double)f.width - 0.5)
                           : scene_pixel(s, x, y);
      for (int c = 0; c < f.channels; c++)
        f.radiance[at++] = (float)fmax(v + s->noise * random_normal(&random), 0);
    }
  return f;
}

static inline void scene_free(hl_frame *f)
{
  free(f->radiance);
  free(f->state);
}

/* Error of a pose in pixels: of the centre's place in the frame, and of the radius. */
static inline void scene_error(const ball_scene *s, const hl_sphere *found, double *center_px,
                               double *radius_px)
{
  const double *c = s->ball.center_m, *d = found->center_m;
  double p[2], q[2];
  if (hl_camera_project(NULL, &s->camera, c, p) != HL_OK ||
      hl_camera_project(NULL, &s->camera, d, q) != HL_OK)
    abort();
  *center_px = hypot(p[0] - q[0], p[1] - q[1]);
  const double r = s->camera.fx * s->ball.radius_m / hl_norm(c);
  *radius_px = r * fabs(hl_norm(c) / hl_norm(d) - 1);
}

#endif
