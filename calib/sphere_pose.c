/*
 * A ball's pose from rays that graze it.
 *
 * A ray u grazes a ball about c when its angle to c/|c| is the half-angle t with sin t = R/|c|.
 * With w = c / (|c| cos t) that reads u.w = 1: linear, closed form, any lens. The residual that
 * matters is the angle phi(u) - t; it is refined in three steps (two turns of the axis, one
 * opening of the cone) with d phi / d turn = -(cos a, sin a) at azimuth a and d / d open = -1.
 * Readings carry their own sigma; scatter beyond it (excess) is estimated and added, so that a
 * few very sure but slightly wrong readings cannot outvote the rest. Covariance: the sandwich
 * H^-1 (sum g g') H^-1, which holds where the stated sigmas do not.
 */
#include "sphere_pose.h"

#include <stdlib.h>
#include <string.h>

#include "halflight/vec3.h"

static const double tukey = 4.685; /* 95 % efficient for a normal distribution */

bool hl_solve3(const double a[3][3], const double b[3], double x[3])
{
  double l[3][3] = {{0}};
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j <= i; j++) {
      double sum = a[i][j];
      for (int k = 0; k < j; k++)
        sum -= l[i][k] * l[j][k];
      if (i != j) {
        l[i][j] = sum / l[j][j];
        continue;
      }
      if (!(sum > 1e-12 * a[i][i]) || !(a[i][i] > 0))
        return false;
      l[i][i] = sqrt(sum);
    }
  }
  double y[3];
  for (int i = 0; i < 3; i++) {
    y[i] = b[i];
    for (int k = 0; k < i; k++)
      y[i] -= l[i][k] * y[k];
    y[i] /= l[i][i];
  }
  for (int i = 2; i >= 0; i--) {
    x[i] = y[i];
    for (int k = i + 1; k < 3; k++)
      x[i] -= l[k][i] * x[k];
    x[i] /= l[i][i];
  }
  return true;
}

static bool invert3(const double a[3][3], double out[3][3])
{
  for (int j = 0; j < 3; j++) {
    const double unit[3] = {j == 0, j == 1, j == 2};
    double column[3];
    if (!hl_solve3(a, unit, column))
      return false;
    for (int i = 0; i < 3; i++)
      out[i][j] = column[i];
  }
  return true;
}

static void set_axis(hl_cone *cone, const double axis[3])
{
  hl_unit(axis, cone->axis);
  hl_tangent_basis(cone->axis, cone->e1, cone->e2);
}

hl_cone hl_cone_step(const hl_cone *cone, const double step[3])
{
  hl_cone next = *cone;
  double axis[3];
  hl_add_scaled(cone->axis, tan(step[0]), cone->e1, axis);
  hl_add_scaled(axis, tan(step[1]), cone->e2, axis);
  set_axis(&next, axis);
  next.half_angle_rad += step[2];
  return next;
}

bool hl_cone_from_rays(const double *rays, int n, const double *weights, hl_cone *out)
{
  double mean[3] = {0};
  for (int i = 0; i < n; i++)
    hl_add_scaled(mean, weights ? weights[i] : 1, rays + 3 * i, mean);
  hl_cone about;
  set_axis(&about, mean);

  /* In the frame of the mean ray and scaled by the spread, the three columns are alike in size;
   * u.m is 1 less a small number, which is kept apart so as not to drown. */
  double spread = 0, total = 0;
  for (int i = 0; i < n; i++) {
    const double *u = rays + 3 * i;
    const double x = hl_dot(u, about.e1), y = hl_dot(u, about.e2);
    const double w = weights ? weights[i] : 1;
    spread += w * (x * x + y * y);
    total += w;
  }
  spread = sqrt(spread / total);
  if (!(spread > 1e-9))
    return false;
  double a[3][3] = {{0}}, b[3] = {0};
  for (int i = 0; i < n; i++) {
    const double *u = rays + 3 * i;
    const double w = weights ? weights[i] : 1;
    const double x = hl_dot(u, about.e1), y = hl_dot(u, about.e2);
    const double z = hl_dot(u, about.axis);
    const double row[3] = {x / spread, y / spread, z};
    const double less = (x * x + y * y) / ((1 + z) * spread * spread); /* (1 - z) / spread^2 */
    for (int j = 0; j < 3; j++) {
      for (int k = 0; k < 3; k++)
        a[j][k] += w * row[j] * row[k];
      b[j] += w * row[j] * less;
    }
  }
  double v[3];
  if (!hl_solve3(a, b, v))
    return false;
  double w[3];
  for (int i = 0; i < 3; i++)
    w[i] = v[0] * spread * about.e1[i] + v[1] * spread * about.e2[i] +
           (1 + spread * spread * v[2]) * about.axis[i];
  const double excess = spread * spread * (2 * v[2] + v[0] * v[0] + v[1] * v[1]) +
                        spread * spread * spread * spread * v[2] * v[2]; /* |w|^2 - 1 */
  if (!(excess > 0))
    return false;
  set_axis(out, w);
  out->half_angle_rad = atan(sqrt(excess));
  return isfinite(out->half_angle_rad);
}

