/* Lit balls drawn in memory: each pixel is the mean over its area of
 *
 *   body (0.4) max(0, n.s) + gloss f(n.h) [/ n.v],   h = (s + v) / |s + v|,
 *
 * sampled at the nodes of Gauss's two-point rule on a grid of cells, which is finer where the lobe is
 * narrower than the pixel: that mean is exact for shading that is cubic across a cell, where the mean of
 * the cells' middles falls short of the bend by one over the square of their number. Rays come from the
 * camera's own lens, so distortion is in the picture.
 *
 * Codes are what is left of a raw frame once its black level is taken off: noise in the dark stays as
 * often below zero as above it, unless the sensor cuts it there (`cut`). */
#include "bench_ball.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/vec3.h"

static const double RADIANS = 3.14159265358979323846 / 180;
static const double BODY = 0.4;
static const double MIN_COS_VIEW = 0.1; /* the command's */
static const double MARGIN = 1.15;      /* half the frame's side over the ball's radius */

static const double NODE = 0.28867513459481288; /* of Gauss's two-point rule: 1 / sqrt(12) */

enum { ACROSS = 4, ACROSS_MAX = 48 }; /* samples across a pixel, two a cell */

/* Vigna's splitmix64, uniform in [0, 1). */
static double uniform(uint64_t *state)
{
  uint64_t z = *state += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static double normal(uint64_t *state)
{
  double sum = -6;
  for (int i = 0; i < 12; i++)
    sum += uniform(state);
  return sum;
}

static hl_camera camera_of(const hl_bench_ball *b, hl_sphere *sphere)
{
  const int side = 2 * (int)ceil(MARGIN * b->radius_px) + 9;
  const int frame = b->corner ? 4 * side : side;
  hl_camera camera = {.model = HL_LENS_PINHOLE,
                      .n_distortion = 5,
                      .width = frame,
                      .height = frame,
                      .fx = b->focal_px,
                      .fy = b->focal_px,
                      .cx = frame / 2.0 - 0.3,
                      .cy = frame / 2.0 + 0.2};
  const double at = b->corner ? frame - side / 2.0 : frame / 2.0;
  double axis[3] = {(at - camera.cx) / camera.fx, (at - camera.cy) / camera.fy, 1};
  if (b->corner)
    camera.distortion[0] = -0.25;
  hl_unit(axis, axis);
  sphere->radius_m = 0.03;
  const double distance = sphere->radius_m / sin(atan(b->radius_px / b->focal_px));
  for (int i = 0; i < 3; i++)
    sphere->center_m[i] = distance * axis[i];
  return camera;
}

/* `light_deg` from the direction to the camera, turned by `turn_deg` about it. */
static void light_of(const hl_sphere *sphere, double light_deg, double turn_deg, double out[3])
{
  double view[3], x[3] = {1, 0, 0}, y[3];
  hl_unit(sphere->center_m, view);
  for (int i = 0; i < 3; i++)
    view[i] = -view[i];
  hl_add_scaled(x, -hl_dot(x, view), view, x);
  hl_unit(x, x);
  hl_cross(view, x, y);
  const double a = light_deg * RADIANS, t = turn_deg * RADIANS;
  for (int i = 0; i < 3; i++)
    out[i] = cos(a) * view[i] + sin(a) * (cos(t) * x[i] + sin(t) * y[i]);
}

static double lobe_at(const hl_bench_ball *b, double nh, double sine2)
{
  if (b->lobe == HL_BENCH_LINEAR)
    return nh;
  if (b->lobe == HL_BENCH_QUADRATIC)
    return nh * nh;
  const double a = fmin(b->lobe_deg * RADIANS, 1), a2 = a * a;
  const double q = a2 * nh * nh + sine2;
  return a2 * a2 / (q * q);
}

static double shade(const hl_bench_ball *b, const double s[3], const double n[3], const double v[3])
{
  const double ns = hl_dot(n, s);
  if (ns <= 0)
    return 0;
  double value = BODY * ns;
  if (b->lobe != HL_BENCH_MATTE) {
    double h[3], cross[3];
    hl_add_scaled(s, 1, v, h);
    hl_unit(h, h);
    hl_cross(n, h, cross);
    const double over = b->lobe == HL_BENCH_GGX ? fmax(hl_dot(n, v), 0.05) : 1;
    value += b->gloss * lobe_at(b, fmax(hl_dot(n, h), 0), hl_dot(cross, cross)) / over;
  }
  return value;
}

/* How many samples across a pixel: many only where a narrow lobe falls into it. */
static int across_of(const hl_bench_ball *b, const hl_surface *surface, int i, const double s[3])
{
  if (b->lobe != HL_BENCH_GGX)
    return ACROSS;
  double h[3], d[3];
  const double a = b->lobe_deg * RADIANS, f = surface->footprint[i];
  hl_add_scaled(s, 1, surface->view + 3 * i, h);
  hl_unit(h, h);
  hl_add_scaled(surface->normal + 3 * i, -1, h, d);
  const double fine = hl_norm(d) < 8 * a + 2 * f ? ceil(4 * f / a) : ACROSS;
  const int samples = (int)fmin(fmax(fine, ACROSS), ACROSS_MAX);
  return samples + samples % 2;
}

/* Of sample k of `across`, from the pixel's centre, in pixels. */
static double offset_of(int k, int across)
{
  const int pair = k / 2, pairs = across / 2;
  return (pair + 0.5 + (k % 2 ? NODE : -NODE)) / pairs - 0.5;
}

static double mean_of(const hl_bench_ball *b, const hl_surface *surface, int i, const double s[3])
{
  const int across = across_of(b, surface, i, s), x0 = surface->pixel[i] % surface->width,
            y0 = surface->pixel[i] / surface->width;
  const double *center = surface->ball.center_m, r = surface->ball.radius_m;
  const double beyond = hl_dot(center, center) - r * r;
  double sum = 0;
  for (int k = 0; k < across * across; k++) {
    const int column = k % across, row = k / across;
    double ray[3], n[3];
    if (hl_camera_unproject(NULL, &surface->camera, x0 + offset_of(column, across),
                            y0 + offset_of(row, across), ray) != HL_OK)
      continue;
    const double along = hl_dot(ray, center);
    const double depth = along - sqrt(fmax(along * along - beyond, 0));
    for (int j = 0; j < 3; j++)
      n[j] = (ray[j] * depth - center[j]) / r;
    const double v[3] = {-ray[0], -ray[1], -ray[2]};
    sum += shade(b, s, n, v);
  }
  return sum / (across * across);
}

/* What a flaw makes of a pixel's value. */
static double spoil(const hl_bench_ball *b, const hl_surface *surface, int i, double value,
                    uint64_t *state)
{
  if (b->flaw == HL_BENCH_DUST && uniform(state) < b->share)
    return value * (0.2 + 1.3 * uniform(state));
  if (b->flaw == HL_BENCH_LABEL && i < b->share * surface->n)
    return 0.3 * value;
  if (b->flaw == HL_BENCH_SECOND) {
    double second[3];
    light_of(&surface->ball, 50, 200, second);
    return value + mean_of(b, surface, i, second) / 3;
  }
  return value;
}

static void draw(const hl_bench_ball *b, const hl_surface *surface, const double s[3],
                 uint64_t seed, hl_frame *frame)
{
  static const double tint[3] = {1, 0.6, 0.35}; /* of the body's share of each channel */
  uint64_t state = seed;
  const double top = b->lobe == HL_BENCH_MATTE ? BODY : BODY + b->gloss;
  const double limit = b->clipped > 0 ? BODY + b->gloss * (1 - b->clipped) : 1.2 * top;
  const double full = b->bits > 0 ? pow(2, b->bits) - 1 : 0;
  frame->saturation = b->clipped > 0 || b->bits > 0 ? limit * b->scale : 0;
  for (int i = 0; i < surface->n; i++) {
    const double clean = spoil(b, surface, i, mean_of(b, surface, i, s), &state);
    for (int c = 0; c < frame->channels; c++) {
      const size_t at = (size_t)surface->pixel[i] * (size_t)frame->channels + (size_t)c;
      /* NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): 1 or 3 channels */
      double value = clean * (frame->channels == 1 ? 1 : tint[c]);
      if (b->noise > 0)
        value += b->noise * BODY * normal(&state);
      if (b->flaw == HL_BENCH_DEAD && c == 1)
        value = 0;
      frame->state[at] = HL_SAMPLE_OK;
      if (frame->saturation > 0 && value >= limit) {
        value = limit;
        frame->state[at] = HL_SAMPLE_CLIPPED;
        frame->n_clipped++;
      } else if (b->bits > 0) {
        value = floor(value / limit * full + 0.5) / full * limit;
        if (b->cut && value < 0)
          value = 0;
      }
      frame->radiance[at] = (float)(value * b->scale);
    }
  }
}

hl_status hl_bench_ball_draw(hl_ctx *ctx, const hl_bench_ball *ball, uint64_t seed, hl_frame *frame,
                             hl_surface *surface, double light[3])
{
  hl_sphere sphere = {0};
  const hl_camera camera = camera_of(ball, &sphere);
  hl_status st = hl_surface_of_sphere(ctx, &camera, &sphere, MIN_COS_VIEW, surface);
  if (st != HL_OK)
    return st;
  *frame = (hl_frame){.width = camera.width,
                      .height = camera.height,
                      .channels = ball->flaw == HL_BENCH_DEAD ? 3 : 1,
                      .bits = 32};
  const size_t n = (size_t)frame->width * (size_t)frame->height * (size_t)frame->channels;
  frame->radiance = calloc(n, sizeof *frame->radiance);
  frame->state = malloc(n);
  if (!frame->radiance || !frame->state) {
    hl_frame_free(frame);
    hl_surface_free(surface);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a frame of %d x %d", frame->width,
                   frame->height);
  }
  memset(frame->state, HL_SAMPLE_UNUSABLE, n);
  light_of(&sphere, ball->light_deg, -60, light);
  draw(ball, surface, light, seed, frame);
  return HL_OK;
}
