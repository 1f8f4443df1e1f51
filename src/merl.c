/* MERL tables asked at any angles.
 *
 * With t, b, h as in merl.h and n = -sin(theta_half) t + cos(theta_half) h, at a cell's centre
 *
 *   n.s = p - q,  n.v = p + q,   p = cos theta_half cos theta_diff,
 *                                q = sin theta_half sin theta_diff cos phi_diff,
 *
 * so (n.s)(n.v) = p^2 - q^2 is positive just where both are above the horizon.
 *
 * The grid goes on beyond its ends: theta_diff -> -theta_diff is phi_diff + pi, which is the same cell
 * by reciprocity, and theta_half -> -theta_half likewise, so both mirror at 0, which half a cell from
 * the first centre is to stay at its value; phi_diff runs around. */
#include "halflight/merl.h"

#include <math.h>
#include <stdlib.h>

#include "halflight/vec3.h"

static const double pi = 3.14159265358979323846;
static const double half_pi = 1.57079632679489661923;
static const double least_measured = 0.5; /* of the weight of the cells about */

double hl_merl_scale(int channel)
{
  static const double scale[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};
  return scale[channel];
}

hl_merl_angles hl_merl_center(int half, int diff, int phi)
{
  const double x = (half + 0.5) / HL_MERL_THETA_HALF;
  const hl_merl_angles a = {.theta_half = x * x * half_pi,
                            .theta_diff = (diff + 0.5) / HL_MERL_THETA_DIFF * half_pi,
                            .phi_diff = (phi + 0.5) / HL_MERL_PHI_DIFF * pi};
  return a;
}

void hl_merl_directions(hl_merl_angles a, double s[3], double v[3])
{
  const double x = sin(a.theta_diff) * cos(a.phi_diff), y = sin(a.theta_diff) * sin(a.phi_diff);
  const double c = cos(a.theta_half), d = sin(a.theta_half), z = cos(a.theta_diff);
  s[0] = c * x + d * z;
  s[1] = y;
  s[2] = -d * x + c * z;
  v[0] = -c * x + d * z;
  v[1] = -y;
  v[2] = d * x + c * z;
}

hl_merl_angles hl_merl_angles_of(const double n[3], const double s[3], const double v[3])
{
  double h[3], b[3], t[3];
  hl_merl_angles a;
  hl_add_scaled(s, 1, v, h);
  hl_unit(h, h);
  hl_cross(n, h, b);
  hl_unit(b, b);
  hl_cross(b, h, t);
  a.theta_half = hl_angle(n, h);
  a.theta_diff = 0.5 * hl_angle(s, v);
  a.phi_diff = atan2(hl_dot(b, s), hl_dot(t, s));
  if (a.phi_diff < 0)
    a.phi_diff += pi;
  if (a.phi_diff >= pi)
    a.phi_diff -= pi;
  return a;
}

hl_status hl_merl_new(hl_ctx *ctx, hl_merl *out)
{
  double *value = malloc(3 * (size_t)HL_MERL_CELLS * sizeof *value);
  if (!value)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a MERL table of 3 x %d values",
                   HL_MERL_CELLS);
  for (size_t i = 0; i < 3 * (size_t)HL_MERL_CELLS; i++)
    value[i] = -1;
  out->value = value;
  return HL_OK;
}

void hl_merl_free(hl_merl *merl)
{
  if (!merl)
    return;
  free(merl->value);
  merl->value = NULL;
}

/* (n.s)(n.v) at a cell's centre. */
static double cosines(int half, int diff, int phi)
{
  const hl_merl_angles a = hl_merl_center(half, diff, phi);
  const double p = cos(a.theta_half) * cos(a.theta_diff);
  const double q = sin(a.theta_half) * sin(a.theta_diff) * cos(a.phi_diff);
  return p * p - q * q;
}

static bool is_measured(const hl_merl *merl, size_t cell)
{
  const double *value = merl->value + cell;
  return value[0] >= 0 && value[HL_MERL_CELLS] >= 0 && value[2 * (size_t)HL_MERL_CELLS] >= 0;
}

double hl_merl_measured(const hl_merl *merl)
{
  long above = 0, measured = 0;
  for (int i = 0; i < HL_MERL_THETA_HALF; i++)
    for (int j = 0; j < HL_MERL_THETA_DIFF; j++)
      for (int k = 0; k < HL_MERL_PHI_DIFF; k++)
        if (cosines(i, j, k) > 0) {
          above++;
          measured += is_measured(merl, hl_merl_cell(i, j, k));
        }
  return (double)measured / (double)above;
}

