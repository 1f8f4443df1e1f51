/*
 * Two calibrations as evidence of what changed between them.
 *
 * Calibration k states theta_k = its true intrinsics + e_k, Cov(e_k) = L_k L_k', so e_k = L_k w_k with
 * w_k of unit covariance. With d the true change of the intrinsics, e_1 = theta_1 - theta_0 - d + e_0:
 *
 *   0                           = w_0                      + unit noise
 *   L_1^-1 (theta_1 - theta_0)  = L_1^-1 (d - L_0 w_0)     + unit noise
 *
 * Where a board stood still, its poses in both give the mount's motion, T_i = P_1i P_0i^-1, in error
 * by what its corners say themselves (own_k) and by its pose's following the intrinsics' errors
 * (G_k e_k), which all boards share. With M = exp(m) the mount's motion, t_i the motion T_i M^-1, J_k
 * the motion that a change of pose k makes (after M, for the reference's), G_k' = J_k G_k:
 *
 *   t_i - G_1i' (theta_1 - theta_0) = m - G_1i' d + (G_1i' - G_0i') L_0 w_0 + noise,
 *   Cov(noise) = J_1 own_1i J_1' + J_0 own_0i J_0'
 *
 * w_0 is free, so the triangle of (d, m) is the evidence (drift_parts.c), and what no solution
 * explains is chi-squared with 6 V - 6 degrees of freedom where V boards stood still. The two are
 * independent, so that leaving the mount out where they did not, changes no rate of false alarms.
 * M is found by repeating this from where it came out.
 *
 * Poses are in this as they are in the covariance of the intrinsics: free. So a centre that moved as a
 * rotation would have it is judged by what the boards, not the wish, say about the difference.
 *
 * The two sides' noises are known from different numbers of residuals: the fewer count for both, which
 * is on the safe side (Hsu 1938).
 */
#include "drift_sessions.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/notes.h"
#include "significance.h"

enum { ROUNDS = 20 };

static const double settled = 1e-12;     /* rad, m */
static const double settled_rest = 1e-9; /* of itself */

/* ---- boards of the same names ---- */

typedef struct board_pair {
  const hl_view_pose *reference, *current;
} board_pair;

/* The file's name without its folder. */
static const char *short_name(const char *name)
{
  const char *slash = strrchr(name, '/');
  return slash ? slash + 1 : name;
}

/* The only used view of that name; NULL where there is none or several. */
static const hl_view_pose *only_view(const hl_calibration *c, const char *name)
{
  const hl_view_pose *found = NULL;
  for (int i = 0; i < c->n_views; i++) {
    if (!c->view[i].used || strcmp(short_name(c->view[i].name), name) != 0)
      continue;
    if (found)
      return NULL;
    found = &c->view[i];
  }
  return found;
}

static int find_pairs(const hl_calibration *reference, const hl_calibration *current,
                      board_pair *out)
{
  int n = 0;
  for (int i = 0; i < reference->n_views; i++) {
    const hl_view_pose *view = &reference->view[i];
    const char *name = short_name(view->name);
    const hl_view_pose *partner = only_view(current, name);
    if (partner && view->used && only_view(reference, name) == view)
      out[n++] = (board_pair){view, partner};
  }
  return n;
}

/* ---- the equations ---- */

enum { ROW = HL_TRIANGLE_MAX + 1 };

/* Unknowns w_0, then d / scale, then m. */
typedef struct comparison {
  const hl_drift_side *reference, *current;
  int n;
  double difference[HL_INTRINSICS_MAX];
  double scale[HL_CHANGES_MAX];
  hl_pose mount;
  const board_pair *pair;
  int n_pairs;
} comparison;

/* Their last column is the datum. */
static void add_rows(hl_triangle *triangle, double (*rows)[ROW], int n)
{
  for (int i = 0; i < n; i++)
    hl_triangle_add(triangle, rows[i], rows[i][triangle->n]);
}

static void add_intrinsics(const comparison *c, hl_triangle *triangle)
{
  const int n = c->n;
  double rows[HL_INTRINSICS_MAX][ROW] = {{0}};
  for (int i = 0; i < n; i++)
    rows[i][i] = 1;
  add_rows(triangle, rows, n);
  memset(rows, 0, sizeof rows);
  for (int i = 0; i < n; i++) {
    for (int k = 0; k < n; k++)
      rows[i][k] = -c->reference->lower[i][k];
    rows[i][n + i] = c->scale[i];
    rows[i][triangle->n] = c->difference[i];
  }
  hl_drift_whiten(c->current->lower[0], HL_INTRINSICS_MAX, n, rows[0], triangle->n + 1, ROW);
  add_rows(triangle, rows, n);
}

/* out += a own a' */
static void add_spread(const double (*a)[HL_POSE_SIZE], const double (*own)[HL_POSE_SIZE],
                       double widened, double (*out)[HL_POSE_SIZE])
{
  for (int i = 0; i < HL_POSE_SIZE; i++)
    for (int k = 0; k < HL_POSE_SIZE; k++)
      for (int r = 0; r < HL_POSE_SIZE; r++)
        for (int s = 0; s < HL_POSE_SIZE; s++)
          out[i][k] += widened * a[i][r] * own[r][s] * a[k][s];
}

