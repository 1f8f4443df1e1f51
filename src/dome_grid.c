/*
 * A plane grid: lights at nodes (i, j) of a lattice, P = P0 + i U + j V; directions see P / |P|, and
 * know P0, U and V up to one common factor.
 *
 * Candidates are cells. Of directions, four lights that see the corners of one cell determine it: with
 * l the distances, l0 d0 - l1 d1 - l2 d2 + l3 d3 = 0, all l > 0. Of positions, a light and two of its
 * neighbours. The best by evidence are refined by Gauss-Newton on P0, U, V, nodes and deviation taken
 * anew at each step; with T tangents at x, the residual of a direction is
 *
 *   r = T P / |P|,   dr = T (I - d d') (dP0 + i dU + j dV) / |P|
 *
 * in which the common factor has no weight, and the pivot that it leaves is raised.
 */
#include <math.h>
#include <string.h>

#include "dome_work.h"
#include "halflight/vec3.h"

static const double pi = 3.14159265358979323846;

enum { NEIGHBOURS = 8, KEPT = 6, STEPS = 30, UNKNOWNS = 9, LIGHTS_MIN = 12, NODES_MAX = 100000 };

/* x = a[0] out[0] + a[1] out[1] + a[2] out[2]; false where the three are in a plane. */
static bool solve_three(const double *const a[3], const double x[3], double out[3])
{
  double c[3][3];
  for (int k = 0; k < 3; k++)
    hl_cross(a[(k + 1) % 3], a[(k + 2) % 3], c[k]);
  const double volume = hl_dot(a[0], c[0]);
  if (!(fabs(volume) > 1e-12 * hl_norm(a[0]) * hl_norm(a[1]) * hl_norm(a[2])))
    return false;
  for (int k = 0; k < 3; k++)
    out[k] = hl_dot(x, c[k]) / volume;
  return true;
}

static void node_at(const hl_dome_fit *fit, int i, int j, double p[3])
{
  hl_add_scaled(fit->corner, i, fit->step[0], p);
  hl_add_scaled(p, j, fit->step[1], p);
}

/* Coordinates of x in the lattice; false where its ray does not meet the plane. */
static bool lattice_coordinates(const hl_dome_fit *fit, bool positions, const double x[3],
                                double at[2])
{
  double y[3], from[3], normal[3];
  hl_cross(fit->step[0], fit->step[1], normal);
  const double *const sides[3] = {fit->step[0], fit->step[1], positions ? normal : fit->corner};
  hl_add_scaled(x, positions ? -1 : 0, fit->corner, from);
  if (!solve_three((const double *const *)sides, from, y) || (!positions && !(y[2] > 0)))
    return false;
  for (int k = 0; k < 2; k++)
    at[k] = positions ? y[k] : y[k] / y[2];
  return fabs(at[0]) < NODES_MAX && fabs(at[1]) < NODES_MAX;
}

double hl_dome_grid_nearest(const hl_dome_fit *fit, bool positions, const double x[3], int node[2],
                            double *log_peak)
{
  double at[2], p[3];
  const double s = fit->sigma * sqrt(2 * pi);
  *log_peak = -log((double)fit->size[0] * fit->size[1]) - (positions ? 3 : 2) * log(s);
  node[0] = node[1] = 0;
  if (!lattice_coordinates(fit, positions, x, at))
    return positions ? HUGE_VAL : pi;
  for (int k = 0; k < 2; k++)
    node[k] = (int)lround(at[k]);
  node_at(fit, node[0], node[1], p);
  if (!positions)
    return hl_angle(p, x);
  hl_add_scaled(x, -1, p, p);
  return hl_norm(p);
}

/* first and size, from the lights within the cut; how many they are. */
static int measure(const hl_dome_data *data, hl_dome_fit *fit, bool all)
{
  const double cut = hl_dome_cut(data->positions ? 3 : 2) * fit->sigma;
  int low[2] = {0, 0}, high[2] = {0, 0}, held = 0;
  fit->size[0] = fit->size[1] = 1;
  for (int i = 0; i < (all ? data->n : data->n_scored); i++) {
    const double *x = data->x + 3 * (all ? i : data->scored[i]);
    int node[2];
    double peak;
    if (!(hl_dome_grid_nearest(fit, data->positions, x, node, &peak) <= cut))
      continue;
    for (int k = 0; k < 2; k++) {
      low[k] = held == 0 || node[k] < low[k] ? node[k] : low[k];
      high[k] = held == 0 || node[k] > high[k] ? node[k] : high[k];
    }
    held++;
  }
  for (int k = 0; k < 2; k++) {
    fit->first[k] = low[k];
    fit->size[k] = high[k] - low[k] + 1;
  }
  return held;
}

/* ---- refinement */

