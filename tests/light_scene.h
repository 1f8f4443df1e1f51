/* A lit ball, each pixel the light model's own value at its centre: truth for the light's tests. */
#ifndef HALFLIGHT_TESTS_LIGHT_SCENE_H
#define HALFLIGHT_TESTS_LIGHT_SCENE_H

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/light.h"
#include "halflight/vec3.h"
#include "near.h"

#if defined(__SANITIZE_ADDRESS__)
#define LIT_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define LIT_SANITIZED 1
#endif
#endif
#ifndef LIT_SANITIZED
#define LIT_SANITIZED 0
#endif

#if LIT_SANITIZED
/* LLVM's threads keep what they allocate for themselves. */
const char *__lsan_default_suppressions(void);
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void)
{
  return "leak:libomp.so\n";
}
#endif

#define LIT_DEG 0.017453292519943295 /* pi / 180 */

enum { LIT_SIDE = 144 };

typedef enum lit_lobe {
  LIT_MATTE,        /* no lobe */
  LIT_PLAIN,        /* exp(-|n - h|^2 / width^2) */
  LIT_FORESHORTENED /* GGX of roughness `width`, 1 at n = h, over n.v */
} lit_lobe;

typedef struct lit_scene {
  hl_camera camera;
  hl_sphere ball;
  double light[3];
  lit_lobe lobe;
  double width;
  double body[3], gloss[3]; /* k_c, and the lobe's height */
  double ambient;
  double noise;      /* standard deviation */
  double saturation; /* 0 = none */
  double scale;      /* exposure: multiplies all of it, saturation too */
  int channels;
  int across; /* samples across a pixel; 0: the model's own value, from the pixel's centre */
} lit_scene;

/* Towards the light, `angle_deg` from the direction to the camera, turned about it. */
static inline void lit_direction(double angle_deg, double turn_deg, double out[3])
{
  const double a = angle_deg * LIT_DEG, t = turn_deg * LIT_DEG;
  out[0] = sin(a) * cos(t);
  out[1] = sin(a) * sin(t);
  out[2] = -cos(a);
}

/* A glossy ball off the axis under an oblique light, one channel. */
static inline lit_scene lit_ball(double radius_px)
{
  lit_scene s = {.lobe = LIT_PLAIN, .width = 0.15, .channels = 1, .scale = 1};
  s.camera = (hl_camera){
      .width = LIT_SIDE, .height = LIT_SIDE, .fx = 420, .fy = 420, .cx = 60.5, .cy = 64.5};
  s.ball.radius_m = 0.03;
  const double distance = s.ball.radius_m / sin(atan(radius_px / s.camera.fx));
  const double toward[3] = {(74 - s.camera.cx) / s.camera.fx, (70 - s.camera.cy) / s.camera.fy, 1};
  double axis[3];
  hl_unit(toward, axis);
  for (int i = 0; i < 3; i++) {
    s.ball.center_m[i] = distance * axis[i];
    s.body[i] = 0.4;
    s.gloss[i] = 0.8;
  }
  lit_direction(45, -60, s.light);
  return s;
}

static inline lit_scene lit_glossy(void)
{
  return lit_ball(35);
}

/* A frame of the model's own values shows points where a ball's pixels show means: its surface is then
 * one of given normals. */
static inline hl_surface lit_surface(const lit_scene *s)
{
  hl_surface out;
  hl_ctx ctx = {0};
  if (hl_surface_of_sphere(&ctx, &s->camera, &s->ball, 0.05, &out) != HL_OK) {
    print_error("%s\n", ctx.msg);
    abort();
  }
  out.is_ball = s->across > 0;
  return out;
}

static inline double lit_lobe_at(const lit_scene *s, double u)
{
  if (s->lobe == LIT_PLAIN)
    return exp(-u * u / (s->width * s->width));
  const double nh = 1 - u * u / 2, a2 = s->width * s->width;
  const double q = nh * nh * (a2 - 1) + 1;
  return a2 * a2 / (q * q);
}

/* Value at a normal, with `width` the change of n.s across the pixel (0: a point): the shares of
 * the pixel that sees the light, and the mean of max(0, n.s) over it, for n.s spread evenly. */
static inline double lit_value(const lit_scene *s, const double n[3], const double v[3],
                               double width, int c)
{
  double h[3], d[3];
  const double ns = hl_dot(n, s->light);
  const double lit = width > 0 ? fmin(fmax(ns / width + 0.5, 0), 1) : ns > 0;
  const double mean = ns >= width / 2 ? fmax(ns, 0) : lit * lit * width / 2;
  double value = s->ambient + s->body[c] * mean;
  if (s->lobe != LIT_MATTE && lit > 0) {
    hl_add_scaled(s->light, 1, v, h);
    hl_unit(h, h);
    hl_add_scaled(n, -1, h, d);
    const double g = s->lobe == LIT_FORESHORTENED ? 1 / hl_dot(n, v) : 1;
    value += s->gloss[c] * lit * g * lit_lobe_at(s, hl_norm(d));
  }
  return value;
}