static void multiply(const double (*a)[HL_POSE_SIZE], const double *b, int columns, int stride,
                     double *out)
{
  for (int i = 0; i < HL_POSE_SIZE; i++)
    for (int c = 0; c < columns; c++) {
      double sum = 0;
      for (int k = 0; k < HL_POSE_SIZE; k++)
        sum += a[i][k] * b[k * stride + c];
      out[i * stride + c] = sum;
    }
}

/* G_1i' - G_0i' and G_1i', the noise's covariance, and t_i. */
typedef struct pair_motion {
  double follows[HL_POSE_SIZE][HL_INTRINSICS_MAX];
  double unlike[HL_POSE_SIZE][HL_INTRINSICS_MAX];
  double spread[HL_POSE_SIZE][HL_POSE_SIZE];
  double motion[HL_POSE_SIZE];
} pair_motion;

static void pose_numbers(const hl_pose *pose, double out[HL_POSE_SIZE])
{
  memcpy(out, pose->rotation_rad, sizeof pose->rotation_rad);
  memcpy(out + 3, pose->translation_m, sizeof pose->translation_m);
}

static pair_motion motion_of(const comparison *c, const board_pair *pair)
{
  pair_motion out = {0};
  hl_pose back, relative;
  double by_current[HL_POSE_SIZE][HL_POSE_SIZE], by_reference[HL_POSE_SIZE][HL_POSE_SIZE];
  double adjoint[HL_POSE_SIZE][HL_POSE_SIZE], moved[HL_POSE_SIZE][HL_POSE_SIZE];
  double behind[HL_POSE_SIZE][HL_INTRINSICS_MAX];
  hl_pose_inverse(&pair->reference->cam_from_board, &back);
  hl_pose_compose(&pair->current->cam_from_board, &back, &relative);
  hl_pose_inverse(&c->mount, &back);
  hl_pose_compose(&relative, &back, &relative);
  pose_numbers(&relative, out.motion);

  hl_pose_motion(&pair->current->cam_from_board, by_current);
  hl_pose_motion(&pair->reference->cam_from_board, by_reference);
  hl_pose_adjoint(&c->mount, adjoint);
  multiply((const double(*)[HL_POSE_SIZE])adjoint, by_reference[0], HL_POSE_SIZE, HL_POSE_SIZE,
           moved[0]);
  multiply((const double(*)[HL_POSE_SIZE])by_current, pair->current->by_intrinsics[0], c->n,
           HL_INTRINSICS_MAX, out.follows[0]);
  multiply((const double(*)[HL_POSE_SIZE])moved, pair->reference->by_intrinsics[0], c->n,
           HL_INTRINSICS_MAX, behind[0]);
  for (int i = 0; i < HL_POSE_SIZE; i++)
    for (int k = 0; k < c->n; k++)
      out.unlike[i][k] = out.follows[i][k] - behind[i][k];
  add_spread((const double(*)[HL_POSE_SIZE])by_current, pair->current->own_covariance,
             c->current->widened, out.spread);
  add_spread((const double(*)[HL_POSE_SIZE])moved, pair->reference->own_covariance,
             c->reference->widened, out.spread);
  return out;
}

/* False where the boards' stated uncertainty is singular. */
static bool add_board(const comparison *c, const board_pair *pair, hl_triangle *triangle)
{
  const pair_motion m = motion_of(c, pair);
  const int n = c->n;
  double lower[HL_POSE_SIZE][HL_POSE_SIZE], rows[HL_POSE_SIZE][ROW] = {{0}}, mount[HL_POSE_SIZE];
  if (!hl_drift_lower(m.spread[0], HL_POSE_SIZE, HL_POSE_SIZE, lower[0]))
    return false;
  pose_numbers(&c->mount, mount);
  for (int i = 0; i < HL_POSE_SIZE; i++) {
    double datum = m.motion[i] + mount[i];
    for (int k = 0; k < n; k++) {
      for (int j = k; j < n; j++)
        rows[i][k] += m.unlike[i][j] * c->reference->lower[j][k];
      rows[i][n + k] = -m.follows[i][k] * c->scale[k];
      datum -= m.follows[i][k] * c->difference[k];
    }
    rows[i][2 * n + i] = 1;
    rows[i][triangle->n] = datum;
  }
  hl_drift_whiten(lower[0], HL_POSE_SIZE, HL_POSE_SIZE, rows[0], triangle->n + 1, ROW);
  add_rows(triangle, rows, HL_POSE_SIZE);
  return true;
}

/* The problem as it is now; returns how many boards are in it. */
static int build(const comparison *c, hl_triangle *triangle)
{
  int boards = 0;
  hl_triangle_clear(triangle, 2 * c->n + (c->n_pairs > 0 ? HL_POSE_SIZE : 0));
  add_intrinsics(c, triangle);
  for (int i = 0; i < c->n_pairs; i++)
    boards += add_board(c, &c->pair[i], triangle);
  return boards;
}