static void add_light(const hl_dome_data *data, const hl_dome_fit *fit, const double x[3],
                      const int node[2], hl_dome_system *s)
{
  const double by[3] = {1, node[0], node[1]};
  double p[3], e[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, length = 1;
  node_at(fit, node[0], node[1], p);
  if (!data->positions) {
    length = hl_norm(p);
    hl_tangent_basis(x, e[0], e[1]);
  }
  for (int u = 0; u < (data->positions ? 3 : 2); u++) {
    double row[UNKNOWNS], t[3];
    const double along = hl_dot(e[u], p) / length;
    const double r = data->positions ? along - hl_dot(e[u], x) : along;
    hl_add_scaled(e[u], data->positions ? 0 : -along / length, p, t);
    for (int k = 0; k < UNKNOWNS; k++)
      row[k] = by[k / 3] * t[k % 3] / length;
    hl_dome_add_row(s, row, r, UNKNOWNS);
  }
}

/* Of directions: the plane 1 away. */
static bool put_at_one(hl_dome_fit *fit)
{
  double normal[3];
  hl_cross(fit->step[0], fit->step[1], normal);
  hl_unit(normal, normal);
  const double away = fabs(hl_dot(normal, fit->corner));
  if (!(away > 1e-6 * hl_norm(fit->corner)))
    return false;
  for (int k = 0; k < 3; k++) {
    fit->corner[k] /= away;
    fit->step[0][k] /= away;
    fit->step[1][k] /= away;
  }
  return true;
}

static bool refine(const hl_dome_data *data, hl_dome_fit *fit)
{
  const int unknowns = hl_dome_unknowns(fit, data->positions);
  for (int step = 0; step < STEPS; step++) {
    hl_dome_system s;
    const double cut = hl_dome_cut(data->positions ? 3 : 2) * fit->sigma;
    int held = 0;
    memset(&s, 0, sizeof s);
    for (int i = 0; i < data->n; i++) {
      const double *x = data->x + 3 * i;
      int node[2];
      double peak;
      if (!(hl_dome_grid_nearest(fit, data->positions, x, node, &peak) <= cut))
        continue;
      add_light(data, fit, x, node, &s);
      held++;
    }
    if (held < LIGHTS_MIN)
      return false;
    hl_dome_solve(&s, UNKNOWNS);
    for (int k = 0; k < 3; k++) {
      fit->corner[k] += s.b[k];
      fit->step[0][k] += s.b[3 + k];
      fit->step[1][k] += s.b[6 + k];
    }
    if (!data->positions && !put_at_one(fit))
      return false;
    fit->sigma = hl_dome_sigma(data, s.squares, s.coordinates, unknowns);
  }
  return measure(data, fit, true) >= LIGHTS_MIN;
}

/* ---- search */

static int neighbours(const hl_dome_data *data, const double x[3], const double *out[NEIGHBOURS])
{
  double away[NEIGHBOURS];
  int n = 0;
  for (int i = 0; i < data->n; i++) {
    double d[3];
    hl_add_scaled(data->x + 3 * i, -1, x, d);
    const double r = hl_norm(d);
    if (!(r > 0) || (n == NEIGHBOURS && !(r < away[n - 1])))
      continue;
    int at = n < NEIGHBOURS ? n++ : n - 1;
    for (; at > 0 && away[at - 1] > r; at--) {
      away[at] = away[at - 1];
      out[at] = out[at - 1];
    }
    away[at] = r;
    out[at] = data->x + 3 * i;
  }
  return n;
}

static void keep(const hl_dome_data *data, hl_dome_fit *fit, hl_dome_fit *kept, int *n)
{
  fit->shape = HL_DOME_GRID;
  fit->size[0] = fit->size[1] = 1;
  fit->sigma = hl_dome_rough_sigma(data, fit);
  if (measure(data, fit, false) < LIGHTS_MIN / 2)
    return;
  fit->evidence = hl_dome_evidence(data, fit, false);
  int at = *n < KEPT ? (*n)++ : KEPT;
  for (; at > 0 && kept[at - 1].evidence < fit->evidence; at--)
    if (at < KEPT)
      kept[at] = kept[at - 1];
  if (at < KEPT)
    kept[at] = *fit;
}

/* d1 and d2 are beside d0 in their cell, d3 across. */
static void try_cell(const hl_dome_data *data, const double *d0, const double *d1, const double *d2,
                     const double *d3, hl_dome_fit *kept, int *n)
{
  const double *const sides[3] = {d1, d2, d0};
  hl_dome_fit fit = {0};
  double l[3];
  if (!solve_three((const double *const *)sides, d3, l) || !(l[0] > 0 && l[1] > 0 && l[2] < 0))
    return;
  for (int k = 0; k < 3; k++) {
    fit.corner[k] = -l[2] * d0[k];
    fit.step[0][k] = l[0] * d1[k] - fit.corner[k];
    fit.step[1][k] = l[1] * d2[k] - fit.corner[k];
  }
  if (put_at_one(&fit))
    keep(data, &fit, kept, n);
}

static void try_around(const hl_dome_data *data, const double *x, hl_dome_fit *kept, int *n)
{
  const double *near[NEIGHBOURS];
  const int m = neighbours(data, x, near);
  for (int i = 0; i < m; i++)
    for (int j = i + 1; j < m; j++) {
      for (int k = 0; k < m && !data->positions; k++)
        if (k != i && k != j)
          try_cell(data, x, near[i], near[j], near[k], kept, n);
      if (!data->positions)
        continue;
      hl_dome_fit fit = {.corner = {x[0], x[1], x[2]}};
      double normal[3];
      hl_add_scaled(near[i], -1, x, fit.step[0]);
      hl_add_scaled(near[j], -1, x, fit.step[1]);
      hl_cross(fit.step[0], fit.step[1], normal);
      if (hl_norm(normal) > 0.1 * hl_norm(fit.step[0]) * hl_norm(fit.step[1]))
        keep(data, &fit, kept, n);
    }
}

bool hl_dome_fit_grid(const hl_dome_data *data, hl_dome_fit *out)
{
  hl_dome_fit kept[KEPT];
  int n = 0;
  if (data->n < LIGHTS_MIN)
    return false;
  for (int i = 0; i < data->n_scored; i++)
    try_around(data, data->x + 3 * data->scored[i], kept, &n);
  return hl_dome_best(data, refine, kept, n, out);
}
