/*
 * Rings: directions at a few angles a_k from one axis u, and where a light is on the axis, the pole.
 *
 * Three lights of one ring give its axis: the normal of their plane. Axes from all triples of a thinned
 * list are tried; for each the angles of the lights are sorted and, for a few widths, the window that
 * holds most of them is taken as a ring, then of the rest. The best by evidence are refined by
 * Gauss-Newton on axis and angles, lights and deviation taken anew at each step. With t the unit tangent
 * at u towards x, r = angle(u, x) - a_k has
 *
 *   dr = -t.du - da_k,      at the pole, two coordinates: dr = -du
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dome_work.h"
#include "halflight/vec3.h"

static const double pi = 3.14159265358979323846;
static const double apart = 10; /* deviations between rings, at least */

enum { TRIPLES_OF = 18, KEPT = 6, STEPS = 30, RING_LIGHTS_MIN = 3, WIDTHS = 4 };

/* Nearest ring, -1 for the pole. */
static int nearest_ring(const hl_dome_fit *fit, double angle, double *off)
{
  int at = -1;
  *off = fit->pole ? angle : HUGE_VAL;
  for (int k = 0; k < fit->n_rings; k++)
    if (fabs(angle - fit->half_angle_rad[k]) < *off) {
      *off = fabs(angle - fit->half_angle_rad[k]);
      at = k;
    }
  return at;
}

double hl_dome_rings_nearest(const hl_dome_fit *fit, const double x[3], double *log_peak)
{
  double off;
  const int k = nearest_ring(fit, hl_angle(fit->axis, x), &off);
  const double s = fit->sigma;
  const double round = k < 0 ? 1 : 2 * pi * fmax(sin(fit->half_angle_rad[k]), s);
  const double across = k < 0 ? 2 * pi * s * s : sqrt(2 * pi) * s;
  *log_peak = -log(round * across * (fit->n_rings + fit->pole));
  return off;
}

/* ---- rings about a given axis */

