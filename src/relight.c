/*
 * Drawing a fitted reflectance under another light.
 *
 * Axes: `down` is the frame's own down made orthogonal to the view, right = down x (-view), which is
 * right-handed as x right, y down, z into the picture is. Seen from straight above or below, down is
 * taken towards the front.
 */
#include "halflight/relight.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/vec3.h"

enum { RADIUS_MAX = 8192, CHANNELS = 3 };

static const double least_lit = 0.02; /* n.s below which nothing is compared */

hl_status hl_viewing_along(hl_ctx *ctx, const double *view, bool camera_frame, hl_viewing *out)
{
  const double front[3] = {0, 0, camera_frame ? -1 : 1};
  const double below[3] = {0, camera_frame ? 1 : -1, 0};
  const double *towards = view ? view : front;
  hl_viewing v;
  hl_unit(towards, v.view);
  if (!(hl_norm(v.view) > 0.5))
    return hl_fail(ctx, HL_ERR_ARG, "view (%g, %g, %g); a direction is needed", towards[0],
                   towards[1], towards[2]);
  const double along = hl_dot(below, v.view);
  hl_add_scaled(below, -along, v.view, v.down);
  if (!(hl_norm(v.down) > 1e-6))
    hl_add_scaled(front, -hl_dot(front, v.view), v.view, v.down);
  hl_unit(v.down, v.down);
  hl_cross(v.view, v.down, v.right); /* down x (-view) */
  *out = v;
  return HL_OK;
}

static hl_status image_new(hl_ctx *ctx, int width, int height, hl_frame *out)
{
  const size_t samples = (size_t)width * (size_t)height * CHANNELS;
  hl_frame f = {.width = width, .height = height, .channels = CHANNELS, .bits = 32};
  f.radiance = calloc(samples, sizeof *f.radiance);
  f.state = calloc(samples, sizeof *f.state);
  if (!f.radiance || !f.state) {
    hl_frame_free(&f);
    hl_fail(ctx, HL_ERR_MEMORY, "no memory for an image of %d x %d pixels", width, height);
    return HL_ERR_MEMORY;
  }
  *out = f;
  return HL_OK;
}

hl_status hl_normals_of_ball(hl_ctx *ctx, int radius_px, const hl_viewing *viewing, hl_frame *out)
{
  if (radius_px < 1 || radius_px > RADIUS_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "radius %d px is outside [1, %d]", radius_px, RADIUS_MAX);
  const int side = 2 * radius_px;
  hl_frame f = {0};
  const hl_status st = image_new(ctx, side, side, &f);
  if (st != HL_OK)
    return st;
  for (int row = 0; row < side; row++)
    for (int column = 0; column < side; column++) {
      const double x = (column + 0.5) / radius_px - 1, y = (row + 0.5) / radius_px - 1;
      const double under = 1 - x * x - y * y;
      float *n = f.radiance + CHANNELS * ((size_t)row * (size_t)side + (size_t)column);
      for (int i = 0; under > 0 && i < 3; i++)
        n[i] =
            (float)(x * viewing->right[i] + y * viewing->down[i] + sqrt(under) * viewing->view[i]);
    }
  *out = f;
  return HL_OK;
}

hl_status hl_relight(hl_ctx *ctx, const hl_reflectance *reflectance, const hl_surface *surface,
                     const double light[3], hl_frame *out)
{
  double s[3];
  hl_frame f = {0};
  hl_unit(light, s);
  if (!(hl_norm(s) > 0.5))
    return hl_fail(ctx, HL_ERR_ARG, "light (%g, %g, %g); a direction is needed", light[0], light[1],
                   light[2]);
  const hl_status st = image_new(ctx, surface->width, surface->height, &f);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < surface->n; i++) {
    double radiance[HL_CHANNELS_MAX];
    hl_reflectance_at(reflectance, surface->normal + 3 * (size_t)i, s,
                      surface->view + 3 * (size_t)i, radiance);
    for (int c = 0; c < CHANNELS; c++)
      f.radiance[CHANNELS * (size_t)surface->pixel[i] + (size_t)c] = (float)radiance[c];
  }
  *out = f;
  return HL_OK;
}

/* The photo's sample beside the relit channel c; false where it says nothing. */
static bool photo_at(const hl_frame *photo, size_t pixel, int c, double *value)
{
  const size_t at = pixel * (size_t)photo->channels + (size_t)(photo->channels == 1 ? 0 : c);
  *value = (double)photo->radiance[at];
  return photo->state[at] == HL_SAMPLE_OK;
}

typedef struct compared {
  double cross, square; /* sums of relit x photo, photo^2 */
  double difference, squares, photo;
  long samples;
} compared;

/* One pass over the pixels that can be compared, the photo multiplied by `scale`. */
static compared compare(const hl_frame *relit, const hl_surface *surface, const double s[3],
                        const hl_frame *photo, double scale, hl_frame *difference)
{
  compared sum = {0};
  for (int i = 0; i < surface->n; i++) {
    const size_t pixel = (size_t)surface->pixel[i];
    if (!(hl_dot(surface->normal + 3 * (size_t)i, s) > least_lit))
      continue;
    for (int c = 0; c < CHANNELS; c++) {
      double y;
      if (!photo_at(photo, pixel, c, &y))
        continue;
      const double x = (double)relit->radiance[CHANNELS * pixel + (size_t)c];
      const double d = fabs(x - scale * y);
      sum.cross += x * y;
      sum.square += y * y;
      sum.difference += d;
      sum.squares += d * d;
      sum.photo += scale * y;
      sum.samples++;
      if (difference)
        difference->radiance[CHANNELS * pixel + (size_t)c] = (float)d;
    }
  }
  return sum;
}

hl_status hl_relit_compare(hl_ctx *ctx, const hl_frame *relit, const hl_surface *surface,
                           const double light[3], const hl_frame *photo, bool fit_scale,
                           hl_relit_error *out, hl_frame *difference)
{
  double s[3];
  hl_unit(light, s);
  if (photo->width != relit->width || photo->height != relit->height)
    return hl_fail(ctx, HL_ERR_FORMAT, "it is %d x %d px; the %d x %d of what is drawn are needed",
                   photo->width, photo->height, relit->width, relit->height);
  hl_relit_error e = {.scale = 1};
  if (fit_scale) {
    const compared sum = compare(relit, surface, s, photo, 1, NULL);
    e.scale = sum.square > 0 ? sum.cross / sum.square : 1;
  }
  hl_frame picture = {0};
  if (difference) {
    const hl_status st = image_new(ctx, relit->width, relit->height, &picture);
    if (st != HL_OK)
      return st;
  }
  const compared sum = compare(relit, surface, s, photo, e.scale, difference ? &picture : NULL);
  if (!(sum.photo > 0)) {
    hl_frame_free(&picture);
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "no pixel to compare: lit by the light, neither clipped nor unusable, and not "
                   "all black is needed");
  }
  e.relative_error = sum.difference / sum.photo;
  e.rms = sqrt(sum.squares / (double)sum.samples);
  e.n_pixels = (int)(sum.samples / CHANNELS);
  *out = e;
  if (difference)
    *difference = picture;
  return HL_OK;
}
