/*
 * Directions of two sessions.
 *
 * The change of light i, in the tangent plane of the reference, is
 *
 *   d_i = J_i w + C_i' e' - C_i e + (K_i' k' - K_i k) + m_i + noise_i
 *
 * with w the rotation of all lights (J_i w = w x s_i: the camera turned in the rig), e and e' the
 * errors of the ball's centre in either session and k, k' those of the camera, which all lights
 * share; k = k' where both sessions used one calibration; m_i is zero but for lights that moved. The
 * shared errors are unknowns with a prior, their stated covariance L L': unknowns u of unit prior,
 * e = L u. So everything is one least-squares problem with as many unknowns as there are shared
 * numbers, whatever the number of lights.
 *
 * A light has moved when freeing it lowers the sum of squares by more than chance does. With the
 * whitened residuals r_i of the fit and its leverage H_i = X_i (R'R)^-1 X_i', freeing light i lowers
 * it by
 *
 *   T_i = r_i' (I - H_i)^-1 r_i      in the fit,     r_i' (I + H_i)^-1 r_i      left out of it
 *
 * which is chi-squared of two (Cook and Weisberg 1982, 2.2). The light with the largest T beyond the
 * limit is left out and all are fitted again, so that a light that moved does not accuse its
 * neighbours.
 */
#include "rig_turn.h"

#include <math.h>
#include <string.h>

#include "halflight/vec3.h"

void hl_rig_root(const double *a, int n, int stride, double *l)
{
  for (int i = 0; i < n; i++)
    for (int j = 0; j <= i; j++) {
      double sum = a[i * stride + j];
      for (int k = 0; k < j; k++)
        sum -= l[i * n + k] * l[j * n + k];
      const bool positive = sum > 1e-14 * a[i * stride + i];
      const double pivot = i == j ? 0 : l[j * n + j];
      l[i * n + j] = i == j ? (positive ? sqrt(sum) : 0) : pivot > 0 ? sum / pivot : 0;
      l[j * n + i] = i == j ? l[i * n + j] : 0;
    }
}

bool hl_rig_same_camera(const hl_camera *a, const hl_camera *b)
{
  const int n = hl_camera_intrinsics_count(a);
  double p[HL_INTRINSICS_MAX], q[HL_INTRINSICS_MAX];
  if (a->model != b->model || n != hl_camera_intrinsics_count(b))
    return false;
  hl_camera_intrinsics(a, p);
  hl_camera_intrinsics(b, q);
  return memcmp(p, q, (size_t)n * sizeof *p) == 0 && a->has_covariance == b->has_covariance &&
         (!a->has_covariance ||
          memcmp(a->covariance, b->covariance, (size_t)(n * n) * sizeof *p) == 0);
}

/* ---- equations ---- */

/* Current's tangent plane to the reference's. */
static void change_of_basis(const hl_rig_light *a, const hl_rig_light *b, double m[2][2])
{
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++)
      m[i][j] = hl_dot(a->tangent_basis[i], b->tangent_basis[j]);
}

/* The tangent vector at s that leads to t, its length the angle. */
static void tangent_change(const hl_rig_light *a, const double t[3], double out[2])
{
  const double along[2] = {hl_dot(a->tangent_basis[0], t), hl_dot(a->tangent_basis[1], t)};
  const double length = hypot(along[0], along[1]);
  const double factor = length > 0 ? hl_angle(a->direction, t) / length : 1;
  out[0] = factor * along[0];
  out[1] = factor * along[1];
}

static bool whitening(const hl_rig_light *a, const hl_rig_light *b, const double m[2][2],
                      double root[2][2])
{
  double w[4];
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++) {
      w[2 * i + j] = a->own_rad2[i][j];
      for (int k = 0; k < 2; k++)
        for (int l = 0; l < 2; l++)
          w[2 * i + j] += m[i][k] * b->own_rad2[k][l] * m[j][l];
    }
  hl_rig_root(w, 2, 2, &root[0][0]);
  return root[0][0] > 0 && root[1][1] > 0;
}

/* Columns first..first+n-1 of the rows become by (2 x n, rows `stride` apart) times l (n x n). */
static void put(hl_rig_rows *rows, int first, const double *by, int stride, const double *l, int n)
{
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < n; j++)
      for (int k = j; k < n; k++)
        rows->x[i][first + j] += by[i * stride + k] * l[k * n + j];
}