static int by_value(const void *a, const void *b)
{
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Takes the fullest window out of n sorted angles; its mean, and how many it held. */
static int take_window(double *angle, int *n, double width, double *mean)
{
  int best = 0, from = 0;
  for (int i = 0, j = 0; i < *n; i++) {
    while (j < *n && angle[j] - angle[i] <= width)
      j++;
    if (j - i > best) {
      best = j - i;
      from = i;
    }
  }
  *mean = 0;
  for (int i = from; i < from + best; i++)
    *mean += angle[i] / best;
  memmove(angle + from, angle + from + best, (size_t)(*n - from - best) * sizeof *angle);
  *n -= best;
  return best;
}

/* Whether fit's last ring is well apart from the others: less than that and they are one, cut up. */
static bool stands_apart(const hl_dome_fit *fit, int last)
{
  for (int k = 0; k < last; k++)
    if (fabs(fit->half_angle_rad[k] - fit->half_angle_rad[last]) < apart * fit->sigma)
      return false;
  return true;
}

/* Rings about fit->axis for fit->sigma, out of sorted angles; how many of them, and with them the
 * evidence, is chosen by what it is about. False without one. */
static bool rings_about(const hl_dome_data *data, hl_dome_fit *fit, const double *sorted)
{
  const double across = log(sqrt(2 * pi) * fit->sigma) + 0.5;
  double *left = data->room + (size_t)2 * (size_t)data->n;
  double sum = 0, most = -HUGE_VAL;
  int n = data->n_scored, kept = 0;
  memcpy(left, sorted, (size_t)n * sizeof *left);
  fit->pole = sorted[0] <= hl_dome_cut(1) * fit->sigma;
  for (int k = 0; k < HL_DOME_RINGS_MAX && n >= RING_LIGHTS_MIN; k++) {
    const int held = take_window(left, &n, 5 * fit->sigma, &fit->half_angle_rad[k]);
    if (held < RING_LIGHTS_MIN || !stands_apart(fit, k))
      break;
    const int on = data->n_scored - n;
    sum -= held * (log(2 * pi * fmax(sin(fit->half_angle_rad[k]), fit->sigma)) + across);
    const double about = sum - on * (log(k + 1.0) + data->log_plain[data->scored[0]]) +
                         n * log((n + 1.0) / (data->n_scored + 2.0)) -
                         0.5 * k * log(data->n_scored);
    if (about > most) {
      most = about;
      kept = k + 1;
    }
  }
  fit->n_rings = kept;
  if (kept > 0)
    fit->evidence = hl_dome_evidence(data, fit, false);
  return kept > 0;
}

/* ---- refinement */

static void gather(const hl_dome_data *data, const hl_dome_fit *fit, const double e[2][3],
                   hl_dome_system *s, int *of_ring)
{
  const int p = 2 + fit->n_rings;
  memset(s, 0, sizeof *s);
  for (int i = 0; i < data->n; i++) {
    const double *x = data->x + 3 * i;
    const double angle = hl_angle(fit->axis, x);
    double off, row[HL_DOME_SIDES_MAX] = {0};
    const int k = nearest_ring(fit, angle, &off);
    if (off > hl_dome_cut(1) * fit->sigma)
      continue;
    const double to[2] = {hl_dot(e[0], x), hl_dot(e[1], x)};
    if (k < 0) {
      const double rows[2][2] = {{-1, 0}, {0, -1}};
      hl_dome_add_row(s, rows[0], to[0], 2);
      hl_dome_add_row(s, rows[1], to[1], 2);
      continue;
    }
    const double sine = fmax(hypot(to[0], to[1]), DBL_MIN);
    row[0] = -to[0] / sine;
    row[1] = -to[1] / sine;
    row[2 + k] = -1;
    hl_dome_add_row(s, row, angle - fit->half_angle_rad[k], p);
    of_ring[k]++;
  }
}

/* Rings that hold too few lights go. */
static void drop_thin(hl_dome_fit *fit, const int *of_ring)
{
  int n = 0;
  for (int k = 0; k < fit->n_rings; k++)
    if (of_ring[k] >= RING_LIGHTS_MIN)
      fit->half_angle_rad[n++] = fit->half_angle_rad[k];
  fit->n_rings = n;
}

static bool refine(const hl_dome_data *data, hl_dome_fit *fit)
{
  for (int step = 0; step < STEPS; step++) {
    double e[2][3];
    int of_ring[HL_DOME_RINGS_MAX] = {0};
    hl_dome_system s;
    hl_tangent_basis(fit->axis, e[0], e[1]);
    gather(data, fit, (const double(*)[3])e, &s, of_ring);
    const int rings = fit->n_rings;
    drop_thin(fit, of_ring);
    if (fit->n_rings == 0)
      return false;
    if (fit->n_rings < rings)
      continue;
    const int p = 2 + rings;
    hl_dome_solve(&s, p);
    const double most = 0.2 / fmax(0.2, hypot(s.b[0], s.b[1])); /* a step of the axis, at most */
    for (int k = 0; k < 2; k++)
      hl_add_scaled(fit->axis, most * s.b[k], e[k], fit->axis);
    hl_unit(fit->axis, fit->axis);
    for (int k = 0; k < rings; k++)
      fit->half_angle_rad[k] += most * s.b[2 + k];
    fit->sigma = hl_dome_sigma(data, s.squares, s.coordinates, p);
  }
  for (int k = 1; k < fit->n_rings; k++)
    if (!stands_apart(fit, k))
      return false;
  return true;
}

/* ---- search */

static void keep(hl_dome_fit *kept, int *n, const hl_dome_fit *fit)
{
  int at = *n < KEPT ? (*n)++ : KEPT;
  for (; at > 0 && kept[at - 1].evidence < fit->evidence; at--)
    if (at < KEPT)
      kept[at] = kept[at - 1];
  if (at < KEPT)
    kept[at] = *fit;
}

static void try_axis(const hl_dome_data *data, const double *const x[3], hl_dome_fit *kept, int *n)
{
  static const double widths_rad[WIDTHS] = {0.002, 0.007, 0.02, 0.06};
  double a[3], b[3], mean[3];
  hl_dome_fit fit = {.shape = HL_DOME_RINGS};
  hl_add_scaled(x[1], -1, x[0], a);
  hl_add_scaled(x[2], -1, x[0], b);
  hl_cross(a, b, fit.axis);
  if (!(hl_norm(fit.axis) > 1e-6))
    return;
  hl_unit(fit.axis, fit.axis);
  for (int k = 0; k < 3; k++)
    mean[k] = x[0][k] + x[1][k] + x[2][k];
  if (hl_dot(fit.axis, mean) < 0)
    hl_add_scaled((const double[3]){0}, -1, fit.axis, fit.axis);
  double *sorted = data->room + data->n;
  for (int i = 0; i < data->n_scored; i++)
    sorted[i] = hl_angle(fit.axis, data->x + 3 * data->scored[i]);
  qsort(sorted, (size_t)data->n_scored, sizeof *sorted, by_value);
  for (int w = 0; w < WIDTHS; w++) {
    fit.sigma = fmax(widths_rad[w], data->sigma);
    if (rings_about(data, &fit, sorted))
      keep(kept, n, &fit);
  }
}

static void order(hl_dome_fit *fit)
{
  qsort(fit->half_angle_rad, (size_t)fit->n_rings, sizeof *fit->half_angle_rad, by_value);
  for (int k = fit->n_rings; k < HL_DOME_RINGS_MAX; k++)
    fit->half_angle_rad[k] = 0;
}

bool hl_dome_fit_rings(const hl_dome_data *data, hl_dome_fit *out)
{
  hl_dome_fit kept[KEPT];
  int n = 0;
  const int m = data->n_scored < TRIPLES_OF ? data->n_scored : TRIPLES_OF;
  for (int i = 0; i < m; i++)
    for (int j = i + 1; j < m; j++)
      for (int k = j + 1; k < m; k++) {
        const double *x[3] = {data->x + 3 * data->scored[i * data->n_scored / m],
                              data->x + 3 * data->scored[j * data->n_scored / m],
                              data->x + 3 * data->scored[k * data->n_scored / m]};
        try_axis(data, (const double *const *)x, kept, &n);
      }
  const bool found = hl_dome_best(data, refine, kept, n, out);
  if (found)
    order(out);
  return found;
}
