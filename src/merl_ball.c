/* A ball of a measured material.
 *
 * Radiance is BRDF x (n.s) for a light of irradiance 1. From afar each pixel shows the normal of its
 * centre, (x, y, sqrt(1 - x^2 - y^2)) with x and y in ball radii; through a camera a pixel is the mean
 * over a regular grid of rays, so that the outline, the shadow's edge and a highlight narrower than a
 * pixel carry the right weight. What one ray cannot tell, their mean cannot either. */
#include "halflight/merl_ball.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ball_hit.h"

enum { RADIUS_MAX = 1024, OVERSAMPLE_MAX = 16, CHANNELS = 3 };

hl_merl_ball_settings hl_merl_ball_defaults(void)
{
  const hl_merl_ball_settings s = {.lookup = HL_MERL_SMOOTH,
                                   .oversample = 4,
                                   .background = 0,
                                   .min_cos_light = 0.02,
                                   .min_cos_view = 0.05};
  return s;
}

const hl_field_table *hl_merl_ball_fields(void)
{
  static const char *const lookups[] = {"smooth", "nearest", NULL};
  static const hl_field fields[] = {
      {"lookup", HL_FIELD_CHOICE, offsetof(hl_merl_ball_settings, lookup), 0, 1, "",
       "how the table is asked between its cells' centres; nearest is the database's own reader",
       lookups},
      {"oversample", HL_FIELD_INT, offsetof(hl_merl_ball_settings, oversample), 1, OVERSAMPLE_MAX,
       "", "through a camera: rays across a pixel, each way", NULL},
      {"background", HL_FIELD_DOUBLE, offsetof(hl_merl_ball_settings, background), 0, 1e6, "",
       "through a camera: radiance behind the ball", NULL},
      {"min_cos_light", HL_FIELD_DOUBLE, offsetof(hl_merl_ball_settings, min_cos_light), 0, 0.9, "",
       "least n.s of a sample", NULL},
      {"min_cos_view", HL_FIELD_DOUBLE, offsetof(hl_merl_ball_settings, min_cos_view), 0, 0.9, "",
       "least n.v of a sample", NULL},
  };
  static const hl_field_table table = {"settings of a measured ball", fields,
                                       (int)(sizeof fields / sizeof *fields)};
  return &table;
}

void hl_merl_ball_free(hl_merl_ball *ball)
{
  if (!ball)
    return;
  hl_frame_free(&ball->frame);
  hl_samples_free(&ball->samples);
}

/* What both ways of seeing share. */
typedef struct shading {
  const hl_merl *merl;
  hl_merl_ball_settings settings;
  double s[3];
  hl_merl_ball ball;
} shading;

static hl_status begin(hl_ctx *ctx, const hl_merl *merl, const double light[3],
                       const hl_merl_ball_settings *settings, int width, int height, shading *out)
{
  const hl_merl_ball_settings own = settings ? *settings : hl_merl_ball_defaults();
  shading d = {.merl = merl, .settings = own};
  const hl_status st = hl_fields_check(ctx, hl_merl_ball_fields(), &own);
  if (st != HL_OK)
    return st;
  hl_unit(light, d.s);
  if (!(hl_norm(d.s) > 0.5)) {
    hl_fail(ctx, HL_ERR_ARG, "light (%g, %g, %g); a direction is needed", light[0], light[1],
            light[2]);
    return HL_ERR_ARG;
  }
  const size_t n = (size_t)width * (size_t)height;
  d.ball.frame = (hl_frame){.width = width, .height = height, .channels = CHANNELS, .bits = 32};
  d.ball.frame.radiance = calloc(n * CHANNELS, sizeof *d.ball.frame.radiance);
  d.ball.frame.state = calloc(n * CHANNELS, sizeof *d.ball.frame.state);
  if (d.ball.frame.radiance && d.ball.frame.state) {
    *out = d;
    return HL_OK;
  }
  hl_merl_ball_free(&d.ball);
  hl_fail(ctx, HL_ERR_MEMORY, "no memory for a frame of %d x %d pixels", width, height);
  return HL_ERR_MEMORY;
}

/* Radiance towards v; false where the table does not say. */
static bool radiance(const shading *d, const double n[3], const double v[3], double out[CHANNELS])
{
  const bool measured = hl_merl_eval(d->merl, n, d->s, v, d->settings.lookup, out);
  for (int c = 0; c < CHANNELS; c++)
    out[c] *= hl_dot(n, d->s) > 0 ? hl_dot(n, d->s) : 0;
  return measured;
}

