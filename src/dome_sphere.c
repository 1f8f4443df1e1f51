/*
 * Positions on a sphere, or on one circle in space.
 *
 * A sphere through four of them, 2 (x_i - x_0).c = |x_i|^2 - |x_0|^2, a circle through three; all fours
 * and threes of a thinned list are tried, the best by evidence is refined by Gauss-Newton, lights and
 * deviation taken anew at each step. Residuals: of the sphere |x - c| - R; of the circle, with n its
 * axis and t the unit vector from the axis to x, n.(x - c) and t.(x - c) - R.
 */
#include <math.h>
#include <string.h>

#include "dome_work.h"
#include "halflight/vec3.h"

static const double pi = 3.14159265358979323846;

enum { TRIED_OF = 16, STEPS = 30 };

double hl_dome_sphere_nearest(const hl_dome_fit *fit, const double x[3], double *log_peak)
{
  double d[3];
  hl_add_scaled(x, -1, fit->center_m, d);
  *log_peak = -log(4 * pi * fit->radius_m * fit->radius_m * sqrt(2 * pi) * fit->sigma);
  return fabs(hl_norm(d) - fit->radius_m);
}

/* Height over the circle's plane and distance beyond its radius; t as above. */
static void circle_coordinates(const hl_dome_fit *fit, const double x[3], double r[2], double t[3])
{
  double d[3];
  hl_add_scaled(x, -1, fit->center_m, d);
  r[0] = hl_dot(fit->axis, d);
  hl_add_scaled(d, -r[0], fit->axis, t);
  r[1] = hl_norm(t) - fit->radius_m;
  hl_unit(t, t);
}

double hl_dome_circle_nearest(const hl_dome_fit *fit, const double x[3], double *log_peak)
{
  double r[2], t[3];
  circle_coordinates(fit, x, r, t);
  *log_peak = -log(2 * pi * fit->radius_m * 2 * pi * fit->sigma * fit->sigma);
  return hypot(r[0], r[1]);
}

static bool take(const hl_dome_data *data, hl_dome_fit *fit, hl_dome_fit *best, bool found)
{
  fit->sigma = hl_dome_rough_sigma(data, fit);
  fit->evidence = hl_dome_evidence(data, fit, false);
  if (!isfinite(fit->evidence) || (found && !(fit->evidence > best->evidence)))
    return found;
  *best = *fit;
  return true;
}

/* ---- sphere */

static bool sphere_through(const double *const x[4], hl_dome_fit *out)
{
  double a[3][3], b[3], c[3][3];
  for (int i = 0; i < 3; i++) {
    hl_add_scaled(x[i + 1], -1, x[0], a[i]);
    b[i] = 0.5 * hl_dot(a[i], a[i]);
  }
  for (int i = 0; i < 3; i++)
    hl_cross(a[(i + 1) % 3], a[(i + 2) % 3], c[i]);
  const double volume = hl_dot(a[0], c[0]);
  if (!(fabs(volume) > 1e-6 * hl_norm(a[0]) * hl_norm(a[1]) * hl_norm(a[2])))
    return false;
  double from[3] = {0};
  for (int i = 0; i < 3; i++)
    hl_add_scaled(from, b[i] / volume, c[i], from);
  *out = (hl_dome_fit){.shape = HL_DOME_SPHERE, .radius_m = hl_norm(from)};
  hl_add_scaled(x[0], 1, from, out->center_m);
  return true;
}

static void refine_sphere(const hl_dome_data *data, hl_dome_fit *fit)
{
  for (int step = 0; step < STEPS; step++) {
    hl_dome_system s;
    memset(&s, 0, sizeof s);
    for (int i = 0; i < data->n; i++) {
      double row[4] = {0, 0, 0, -1}, d[3];
      hl_add_scaled(data->x + 3 * i, -1, fit->center_m, d);
      const double r = hl_norm(d) - fit->radius_m;
      if (fabs(r) > hl_dome_cut(1) * fit->sigma)
        continue;
      hl_unit(d, d);
      hl_add_scaled(row, -1, d, row);
      hl_dome_add_row(&s, row, r, 4);
    }
    hl_dome_solve(&s, 4);
    hl_add_scaled(fit->center_m, 1, s.b, fit->center_m);
    fit->radius_m += s.b[3];
    fit->sigma = hl_dome_sigma(data, s.squares, s.coordinates, 4);
  }
}

