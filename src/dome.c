/*
 * Which shape the lights of a rig stand on.
 *
 * A shape S with deviation sigma states a density of lights: on it (a circle: 1 / (2 pi sin a), one of
 * N nodes: 1 / N), times a normal density across it. With a share e of lights that are anywhere,
 *
 *   p(x | S) = (1 - e) on(x) normal(r(x); sigma) + e p0(x)
 *
 * and its evidence is that of Schwarz (1978, eq. 2) less that of p0 alone,
 *
 *   E = sum_i log p(x_i | S) / p0(x_i)  -  (k + 2 - k0) / 2 log n
 *
 * with half a log n more for each ring, which may be cut out of what is dense by chance;
 * k unknowns of the shape, sigma and e; k0 of p0, the
 * density of lights without order (dome_plain.c). Every density being per unit of the same space,
 * shapes with residuals of one, two or three coordinates are compared as they are, and a fine grid or
 * many rings, which come near any light, pay for it by their N.
 */
#include "halflight/dome.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cholesky.h"
#include "dome_work.h"
#include "halflight/vec3.h"

static const double unit_length = 1e-6; /* what rounding may leave of a unit vector's length */
static const double most_off = 0.25;    /* share of lights */
static const double least_sigma =
    1e-7; /* of the unit or the extent: exact data has a density too */
static const double pivot_floor = 1e-12;

const char *hl_dome_shape_text(hl_dome_shape shape)
{
  static const char *const texts[] = {"none", "sphere", "rings", "grid"};
  return (unsigned)shape < HL_DOME_SHAPES ? texts[shape] : "none";
}

double hl_dome_cut(int coordinates)
{
  return coordinates == 1 ? 3.5 : coordinates == 2 ? 3.9 : 4.2;
}

int hl_dome_coordinates(const hl_dome_fit *fit, bool positions)
{
  switch (fit->shape) {
  case HL_DOME_RINGS:
    return positions ? 2 : 1;
  case HL_DOME_GRID:
    return positions ? 3 : 2;
  default:
    return 1;
  }
}

int hl_dome_unknowns(const hl_dome_fit *fit, bool positions)
{
  switch (fit->shape) {
  case HL_DOME_RINGS:
    return positions ? 6 : 2 + fit->n_rings;
  case HL_DOME_GRID:
    return positions ? 9 : 8;
  default:
    return 4;
  }
}

double hl_dome_sigma(const hl_dome_data *data, double squares, int coordinates, int unknowns)
{
  const int free = coordinates - unknowns;
  return fmax(data->sigma, sqrt(squares / (free > 1 ? free : 1)));
}

double hl_dome_rough_sigma(const hl_dome_data *data, const hl_dome_fit *fit)
{
  /* three quarters of normal residuals of 1, 2, 3 coordinates are within so many deviations */
  static const double quartile[] = {1.150, 1.665, 2.027};
  double off[HL_DOME_SCORED_MAX], peak;
  const int n = data->n_scored;
  for (int i = 0; i < n; i++) {
    const double r = hl_dome_nearest(data, fit, data->x + 3 * data->scored[i], &peak);
    int at = i;
    for (; at > 0 && off[at - 1] > r; at--)
      off[at] = off[at - 1];
    off[at] = r;
  }
  return fmax(data->sigma,
              off[3 * n / 4] / quartile[hl_dome_coordinates(fit, data->positions) - 1]);
}

void hl_dome_add_row(hl_dome_system *s, const double *row, double r, int unknowns)
{
  for (int i = 0; i < unknowns; i++) {
    for (int j = i; j < unknowns; j++)
      s->a[i][j] += row[i] * row[j];
    s->b[i] -= row[i] * r;
  }
  s->squares += r * r;
  s->coordinates++;
}

void hl_dome_solve(hl_dome_system *s, int unknowns)
{
  hl_cholesky(s->a[0], unknowns, HL_DOME_SIDES_MAX, pivot_floor);
  hl_cholesky_solve(s->a[0], unknowns, HL_DOME_SIDES_MAX, s->b);
}

double hl_dome_nearest(const hl_dome_data *data, const hl_dome_fit *fit, const double x[3],
                       double *log_peak)
{
  int node[2];
  switch (fit->shape) {
  case HL_DOME_RINGS:
    return data->positions ? hl_dome_circle_nearest(fit, x, log_peak)
                           : hl_dome_rings_nearest(fit, x, log_peak);
  case HL_DOME_GRID:
    return hl_dome_grid_nearest(fit, data->positions, x, node, log_peak);
  default:
    return hl_dome_sphere_nearest(fit, x, log_peak);
  }
}

double hl_dome_evidence(const hl_dome_data *data, const hl_dome_fit *fit, bool all)
{
  const int n = all ? data->n : data->n_scored;
  const double cut = hl_dome_cut(hl_dome_coordinates(fit, data->positions)) * fit->sigma;
  const int free = hl_dome_unknowns(fit, data->positions) + 2 - data->plain_unknowns;
  double *ratio = data->room; /* log p(x | on S) / p0 */
  double sum = 0;
  int off = 0;
  for (int i = 0; i < n; i++) {
    const int at = all ? i : data->scored[i];
    const double r = hl_dome_nearest(data, fit, data->x + 3 * at, &ratio[i]);
    off += r > cut;
    ratio[i] -= 0.5 * r * r / (fit->sigma * fit->sigma) + data->log_plain[at];
  }
  const double share = (off + 1.0) / (n + 2.0);
  /* of a shape without a finite sigma the ratio is no number, and tells nothing */
  for (int i = 0; i < n; i++)
    sum += log((1 - share) * (isnan(ratio[i]) ? 0 : exp(fmin(ratio[i], 700))) + share);
  return sum - 0.5 * (free + fit->n_rings) * log((double)n);
}

