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
#include <string.h>

#include "halflight/vec3.h"
#include "lens.h"

enum { SIDE_MIN = 2, SIDE_MAX = 65536, GRID = 16, WAY_POINTS = 12, BRINK_STEPS = 900 };

#define FOCAL_MAX_PX 1e7
#define STRETCH_MAX 3.0
#define RIGHT_ANGLE 1.57079632679489661923

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

/* Smaller and larger stretch of the lens at a direction, compared with the same model without
 * distortion; the smaller is negative beyond a fold or upside down. */
static void stretches(const hl_lens *lens, const double *k, const double at[2], double *smaller,
                      double *larger)
{
  static const double none[HL_DISTORTION_MAX] = {0};
  double out[2], bent[2][2], plain[2][2], j[2][2];
  lens->distort(k, at, out, bent);
  lens->distort(none, at, out, plain);
  const double scale = plain[0][0] * plain[1][1] - plain[0][1] * plain[1][0];
  for (int i = 0; i < 2; i++) {
    j[i][0] = (bent[i][0] * plain[1][1] - bent[i][1] * plain[1][0]) / scale;
    j[i][1] = (bent[i][1] * plain[0][0] - bent[i][0] * plain[0][1]) / scale;
  }
  const double sum = hypot(j[0][0] + j[1][1], j[0][1] - j[1][0]) / 2;
  const double difference = hypot(j[0][0] - j[1][1], j[0][1] + j[1][0]) / 2;
  const double determinant = j[0][0] * j[1][1] - j[0][1] * j[1][0];
  *larger = sum + difference;
  const bool upright = determinant > 0 && j[0][0] + j[1][1] > 0;
  *smaller = upright ? fabs(sum - difference) : -fabs(sum - difference);
}

/* Where the lens's picture ends on the way out to a pixel. */
typedef struct brink {
  double angle_deg, px; /* from the axis, from the centre */
  bool folds;           /* there; else 90 deg are reached */
} brink;

static brink find_brink(const hl_camera *c, double x, double y)
{
  const double u = (x - c->cx) / c->fx, v = (y - c->cy) / c->fy, length = hypot(u, v);
  const hl_lens *lens = hl_lens_of(c->model);
  brink b = {0, 0, false};
  for (int i = 1; i <= BRINK_STEPS && !b.folds; i++) {
    const double tangent = tan(fmin(RIGHT_ANGLE * i / BRINK_STEPS, RIGHT_ANGLE - 1e-6));
    const double at[2] = {tangent * u / length, tangent * v / length};
    double out[2], ignored[2][2], smaller, larger;
    stretches(lens, c->distortion, at, &smaller, &larger);
    lens->distort(c->distortion, at, out, ignored);
    b.folds = !(smaller > 0);
    b.angle_deg = 90.0 * i / BRINK_STEPS;
    b.px = hypot(c->fx * out[0], c->fy * out[1]);
  }
  return b;
}

static hl_status sees_nothing(hl_ctx *ctx, const hl_camera *c, double x, double y)
{
  const brink b = find_brink(c, x, y);
  const double px = hypot(x - c->cx, y - c->cy);
  if (!b.folds && !(b.px < px))
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "distortion = [%.4g, %.4g, ...] is no lens's: pixel (%g, %g) sees no direction; "
                   "every pixel of the frame must",
                   c->distortion[0], c->distortion[1], x, y);
  if (!b.folds)
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "pixel (%g, %g) is %.1f px from the centre, but this %s lens reaches 90 deg at "
                   "%.1f px and sees nothing beyond; a frame cropped to less is accepted, with its "
                   "cx, cy",
                   x, y, px, hl_lens_of(c->model)->name, b.px);
  return hl_fail(ctx, HL_ERR_FORMAT,
                 "distortion = [%.4g, %.4g, ...] folds at %.1f deg, %.1f px from the centre: pixel "
                 "(%g, %g), %.1f px from it, sees no direction; a frame that ends before the fold "
                 "is accepted",
                 c->distortion[0], c->distortion[1], b.angle_deg, b.px, x, y, px);
}

