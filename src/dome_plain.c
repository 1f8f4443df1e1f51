/*
 * Lights without order: uniform over the smallest cap about their mean that holds them all (of positions, the
 * smallest ball), or normal about their mean with any covariance, whichever is likelier with its unknowns
 * accounted for. Without the second, lights that merely crowd about a direction would be taken for rings.
 *
 * Directions x are laid out about their mean m by the map of equal areas, y = T x / cos(angle / 2), so
 * that a density of y is one of x.
 */
#include <math.h>
#include <string.h>

#include "cholesky.h"
#include "dome_work.h"
#include "halflight/vec3.h"

static const double pi = 3.14159265358979323846;
static const double least = 1e-7; /* deviation of lights in one place, in units of their extent */

typedef struct layout {
  double mean[3], e[3][3];
  int d; /* dimensions */
} layout;

static layout lay_out(const hl_dome_data *data)
{
  layout l = {.d = data->positions ? 3 : 2, .e = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (int i = 0; i < data->n; i++)
    hl_add_scaled(l.mean, 1.0 / data->n, data->x + 3 * i, l.mean);
  if (!data->positions) {
    if (!(hl_norm(l.mean) > 0))
      l.mean[2] = 1;
    hl_unit(l.mean, l.mean);
    hl_tangent_basis(l.mean, l.e[0], l.e[1]);
  }
  return l;
}

static void place(const layout *l, const double x[3], double y[3])
{
  double d[3];
  hl_add_scaled(x, l->d == 2 ? 0 : -1, l->mean, d);
  const double half = l->d == 2 ? cos(0.5 * hl_angle(x, l->mean)) : 1;
  for (int k = 0; k < l->d; k++)
    y[k] = hl_dot(l->e[k], d) / fmax(half, 1e-6);
}

/* The log density of the normal at each light; their sum. */
static double normal(const hl_dome_data *data, const layout *l, double extent)
{
  const int d = l->d;
  double mean[3] = {0}, cov[9] = {0}, y[3], log_root = 0, sum = 0;
  for (int i = 0; i < data->n; i++) {
    place(l, data->x + 3 * i, y);
    for (int k = 0; k < d; k++)
      mean[k] += y[k] / data->n;
  }
  for (int i = 0; i < data->n; i++) {
    place(l, data->x + 3 * i, y);
    for (int k = 0; k < d; k++)
      for (int j = 0; j < d; j++)
        cov[k * d + j] += (y[k] - mean[k]) * (y[j] - mean[j]) / data->n;
  }
  for (int k = 0; k < d; k++)
    cov[k * d + k] += pow(least * extent, 2);
  hl_cholesky(cov, d, d, 1e-14);
  for (int k = 0; k < d; k++)
    log_root += log(cov[k * d + k]);
  for (int i = 0; i < data->n; i++) {
    place(l, data->x + 3 * i, y);
    double square = 0;
    for (int k = 0; k < d; k++)
      y[k] -= mean[k];
    hl_cholesky_forward(cov, d, d, y);
    for (int k = 0; k < d; k++)
      square += y[k] * y[k];
    data->log_plain[i] = -0.5 * square - log_root - 0.5 * d * log(2 * pi);
    sum += data->log_plain[i];
  }
  return sum;
}

void hl_dome_plain(hl_dome_data *data)
{
  const layout l = lay_out(data);
  const double price = 0.5 * log((double)data->n);
  double farthest = 0;
  for (int i = 0; i < data->n; i++) {
    double y[3] = {0};
    place(&l, data->x + 3 * i, y);
    farthest = fmax(farthest, hl_norm(y));
  }
  const double uniform = l.d == 3 ? -log(4.0 / 3 * pi * pow(farthest, 3))
                                  : -log(fmin(pi * farthest * farthest, 4 * pi));
  const int cap_unknowns = l.d + 1, normal_unknowns = l.d == 3 ? 9 : 5;
  data->plain_unknowns = normal_unknowns;
  if (normal(data, &l, farthest) - price * normal_unknowns >=
      uniform * data->n - price * cap_unknowns)
    return;
  data->plain_unknowns = cap_unknowns;
  for (int i = 0; i < data->n; i++)
    data->log_plain[i] = uniform;
}
