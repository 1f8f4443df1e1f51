/* A ball's pose from the outlines of several frames.
 *
 * One frame shows the lit side of the rim well and the dark one hardly; frames lit from many sides show
 * all of it. Each outline's pose c_i with its covariance C_i enters the weighted mean
 *
 *   c = (sum C_i^-1)^-1 sum C_i^-1 c_i
 *
 * from the median on, those further than chi^2 allows left out, where C_i is scaled by what the poses
 * scatter beyond it. What a straight rim and its blur leave of a true ball is common to all frames and
 * does not average out: `common_px` stays.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cholesky.h"
#include "halflight/vec3.h"
#include "replay_work.h"

static const double common_px = 0.006;    /* as in calib/sphere_locate.c */
static const double least_blur_px = 0.02; /* none, and known: 0 would be found in each frame */
static const double chi2_3_median = 2.366, chi2_3_999 = 16.27;

enum { STARTS = 5, ROUNDS = 8 };

typedef struct outline {
  bool seen, used;
  double center[3], covariance[3][3], blur_px;
} outline;

hl_status hl_replay_read(hl_ctx *ctx, const hl_replay_run *run, int i, hl_frame *out)
{
  const hl_session *s = run->session;
  char *path = NULL;
  hl_status st = hl_session_path(ctx, s, s->frame[i].file, &path);
  if (st == HL_OK)
    st = hl_frame_read(ctx, path, &s->frame_settings, out);
  if (st == HL_OK && (out->width != run->camera.width || out->height != run->camera.height)) {
    st =
        hl_fail(ctx, HL_ERR_FORMAT,
                "%s: the frame has %d x %d px, the camera %d x %d; frames of the camera's size are "
                "needed",
                path, out->width, out->height, run->camera.width, run->camera.height);
    hl_frame_free(out);
  }
  free(path);
  return st;
}

hl_sphere_settings hl_replay_near(const hl_session_ball *ball)
{
  hl_sphere_settings s = hl_sphere_defaults();
  if (ball->circle_px[2] > 0) {
    s.hint_x_px = ball->circle_px[0];
    s.hint_y_px = ball->circle_px[1];
    s.hint_radius_px = ball->circle_px[2];
  }
  return s;
}

bool hl_replay_invert(const double a[3][3], double out[3][3])
{
  double factor[9];
  memcpy(factor, a, sizeof factor);
  if (hl_cholesky(factor, 3, 3, 1e-14) > 0)
    return false;
  for (int j = 0; j < 3; j++) {
    double x[3] = {j == 0, j == 1, j == 2};
    hl_cholesky_solve(factor, 3, 3, x);
    for (int i = 0; i < 3; i++)
      out[i][j] = x[i];
  }
  return true;
}

double hl_replay_distance2(const double difference[3], const double covariance[3][3])
{
  double inverse[3][3], sum = 0;
  if (!hl_replay_invert(covariance, inverse))
    return 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      sum += difference[i] * inverse[i][j] * difference[j];
  return sum;
}

double hl_replay_moved_px(const hl_replay_run *run, const hl_sphere *common, const hl_sphere *own)
{
  double a[2], b[2];
  if (hl_camera_project(NULL, &run->camera, common->center_m, a) != HL_OK ||
      hl_camera_project(NULL, &run->camera, own->center_m, b) != HL_OK)
    return 0;
  const double focal = sqrt(run->camera.fx * run->camera.fy);
  const double r = focal * common->radius_m / hl_norm(common->center_m);
  const double grown = r * fabs(hl_norm(common->center_m) / hl_norm(own->center_m) - 1);
  return fmax(hypot(a[0] - b[0], a[1] - b[1]), grown);
}