/* The last six unknowns: the triangle's corner. */
static void solve_mount(const hl_triangle *t, double out[HL_POSE_SIZE])
{
  const int first = t->n - HL_POSE_SIZE;
  for (int i = HL_POSE_SIZE - 1; i >= 0; i--) {
    double sum = t->z[first + i];
    for (int k = i + 1; k < HL_POSE_SIZE; k++)
      sum -= t->r[first + i][first + k] * out[k];
    out[i] = sum / t->r[first + i][first + i];
  }
}

/* The mount's motion that explains the boards best, begun at what the first of them says; returns how
 * many are in it. Boards that were carried about agree on nothing: then it ends where a round no longer
 * explains more. */
static int settle_mount(comparison *c, hl_triangle *triangle)
{
  if (c->n_pairs > 0) {
    hl_pose back;
    hl_pose_inverse(&c->pair[0].reference->cam_from_board, &back);
    hl_pose_compose(&c->pair[0].current->cam_from_board, &back, &c->mount);
  }
  int boards = build(c, triangle);
  for (int i = 0; i < ROUNDS && boards > 0; i++) {
    const hl_pose before = c->mount;
    const double rest = triangle->rest;
    double now[HL_POSE_SIZE], next[HL_POSE_SIZE], step = 0;
    hl_pose by;
    pose_numbers(&before, now);
    solve_mount(triangle, next);
    for (int k = 0; k < 3; k++) {
      by.rotation_rad[k] = next[k] - now[k];
      by.translation_m[k] = next[3 + k] - now[3 + k];
      step = fmax(step, fmax(fabs(by.rotation_rad[k]), fabs(by.translation_m[k])));
    }
    hl_pose_compose(&by, &before, &c->mount);
    boards = build(c, triangle);
    if (step < settled)
      break;
    if (!(triangle->rest <= rest * (1 + settled_rest))) {
      c->mount = before;
      return build(c, triangle);
    }
  }
  return boards;
}

static int views_used(const hl_calibration *c)
{
  int n = 0;
  for (int i = 0; i < c->n_views; i++)
    n += c->view[i].used;
  return n;
}

static const char *no_pair(const hl_calibration *reference, const hl_calibration *current)
{
  if (views_used(reference) == 0 || views_used(current) == 0)
    return "not compared: a camera states no board poses; 'halflight calibrate' writes them";
  return "not compared: no view of the one has the name of a view of the other";
}

/* Whether the boards stood still, as far as they can tell. */
static bool stood_still(const hl_triangle *triangle, int boards, double noise_dof,
                        double false_alarm, hl_notes *notes)
{
  const double dof = HL_POSE_SIZE * (boards - 1);
  if (boards == 1) {
    hl_notes_add(notes, "mount",
                 "not compared: one board of the same name cannot tell whether it stood still");
    return false;
  }
  if (hl_significance(triangle->rest, dof, noise_dof) >= false_alarm)
    return true;
  hl_notes_add(notes, "mount",
               "not compared: the %d boards of the same names did not stand still between the two "
               "(misfit %.3g times what their uncertainty explains)",
               boards, sqrt(triangle->rest / dof));
  return false;
}

hl_status hl_drift_sessions(hl_ctx *ctx, const hl_drift_side *reference,
                            const hl_drift_side *current, double false_alarm, hl_evidence *out,
                            bool *with_mount, hl_notes *notes)
{
  const double noise_dof = fmin(reference->noise_dof, current->noise_dof);
  const int views = reference->calibration->n_views;
  comparison c = {.reference = reference, .current = current, .n = reference->n};
  board_pair *pair = calloc(views > 0 ? (size_t)views : 1, sizeof *pair);
  hl_triangle triangle;
  if (!pair)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d boards", views);
  for (int i = 0; i < c.n; i++) {
    double variance = 0;
    for (int k = 0; k <= i; k++)
      variance += reference->lower[i][k] * reference->lower[i][k] +
                  current->lower[i][k] * current->lower[i][k];
    c.scale[i] = sqrt(variance);
    c.difference[i] = current->theta[i] - reference->theta[i];
  }
  for (int i = 0; i < HL_POSE_SIZE; i++)
    c.scale[c.n + i] = 1;
  c.pair = pair;
  c.n_pairs = find_pairs(reference->calibration, current->calibration, pair);
  const int boards = settle_mount(&c, &triangle);
  if (boards == 0)
    hl_notes_add(notes, "mount", "%s", no_pair(reference->calibration, current->calibration));
  *with_mount = boards > 0 && stood_still(&triangle, boards, noise_dof, false_alarm, notes);
  if (!*with_mount) {
    c.n_pairs = 0;
    build(&c, &triangle);
  }
  hl_evidence_of(&triangle, c.n, c.scale, noise_dof, out);
  free(pair);
  return HL_OK;
}