bool hl_dome_best(const hl_dome_data *data, bool (*refine)(const hl_dome_data *, hl_dome_fit *),
                  hl_dome_fit *candidate, int n, hl_dome_fit *out)
{
  bool found = false;
  for (int i = 0; i < n; i++) {
    if (!refine(data, &candidate[i]))
      continue;
    candidate[i].evidence = hl_dome_evidence(data, &candidate[i], true);
    if (!found || candidate[i].evidence > out->evidence)
      *out = candidate[i];
    found = true;
  }
  return found;
}

/* The largest distance from the first. */
static double extent(const double *x, int n)
{
  double most = 0;
  for (int i = 1; i < n; i++) {
    double d[3];
    hl_add_scaled(x + 3 * i, -1, x, d);
    most = fmax(most, hl_norm(d));
  }
  return most;
}

/* ---- the choice */

static void count(const hl_dome_data *data, hl_dome_fit *fit)
{
  const double cut = hl_dome_cut(hl_dome_coordinates(fit, data->positions)) * fit->sigma;
  double squares = 0, peak;
  for (int i = 0; i < data->n; i++) {
    const double r = hl_dome_nearest(data, fit, data->x + 3 * i, &peak);
    fit->n_on += r <= cut;
    squares += r <= cut ? r * r : 0;
  }
  fit->n_off = data->n - fit->n_on;
  fit->rms = fit->n_on > 0 ? sqrt(squares / fit->n_on) : 0;
  fit->evidence = hl_dome_evidence(data, fit, true);
}

static void choose(const hl_dome_data *data, hl_dome *out)
{
  double best = HL_DOME_EVIDENCE_MIN;
  for (int s = 1; s < HL_DOME_SHAPES; s++) {
    hl_dome_fit *fit = &out->fit[s];
    fit->shape = (hl_dome_shape)s;
    if (!fit->fitted)
      continue;
    count(data, fit);
    const int told = fit->n_on * hl_dome_coordinates(fit, data->positions);
    if (fit->evidence > best && fit->n_off <= most_off * data->n &&
        told >= 2 * hl_dome_unknowns(fit, data->positions)) {
      best = fit->evidence;
      out->shape = fit->shape;
    }
  }
}

static hl_status check(hl_ctx *ctx, const double *x, int n, bool positions, double sigma)
{
  if (n < 0)
    return hl_fail(ctx, HL_ERR_ARG, "n = %d lights; a number from 0 is needed", n);
  if (!(sigma >= 0 && isfinite(sigma)))
    return hl_fail(ctx, HL_ERR_ARG, "sigma = %g; a number from 0 is needed", sigma);
  for (int i = 0; i < n; i++) {
    const double length = hl_norm(x + 3 * i);
    if (!isfinite(length))
      return hl_fail(ctx, HL_ERR_ARG, "x[%d] is not finite; three numbers are needed", i);
    if (!positions && !(fabs(length - 1) <= unit_length))
      return hl_fail(ctx, HL_ERR_ARG, "x[%d] has length %.9g; a unit vector is needed", i, length);
  }
  return HL_OK;
}

hl_status hl_dome_fit_to(hl_ctx *ctx, const double *x, int n, bool positions, double sigma,
                         hl_dome *out, double *off, bool *is_off)
{
  const hl_status st = check(ctx, x, n, positions, sigma);
  if (st != HL_OK)
    return st;
  hl_dome dome = {.positions = positions, .n = n};
  hl_dome_data data = {.x = x, .n = n, .positions = positions, .sigma = sigma};
  const double across = n > 0 ? extent(x, n) : 0;
  if (n >= HL_DOME_LIGHTS_MIN && across > 0) {
    data.room = malloc((size_t)n * 5 * sizeof *data.room);
    if (!data.room)
      return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d lights", n);
    data.sigma = fmax(sigma, least_sigma * across);
    data.log_plain = data.room + (size_t)4 * (size_t)n;
    hl_dome_plain(&data);
    data.n_scored = n < HL_DOME_SCORED_MAX ? n : HL_DOME_SCORED_MAX;
    for (int i = 0; i < data.n_scored; i++)
      data.scored[i] = (int)((long long)i * n / data.n_scored);
    hl_dome_fit *fit = dome.fit;
    fit[HL_DOME_SPHERE].fitted = positions && hl_dome_fit_sphere(&data, &fit[HL_DOME_SPHERE]);
    fit[HL_DOME_RINGS].fitted = positions ? hl_dome_fit_circle(&data, &fit[HL_DOME_RINGS])
                                          : hl_dome_fit_rings(&data, &fit[HL_DOME_RINGS]);
    fit[HL_DOME_GRID].fitted = hl_dome_fit_grid(&data, &fit[HL_DOME_GRID]);
    choose(&data, &dome);
    free(data.room);
  }
  const hl_dome_fit *claimed = &dome.fit[dome.shape];
  for (int i = 0; i < n; i++) {
    double peak;
    off[i] = dome.shape == HL_DOME_NONE ? 0 : hl_dome_nearest(&data, claimed, x + 3 * i, &peak);
    is_off[i] = dome.shape != HL_DOME_NONE &&
                off[i] > hl_dome_cut(hl_dome_coordinates(claimed, positions)) * claimed->sigma;
  }
  *out = dome;
  return HL_OK;
}