static int compare(const void *a, const void *b)
{
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double median(double *values, int n)
{
  qsort(values, (size_t)n, sizeof *values, compare);
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

static int gather(const outline *o, int n, double *room, int axis)
{
  int m = 0;
  for (int i = 0; i < n; i++)
    if (o[i].seen)
      room[m++] = o[i].center[axis];
  return m;
}

static void difference_of(const outline *o, const double center[3], double out[3])
{
  hl_add_scaled(o->center, -1, center, out);
}

/* Weighted mean of those in use; false where they do not determine it. */
static bool mean(const outline *o, int n, double center[3], double covariance[3][3])
{
  double sum[3][3] = {{0}}, right[3] = {0}, inverse[3][3];
  for (int i = 0; i < n; i++) {
    if (!o[i].used || !hl_replay_invert(o[i].covariance, inverse))
      continue;
    for (int j = 0; j < 3; j++)
      for (int k = 0; k < 3; k++) {
        sum[j][k] += inverse[j][k];
        right[j] += inverse[j][k] * o[i].center[k];
      }
  }
  if (!hl_replay_invert(sum, covariance))
    return false;
  for (int j = 0; j < 3; j++)
    center[j] = hl_dot(covariance[j], right);
  return true;
}

/* Which outlines agree with `center`, and how much more they scatter than they state. */
static double choose(outline *o, int n, const double center[3], double *room)
{
  double d[3];
  int m = 0;
  for (int i = 0; i < n; i++)
    if (o[i].seen) {
      difference_of(&o[i], center, d);
      room[m++] = hl_replay_distance2(d, o[i].covariance);
    }
  const double excess = fmax(1, median(room, m) / chi2_3_median);
  for (int i = 0; i < n; i++) {
    difference_of(&o[i], center, d);
    o[i].used = o[i].seen && hl_replay_distance2(d, o[i].covariance) <= chi2_3_999 * excess;
  }
  return excess;
}

/* The part that all outlines share. */
static void add_common(const hl_replay_run *run, const hl_sphere *ball, double out[3][3])
{
  const double distance = hl_norm(ball->center_m),
               turn = common_px / sqrt(run->camera.fx * run->camera.fy);
  const double opening = asin(ball->radius_m / distance);
  const double across = distance * turn, along = distance * turn / tan(opening);
  double axis[3];
  hl_unit(ball->center_m, axis);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      out[i][j] +=
          across * across * ((i == j) - axis[i] * axis[j]) + along * along * axis[i] * axis[j];
}

static bool combine(const hl_replay_run *run, outline *o, int n, double *room, hl_replay_ball *ball)
{
  double center[3], covariance[3][3];
  int used = 0;
  for (int axis = 0; axis < 3; axis++) {
    const int m = gather(o, n, room, axis);
    if (m == 0)
      return false;
    center[axis] = median(room, m);
  }
  for (int round = 0; round < ROUNDS; round++) {
    ball->excess = choose(o, n, center, room);
    if (!mean(o, n, center, covariance))
      return false;
  }
  for (int i = 0; i < n; i++)
    used += o[i].used;
  memcpy(ball->pose.center_m, center, sizeof center);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      covariance[i][j] *= ball->excess;
  add_common(run, &ball->pose, covariance);
  ball->n_outlines = used;
  ball->pose.has_covariance = true;
  memcpy(ball->pose.covariance_m2, covariance, sizeof covariance);
  if (ball->pose.n_intrinsics == 0)
    return true;
  /* the camera's share follows the start's own response */
  const double(*by)[HL_INTRINSICS_MAX] =
      (const double(*)[HL_INTRINSICS_MAX])ball->pose.by_intrinsics;
  const int q = ball->pose.n_intrinsics;
  memcpy(ball->pose.held_covariance_m2, covariance, sizeof covariance);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      for (int k = 0; k < q; k++)
        for (int l = 0; l < q; l++)
          ball->pose.covariance_m2[i][j] += by[i][k] * run->camera.covariance[k * q + l] * by[j][l];
  return true;
}

static void keep_outline(const hl_sphere *pose, const hl_sphere_fit *fit, outline *out)
{
  /* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): checked where it is made */
  out->seen = true;
  out->blur_px = fmax(fit->blur_px, least_blur_px);
  memcpy(out->center, pose->center_m, sizeof out->center);
  memcpy(out->covariance, pose->n_intrinsics > 0 ? pose->held_covariance_m2 : pose->covariance_m2,
         sizeof out->covariance);
}

static double size_of(const hl_sphere *s)
{
  return s->covariance_m2[0][0] + s->covariance_m2[1][1] + s->covariance_m2[2][2];
}

/* The surest of the first few frames that show the ball. */
static hl_status start(hl_ctx *ctx, const hl_replay_run *run, int b, int n, int stride,
                       hl_sphere *out, double *blur_px)
{
  const hl_session_ball *ball = &run->session->ball[b];
  const hl_sphere_settings settings = hl_replay_near(ball);
  hl_ctx first = {0}, inner = {0};
  int found = 0;
  for (int k = 0; k < n && found < STARTS; k++) {
    hl_frame frame;
    hl_sphere one;
    hl_sphere_fit fit;
    hl_status st = hl_replay_read(&inner, run, k * stride, &frame);
    if (st == HL_OK) {
      st = hl_sphere_locate(&inner, &frame, &run->camera, ball->radius_m, &settings, &one, &fit);
      hl_frame_free(&frame);
    }
    if (st != HL_OK && first.status == HL_OK)
      first = inner;
    if (st != HL_OK)
      continue;
    if (found++ > 0 && size_of(&one) >= size_of(out))
      continue;
    *out = one;
    *blur_px = fmax(fit.blur_px, least_blur_px);
  }
  return found > 0 ? HL_OK
                   : hl_fail(ctx, HL_ERR_DEGENERATE, "no frame shows ball %d; the first: %s", b,
                             first.msg);
}

typedef struct reading {
  hl_replay_run *run;
  int n, stride;
  outline *outline; /* shape (n_balls, n) */
} reading;

static void read_one(const reading *r, int k)
{
  hl_frame frame;
  if (hl_replay_read(NULL, r->run, k * r->stride, &frame) != HL_OK)
    return;
  for (int b = 0; b < r->run->n_balls; b++) {
    hl_sphere one;
    hl_sphere_fit fit;
    hl_sphere_settings s = hl_sphere_defaults();
    s.blur_px = r->run->ball[b].blur_px;
    if (hl_sphere_relocate(NULL, &frame, &r->run->camera, &r->run->ball[b].pose, &s, &one, &fit) ==
        HL_OK)
      keep_outline(&one, &fit, &r->outline[b * r->n + k]);
  }
  hl_frame_free(&frame);
}

static bool asked_to_stop(hl_replay_run *run)
{
  if (run->watch && run->watch->stop && run->watch->stop(run->watch->user))
    run->stopped = true;
  return run->stopped;
}

static void read_outlines(const reading *r)
{
#pragma omp parallel for schedule(dynamic) num_threads(r->run->jobs)
  for (int k = 0; k < r->n; k++) {
    bool stop;
    pthread_mutex_lock(&r->run->guard);
    stop = asked_to_stop(r->run);
    pthread_mutex_unlock(&r->run->guard);
    if (!stop)
      read_one(r, k);
  }
}

static hl_status find_starts(hl_ctx *ctx, hl_replay_run *run, int n, int stride)
{
  hl_status st = HL_OK;
  for (int b = 0; b < run->n_balls && st == HL_OK; b++) {
    const hl_session_ball *ball = &run->session->ball[b];
    run->ball[b].given = ball->sphere != NULL;
    run->ball[b].excess = 1;
    if (!ball->sphere) {
      st = ball->radius_m > 0
               ? start(ctx, run, b, n, stride, &run->ball[b].pose, &run->ball[b].blur_px)
               : hl_fail(ctx, HL_ERR_FORMAT,
                         "ball %d has neither sphere nor radius_m; one of the two is needed", b);
      continue;
    }
    char *path = NULL;
    st = hl_session_path(ctx, run->session, ball->sphere, &path);
    if (st == HL_OK)
      st = hl_sphere_read(ctx, path, &run->ball[b].pose);
    free(path);
  }
  return st;
}

static double median_blur(const outline *o, int n, double *room)
{
  int m = 0;
  for (int i = 0; i < n; i++)
    if (o[i].seen)
      room[m++] = o[i].blur_px;
  return m > 0 ? median(room, m) : 0;
}

hl_status hl_replay_pose(hl_ctx *ctx, hl_replay_run *run)
{
  const int total = run->session->n, most = run->settings.pose_frames;
  const int stride = (total + most - 1) / most, n = (total + stride - 1) / stride;
  hl_status st = find_starts(ctx, run, n, stride);
  if (st != HL_OK)
    return st;
  reading r = {run, n, stride, calloc((size_t)n * (size_t)run->n_balls, sizeof *r.outline)};
  double *room = malloc((size_t)n * sizeof *room);
  if (!r.outline || !room)
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d outlines", n);
  if (st == HL_OK)
    read_outlines(&r);
  for (int b = 0; b < run->n_balls && st == HL_OK; b++)
    run->ball[b].blur_px = median_blur(r.outline + (size_t)b * (size_t)n, n, room);
  for (int b = 0; b < run->n_balls && st == HL_OK && !run->stopped; b++)
    if (!run->ball[b].given &&
        !combine(run, r.outline + (size_t)b * (size_t)n, n, room, &run->ball[b]))
      st = hl_fail(
          ctx, HL_ERR_DEGENERATE,
          "ball %d: the outlines of %d frames give no pose; its sphere in session.json would help",
          b, n);
  free(r.outline);
  free(room);
  return st;
}