static void put_center(const hl_lights *session, const hl_rig_light *light, const double by[2][3],
                       int first, hl_rig_rows *rows)
{
  const hl_sphere *ball = &session->ball[light->ball];
  double l[9];
  if (!ball->has_covariance)
    return;
  hl_rig_root(ball->n_intrinsics > 0 ? &ball->held_covariance_m2[0][0] : &ball->covariance_m2[0][0],
              3, 3, l);
  put(rows, first + 3 * light->ball, &by[0][0], 3, l, 3);
}

static void in_reference(const double m[2][2], const double *by, int stride, int n, double *out)
{
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < n; j++)
      out[i * stride + j] = m[i][0] * by[j] + m[i][1] * by[stride + j];
}

static void put_camera(const hl_camera *camera, const double by[2][HL_INTRINSICS_MAX], int first,
                       hl_rig_rows *rows)
{
  const int n = hl_camera_intrinsics_count(camera);
  double l[HL_INTRINSICS_MAX * HL_INTRINSICS_MAX];
  if (!camera->has_covariance)
    return;
  hl_rig_root(camera->covariance, n, n, l);
  put(rows, first, &by[0][0], HL_INTRINSICS_MAX, l, n);
}

static void negate(double *values, int n)
{
  for (int i = 0; i < n; i++)
    values[i] = -values[i];
}

static void put_shared(const hl_lights *reference, const hl_lights *current, const hl_rig_light *a,
                       const hl_rig_light *b, const double m[2][2], hl_rig_rows *rows)
{
  const int balls = 3 * reference->n_balls, n = hl_camera_intrinsics_count(&reference->camera);
  double center[2][3], from[2][HL_INTRINSICS_MAX] = {{0}}, to[2][HL_INTRINSICS_MAX] = {{0}};
  put_center(reference, a, a->by_center, 3, rows);
  in_reference(m, &b->by_center[0][0], 3, 3, &center[0][0]);
  put_center(current, b, center, 3 + balls, rows);
  memcpy(from, a->by_intrinsics, sizeof from);
  in_reference(m, &b->by_intrinsics[0][0], HL_INTRINSICS_MAX, HL_INTRINSICS_MAX, &to[0][0]);
  negate(&from[0][0], 2 * HL_INTRINSICS_MAX);
  const bool one = hl_rig_same_camera(&reference->camera, &current->camera);
  put_camera(&reference->camera, from, 3 + 2 * balls, rows);
  put_camera(&current->camera, to, 3 + 2 * balls + (one ? 0 : n), rows);
}

static bool equations_of(const hl_lights *reference, const hl_lights *current,
                         const hl_rig_pair *pair, hl_rig_rows *rows)
{
  const hl_rig_light *a = &reference->light[pair->reference], *b = &current->light[pair->current];
  double m[2][2];
  memset(rows, 0, sizeof *rows);
  memcpy(rows->tangent, a->tangent_basis, sizeof rows->tangent);
  change_of_basis(a, b, m);
  if (!whitening(a, b, m, rows->root))
    return false;
  tangent_change(a, b->direction, rows->change);
  for (int i = 0; i < 2; i++)
    hl_cross(a->direction, a->tangent_basis[i], rows->x[i]); /* u . (w x s) = w . (s x u) */
  put_shared(reference, current, a, b, m, rows);
  for (int k = -1; k < HL_TRIANGLE_MAX; k++) {
    double *first = k < 0 ? &rows->change[0] : &rows->x[0][k];
    double *second = k < 0 ? &rows->change[1] : &rows->x[1][k];
    *first /= rows->root[0][0];
    *second = (*second - rows->root[1][0] * *first) / rows->root[1][1];
  }
  return true;
}

hl_status hl_rig_turn_equations(hl_ctx *ctx, const hl_lights *reference, const hl_lights *current,
                                const hl_rig_pair *pair, hl_rig_turn *out)
{
  const int cameras = hl_camera_intrinsics_count(&reference->camera) +
                      (hl_rig_same_camera(&reference->camera, &current->camera)
                           ? 0
                           : hl_camera_intrinsics_count(&current->camera));
  out->unknowns = 3 + 6 * reference->n_balls + cameras;
  if (out->unknowns > HL_TRIANGLE_MAX)
    return hl_fail(ctx, HL_ERR_FORMAT, "%d balls; at most %d can be compared through these cameras",
                   reference->n_balls, (HL_TRIANGLE_MAX - 3 - cameras) / 6);
  for (int i = 0; i < out->n; i++)
    if (!equations_of(reference, current, &pair[i], &out->rows[i]))
      return hl_fail(ctx, HL_ERR_DEGENERATE,
                     "light %.60s states no uncertainty of its own; a positive own_rad2 is needed",
                     pair[i].name);
  return HL_OK;
}

/* ---- the fit ---- */

