/*
 * How far a pixel may really be from where the camera says it is.
 *
 * Intrinsics alone say little: a calibration may shift its centre and turn its idea of where the
 * camera stands by the same angle without any effect. So the point is fixed to what the camera saw,
 * the boards, as mrcal does ("mean-pcam"). Let x be the point that the camera sees at pixel q, and
 * b_i = T_i^-1 x the same point in the frame of board i. Another calibration of the same scene, with
 * intrinsics theta + d(theta) and poses p_i + d(p_i), sees the V boards' mean idea of it at
 *
 *   q' = project(theta + d(theta), (1/V) sum T(p_i + d(p_i)) b_i)
 *
 * To first order, with P = dq/dx, Q = dq/d(theta), D_i = d(T b_i)/d(p_i), and the joint law of
 * calibration.h, d(p_i) = e_i + G_i d(theta) with independent e_i of covariance own_i:
 *
 *   dq      = (Q + (1/V) sum P D_i G_i) d(theta) + (1/V) sum P D_i e_i
 *   Cov(dq) = K Cov(theta) K' + (1/V^2) sum (P D_i) own_i (P D_i)',   K = Q + (1/V) sum P D_i G_i
 *
 * At infinity x and b_i are directions, which translations do not move.
 */
#include <math.h>
#include <string.h>

#include "halflight/calibration.h"
#include "halflight/vec3.h"

/* The point seen at a pixel at a distance, or its direction, with project()'s derivatives there. */
typedef struct seen_point {
  double x[3];
  bool at_infinity;
  double by_point[2][3];
  double by_intrinsics[2][HL_INTRINSICS_MAX];
} seen_point;

static hl_status look(hl_ctx *ctx, const hl_camera *camera, const double pixel[2],
                      double distance_m, seen_point *out)
{
  double ray[3], back[2];
  const hl_status st = hl_camera_unproject(ctx, camera, pixel[0], pixel[1], ray);
  if (st != HL_OK)
    return st;
  out->at_infinity = !isfinite(distance_m);
  for (int i = 0; i < 3; i++)
    out->x[i] = out->at_infinity ? ray[i] : distance_m * ray[i];
  return hl_camera_project_derivatives(ctx, camera, out->x, back, out->by_point,
                                       out->by_intrinsics);
}

/* P D_i: how the pixel follows the pose of one board that the point is fixed to. */
static void by_board(const seen_point *p, const hl_pose *pose, double out[2][HL_POSE_SIZE])
{
  hl_pose to_board, turn = *pose;
  double fixed[3], moved[3], by_pose[3][HL_POSE_SIZE];
  if (p->at_infinity)
    memset(turn.translation_m, 0, sizeof turn.translation_m);
  hl_pose_inverse(&turn, &to_board);
  hl_pose_apply(&to_board, p->x, fixed, NULL, NULL);
  hl_pose_apply(&turn, fixed, moved, by_pose, NULL);
  for (int i = 0; i < 2; i++)
    for (int k = 0; k < HL_POSE_SIZE; k++) {
      out[i][k] = p->by_point[i][0] * by_pose[0][k] + p->by_point[i][1] * by_pose[1][k] +
                  p->by_point[i][2] * by_pose[2][k];
      if (p->at_infinity && k >= 3)
        out[i][k] = 0;
    }
}

/* out += scale a M a', M packed n x n, a of `stride` columns. */
static void add_square(const double *a, int stride, const double *m, int n, double scale,
                       double out[2][2])
{
  for (int i = 0; i < 2; i++)
    for (int k = 0; k < 2; k++) {
      double sum = 0;
      for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++)
          sum += a[i * stride + r] * m[r * n + c] * a[k * stride + c];
      out[i][k] += scale * sum;
    }
}

static int views_used(const hl_calibration *c)
{
  int n = 0;
  for (int i = 0; i < c->n_views; i++)
    n += c->view[i].used;
  return n;
}

hl_status hl_projection_covariance(hl_ctx *ctx, const hl_calibration *c, const double pixel[2],
                                   double distance_m, double out_px2[2][2])
{
  const int n = hl_camera_intrinsics_count(&c->camera);
  const int views = views_used(c);
  seen_point point;
  double sum[2][2] = {{0}};
  if (!(distance_m > 0))
    return hl_fail(ctx, HL_ERR_ARG, "distance_m = %g; one above 0, or infinity, is needed",
                   distance_m);
  if (views == 0 || !c->camera.has_covariance)
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "the camera has no %s; the projection's uncertainty needs a calibration's views "
                   "and covariance",
                   views == 0 ? "views" : "covariance");
  const hl_status st = look(ctx, &c->camera, pixel, distance_m, &point);
  if (st != HL_OK)
    return st;
  double by[2][HL_INTRINSICS_MAX];
  memcpy(by, point.by_intrinsics, sizeof by);
  for (int v = 0; v < c->n_views; v++) {
    const hl_view_pose *view = &c->view[v];
    double board[2][HL_POSE_SIZE];
    if (!view->used)
      continue;
    by_board(&point, &view->cam_from_board, board);
    for (int i = 0; i < 2; i++)
      for (int k = 0; k < n; k++)
        for (int j = 0; j < HL_POSE_SIZE; j++)
          by[i][k] += board[i][j] * view->by_intrinsics[j][k] / views;
    add_square(board[0], HL_POSE_SIZE, view->own_covariance[0], HL_POSE_SIZE,
               1.0 / ((double)views * views), sum);
  }
  add_square(by[0], HL_INTRINSICS_MAX, c->camera.covariance, n, 1, sum);
  sum[0][1] = sum[1][0] = (sum[0][1] + sum[1][0]) / 2;
  memcpy(out_px2, sum, sizeof sum);
  return HL_OK;
}

hl_status hl_calibration_project(hl_ctx *ctx, hl_calibration *calibration, const double pixel[2],
                                 double distance_m)
{
  hl_projection p = {.pixel = {pixel[0], pixel[1]}, .distance_m = distance_m};
  if (calibration->n_projections >= HL_PROJECTIONS_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "more than %d pixels to state the projection's uncertainty at",
                   HL_PROJECTIONS_MAX);
  const hl_status st =
      hl_projection_covariance(ctx, calibration, pixel, distance_m, p.covariance_px2);
  if (st == HL_OK)
    calibration->projection[calibration->n_projections++] = p;
  return st;
}