static double misfit(const hl_cone_offset *r, const double step[3])
{
  return r->offset_rad - hl_dot(step, r->row);
}

/* Scatter beyond the stated sigmas: the least tau with half of what the readings know within
 * 0.6745 of its total sigma. By bisection, so that no array is needed. */
static double excess_scatter(const hl_cone_offset *r, int n, const double step[3], double limit)
{
  double low = 0, high = limit, total = 0;
  for (int i = 0; i < n; i++)
    total += 1 / (r[i].sigma_rad * r[i].sigma_rad);
  for (int it = 0; it < 40; it++) {
    const double tau = it == 0 ? 0 : 0.5 * (low + high);
    double within = 0;
    for (int i = 0; i < n; i++)
      if (fabs(misfit(&r[i], step)) <= 0.6745 * hypot(r[i].sigma_rad, tau))
        within += 1 / (r[i].sigma_rad * r[i].sigma_rad);
    if (!(2 * within >= total))
      low = tau;
    else if (it == 0)
      return 0;
    else
      high = tau;
  }
  return high;
}

static void reweight(hl_cone_offset *r, int n, const double step[3], double excess)
{
  for (int i = 0; i < n; i++) {
    const double z = misfit(&r[i], step) / (tukey * hypot(r[i].sigma_rad, excess));
    r[i].weight = z * z < 1 ? (1 - z * z) * (1 - z * z) : 0;
  }
}

/* Sums over the readings: of w r r', w r offset, and for the covariance of the robust fit the
 * bread sum psi' r r' and the middle sum psi^2 r r', psi = w misfit. */
typedef struct sums {
  double h[3][3], g[3], bread[3][3], middle[3][3];
} sums;

static void accumulate(hl_cone_offset *r, int n, const double step[3], double excess, sums *out)
{
  memset(out, 0, sizeof *out);
  for (int i = 0; i < n; i++) {
    const double *row = r[i].row;
    const double v = 1 / (r[i].sigma_rad * r[i].sigma_rad + excess * excess);
    const double w = r[i].weight * v, e = w * misfit(&r[i], step);
    const double root = sqrt(r[i].weight); /* 1 - z^2 */
    const double slope = v * root * (5 * root - 4);
    r[i].slope = slope;
    for (int j = 0; j < 3; j++) {
      out->g[j] += w * row[j] * r[i].offset_rad;
      for (int k = 0; k < 3; k++) {
        out->h[j][k] += w * row[j] * row[k];
        out->bread[j][k] += slope * row[j] * row[k];
        out->middle[j][k] += e * e * row[j] * row[k];
      }
    }
  }
}

static void sandwich(const double inverse[3][3], const double middle[3][3], double factor,
                     double out[3][3])
{
  double t[3][3] = {{0}};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      for (int k = 0; k < 3; k++)
        t[i][j] += inverse[i][k] * middle[k][j];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      out[i][j] = 0;
      for (int k = 0; k < 3; k++)
        out[i][j] += factor * t[i][k] * inverse[j][k];
    }
}

bool hl_cone_fit_offsets(hl_cone_offset *r, int n, double limit_rad, hl_cone_fit *out)
{
  sums sum;
  double step[3] = {0}, excess = 0.1 * limit_rad;
  for (int i = 0; i < n; i++) {
    r[i].row[0] = cos(r[i].azimuth_rad);
    r[i].row[1] = sin(r[i].azimuth_rad);
    r[i].row[2] = 1;
    r[i].weight = 1;
  }
  for (int it = 0; it < 30; it++) {
    accumulate(r, n, step, excess, &sum);
    double next[3];
    if (!hl_solve3((const double(*)[3])sum.h, sum.g, next))
      return false;
    double moved = 0;
    for (int j = 0; j < 3; j++)
      moved = fmax(moved, fabs(next[j] - step[j]));
    memcpy(step, next, sizeof step);
    excess = excess_scatter(r, n, step, limit_rad);
    reweight(r, n, step, excess);
    if (it > 2 && moved < 1e-6 * limit_rad)
      break;
  }
  accumulate(r, n, step, excess, &sum);
  double inverse[3][3], bread[3][3], squares = 0, total = 0;
  if (!invert3((const double(*)[3])sum.h, inverse))
    return false;
  /* where too many readings lie on the far flank the plain weights must do */
  if (!invert3((const double(*)[3])sum.bread, bread)) {
    memcpy(bread, inverse, sizeof bread);
    for (int i = 0; i < n; i++)
      r[i].slope = r[i].weight / (r[i].sigma_rad * r[i].sigma_rad + excess * excess);
  }
  int kept = 0;
  for (int i = 0; i < n; i++) {
    kept += r[i].weight > 0;
    total += r[i].weight;
    squares += r[i].weight * misfit(&r[i], step) * misfit(&r[i], step);
  }
  if (kept < 3)
    return false;
  memcpy(out->step, step, sizeof step);
  memcpy(out->inverse, inverse, sizeof inverse);
  memcpy(out->bread, bread, sizeof bread);
  /* three numbers were fitted to the readings whose scatter is now taken, which also hides the
   * readings that pulled most: once for each (as in HC3) */
  const double fitted = kept > 3 ? (double)kept / (kept - 3) : 1;
  sandwich((const double(*)[3])bread, (const double(*)[3])sum.middle, fitted * fitted,
           out->covariance);
  out->excess_rad = excess;
  out->rms_rad = sqrt(squares / total);
  out->n_kept = kept;
  return true;
}