static void put_pixel(shading *d, size_t pixel, const double value[CHANNELS], bool measured)
{
  hl_frame *f = &d->ball.frame;
  d->ball.n_pixels++;
  d->ball.n_unmeasured += !measured;
  for (size_t c = 0; c < CHANNELS; c++) {
    f->radiance[CHANNELS * pixel + c] = measured ? (float)value[c] : 0;
    f->state[CHANNELS * pixel + c] = measured ? HL_SAMPLE_OK : HL_SAMPLE_UNUSABLE;
    f->n_unusable += !measured;
  }
}

static bool is_sample(const shading *d, const double n[3], const double v[3])
{
  return hl_dot(n, d->s) > d->settings.min_cos_light && hl_dot(n, v) > d->settings.min_cos_view;
}

/* Rooms for `room` samples; arrays of no use stay NULL. */
static hl_status samples_new(hl_ctx *ctx, size_t room, bool with_views, hl_samples *out)
{
  hl_samples s = {.channels = CHANNELS};
  bool good = true;
  room = room > 0 ? room : 1;
  s.normal = malloc(3 * room * sizeof *s.normal);
  s.view = with_views ? malloc(3 * room * sizeof *s.view) : NULL;
  for (int c = 0; c < CHANNELS; c++) {
    s.value[c] = malloc(room * sizeof *s.value[c]);
    good = good && s.value[c];
  }
  *out = s;
  if (good && s.normal && (s.view || !with_views))
    return HL_OK;
  hl_samples_free(out);
  hl_fail(ctx, HL_ERR_MEMORY, "no memory for %zu samples", room);
  return HL_ERR_MEMORY;
}

static void push_sample(hl_samples *to, const double n[3], const double v[3],
                        const double value[CHANNELS])
{
  const size_t i = (size_t)to->n++;
  memcpy(to->normal + 3 * i, n, 3 * sizeof *n);
  if (to->view)
    memcpy(to->view + 3 * i, v, 3 * sizeof *v);
  for (int c = 0; c < CHANNELS; c++)
    to->value[c][i] = value[c];
}

/* Hand the ball over, or say why it shows nothing. */
static hl_status end(hl_ctx *ctx, shading *d, hl_status st, hl_merl_ball *out)
{
  if (st == HL_OK && d->ball.n_pixels == 0)
    st = hl_fail(ctx, HL_ERR_DEGENERATE,
                 "no pixel of the %d x %d frame shows the ball; a ball within the frame is needed",
                 d->ball.frame.width, d->ball.frame.height);
  else if (st == HL_OK && d->ball.samples.n == 0)
    st =
        hl_fail(ctx, HL_ERR_DEGENERATE,
                "light (%.6g, %.6g, %.6g) lights no measured part of the ball that is seen; one on "
                "the viewer's side is needed",
                d->s[0], d->s[1], d->s[2]);
  if (st == HL_OK)
    *out = d->ball;
  else
    hl_merl_ball_free(&d->ball);
  return st;
}

/* ---- from afar */

hl_status hl_merl_ball_from_afar(hl_ctx *ctx, const hl_merl *merl, int radius_px,
                                 const double light[3], const hl_merl_ball_settings *settings,
                                 hl_merl_ball *out)
{
  static const double v[3] = {0, 0, 1};
  shading d;
  if (radius_px < 1 || radius_px > RADIUS_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "radius %d px is outside [1, %d]", radius_px, RADIUS_MAX);
  const int side = 2 * radius_px;
  hl_status st = begin(ctx, merl, light, settings, side, side, &d);
  if (st != HL_OK)
    return st;
  st = samples_new(ctx, (size_t)side * (size_t)side, false, &d.ball.samples);
  for (int row = 0; row < side && st == HL_OK; row++)
    for (int column = 0; column < side; column++) {
      const double x = (column + 0.5) / radius_px - 1, y = 1 - (row + 0.5) / radius_px;
      const double under = 1 - x * x - y * y;
      if (!(under > 0))
        continue;
      const double n[3] = {x, y, sqrt(under)};
      double value[CHANNELS];
      const bool measured = radiance(&d, n, v, value);
      put_pixel(&d, (size_t)row * (size_t)side + (size_t)column, value, measured);
      if (measured && is_sample(&d, n, v))
        push_sample(&d.ball.samples, n, v, value);
    }
  return end(ctx, &d, st, out);
}

/* ---- through a camera */

