/*
 * One new view of a board that has not moved, against the reference.
 *
 * The reference states intrinsics theta_0 = true + e, e = L w, and the board's pose b_0 = true + h + G e
 * (its own corners' error h, and its following the intrinsics). With M = exp(m) the mount's motion and
 * d the change of the intrinsics since, a corner is now seen at
 *
 *   q = project(theta_0 - e + d, M (b_0 - h - G e)) + noise
 *
 * so that, with Q = dq/d(theta), P = dq by a motion after M b_0, A what turns a change of b_0 into such
 * a motion (hl_pose_adjoint, hl_pose_motion), the residual of the prediction is
 *
 *   r = Q d + P m - (Q + P A G) L w - P A h + noise
 *
 * Q + P A G is what the intrinsics' error still does after the pose has followed it: of what they do
 * to a board the pose has taken up nearly all, and only the difference counts against the camera. w
 * and h are free unknowns with their stated spread; the triangle of (d, m) is the evidence
 * (drift_parts.c). One view does not tell every change apart, which the ranks there see to.
 *
 * So that a large motion is seen as it is, the rows are taken at the pose that fits the new view best:
 * r is what that pose leaves plus P times the motion from b_0 to it, which is the same to first order.
 * The pose is nowhere free to hide a change: m is compared with nothing. What no change of camera or
 * mount explains is the new view's own noise; where it is more than the calibration's, it is the one
 * that counts.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "board_pose.h"
#include "drift_parts.h"
#include "drift_projection.h"
#include "drift_sessions.h"
#include "halflight/notes.h"
#include "significance.h"

static const double noise_rate = 1e-3; /* how often the view's noise is called larger wrongly */
static const double same_number = 1e-9;

typedef struct board_view {
  const hl_drift_side *reference;
  const hl_board_pose *board;
  hl_sighting *sighting;
  int n;
  double noise_px;
  hl_pose now, moved; /* the board as it is seen, and the mount's motion that has to be */
  double by_cause[HL_POSE_SIZE][HL_INTRINSICS_MAX]; /* A G L */
  double by_own[HL_POSE_SIZE][HL_POSE_SIZE];        /* A times the root of the own covariance */
} board_view;

/* ---- what belongs together ---- */

static bool same_target(const hl_target *a, const hl_target *b)
{
  return a->kind == b->kind && a->columns == b->columns && a->rows == b->rows &&
         fabs(a->size_m - b->size_m) <= same_number * a->size_m &&
         fabs(a->spacing_ratio - b->spacing_ratio) <= same_number;
}

static bool same_camera(const hl_camera *a, const hl_camera *b)
{
  double one[HL_INTRINSICS_MAX], two[HL_INTRINSICS_MAX];
  if (a->model != b->model || a->n_distortion != b->n_distortion)
    return false;
  hl_camera_intrinsics(a, one);
  hl_camera_intrinsics(b, two);
  for (int i = 0; i < hl_camera_intrinsics_count(a); i++)
    if (!(fabs(one[i] - two[i]) <= same_number * (1 + fabs(one[i]))))
      return false;
  return true;
}

static hl_status check(hl_ctx *ctx, const hl_calibration *reference, const hl_board_pose *board,
                       const hl_corners *corners, const hl_drift_settings *settings)
{
  char one[HL_TARGET_SPEC_MAX], two[HL_TARGET_SPEC_MAX];
  const hl_status st = hl_fields_check(ctx, hl_drift_fields(), settings);
  if (st != HL_OK)
    return st;
  if (!same_target(&board->target, &corners->target))
    return hl_fail(ctx, HL_ERR_FORMAT, "the board's pose is that of %s, the view shows %s",
                   hl_target_spec(&board->target, one), hl_target_spec(&corners->target, two));
  if (board->camera.width > 0 && !same_camera(&board->camera, &reference->camera))
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "the board's pose was fitted with another camera file (fx = %.6g there, %.6g "
                   "here); fit it again with this one",
                   board->camera.fx, reference->camera.fx);
  return HL_OK;
}

/* ---- the view ---- */

/* A chessboard counted from its other end is the same board; the end nearer to the prediction is
 * meant. */
