/*
 * A calibrated camera: pixels to rays and back.
 *
 *   pixel = (fx u + cx, fy v + cy),   (u, v) = lens(x/z, y/z)
 *
 * A camera is checked where it is used: along the border and on a grid of the frame every pixel's
 * ray must exist, and on the straight way from the optical axis to it the lens must neither fold
 * nor stretch more than any lens does.
 */
#include "halflight/camera.h"

#include <math.h>
#include <stdio.h>

#include "halflight/vec3.h"
#include "lens.h"

enum { SIDE_MIN = 2, SIDE_MAX = 65536, GRID = 16, WAY_POINTS = 12 };

#define FOCAL_MAX_PX 1e7
#define STRETCH_MAX 3.0

static hl_status outside(hl_ctx *ctx, const char *name, double value, const char *unit, double min,
                         double max)
{
  return hl_fail(ctx, HL_ERR_FORMAT, "%s = %.6g%s is outside [%.6g, %.6g]%s", name, value, unit,
                 min, max, unit);
}

/* Written so that NaN is outside. */
static bool is_in(double value, double min, double max)
{
  return value >= min && value <= max;
}

static hl_status check_numbers(hl_ctx *ctx, const hl_camera *c)
{
  const double w = c->width, h = c->height;
  if (!is_in(w, SIDE_MIN, SIDE_MAX))
    return outside(ctx, "width", w, " px", SIDE_MIN, SIDE_MAX);
  if (!is_in(h, SIDE_MIN, SIDE_MAX))
    return outside(ctx, "height", h, " px", SIDE_MIN, SIDE_MAX);
  if (!is_in(c->fx, w / 1000, FOCAL_MAX_PX))
    return outside(ctx, "fx", c->fx, " px", w / 1000, FOCAL_MAX_PX);
  if (!is_in(c->fy, w / 1000, FOCAL_MAX_PX))
    return outside(ctx, "fy", c->fy, " px", w / 1000, FOCAL_MAX_PX);
  if (!is_in(c->cx, -w, 2 * w))
    return outside(ctx, "cx", c->cx, " px", -w, 2 * w);
  if (!is_in(c->cy, -h, 2 * h))
    return outside(ctx, "cy", c->cy, " px", -h, 2 * h);
  const hl_lens *lens = hl_lens_of(c->model);
  if (!lens)
    return hl_fail(ctx, HL_ERR_FORMAT, "model = %d is none of the known lens models",
                   (int)c->model);
  if (c->n_distortion != lens->n_coefficients)
    return hl_fail(ctx, HL_ERR_FORMAT, "distortion has %d coefficients; model %s needs %d",
                   c->n_distortion, lens->name, lens->n_coefficients);
  for (int i = 0; i < c->n_distortion; i++)
    if (!isfinite(c->distortion[i]))
      return hl_fail(ctx, HL_ERR_FORMAT, "distortion[%d] = %g; a finite number is needed", i,
                     c->distortion[i]);
  return HL_OK;
}

/* Smaller and larger stretch of the lens at a direction; the smaller is negative beyond a fold or
 * upside down. */
static void stretches(const hl_lens *lens, const double *k, const double at[2], double *smaller,
                      double *larger)
{
  double out[2], j[2][2];
  lens->distort(k, at, out, j);
  const double sum = hypot(j[0][0] + j[1][1], j[0][1] - j[1][0]) / 2;
  const double difference = hypot(j[0][0] - j[1][1], j[0][1] + j[1][0]) / 2;
  const double determinant = j[0][0] * j[1][1] - j[0][1] * j[1][0];
  *larger = sum + difference;
  const bool upright = determinant > 0 && j[0][0] + j[1][1] > 0;
  *smaller = upright ? fabs(sum - difference) : -fabs(sum - difference);
}

static hl_status check_pixel(hl_ctx *ctx, const hl_camera *c, double x, double y)
{
  const hl_lens *lens = hl_lens_of(c->model);
  const double image[2] = {(x - c->cx) / c->fx, (y - c->cy) / c->fy};
  double end[2];
  if (!hl_lens_undistort(lens, c->distortion, image, end))
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "distortion = [%.4g, %.4g, ...] folds: pixel (%g, %g) sees no direction; every "
                   "pixel of the frame must",
                   c->distortion[0], c->distortion[1], x, y);
  for (int i = 1; i <= WAY_POINTS; i++) {
    const double t = (double)i / WAY_POINTS;
    const double at[2] = {t * end[0], t * end[1]};
    double smaller, larger;
    stretches(lens, c->distortion, at, &smaller, &larger);
    if (!(smaller > 0))
      return hl_fail(ctx, HL_ERR_FORMAT,
                     "distortion = [%.4g, %.4g, ...] folds between the axis and pixel (%g, %g); it "
                     "must not inside the frame",
                     c->distortion[0], c->distortion[1], x, y);
    if (!(larger <= STRETCH_MAX))
      return hl_fail(ctx, HL_ERR_FORMAT,
                     "distortion = [%.4g, %.4g, ...] stretches the image %.3g times near pixel "
                     "(%g, %g); up to %g is accepted",
                     c->distortion[0], c->distortion[1], larger, x, y, STRETCH_MAX);
  }
  return HL_OK;
}

/* Corners of all pixels included, since outlines and areas reach there. The outermost first: that
 * is where a wrong distortion shows most. */
static hl_status check_lens(hl_ctx *ctx, const hl_camera *c)
{
  for (int i = 0; i <= GRID; i++)
    for (int k = 0; k <= GRID; k++) {
      const double x = (double)c->width * i / GRID - 0.5;
      const double y = (double)c->height * k / GRID - 0.5;
      const hl_status st = check_pixel(ctx, c, x, y);
      if (st != HL_OK)
        return st;
    }
  return HL_OK;
}

hl_status hl_camera_check(hl_ctx *ctx, const hl_camera *camera)
{
  const hl_status st = check_numbers(ctx, camera);
  return st == HL_OK ? check_lens(ctx, camera) : st;
}

hl_status hl_camera_unproject(hl_ctx *ctx, const hl_camera *camera, double x, double y,
                              double ray[3])
{
  const hl_lens *lens = hl_lens_of(camera->model);
  const double image[2] = {(x - camera->cx) / camera->fx, (y - camera->cy) / camera->fy};
  double direction[3] = {0, 0, 1};
  if (!lens || !hl_lens_undistort(lens, camera->distortion, image, direction))
    return hl_fail(ctx, HL_ERR_NOT_CONVERGED,
                   "pixel (%.6g, %.6g) sees no direction through this lens", x, y);
  hl_unit(direction, ray);
  return HL_OK;
}

hl_status hl_camera_project(hl_ctx *ctx, const hl_camera *camera, const double point[3],
                            double pixel[2])
{
  const hl_lens *lens = hl_lens_of(camera->model);
  const double at[2] = {point[0] / point[2], point[1] / point[2]};
  if (!lens || !(point[2] > 0) || !isfinite(at[0]) || !isfinite(at[1]))
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "point (%.6g, %.6g, %.6g) is not in front of the camera; z > 0 is needed",
                   point[0], point[1], point[2]);
  double image[2], jacobian[2][2];
  lens->distort(camera->distortion, at, image, jacobian);
  pixel[0] = camera->fx * image[0] + camera->cx;
  pixel[1] = camera->fy * image[1] + camera->cy;
  return HL_OK;
}