static hl_status check_pixel(hl_ctx *ctx, const hl_camera *c, double x, double y)
{
  const hl_lens *lens = hl_lens_of(c->model);
  const double image[2] = {(x - c->cx) / c->fx, (y - c->cy) / c->fy};
  double end[2];
  if (!hl_lens_undistort(lens, c->distortion, image, end))
    return sees_nothing(ctx, c, x, y);
  const double reach = hypot(end[0], end[1]);
  for (int i = 1; i <= WAY_POINTS; i++) {
    const double t = reach > 0 ? tan(atan(reach) * i / WAY_POINTS) / reach : 0;
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

int hl_camera_intrinsics_count(const hl_camera *camera)
{
  return 4 + camera->n_distortion;
}

void hl_camera_intrinsics(const hl_camera *camera, double out[HL_INTRINSICS_MAX])
{
  const double axes[4] = {camera->fx, camera->fy, camera->cx, camera->cy};
  memcpy(out, axes, sizeof axes);
  memcpy(out + 4, camera->distortion, (size_t)camera->n_distortion * sizeof *out);
}

void hl_camera_set_intrinsics(hl_camera *camera, const double in[HL_INTRINSICS_MAX])
{
  camera->fx = in[0];
  camera->fy = in[1];
  camera->cx = in[2];
  camera->cy = in[3];
  memcpy(camera->distortion, in + 4, (size_t)camera->n_distortion * sizeof *in);
}

hl_status hl_camera_project_derivatives(hl_ctx *ctx, const hl_camera *camera, const double point[3],
                                        double pixel[2], double by_point[2][3],
                                        double by_intrinsics[2][HL_INTRINSICS_MAX])
{
  const hl_status st = hl_camera_project(ctx, camera, point, pixel);
  if (st != HL_OK)
    return st;
  const hl_lens *lens = hl_lens_of(camera->model);
  const double at[2] = {point[0] / point[2], point[1] / point[2]};
  const double focal[2] = {camera->fx, camera->fy};
  double image[2], j[2][2], by[2][HL_DISTORTION_MAX];
  lens->distort(camera->distortion, at, image, j);
  lens->by_coefficients(camera->distortion, at, by);
  for (int i = 0; i < 2; i++) {
    if (by_point) {
      by_point[i][0] = focal[i] * j[i][0] / point[2];
      by_point[i][1] = focal[i] * j[i][1] / point[2];
      by_point[i][2] = -(by_point[i][0] * at[0] + by_point[i][1] * at[1]);
    }
    if (by_intrinsics) {
      for (int k = 0; k < 2; k++) {
        by_intrinsics[i][k] = k == i ? image[i] : 0;
        by_intrinsics[i][2 + k] = k == i;
      }
      for (int k = 0; k < lens->n_coefficients; k++)
        by_intrinsics[i][4 + k] = focal[i] * by[i][k];
    }
  }
  return HL_OK;
}

/* With A = d(pixel)/d(direction (a, b, 1)): d(a, b) = A^-1 (d pixel - d(pixel)/d(theta) d theta),
 * and the unit ray follows by projection onto its tangent plane. */
hl_status hl_camera_unproject_derivatives(hl_ctx *ctx, const hl_camera *camera, double x, double y,
                                          double ray[3], double by_pixel[3][2],
                                          double by_intrinsics[3][HL_INTRINSICS_MAX])
{
  double u[3] = {0}, pixel[2], a[2][3], by[2][HL_INTRINSICS_MAX];
  hl_status st = hl_camera_unproject(ctx, camera, x, y, u);
  if (st != HL_OK)
    return st;
  const double direction[3] = {u[0] / u[2], u[1] / u[2], 1};
  st = hl_camera_project_derivatives(ctx, camera, direction, pixel, a, by);
  if (st != HL_OK)
    return st;
  memcpy(ray, u, sizeof u);
  const double determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
  const double inverse[2][2] = {{a[1][1] / determinant, -a[0][1] / determinant},
                                {-a[1][0] / determinant, a[0][0] / determinant}};
  double turn[3][2]; /* d(ray)/d(pixel) */
  for (int k = 0; k < 2; k++) {
    const double d[3] = {inverse[0][k], inverse[1][k], 0};
    const double along = hl_dot(d, ray);
    for (int i = 0; i < 3; i++)
      turn[i][k] = ray[2] * (d[i] - along * ray[i]);
  }
  for (int i = 0; i < 3; i++) {
    for (int k = 0; by_pixel && k < 2; k++)
      by_pixel[i][k] = turn[i][k];
    for (int k = 0; by_intrinsics && k < hl_camera_intrinsics_count(camera); k++)
      by_intrinsics[i][k] = -(turn[i][0] * by[0][k] + turn[i][1] * by[1][k]);
  }
  return HL_OK;
}