/* Mean over a pixel of what its points show, by `across` x `across` of them. */
static inline double lit_mean(const lit_scene *s, int pixel, int across, int c)
{
  double sum = 0;
  for (int k = 0; k < across * across; k++) {
    double ray[3], n[3];
    const double x = pixel % s->camera.width + (k % across + 0.5) / across - 0.5;
    const double y = pixel / s->camera.width + (k / across + 0.5) / across - 0.5;
    if (hl_camera_unproject(NULL, &s->camera, x, y, ray) != HL_OK)
      abort();
    const double *center = s->ball.center_m, r = s->ball.radius_m;
    const double along = hl_dot(ray, center);
    const double inside = along * along - hl_dot(center, center) + r * r;
    for (int i = 0; i < 3; i++)
      n[i] = (ray[i] * (along - sqrt(inside)) - center[i]) / r;
    const double v[3] = {-ray[0], -ray[1], -ray[2]};
    sum += lit_value(s, n, v, 0, c);
  }
  return sum / (across * across);
}

/* Beside the surface nothing is usable. `random` may be NULL where there is no noise. */
static inline hl_frame lit_frame(const lit_scene *s, const hl_surface *surface, test_random *random)
{
  hl_frame f = {.width = surface->width,
                .height = surface->height,
                .channels = s->channels,
                .bits = 32,
                .saturation = s->scale * s->saturation};
  const size_t n = (size_t)f.width * (size_t)f.height * (size_t)f.channels;
  f.radiance = calloc(n, sizeof *f.radiance);
  f.state = malloc(n);
  if (!f.radiance || !f.state)
    abort();
  memset(f.state, HL_SAMPLE_UNUSABLE, n);
  for (int i = 0; i < surface->n; i++)
    for (int c = 0; c < f.channels; c++) {
      const size_t at = (size_t)surface->pixel[i] * (size_t)f.channels + (size_t)c;
      double v = s->across > 0 ? lit_mean(s, surface->pixel[i], s->across, c)
                               : lit_value(s, surface->normal + 3 * i, surface->view + 3 * i,
                                           surface->footprint[i], c);
      if (s->noise > 0)
        v += s->noise * random_normal(random);
      f.state[at] = HL_SAMPLE_OK;
      if (s->saturation > 0 && v >= s->saturation) {
        v = s->saturation;
        f.state[at] = HL_SAMPLE_CLIPPED;
        f.n_clipped++;
      }
      f.radiance[at] = (float)(s->scale * v);
    }
  return f;
}

static inline void lit_frame_free(hl_frame *f)
{
  free(f->radiance);
  free(f->state);
}

static inline hl_status lit_status(const hl_frame *frame, const hl_surface *surface,
                                   const hl_light_settings *settings, hl_ctx *ctx, hl_light *out)
{
  hl_light_work *work = NULL;
  if (hl_light_work_new(ctx, surface->n, frame->channels, &work) != HL_OK)
    abort();
  const hl_status st = hl_light_estimate(ctx, work, frame, surface, settings, out);
  hl_light_work_free(work);
  return st;
}

/* Render and estimate; whatever refuses fails the test. */
static inline hl_light lit_estimate(const lit_scene *s, const hl_light_settings *settings)
{
  hl_surface surface = lit_surface(s);
  hl_frame frame = lit_frame(s, &surface, NULL);
  hl_ctx ctx = {0};
  hl_light out;
  if (lit_status(&frame, &surface, settings, &ctx, &out) != HL_OK) {
    print_error("%s\n", ctx.msg);
    fail();
  }
  lit_frame_free(&frame);
  hl_surface_free(&surface);
  return out;
}

static inline double lit_error_deg(const lit_scene *s, const hl_light *light)
{
  return hl_angle(s->light, light->direction) / LIT_DEG;
}

/* A surface and its frame, for tests that change one of them. */
typedef struct lit_shot {
  hl_surface surface;
  hl_frame frame;
} lit_shot;

static inline lit_shot lit_shot_of(const lit_scene *s, uint64_t seed)
{
  test_random random = {seed};
  lit_shot out = {.surface = lit_surface(s)};
  out.frame = lit_frame(s, &out.surface, &random);
  return out;
}

static inline void lit_shot_free(lit_shot *s)
{
  hl_surface_free(&s->surface);
  lit_frame_free(&s->frame);
}

static inline hl_light lit_light_of(const lit_shot *s, const hl_light_settings *settings)
{
  hl_light out;
  hl_ctx ctx = {0};
  if (lit_status(&s->frame, &s->surface, settings, &ctx, &out) != HL_OK) {
    print_error("%s\n", ctx.msg);
    fail();
  }
  return out;
}

/* With noise and clipping, so that nothing is special. */
static inline lit_scene lit_usual(void)
{
  lit_scene s = lit_glossy();
  s.noise = 0.004;
  s.saturation = 0.8;
  return s;
}

#endif