static const double *tried(const hl_dome_data *data, int i, int m)
{
  return data->x + 3 * data->scored[i * data->n_scored / m];
}

bool hl_dome_fit_sphere(const hl_dome_data *data, hl_dome_fit *out)
{
  const int m = data->n_scored < TRIED_OF ? data->n_scored : TRIED_OF;
  bool found = false;
  for (int i = 0; i < m; i++)
    for (int j = i + 1; j < m; j++)
      for (int k = j + 1; k < m; k++)
        for (int l = k + 1; l < m; l++) {
          const double *const x[4] = {tried(data, i, m), tried(data, j, m), tried(data, k, m),
                                      tried(data, l, m)};
          hl_dome_fit fit;
          if (sphere_through((const double *const *)x, &fit))
            found = take(data, &fit, out, found);
        }
  if (found)
    refine_sphere(data, out);
  return found && out->radius_m > 0;
}

/* ---- circle */

static bool circle_through(const double *const x[3], hl_dome_fit *out)
{
  double a[3], b[3], n[3], p[3], q[3];
  hl_add_scaled(x[1], -1, x[0], a);
  hl_add_scaled(x[2], -1, x[0], b);
  hl_cross(a, b, n);
  const double area2 = hl_dot(n, n);
  if (!(area2 > 1e-8 * hl_dot(a, a) * hl_dot(b, b)))
    return false;
  hl_cross(b, n, p);
  hl_cross(n, a, q);
  double from[3] = {0};
  hl_add_scaled(from, 0.5 * hl_dot(a, a) / area2, p, from);
  hl_add_scaled(from, 0.5 * hl_dot(b, b) / area2, q, from);
  *out = (hl_dome_fit){.shape = HL_DOME_RINGS, .n_rings = 1, .radius_m = hl_norm(from)};
  hl_add_scaled(x[0], 1, from, out->center_m);
  hl_unit(n, out->axis);
  return true;
}

static void refine_circle(const hl_dome_data *data, hl_dome_fit *fit)
{
  for (int step = 0; step < STEPS; step++) {
    double e[2][3], t[3], r[2];
    hl_dome_system s;
    memset(&s, 0, sizeof s);
    hl_tangent_basis(fit->axis, e[0], e[1]);
    for (int i = 0; i < data->n; i++) {
      const double *x = data->x + 3 * i;
      circle_coordinates(fit, x, r, t);
      if (hypot(r[0], r[1]) > hl_dome_cut(2) * fit->sigma)
        continue;
      double up[6] = {0}, out[6] = {0, 0, 0, 0, 0, -1};
      for (int k = 0; k < 3; k++) {
        up[k] = -fit->axis[k];
        out[k] = -t[k];
      }
      for (int k = 0; k < 2; k++) {
        up[3 + k] = (r[1] + fit->radius_m) * hl_dot(t, e[k]);
        out[3 + k] = -r[0] * hl_dot(t, e[k]);
      }
      hl_dome_add_row(&s, up, r[0], 6);
      hl_dome_add_row(&s, out, r[1], 6);
    }
    hl_dome_solve(&s, 6);
    hl_add_scaled(fit->center_m, 1, s.b, fit->center_m);
    for (int k = 0; k < 2; k++)
      hl_add_scaled(fit->axis, s.b[3 + k], e[k], fit->axis);
    hl_unit(fit->axis, fit->axis);
    fit->radius_m += s.b[5];
    fit->sigma = hl_dome_sigma(data, s.squares, s.coordinates, 6);
  }
}

bool hl_dome_fit_circle(const hl_dome_data *data, hl_dome_fit *out)
{
  const int m = data->n_scored < TRIED_OF ? data->n_scored : TRIED_OF;
  bool found = false;
  for (int i = 0; i < m; i++)
    for (int j = i + 1; j < m; j++)
      for (int k = j + 1; k < m; k++) {
        const double *const x[3] = {tried(data, i, m), tried(data, j, m), tried(data, k, m)};
        hl_dome_fit fit;
        if (circle_through((const double *const *)x, &fit))
          found = take(data, &fit, out, found);
      }
  if (found)
    refine_circle(data, out);
  return found && out->radius_m > 0;
}
