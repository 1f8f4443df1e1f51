/*
 * Two sessions of one rig compared, part by part.
 *
 *   mount       rotation of all lights against none: chi-squared of 3 (rig_turn.c)
 *   direction   each light beside that rotation: chi-squared of 2 (rig_turn.c)
 *   sphere      D = c' - c against Cov(c) + Cov(c'), the camera's share entering once where both
 *               sessions used one calibration: chi-squared of 3. A camera that turned by w carries
 *               the ball along: where the mount is named, w x c is taken off first.
 *   intensity   ln(I'/I) against the weighted mean of all that have not changed, since both are
 *               relative to a median of their session: chi-squared of 1, leaving one out
 *   intrinsics  where the calibrations differ: chi-squared of their number
 *   exposure    recorded, not estimated: any change beyond 0.1 %, which is what sensors round to
 *
 * Each of the K estimated tests is taken at the rate of false alarms over K. A threshold is the
 * figure that would just be an alarm in the direction of the change: figure sqrt(limit / statistic).
 */
#include "halflight/rig_drift.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/notes.h"
#include "halflight/vec3.h"
#include "rig_turn.h"
#include "significance.h"

static const double degrees = 180 / 3.14159265358979323846;
static const double same_exposure = 1e-3, same_radius = 1e-6;

typedef struct rig_run {
  const hl_lights *reference, *current;
  int n;
  hl_rig_pair *pair;
  hl_rig_turn turn;
  bool one_camera, intrinsics;
  double rate; /* of one test */
  hl_rig_drift *out;
} rig_run;

hl_rig_drift_settings hl_rig_drift_defaults(void)
{
  return (hl_rig_drift_settings){.false_alarm = 0.01};
}

const hl_field_table *hl_rig_drift_fields(void)
{
  static const hl_field fields[] = {
      {"false_alarm", HL_FIELD_DOUBLE, offsetof(hl_rig_drift_settings, false_alarm), 1e-12, 0.5, "",
       "how often a rig that has not changed may be called drifted", NULL}};
  static const hl_field_table table = {"rig drift", fields, 1};
  return &table;
}

void hl_rig_drift_free(hl_rig_drift *drift)
{
  free(drift->cause);
  memset(drift, 0, sizeof *drift);
}

static const char *what_of(hl_rig_part part)
{
  static const char *const what[] = {"mount", "intrinsics", "sphere", "light", "light", "exposure"};
  return what[part];
}

static const char *unit_of(hl_rig_part part)
{
  static const char *const unit[] = {"deg", "px", "m", "deg", "relative", "relative"};
  return unit[part];
}

static hl_rig_cause *add(rig_run *r, hl_rig_part part, const char *name, int reference, int current)
{
  hl_rig_cause *c = &r->out->cause[r->out->n_causes++];
  *c = (hl_rig_cause){.part = part,
                      .what = what_of(part),
                      .name = name,
                      .reference = reference,
                      .current = current,
                      .unit = unit_of(part),
                      .threshold = NAN};
  return c;
}

static void judge(const rig_run *r, hl_rig_cause *c, double figure, double statistic, double dof)
{
  const double limit = hl_significance_limit(r->rate, dof, HUGE_VAL);
  c->figure = figure;
  c->significance = hl_significance(statistic, dof, HUGE_VAL);
  c->threshold = statistic > 0 ? figure * sqrt(limit / statistic) : NAN;
  c->moved = statistic > limit;
}

/* d' A^-1 d. A change that A does not explain at all counts as without bound. */
static double square(const double *a, const double *d, int n)
{
  double l[HL_INTRINSICS_MAX * HL_INTRINSICS_MAX], y[HL_INTRINSICS_MAX], sum = 0;
  hl_rig_root(a, n, n, l);
  for (int i = 0; i < n; i++) {
    y[i] = d[i];
    for (int k = 0; k < i; k++)
      y[i] -= l[i * n + k] * y[k];
    if (l[i * n + i] > 0)
      y[i] /= l[i * n + i];
    else
      y[i] = fabs(y[i]) > 1e-12 * fabs(d[i]) ? HUGE_VAL : 0;
    sum += y[i] * y[i];
  }
  return sum;
}

/* ---- parts ---- */

static void compare_mount(rig_run *r)
{
  hl_rig_cause *c = add(r, HL_RIG_MOUNT, "", -1, -1);
  memcpy(c->change, r->turn.rotation_rad, sizeof c->change);
  judge(r, c, degrees * hl_norm(c->change), r->turn.statistic, 3);
}