static void choose_end(board_view *v)
{
  if (v->board->target.kind != HL_TARGET_CHESSBOARD)
    return;
  const hl_camera *camera = &v->reference->calibration->camera;
  const int last = hl_target_corners(&v->board->target) - 1;
  const double straight = hl_sightings_cost(camera, &v->board->cam_from_board, v->sighting, v->n);
  for (int turn = 0; turn < 2; turn++) {
    for (int i = 0; i < v->n; i++) {
      v->sighting[i].index = last - v->sighting[i].index;
      hl_target_corner(&v->board->target, v->sighting[i].index, v->sighting[i].board_m);
    }
    if (hl_sightings_cost(camera, &v->board->cam_from_board, v->sighting, v->n) < straight)
      return;
  }
}

/* The pose the view shows: from where the board was, and from nothing where that can be had. */
static hl_status see_board(hl_ctx *ctx, board_view *v)
{
  const hl_camera *camera = &v->reference->calibration->camera;
  hl_pose other;
  double cost;
  v->now = v->board->cam_from_board;
  const double least = hl_sightings_refine(camera, v->sighting, v->n, &v->now);
  if (hl_sightings_pose(NULL, camera, v->sighting, v->n, &other, &cost) == HL_OK &&
      cost < least * (1 - same_number))
    v->now = other;
  else if (!isfinite(least))
    return hl_fail(ctx, HL_ERR_DEGENERATE, "no pose of the board explains its %d corners", v->n);
  hl_pose_inverse(&v->board->cam_from_board, &other);
  hl_pose_compose(&v->now, &other, &v->moved);
  return HL_OK;
}

/* A, and with it what the reference's errors do to the prediction as motions. */
static hl_status spread_pose(hl_ctx *ctx, board_view *v)
{
  const hl_board_pose *b = v->board;
  double motion[HL_POSE_SIZE][HL_POSE_SIZE], adjoint[HL_POSE_SIZE][HL_POSE_SIZE];
  double root[HL_POSE_SIZE][HL_POSE_SIZE] = {{0}}, a[HL_POSE_SIZE][HL_POSE_SIZE] = {{0}};
  if (!b->has_covariance)
    return HL_OK;
  if (!hl_drift_lower(b->covariance[0], HL_POSE_SIZE, HL_POSE_SIZE, root[0]))
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "the board pose's covariance is singular; a pose fitted to a view is needed");
  hl_pose_motion(&b->cam_from_board, motion);
  hl_pose_adjoint(&v->moved, adjoint);
  for (int i = 0; i < HL_POSE_SIZE; i++)
    for (int k = 0; k < HL_POSE_SIZE; k++)
      for (int j = 0; j < HL_POSE_SIZE; j++)
        a[i][k] += adjoint[i][j] * motion[j][k];
  for (int i = 0; i < HL_POSE_SIZE; i++)
    for (int k = 0; k < HL_POSE_SIZE; k++) {
      for (int j = k; j < HL_POSE_SIZE; j++)
        v->by_own[i][k] += a[i][j] * root[j][k];
      for (int c = 0; c < v->reference->n; c++)
        for (int j = c; j < v->reference->n; j++)
          v->by_cause[i][c] += a[i][k] * b->by_intrinsics[k][j] * v->reference->lower[j][c];
    }
  return HL_OK;
}

/* ---- the equations ---- */

/* A corner at a pose of the board: what is left of it, and how it follows intrinsics (Q) and a motion
 * of the camera (P). False where it is not in front. */
static bool corner_at(const board_view *v, const hl_sighting *s, const hl_pose *pose,
                      double left[2], double by_theta[2][HL_INTRINSICS_MAX],
                      double by_motion[2][HL_POSE_SIZE])
{
  double point[3], pixel[2], by_point[2][3];
  hl_pose_apply(pose, s->board_m, point, NULL, NULL);
  if (hl_camera_project_derivatives(NULL, &v->reference->calibration->camera, point, pixel,
                                    by_point, by_theta) != HL_OK)
    return false;
  for (int i = 0; i < 2; i++) {
    const double *p = by_point[i];
    left[i] = s->pixel[i] - pixel[i];
    by_motion[i][0] = p[2] * point[1] - p[1] * point[2];
    by_motion[i][1] = p[0] * point[2] - p[2] * point[0];
    by_motion[i][2] = p[1] * point[0] - p[0] * point[1];
    memcpy(by_motion[i] + 3, p, 3 * sizeof *p);
  }
  return true;
}