typedef struct through {
  const hl_camera *camera;
  const hl_sphere *sphere;
  double half_rad; /* half-angle of the ball */
} through;

static bool normal_at(const through *t, double x, double y, double n[3], double v[3])
{
  double ray[3];
  if (hl_camera_unproject(NULL, t->camera, x, y, ray) != HL_OK || !hl_ball_hit(t->sphere, ray, n))
    return false;
  for (int i = 0; i < 3; i++)
    v[i] = -ray[i];
  return true;
}

/* Can some ray of the pixel meet the ball? Its corners are no farther from its centre than twice the
 * farthest next pixel's centre. */
static bool comes_near(const through *t, int x, int y)
{
  double ray[3], other[3], reach = 0;
  if (hl_camera_unproject(NULL, t->camera, x, y, ray) != HL_OK)
    return true;
  for (int i = -1; i <= 1; i += 2) {
    if (hl_camera_unproject(NULL, t->camera, x + i, y + i, other) != HL_OK)
      return true;
    reach = fmax(reach, hl_angle(ray, other));
  }
  return hl_angle(ray, t->sphere->center_m) <= t->half_rad + 2 * reach;
}

/* Mean over a pixel; the number of rays that met the ball. */
static int mean_over(const shading *d, const through *t, int x, int y, double mean[CHANNELS],
                     bool *measured)
{
  const int across = d->settings.oversample;
  int hits = 0;
  double sum[CHANNELS] = {0};
  *measured = true;
  for (int k = 0; k < across * across; k++) {
    double n[3], v[3], value[CHANNELS];
    const int row = k / across, column = k % across;
    const double dx = (column + 0.5) / across - 0.5, dy = (row + 0.5) / across - 0.5;
    if (!normal_at(t, x + dx, y + dy, n, v)) {
      for (int c = 0; c < CHANNELS; c++)
        sum[c] += d->settings.background;
      continue;
    }
    hits++;
    *measured = radiance(d, n, v, value) && *measured;
    for (int c = 0; c < CHANNELS; c++)
      sum[c] += value[c];
  }
  for (int c = 0; c < CHANNELS; c++)
    mean[c] = sum[c] / (across * across);
  return hits;
}

static void fill(shading *d, const through *t)
{
  hl_frame *f = &d->ball.frame;
  for (int y = 0; y < f->height; y++)
    for (int x = 0; x < f->width; x++) {
      const size_t pixel = (size_t)y * (size_t)f->width + (size_t)x;
      double value[CHANNELS];
      bool measured = true;
      const int hits = comes_near(t, x, y) ? mean_over(d, t, x, y, value, &measured) : 0;
      if (hits > 0)
        put_pixel(d, pixel, value, measured);
      for (size_t c = 0; c < CHANNELS && hits == 0; c++)
        f->radiance[CHANNELS * pixel + c] = (float)d->settings.background;
    }
}

static hl_status take_samples(hl_ctx *ctx, shading *d, const through *t)
{
  const hl_status st = samples_new(ctx, (size_t)d->ball.n_pixels, true, &d->ball.samples);
  for (int y = 0; y < d->ball.frame.height && st == HL_OK; y++)
    for (int x = 0; x < d->ball.frame.width; x++) {
      double n[3], v[3], value[CHANNELS];
      if (d->ball.samples.n < d->ball.n_pixels && normal_at(t, x, y, n, v) && is_sample(d, n, v) &&
          radiance(d, n, v, value))
        push_sample(&d->ball.samples, n, v, value);
    }
  return st;
}

hl_status hl_merl_ball_through_camera(hl_ctx *ctx, const hl_merl *merl, const hl_camera *camera,
                                      const hl_sphere *sphere, const double light[3],
                                      const hl_merl_ball_settings *settings, hl_merl_ball *out)
{
  hl_ctx inner = {0};
  shading d;
  if (hl_camera_check(&inner, camera) != HL_OK)
    return hl_fail(ctx, HL_ERR_ARG, "camera: %s", inner.msg);
  if (hl_sphere_check(&inner, sphere) != HL_OK)
    return hl_fail(ctx, HL_ERR_ARG, "sphere: %s", inner.msg);
  const through t = {camera, sphere, asin(fmin(1, sphere->radius_m / hl_norm(sphere->center_m)))};
  hl_status st = begin(ctx, merl, light, settings, camera->width, camera->height, &d);
  if (st != HL_OK)
    return st;
  fill(&d, &t);
  st = take_samples(ctx, &d, &t);
  return end(ctx, &d, st, out);
}