static void compare_intrinsics(rig_run *r)
{
  const hl_camera *a = &r->reference->camera, *b = &r->current->camera;
  const int n = hl_camera_intrinsics_count(a);
  double p[HL_INTRINSICS_MAX], q[HL_INTRINSICS_MAX], cov[HL_INTRINSICS_MAX * HL_INTRINSICS_MAX];
  if (!r->intrinsics)
    return;
  hl_camera_intrinsics(a, p);
  hl_camera_intrinsics(b, q);
  for (int i = 0; i < n; i++)
    q[i] -= p[i];
  for (int i = 0; i < n * n; i++)
    cov[i] = a->covariance[i] + b->covariance[i];
  hl_rig_cause *c = add(r, HL_RIG_INTRINSICS, "", -1, -1);
  c->change[0] = q[0];
  c->change[1] = q[1];
  judge(r, c, hypot(q[0], q[1]) / sqrt(2), square(cov, q, n), n);
}

/* += J K J' of the camera's share; J may be the difference of two. */
static void add_camera(const hl_camera *camera, const hl_sphere *to, const hl_sphere *from,
                       double cov[9])
{
  const int n = hl_camera_intrinsics_count(camera);
  double j[3][HL_INTRINSICS_MAX];
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < n; k++)
      j[i][k] = to->by_intrinsics[i][k] - (from ? from->by_intrinsics[i][k] : 0);
  for (int i = 0; i < 9; i++)
    for (int k = 0; k < n; k++)
      for (int l = 0; l < n; l++)
        cov[i] += j[i / 3][k] * camera->covariance[k * n + l] * j[i % 3][l];
}

static void sphere_covariance(const rig_run *r, int i, double cov[9])
{
  const hl_sphere *a = &r->reference->ball[i], *b = &r->current->ball[i];
  const bool apart = a->n_intrinsics > 0 && b->n_intrinsics > 0;
  const double *p = apart ? &a->held_covariance_m2[0][0] : &a->covariance_m2[0][0];
  const double *q = apart ? &b->held_covariance_m2[0][0] : &b->covariance_m2[0][0];
  for (int k = 0; k < 9; k++)
    cov[k] = p[k] + q[k];
  if (apart && r->reference->camera.has_covariance && r->current->camera.has_covariance) {
    add_camera(&r->current->camera, b, r->one_camera ? a : NULL, cov);
    if (!r->one_camera)
      add_camera(&r->reference->camera, a, NULL, cov);
  }
}

/* Takes off what the mount's rotation explains; its uncertainty joins that of the change. */
static void take_off_mount(const hl_rig_turn *turn, const double center[3], double change[3],
                           double cov[9])
{
  double carried[3], j[3][3]; /* w x c = J w */
  hl_cross(turn->rotation_rad, center, carried);
  hl_add_scaled(change, -1, carried, change);
  for (int k = 0; k < 3; k++) {
    double column[3], unit[3] = {0};
    unit[k] = 1;
    hl_cross(unit, center, column);
    for (int i = 0; i < 3; i++)
      j[i][k] = column[i];
  }
  for (int i = 0; i < 9; i++)
    for (int k = 0; k < 3; k++)
      for (int l = 0; l < 3; l++)
        cov[i] += j[i / 3][k] * turn->rotation_covariance[k][l] * j[i % 3][l];
}

static void compare_spheres(rig_run *r, bool turned)
{
  for (int i = 0; i < r->reference->n_balls; i++) {
    const hl_sphere *a = &r->reference->ball[i], *b = &r->current->ball[i];
    double cov[9];
    if (!a->has_covariance || !b->has_covariance)
      continue;
    hl_rig_cause *c = add(r, HL_RIG_SPHERE, "", i, i);
    hl_add_scaled(b->center_m, -1, a->center_m, c->change);
    sphere_covariance(r, i, cov);
    if (turned)
      take_off_mount(&r->turn, a->center_m, c->change, cov);
    judge(r, c, hl_norm(c->change), square(cov, c->change, 3), 3);
    if (c->moved && turned)
      hl_notes_add(&r->out->notes, "sphere",
                   "the camera turned, and whether it also shifted or the ball did cannot be told");
  }
}

static void compare_directions(rig_run *r)
{
  for (int i = 0; i < r->n; i++) {
    const hl_rig_rows *rows = &r->turn.rows[i];
    const double left[2] = {rows->root[0][0] * rows->left[0],
                            rows->root[1][0] * rows->left[0] + rows->root[1][1] * rows->left[1]};
    hl_rig_cause *c =
        add(r, HL_RIG_DIRECTION, r->pair[i].name, r->pair[i].reference, r->pair[i].current);
    for (int k = 0; k < 3; k++)
      c->change[k] = left[0] * rows->tangent[0][k] + left[1] * rows->tangent[1][k];
    judge(r, c, degrees * hypot(left[0], left[1]), rows->statistic, 2);
  }
}