/* What the reference's unit-noise errors w, then h, do to a row. */
static void row_causes(const board_view *v, const double *by_theta, const double *by_motion,
                       double *out)
{
  const int n = v->reference->n;
  for (int c = 0; c < n; c++) {
    out[c] = 0;
    for (int j = c; j < n; j++)
      out[c] -= by_theta[j] * v->reference->lower[j][c];
    for (int k = 0; k < HL_POSE_SIZE; k++)
      out[c] -= by_motion[k] * v->by_cause[k][c];
  }
  for (int c = 0; c < HL_POSE_SIZE; c++) {
    out[n + c] = 0;
    for (int k = 0; k < HL_POSE_SIZE; k++)
      out[n + c] -= by_motion[k] * v->by_own[k][c];
  }
}

static hl_status build(hl_ctx *ctx, const board_view *v, const double *scale, hl_triangle *out)
{
  const int n = v->reference->n, causes = n + HL_POSE_SIZE;
  hl_triangle_clear(out, 2 * causes);
  for (int i = 0; i < causes; i++) {
    double row[HL_TRIANGLE_MAX] = {0};
    row[i] = 1;
    hl_triangle_add(out, row, 0);
  }
  for (int c = 0; c < v->n; c++) {
    const hl_sighting *s = &v->sighting[c];
    const double weight = s->weight / v->noise_px;
    double left[2], by_theta[2][HL_INTRINSICS_MAX], by_motion[2][HL_POSE_SIZE];
    if (!corner_at(v, s, &v->now, left, by_theta, by_motion))
      return hl_fail(ctx, HL_ERR_DEGENERATE, "a corner of the board lies behind the camera");
    for (int i = 0; i < 2; i++) {
      double row[HL_TRIANGLE_MAX], datum = left[i];
      row_causes(v, by_theta[i], by_motion[i], row);
      for (int k = 0; k < n; k++)
        row[causes + k] = by_theta[i][k] * scale[k];
      for (int k = 0; k < 3; k++) {
        row[causes + n + k] = by_motion[i][k];
        row[causes + n + 3 + k] = by_motion[i][3 + k];
        datum += by_motion[i][k] * v->moved.rotation_rad[k] +
                 by_motion[i][3 + k] * v->moved.translation_m[k];
      }
      for (int k = 0; k < 2 * causes; k++)
        row[k] *= weight;
      hl_triangle_add(out, row, weight * datum);
    }
  }
  return HL_OK;
}

/* The evidence, with the noise that the view itself shows where that is more. */
static hl_status weigh(hl_ctx *ctx, board_view *v, hl_evidence *out, hl_notes *notes)
{
  const int n = v->reference->n;
  const double dof = 2.0 * v->n - n - HL_POSE_SIZE;
  double scale[HL_CHANGES_MAX] = {0}, noise_dof = v->reference->noise_dof;
  hl_triangle triangle;
  for (int i = 0; i < n + HL_POSE_SIZE; i++) {
    scale[i] = i >= n;
    for (int k = 0; i < n && k <= i; k++)
      scale[i] = hypot(scale[i], v->reference->lower[i][k]);
  }
  const bool stated = v->noise_px > 0;
  if (!stated)
    v->noise_px = 1;
  hl_status st = build(ctx, v, scale, &triangle);
  if (st == HL_OK && (!stated || hl_significance(triangle.rest, dof, noise_dof) < noise_rate)) {
    const double seen = v->noise_px * sqrt(triangle.rest / dof);
    if (stated)
      hl_notes_add(notes, "corner noise",
                   "%.3g px along an axis in this view, %.3g px in the calibration: blurred, or a "
                   "corner missed; the view's own is used",
                   seen, v->noise_px);
    else
      hl_notes_add(notes, "corner noise",
                   "the camera states no rms_px; the view's own %.3g px is used", seen);
    v->noise_px = seen;
    noise_dof = dof;
    st = build(ctx, v, scale, &triangle);
  }
  if (st == HL_OK)
    hl_evidence_of(&triangle, n + HL_POSE_SIZE, scale, noise_dof, out);
  return st;
}

/* ---- what a user sees ---- */