/* With `held`, no rotation. */
static void fit(const hl_rig_turn *turn, bool held, hl_triangle *t)
{
  const int skip = held ? 3 : 0, n = turn->unknowns - skip;
  double row[HL_TRIANGLE_MAX];
  hl_triangle_clear(t, n);
  for (int i = 3 - skip; i < n; i++) { /* the priors */
    memset(row, 0, sizeof row);
    row[i] = 1;
    hl_triangle_add(t, row, 0);
  }
  for (int i = 0; i < turn->n; i++)
    for (int k = 0; k < 2 && !turn->rows[i].moved; k++) {
      memcpy(row, turn->rows[i].x[k] + skip, (size_t)n * sizeof *row);
      hl_triangle_add(t, row, turn->rows[i].change[k]);
    }
}

static bool solve(const hl_triangle *t, double *u)
{
  for (int i = t->n - 1; i >= 0; i--) {
    double sum = t->z[i];
    for (int k = i + 1; k < t->n; k++)
      sum -= t->r[i][k] * u[k];
    if (!(fabs(t->r[i][i]) > 0))
      return false;
    u[i] = sum / t->r[i][i];
  }
  return true;
}

/* y = R'^-1 x, so that y.y is x (R'R)^-1 x'. */
static void forward(const hl_triangle *t, const double *x, double *y)
{
  for (int i = 0; i < t->n; i++) {
    double sum = x[i];
    for (int k = 0; k < i; k++)
      sum -= t->r[k][i] * y[k];
    y[i] = sum / t->r[i][i];
  }
}

static double dot(const double *a, const double *b, int n)
{
  double sum = 0;
  for (int i = 0; i < n; i++)
    sum += a[i] * b[i];
  return sum;
}

static void test_light(const hl_triangle *t, const double *u, hl_rig_rows *rows)
{
  double y[2][HL_TRIANGLE_MAX], r[2], sign = rows->moved ? 1 : -1;
  for (int k = 0; k < 2; k++) {
    forward(t, rows->x[k], y[k]);
    r[k] = rows->change[k] - dot(rows->x[k], u, t->n);
  }
  const double a = 1 + sign * dot(y[0], y[0], t->n), b = sign * dot(y[0], y[1], t->n);
  const double c = 1 + sign * dot(y[1], y[1], t->n), det = a * c - b * b;
  const double v[2] = {(c * r[0] - b * r[1]) / det, (a * r[1] - b * r[0]) / det};
  const bool told = det > 1e-9;
  rows->statistic = told ? r[0] * v[0] + r[1] * v[1] : 0;
  for (int k = 0; k < 2; k++)
    rows->left[k] = rows->moved ? r[k] : told ? v[k] : 0;
}

static void rotation(const hl_triangle *t, const double *u, hl_rig_turn *turn)
{
  double y[3][HL_TRIANGLE_MAX];
  for (int i = 0; i < 3; i++) {
    double unit[HL_TRIANGLE_MAX] = {0};
    unit[i] = 1;
    /* NOLINTNEXTLINE(clang-analyzer-core.uninitialized.Assign): its n numbers are set */
    turn->rotation_rad[i] = u[i];
    forward(t, unit, y[i]);
  }
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++)
      turn->rotation_covariance[i][k] = dot(y[i], y[k], t->n);
}

static hl_status test_all(hl_ctx *ctx, hl_rig_turn *turn)
{
  hl_triangle t, held;
  double u[HL_TRIANGLE_MAX];
  fit(turn, false, &t);
  if (!solve(&t, u))
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "the lights' directions do not tell a rotation; lights apart are needed");
  fit(turn, true, &held);
  rotation(&t, u, turn);
  turn->statistic = fmax(0, held.rest - t.rest);
  for (int i = 0; i < turn->n; i++)
    test_light(&t, u, &turn->rows[i]);
  return HL_OK;
}

static int worst(const hl_rig_turn *turn, double limit)
{
  int at = -1, still = 0;
  for (int i = 0; i < turn->n; i++) {
    still += !turn->rows[i].moved;
    if (!turn->rows[i].moved && turn->rows[i].statistic > limit &&
        (at < 0 || turn->rows[i].statistic > turn->rows[at].statistic))
      at = i;
  }
  return 2 * still > turn->n && still > 3 ? at : -1;
}

hl_status hl_rig_turn_settle(hl_ctx *ctx, double limit, hl_rig_turn *turn)
{
  hl_status st = test_all(ctx, turn);
  for (int at; st == HL_OK && (at = worst(turn, limit)) >= 0;) {
    turn->rows[at].moved = true;
    st = test_all(ctx, turn);
  }
  return st;
}