/* Coordinates in cells: cell i runs from i to i + 1. */
static void coordinates(hl_merl_angles a, double x[3])
{
  const double half = a.theta_half / half_pi;
  x[0] = HL_MERL_THETA_HALF * sqrt(half > 0 ? half : 0);
  x[1] = HL_MERL_THETA_DIFF * a.theta_diff / half_pi;
  x[2] = HL_MERL_PHI_DIFF * a.phi_diff / pi;
}

static int clamped(double x, int n)
{
  return x > 0 ? (x < n - 1 ? (int)x : n - 1) : 0;
}

static bool nearest(const hl_merl *merl, const double x[3], double out[3])
{
  const size_t cell =
      hl_merl_cell(clamped(x[0], HL_MERL_THETA_HALF), clamped(x[1], HL_MERL_THETA_DIFF),
                   clamped(x[2], HL_MERL_PHI_DIFF));
  const bool measured = is_measured(merl, cell);
  for (int c = 0; c < 3; c++)
    out[c] =
        measured ? hl_merl_scale(c) * merl->value[(size_t)c * HL_MERL_CELLS + cell] : (double)NAN;
  return measured;
}

/* The two centres about x of n in a row, and the weight of the second. */
static void neighbours(double x, int n, int at[2], double *second)
{
  const double y = x - 0.5 > 0 ? (x - 0.5 < n - 1 ? x - 0.5 : n - 1) : 0;
  at[0] = y < n - 2 ? (int)y : n - 2;
  at[1] = at[0] + 1;
  *second = y - at[0];
}

/* The same around a circle. */
static void neighbours_around(double x, int n, int at[2], double *second)
{
  const double down = floor(x - 0.5);
  at[0] = ((int)down % n + n) % n;
  at[1] = (at[0] + 1) % n;
  *second = x - 0.5 - down;
}

/* A cell near the angles: its place, its trilinear weight, (n.s)(n.v) at its centre. */
typedef struct corner {
  size_t cell;
  double weight, cosines;
} corner;

static void corners_about(const double x[3], corner out[8])
{
  int at[3][2];
  double second[3], p[2][2], q[2][2];
  neighbours(x[0], HL_MERL_THETA_HALF, at[0], &second[0]);
  neighbours(x[1], HL_MERL_THETA_DIFF, at[1], &second[1]);
  neighbours_around(x[2], HL_MERL_PHI_DIFF, at[2], &second[2]);
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++) {
      const hl_merl_angles a = hl_merl_center(at[0][i], at[1][j], 0);
      p[i][j] = cos(a.theta_half) * cos(a.theta_diff);
      q[i][j] = sin(a.theta_half) * sin(a.theta_diff);
    }
  for (int k = 0, m = 0; k < 2; k++) {
    const double turn = cos(hl_merl_center(0, 0, at[2][k]).phi_diff);
    for (int i = 0; i < 2; i++)
      for (int j = 0; j < 2; j++, m++) {
        out[m].cell = hl_merl_cell(at[0][i], at[1][j], at[2][k]);
        out[m].weight = (i ? second[0] : 1 - second[0]) * (j ? second[1] : 1 - second[1]) *
                        (k ? second[2] : 1 - second[2]);
        out[m].cosines = p[i][j] * p[i][j] - q[i][j] * q[i][j] * turn * turn;
      }
  }
}

static bool smooth(const hl_merl *merl, const double x[3], double out[3])
{
  corner about[8];
  double sum[3] = {0}, product = 0, above = 0, measured = 0;
  corners_about(x, about);
  for (int m = 0; m < 8; m++) {
    const corner *at = &about[m];
    if (!(at->weight > 0) || !(at->cosines > 0))
      continue;
    above += at->weight;
    if (!is_measured(merl, at->cell))
      continue;
    measured += at->weight;
    product += at->weight * at->cosines;
    for (int c = 0; c < 3; c++)
      sum[c] += at->weight * at->cosines * merl->value[(size_t)c * HL_MERL_CELLS + at->cell];
  }
  if (!(above > 0))
    return nearest(merl, x, out);
  const bool enough = measured >= least_measured * above;
  for (int c = 0; c < 3; c++)
    out[c] = enough ? hl_merl_scale(c) * (sum[c] / product) : (double)NAN;
  return enough;
}

bool hl_merl_at(const hl_merl *merl, hl_merl_angles angles, hl_merl_lookup lookup, double out[3])
{
  double x[3];
  coordinates(angles, x);
  return lookup == HL_MERL_NEAREST ? nearest(merl, x, out) : smooth(merl, x, out);
}

bool hl_merl_eval(const hl_merl *merl, const double n[3], const double s[3], const double v[3],
                  hl_merl_lookup lookup, double out[3])
{
  if (hl_dot(n, s) > 0 && hl_dot(n, v) > 0)
    return hl_merl_at(merl, hl_merl_angles_of(n, s, v), lookup, out);
  out[0] = out[1] = out[2] = 0;
  return true;
}