/* ---- intensities ---- */

static double mean_intensity(const hl_rig_light *light)
{
  return (light->intensity[0] + light->intensity[1] + light->intensity[2]) / 3;
}

static bool has_intensity(const hl_rig_light *a, const hl_rig_light *b)
{
  return a->intensity_sigma > 0 && b->intensity_sigma > 0 && mean_intensity(a) > 0 &&
         mean_intensity(b) > 0;
}

typedef struct brightness {
  double change, variance; /* of ln(I'/I) */
  hl_rig_cause *cause;     /* NULL: not known */
} brightness;

static void judge_brightness(const rig_run *r, brightness *b, double sum, double weight)
{
  const double own = b->cause->moved ? 0 : 1 / b->variance;
  const double rest = weight - own;
  const double left = b->change - (rest > 0 ? (sum - own * b->change) / rest : 0);
  const double statistic = rest > 0 ? left * left / (b->variance + 1 / rest) : 0;
  b->cause->change[0] = exp(left);
  judge(r, b->cause, fabs(expm1(left)), statistic, 1);
}

/* One round: all against the mean of those not yet named; the one furthest beyond its limit. */
static int worst_brightness(const rig_run *r, brightness *b, const bool *named)
{
  double sum = 0, weight = 0, most = 0;
  int at = -1, still = 0;
  for (int i = 0; i < r->n; i++)
    /* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): the status says there is memory */
    if (b[i].cause && !named[i]) {
      sum += b[i].change / b[i].variance;
      weight += 1 / b[i].variance;
      still++;
    }
  for (int i = 0; i < r->n; i++) {
    if (!b[i].cause)
      continue;
    b[i].cause->moved = named[i];
    judge_brightness(r, &b[i], sum, weight);
    const double excess = b[i].cause->figure / b[i].cause->threshold;
    if (!named[i] && b[i].cause->moved && excess > most) {
      most = excess;
      at = i;
    }
  }
  return still > 2 ? at : -1;
}

static hl_status compare_intensities(hl_ctx *ctx, rig_run *r)
{
  const size_t n = r->n > 0 ? (size_t)r->n : 1;
  brightness *b = calloc(n, sizeof *b);
  bool *named = calloc(n, sizeof *named);
  const hl_status st =
      b && named ? HL_OK : hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d lights", r->n);
  for (int i = 0; st == HL_OK && i < r->n; i++) {
    const hl_rig_pair *pair = &r->pair[i];
    const hl_rig_light *p = &r->reference->light[pair->reference];
    const hl_rig_light *q = &r->current->light[pair->current];
    if (!has_intensity(p, q))
      continue;
    b[i].change = log(mean_intensity(q) / mean_intensity(p));
    b[i].variance =
        p->intensity_sigma * p->intensity_sigma + q->intensity_sigma * q->intensity_sigma;
    b[i].cause = add(r, HL_RIG_INTENSITY, pair->name, pair->reference, pair->current);
  }
  for (int at; st == HL_OK && (at = worst_brightness(r, b, named)) >= 0;)
    /* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): the status says there is memory */
    named[at] = true;
  free(named);
  free(b);
  return st;
}

/* ---- exposure ---- */

static void compare_exposures(rig_run *r)
{
  const hl_rig_pair *furthest = NULL;
  double most = 0, factor = 1;
  int known = 0, off = 0;
  for (int i = 0; i < r->n; i++) {
    const hl_rig_light *a = &r->reference->light[r->pair[i].reference];
    const hl_rig_light *b = &r->current->light[r->pair[i].current];
    const double from = a->exposure_us * a->gain, to = b->exposure_us * b->gain;
    if (!(from > 0 && to > 0))
      continue;
    known++;
    off += fabs(to / from - 1) > same_exposure;
    if (fabs(to / from - 1) >= most) {
      most = fabs(to / from - 1);
      factor = to / from;
      furthest = &r->pair[i];
    }
  }
  if (known == 0) {
    hl_notes_add(&r->out->notes, "exposure", "not compared: the sessions do not state it");
    return;
  }
  hl_rig_cause *c = add(r, HL_RIG_EXPOSURE, off > 0 && off < known ? furthest->name : "", -1, -1);
  c->figure = most;
  c->threshold = same_exposure;
  c->change[0] = factor;
  c->moved = off > 0;
  c->significance = off > 0 ? 0 : 1;
}

/* ---- the whole ---- */