void hl_cone_center_by_step(const hl_cone *cone, double radius_m, double out[3][3])
{
  const double t = cone->half_angle_rad, distance = radius_m / sin(t);
  for (int i = 0; i < 3; i++) {
    out[i][0] = distance * cone->e1[i];
    out[i][1] = distance * cone->e2[i];
    out[i][2] = -distance / tan(t) * cone->axis[i];
  }
}

void hl_cone_to_sphere(const hl_cone *cone, const double covariance[3][3], double radius_m,
                       hl_sphere *out)
{
  const double distance = radius_m / sin(cone->half_angle_rad);
  memset(out, 0, sizeof *out);
  for (int i = 0; i < 3; i++)
    out->center_m[i] = distance * cone->axis[i];
  out->radius_m = radius_m;
  out->has_covariance = true;
  double d[3][3];
  hl_cone_center_by_step(cone, radius_m, d);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      double sum = 0;
      for (int k = 0; k < 3; k++)
        for (int l = 0; l < 3; l++)
          sum += d[i][k] * covariance[k][l] * d[j][l];
      out->covariance_m2[i][j] = sum;
    }
}

static hl_status check_rays(hl_ctx *ctx, const double *rays, int n, double radius_m,
                            double sigma_rad)
{
  if (!rays || !(n >= 3 && n <= 1 << 24))
    return hl_fail(ctx, HL_ERR_ARG, "rays of the outline: n = %d, at least 3 are needed", n);
  if (!(radius_m > 0) || !isfinite(radius_m))
    return hl_fail(ctx, HL_ERR_ARG, "radius_m = %.6g, a finite number > 0 is needed", radius_m);
  if (!(sigma_rad >= 0) || !isfinite(sigma_rad))
    return hl_fail(ctx, HL_ERR_ARG, "sigma_rad = %.6g, a finite number >= 0 is needed", sigma_rad);
  for (int i = 0; i < n; i++) {
    const double length = hl_norm(rays + 3 * i);
    if (!(fabs(length - 1) < 1e-6))
      return hl_fail(ctx, HL_ERR_ARG, "ray %d has length %.9g, unit rays are needed", i, length);
  }
  return HL_OK;
}

/* Turns each ray into its reading of the present cone. */
static void read_rays(const double *rays, int n, const hl_cone *cone, hl_cone_offset *out)
{
  for (int i = 0; i < n; i++) {
    const double *u = rays + 3 * i;
    out[i].azimuth_rad = atan2(hl_dot(u, cone->e2), hl_dot(u, cone->e1));
    out[i].offset_rad = hl_angle(u, cone->axis) - cone->half_angle_rad;
  }
}

static bool refine(const double *rays, int n, double sigma_rad, hl_cone *cone,
                   hl_cone_offset *readings, hl_cone_fit *fit)
{
  /* rays exact to rounding still need a width to divide by */
  for (int i = 0; i < n; i++)
    readings[i].sigma_rad = fmax(sigma_rad, 1e-12);
  for (int it = 0; it < 20; it++) {
    read_rays(rays, n, cone, readings);
    if (!hl_cone_fit_offsets(readings, n, cone->half_angle_rad, fit))
      return false;
    const double moved = hl_norm(fit->step);
    if (!(moved < cone->half_angle_rad))
      return false;
    *cone = hl_cone_step(cone, fit->step);
    if (moved < 1e-14)
      break;
  }
  return cone->half_angle_rad > 0 && cone->half_angle_rad < 1.5;
}

hl_status hl_sphere_from_rays(hl_ctx *ctx, const double *rays, int n, double radius_m,
                              double sigma_rad, hl_sphere *out, double *rms_rad)
{
  const hl_status st = check_rays(ctx, rays, n, radius_m, sigma_rad);
  if (st != HL_OK)
    return st;
  hl_cone cone;
  hl_cone_fit fit;
  hl_cone_offset *readings = malloc((size_t)n * sizeof *readings);
  if (!readings)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d outline rays", n);
  const bool found =
      hl_cone_from_rays(rays, n, NULL, &cone) && refine(rays, n, sigma_rad, &cone, readings, &fit);
  free(readings);
  if (!found)
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "%d outline rays do not span a cone; rays spread about the outline are needed",
                   n);
  hl_sphere sphere;
  const bool stated = sigma_rad > 0 && !(fit.excess_rad > 0);
  hl_cone_to_sphere(&cone, stated ? fit.inverse : fit.covariance, radius_m, &sphere);
  sphere.has_covariance = sigma_rad > 0 || n > 5;
  *out = sphere;
  if (rms_rad)
    *rms_rad = fit.rms_rad;
  return HL_OK;
}