/* Seen minus predicted at the corners, with what the prediction and the corner itself explain. */
static void fill_nodes(const board_view *v, hl_drift *out)
{
  const int room = HL_DRIFT_GRID * HL_DRIFT_GRID, causes = v->reference->n + HL_POSE_SIZE;
  const int nodes = v->n < room ? v->n : room;
  double sum = 0;
  int seen = 0;
  for (int c = 0; c < v->n; c++) {
    const hl_sighting *s = &v->sighting[c];
    const int k = (int)((long)c * nodes / v->n);
    double left[2] = {0}, by_theta[2][HL_INTRINSICS_MAX], by_motion[2][HL_POSE_SIZE];
    double by[2][HL_CHANGES_MAX], spread[2][2] = {{0}};
    const bool good = corner_at(v, s, &v->board->cam_from_board, left, by_theta, by_motion);
    for (int i = 0; good && i < 2; i++)
      row_causes(v, by_theta[i], by_motion[i], by[i]);
    for (int i = 0; good && i < 2; i++)
      for (int j = 0; j < 2; j++) {
        spread[i][j] = i == j ? v->noise_px * v->noise_px / (s->weight * s->weight) : 0;
        for (int a = 0; a < causes; a++)
          spread[i][j] += by[i][a] * by[j][a];
      }
    for (int i = 0; i < 2; i++) {
      out->at_px[k][i] = s->pixel[i] - (good ? left[i] : 0);
      out->difference_px[k][i] = good ? left[i] : NAN;
    }
    out->sigma_px[k] = good ? hl_drift_deviation(left, (const double(*)[2])spread) : NAN;
    if (!good)
      continue;
    const double length = hypot(left[0], left[1]);
    sum += length;
    out->max_px = fmax(out->max_px, length);
    seen++;
  }
  out->mean_px = seen > 0 ? sum / seen : NAN;
  out->n_nodes = nodes;
  out->implied = v->moved;
}

/* Mean over the corners of what a change of the distortion does to them, as hl_drift_effect has it for
 * the frame: what the view says nothing about is not spoken of. */
static void distortion_metric(const board_view *v, hl_part *part)
{
  memset(part->metric, 0, sizeof part->metric);
  for (int c = 0; c < v->n; c++) {
    double left[2], by_theta[2][HL_INTRINSICS_MAX], by_motion[2][HL_POSE_SIZE];
    if (!corner_at(v, &v->sighting[c], &v->now, left, by_theta, by_motion))
      continue;
    for (int i = 0; i < 2; i++)
      for (int a = 0; a < part->n; a++)
        for (int b = 0; b < part->n; b++)
          part->metric[a][b] += by_theta[i][part->first + a] * by_theta[i][part->first + b] / v->n;
  }
}

static void note_limits(const hl_board_pose *board, hl_drift *out)
{
  bool mount = false;
  for (int i = 0; i < out->n_causes; i++)
    mount = mount || (out->cause[i].moved && strcmp(out->cause[i].what, "mount") == 0);
  if (mount)
    hl_notes_add(&out->notes, "mount", "a board that has moved itself looks the same");
  if (!board->has_covariance)
    hl_notes_add(&out->notes, "board pose", "states no covariance; it is taken as exact");
}

hl_status hl_drift_board(hl_ctx *ctx, const hl_calibration *reference, const hl_board_pose *board,
                         const hl_corners *corners, int view, const hl_drift_settings *settings,
                         hl_drift *out)
{
  const hl_drift_settings s = settings ? *settings : hl_drift_defaults();
  hl_drift d = {.false_alarm = s.false_alarm,
                .width = reference->camera.width,
                .height = reference->camera.height};
  hl_drift_side side;
  hl_evidence evidence;
  board_view v = {.reference = &side, .board = board, .noise_px = hl_board_noise(reference)};
  hl_status st = check(ctx, reference, board, corners, &s);
  if (st == HL_OK)
    st = hl_drift_side_of(ctx, "reference", reference, &side, &d.notes);
  if (st == HL_OK)
    st = hl_board_sightings(ctx, &reference->camera, corners, view, &v.sighting, &v.n);
  if (st == HL_OK) {
    choose_end(&v);
    st = see_board(ctx, &v);
  }
  if (st == HL_OK)
    st = spread_pose(ctx, &v);
  if (st == HL_OK)
    st = weigh(ctx, &v, &evidence, &d.notes);
  if (st == HL_OK) {
    hl_part part[HL_DRIFT_CAUSES_MAX];
    const int n = hl_drift_parts(&reference->camera, true, part);
    for (int p = 0; p < n; p++)
      if (strcmp(part[p].part, "distortion") == 0)
        distortion_metric(&v, &part[p]);
    hl_parts_judge(&evidence, part, n, &d);
    fill_nodes(&v, &d);
    note_limits(board, &d);
    *out = d;
  }
  free(v.sighting);
  return st;
}
