/*
 * Where two cameras see the same points.
 *
 * A node g of a grid over the reference's frame is seen along its ray u(theta_0, g); the point at
 * `distance` on it, or its direction, is seen by the current camera at
 *
 *   q(theta_1, T) = project(theta_1, T u(theta_0, g))
 *
 * T is the motion between the two cameras' own frames that the calibrations cannot know: a rotation,
 * and for points at a distance a translation too (mrcal's differencing). It is fitted by
 * Gauss-Newton to q = g, every node weighted by its stated variance, so that what neither calibration
 * knows does not turn the rest. With N = dq/d(w) by the unit-noise causes w of theta_0 and theta_1,
 * B = dq/dT and W the weights, the difference d = q - g and its spread at the fitted T are
 *
 *   Cov(d) = F F',   F = N - B (B'WB)^-1 B'W N
 */
#include "drift_projection.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/vec3.h"
#include "spd.h"

enum { NODES_MAX = HL_DRIFT_GRID * HL_DRIFT_GRID, ROUNDS = 50 };

static const double settled_px = 1e-9;
static const double least_px = 1e-3; /* no calibration is better than that */
static const double same_ray = 1e-6; /* rad */
static const double damping = 1e-12;

static void grid_size(const hl_camera *camera, int *columns, int *rows)
{
  const double w = camera->width, h = camera->height;
  const double longer = fmax(w, h);
  *columns = (int)fmax(2, round(HL_DRIFT_GRID * w / longer));
  *rows = (int)fmax(2, round(HL_DRIFT_GRID * h / longer));
}

/* Node k of the grid, which reaches the centres of the frame's outermost pixels. */
static void grid_node(const hl_camera *camera, int columns, int rows, int k, double at[2])
{
  at[0] = (double)(k % columns) * (camera->width - 1) / (columns - 1);
  const int row = k / columns;
  at[1] = (double)row * (camera->height - 1) / (rows - 1);
}

/* The reference's half: points, and how they follow its intrinsics. */
static void look(const hl_drift_fit *f, int k)
{
  const hl_camera *camera = &f->reference->calibration->camera;
  hl_drift_node *n = &f->node[k];
  const double far = f->distance_m > 0 ? f->distance_m : 1;
  grid_node(camera, f->columns, f->rows, k, n->at);
  n->seen = hl_camera_unproject_derivatives(NULL, camera, n->at[0], n->at[1], n->point, NULL,
                                            n->by_reference) == HL_OK;
  for (int i = 0; i < 3; i++) {
    n->point[i] *= far;
    for (int j = 0; j < f->reference->n; j++)
      n->by_reference[i][j] *= far;
  }
}

/* The current camera's half, at the present motion; by_cause where `spread`. */
static void project(const hl_drift_fit *f, hl_drift_node *n, bool spread)
{
  const hl_camera *camera = &f->current->calibration->camera;
  const int n0 = f->reference->n, n1 = f->current->n;
  double moved[3], by_pose[3][HL_POSE_SIZE], turn[3][3], pixel[2], back[3];
  double by_point[2][3], by_current[2][HL_INTRINSICS_MAX];
  hl_pose_apply(&f->motion, n->point, moved, by_pose, turn);
  /* beyond a fold of the lens the pixel belongs to another direction */
  n->seen =
      hl_camera_project_derivatives(NULL, camera, moved, pixel, by_point, by_current) == HL_OK &&
      hl_camera_unproject(NULL, camera, pixel[0], pixel[1], back) == HL_OK &&
      hl_angle(moved, back) < same_ray;
  if (!n->seen)
    return;
  for (int i = 0; i < 2; i++) {
    n->difference[i] = pixel[i] - n->at[i];
    for (int j = 0; j < f->n_motion; j++)
      n->by_motion[i][j] = by_point[i][0] * by_pose[0][j] + by_point[i][1] * by_pose[1][j] +
                           by_point[i][2] * by_pose[2][j];
    for (int c = 0; spread && c < n0 + n1; c++) {
      double sum = 0;
      for (int j = c; c < n0 && j < n0; j++) {
        double by = 0;
        for (int a = 0; a < 3; a++)
          for (int b = 0; b < 3; b++)
            by += by_point[i][a] * turn[a][b] * n->by_reference[b][j];
        sum += by * f->reference->lower[j][c];
      }
      for (int j = c - n0; c >= n0 && j < n1; j++)
        sum += by_current[i][j] * f->current->lower[j][c - n0];
      n->by_cause[i][c] = sum;
    }
  }
}