static hl_status check(hl_ctx *ctx, const hl_lights *a, const hl_lights *b)
{
  if (a->camera.width != b->camera.width || a->camera.height != b->camera.height)
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "frames of %d x %d and of %d x %d; sessions of one camera are needed",
                   a->camera.width, a->camera.height, b->camera.width, b->camera.height);
  if (a->n_balls != b->n_balls)
    return hl_fail(ctx, HL_ERR_FORMAT, "%d and %d balls; sessions with the same balls are needed",
                   a->n_balls, b->n_balls);
  for (int i = 0; i < a->n_balls; i++)
    if (fabs(a->ball[i].radius_m - b->ball[i].radius_m) > same_radius)
      return hl_fail(ctx, HL_ERR_FORMAT,
                     "ball %d has a radius of %g m and of %g m; the same balls are needed", i,
                     a->ball[i].radius_m, b->ball[i].radius_m);
  return HL_OK;
}

static void plan_tests(rig_run *r, double false_alarm)
{
  hl_notes *notes = &r->out->notes;
  const hl_camera *a = &r->reference->camera, *b = &r->current->camera;
  int n = 1 + r->n;
  r->one_camera = hl_rig_same_camera(a, b);
  r->intrinsics = !r->one_camera && a->model == b->model && a->has_covariance && b->has_covariance;
  n += r->intrinsics;
  if (r->one_camera)
    hl_notes_add(notes, "intrinsics", "both sessions were seen through one calibration");
  else if (!r->intrinsics)
    hl_notes_add(notes, "intrinsics", "not compared: %s",
                 a->model != b->model ? "the lens models differ" : "a camera states no covariance");
  for (int i = 0; i < r->reference->n_balls; i++)
    n += r->reference->ball[i].has_covariance && r->current->ball[i].has_covariance;
  int dark = 0;
  for (int i = 0; i < r->n; i++)
    /* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): the status says there is memory */
    dark += !has_intensity(&r->reference->light[r->pair[i].reference],
                           &r->current->light[r->pair[i].current]);
  if (dark > 0)
    hl_notes_add(notes, "intensity", "of %d lights not compared: it has no stated deviation", dark);
  r->out->n_tests = n + r->n - dark;
  r->out->false_alarm = false_alarm;
  r->rate = false_alarm / r->out->n_tests;
}

static hl_status compare(hl_ctx *ctx, rig_run *r)
{
  hl_status st = hl_rig_turn_equations(ctx, r->reference, r->current, r->pair, &r->turn);
  if (st == HL_OK)
    st = hl_rig_turn_settle(ctx, hl_significance_limit(r->rate, 2, HUGE_VAL), &r->turn);
  if (st != HL_OK)
    return st;
  compare_mount(r);
  compare_intrinsics(r);
  compare_spheres(r, r->out->cause[0].moved);
  compare_directions(r);
  st = compare_intensities(ctx, r);
  compare_exposures(r);
  r->out->significance = 1;
  for (int i = 0; i < r->out->n_causes; i++) {
    const hl_rig_cause *c = &r->out->cause[i];
    const double all =
        c->part == HL_RIG_EXPOSURE ? c->significance : c->significance * r->out->n_tests;
    r->out->significance = fmin(r->out->significance, all);
    r->out->drifted = r->out->drifted || c->moved;
  }
  return st;
}

hl_status hl_drift_rig(hl_ctx *ctx, const hl_lights *reference, const hl_lights *current,
                       const hl_rig_drift_settings *settings, hl_rig_drift *out)
{
  const hl_rig_drift_settings s = settings ? *settings : hl_rig_drift_defaults();
  rig_run r = {.reference = reference, .current = current, .out = out};
  memset(out, 0, sizeof *out);
  hl_status st = hl_fields_check(ctx, hl_rig_drift_fields(), &s);
  if (st == HL_OK)
    st = check(ctx, reference, current);
  if (st != HL_OK)
    return st;
  const size_t n = reference->n > 0 ? (size_t)reference->n : 1;
  r.pair = calloc(n, sizeof *r.pair);
  r.turn.rows = calloc(n, sizeof *r.turn.rows);
  out->cause = calloc(2 * n + 3 + HL_BALLS_MAX, sizeof *out->cause);
  if (!r.pair || !r.turn.rows || !out->cause)
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d lights", reference->n);
  if (st == HL_OK) {
    out->n_matched = r.n = r.turn.n = hl_rig_match(reference, current, r.pair, &out->notes);
    if (r.n < 3)
      st = hl_fail(ctx, HL_ERR_DEGENERATE,
                   "the sessions have %d lights in common that both know; at least 3 are needed",
                   r.n);
  }
  if (st == HL_OK) {
    plan_tests(&r, s.false_alarm);
    st = compare(ctx, &r);
  }
  free(r.turn.rows);
  free(r.pair);
  if (st != HL_OK)
    hl_rig_drift_free(out);
  return st;
}