static void weigh(const hl_drift_fit *f, hl_drift_node *n)
{
  double variance = 0;
  for (int i = 0; i < 2; i++)
    for (int c = 0; c < f->n_causes; c++)
      variance += n->by_cause[i][c] * n->by_cause[i][c] / 2;
  n->weight = 1 / (variance + least_px * least_px);
}

/* B'WB, factored; false where the nodes do not tell the motion. */
static bool motion_information(const hl_drift_fit *f, hl_spd *out)
{
  const int m = f->n_motion;
  double information[HL_POSE_SIZE * HL_POSE_SIZE] = {0};
  for (int k = 0; k < f->n_nodes; k++) {
    const hl_drift_node *n = &f->node[k];
    for (int i = 0; n->seen && i < 2; i++)
      for (int a = 0; a < m; a++)
        for (int b = 0; b < m; b++)
          information[a * m + b] += n->weight * n->by_motion[i][a] * n->by_motion[i][b];
  }
  return hl_spd_factor(information, m, damping, out, NULL);
}

/* (B'WB)^-1 B'W y, y the differences or, for c >= 0, the nodes' by_cause column. */
static void motion_of(const hl_drift_fit *f, const hl_spd *information, int c, double *out)
{
  double right[HL_POSE_SIZE] = {0};
  for (int k = 0; k < f->n_nodes; k++) {
    const hl_drift_node *n = &f->node[k];
    for (int i = 0; n->seen && i < 2; i++)
      for (int a = 0; a < f->n_motion; a++)
        right[a] += n->weight * n->by_motion[i][a] * (c < 0 ? n->difference[i] : n->by_cause[i][c]);
  }
  hl_spd_solve(information, right, out);
}

/* One step of the motion; how far it moves a node at most [px]. False: not determined. */
static bool step_motion(hl_drift_fit *f, double *moved_px)
{
  hl_spd information;
  double step[HL_POSE_SIZE] = {0};
  if (!motion_information(f, &information))
    return false;
  motion_of(f, &information, -1, step);
  *moved_px = 0;
  for (int k = 0; k < f->n_nodes; k++)
    for (int i = 0; f->node[k].seen && i < 2; i++) {
      double by = 0;
      for (int a = 0; a < f->n_motion; a++)
        by += f->node[k].by_motion[i][a] * step[a];
      *moved_px = fmax(*moved_px, fabs(by));
    }
  for (int i = 0; i < 3; i++) {
    f->motion.rotation_rad[i] -= step[i];
    f->motion.translation_m[i] -= step[3 + i];
  }
  return true;
}

static hl_status fit_motion(hl_ctx *ctx, hl_drift_fit *f)
{
  double moved_px = HUGE_VAL;
  for (int i = 0; i < ROUNDS && moved_px > settled_px; i++) {
    for (int k = 0; k < f->n_nodes; k++) {
      hl_drift_node *n = &f->node[k];
      if (i > 0 && !n->seen)
        continue;
      if (n->seen)
        project(f, n, i == 0);
      if (n->seen && i == 0)
        weigh(f, n);
    }
    if (!step_motion(f, &moved_px))
      return hl_fail(ctx, HL_ERR_DEGENERATE,
                     "the two cameras see no common directions; calibrations of one camera are "
                     "needed");
  }
  for (int k = 0; k < f->n_nodes; k++)
    if (f->node[k].seen)
      project(f, &f->node[k], true);
  return HL_OK;
}

hl_status hl_drift_fit_open(hl_ctx *ctx, const hl_drift_side *reference,
                            const hl_drift_side *current, double distance_m, hl_drift_fit *out)
{
  hl_drift_fit f = {.reference = reference,
                    .current = current,
                    .distance_m = distance_m,
                    .n_motion = distance_m > 0 ? 6 : 3,
                    .n_causes = reference->n + current->n};
  grid_size(&reference->calibration->camera, &f.columns, &f.rows);
  f.n_nodes = f.columns * f.rows;
  f.node = calloc(NODES_MAX, sizeof *f.node);
  if (!f.node)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d points", NODES_MAX);
  for (int k = 0; k < f.n_nodes; k++)
    look(&f, k);
  const hl_status st = fit_motion(ctx, &f);
  if (st == HL_OK)
    *out = f;
  else
    free(f.node);
  return st;
}

/* ---- the difference as a user sees it ---- */

/* N becomes F. */
static void free_of_motion(hl_drift_fit *f)
{
  hl_spd information;
  if (!motion_information(f, &information))
    return;
  for (int c = 0; c < f->n_causes; c++) {
    double by[HL_POSE_SIZE];
    motion_of(f, &information, c, by);
    for (int k = 0; k < f->n_nodes; k++)
      for (int i = 0; f->node[k].seen && i < 2; i++)
        for (int a = 0; a < f->n_motion; a++)
          f->node[k].by_cause[i][c] -= f->node[k].by_motion[i][a] * by[a];
  }
}

/* |d| / sqrt(d' Cov^-1 d) */
double hl_drift_deviation(const double difference[2], const double covariance[2][2])
{
  const double(*c)[2] = covariance;
  const double length = hypot(difference[0], difference[1]);
  const double x = length > 0 ? difference[0] / length : 1;
  const double y = length > 0 ? difference[1] / length : 0;
  const double determinant = c[0][0] * c[1][1] - c[0][1] * c[1][0];
  const double inverse = x * x * c[1][1] - 2 * x * y * c[0][1] + y * y * c[0][0];
  return inverse > 0 ? sqrt(fmax(determinant, 0) / inverse) : 0;
}

static double deviation_of(const hl_drift_fit *f, const hl_drift_node *n)
{
  double c[2][2] = {{0}};
  for (int i = 0; i < 2; i++)
    for (int k = 0; k < 2; k++)
      for (int j = 0; j < f->n_causes; j++)
        c[i][k] += n->by_cause[i][j] * n->by_cause[k][j];
  return hl_drift_deviation(n->difference, (const double(*)[2])c);
}

hl_status hl_drift_projections(hl_ctx *ctx, const hl_drift_side *reference,
                               const hl_drift_side *current, double distance_m, hl_drift *out)
{
  hl_drift_fit f = {0};
  const hl_status st = hl_drift_fit_open(ctx, reference, current, distance_m, &f);
  if (st != HL_OK)
    return st;
  free_of_motion(&f);
  int seen = 0;
  double sum = 0, most = 0;
  for (int k = 0; k < f.n_nodes; k++) {
    const hl_drift_node *n = &f.node[k];
    const double length = hypot(n->difference[0], n->difference[1]);
    for (int i = 0; i < 2; i++) {
      out->at_px[k][i] = n->at[i];
      out->difference_px[k][i] = n->seen ? n->difference[i] : NAN;
    }
    out->sigma_px[k] = n->seen ? deviation_of(&f, n) : NAN;
    if (!n->seen)
      continue;
    seen++;
    sum += length;
    most = fmax(most, length);
  }
  out->columns = f.columns;
  out->rows = f.rows;
  out->n_nodes = f.n_nodes;
  out->mean_px = sum / seen;
  out->max_px = most;
  out->implied = f.motion;
  free(f.node);
  return HL_OK;
}

/* ---- what a change of the intrinsics does ---- */

void hl_drift_effect(const hl_camera *camera, int first, int n,
                     double out[HL_DISTORTION_MAX][HL_DISTORTION_MAX])
{
  int columns, rows, seen = 0;
  grid_size(camera, &columns, &rows);
  memset(out, 0, sizeof(double[HL_DISTORTION_MAX][HL_DISTORTION_MAX]));
  for (int k = 0; k < columns * rows; k++) {
    double at[2], ray[3], pixel[2], by[2][HL_INTRINSICS_MAX];
    grid_node(camera, columns, rows, k, at);
    if (hl_camera_unproject(NULL, camera, at[0], at[1], ray) != HL_OK ||
        hl_camera_project_derivatives(NULL, camera, ray, pixel, NULL, by) != HL_OK)
      continue;
    seen++;
    for (int i = 0; i < 2; i++)
      for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++)
          out[a][b] += by[i][first + a] * by[i][first + b];
  }
  for (int a = 0; a < n; a++)
    for (int b = 0; b < n; b++)
      out[a][b] /= seen > 0 ? seen : 1;
}
