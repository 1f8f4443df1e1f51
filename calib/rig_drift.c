/*
 * Two sessions of one rig compared, part by part.
 *
 *   mount       rotation of all lights against none: chi-squared of 3 (rig_turn.c)
 *   direction   each light beside that rotation: chi-squared of 2 (rig_turn.c)
 *   sphere      a ball's centre: chi-squared of 3 (rig_sphere.c)
 *   intensity   each light against all others: chi-squared of 1 (rig_intensity.c)
 *   intrinsics  where the calibrations differ: chi-squared of their number
 *   exposure    recorded, not estimated: any change beyond 0.1 %, which is what sensors round to
 *
 * Each of the K estimated tests is taken at the rate of false alarms over K (Bonferroni). Holm's
 * steps (Scand. J. Statist. 6, 1979, p. 65) give the same verdict, as the first of them is this one, and
 * after m parts are named test the next at the rate over K - m: of the 50 tests of 24 lights the
 * limit of chi-squared of 2 falls by 0.12 after three. They would make each limit depend on what else is
 * named, in mount, lights and brightness at once, for that. A threshold is the
 * figure that would just be an alarm in the direction of the change: figure sqrt(limit / statistic).
 */
#include "halflight/rig_drift.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/notes.h"
#include "halflight/vec3.h"
#include "rig_work.h"
#include "significance.h"

static const double degrees = 180 / 3.14159265358979323846;
static const double same_exposure = 1e-3, same_radius = 1e-6;

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

hl_rig_cause *hl_rig_add(hl_rig_run *r, hl_rig_part part, const char *name, int reference,
                         int current)
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

void hl_rig_judge(const hl_rig_run *r, hl_rig_cause *c, double figure, double statistic, double dof)
{
  const double limit = hl_significance_limit(r->rate, dof, HUGE_VAL);
  c->figure = figure;
  c->significance = hl_significance(statistic, dof, HUGE_VAL);
  c->threshold = statistic > 0 ? figure * sqrt(limit / statistic) : NAN;
  c->moved = statistic > limit;
}

/* d' A^-1 d. A change that A does not explain at all counts as without bound. */
double hl_rig_square(const double *a, const double *d, int n)
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

static void compare_mount(hl_rig_run *r)
{
  hl_rig_cause *c = hl_rig_add(r, HL_RIG_MOUNT, "", -1, -1);
  memcpy(c->change, r->turn.rotation_rad, sizeof c->change);
  hl_rig_judge(r, c, degrees * hl_norm(c->change), r->turn.statistic, 3);
}

static void compare_intrinsics(hl_rig_run *r)
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
  hl_rig_cause *c = hl_rig_add(r, HL_RIG_INTRINSICS, "", -1, -1);
  c->change[0] = q[0];
  c->change[1] = q[1];
  hl_rig_judge(r, c, hypot(q[0], q[1]) / sqrt(2), hl_rig_square(cov, q, n), n);
}

static void compare_directions(hl_rig_run *r)
{
  for (int i = 0; i < r->n; i++) {
    const hl_rig_rows *rows = &r->turn.rows[i];
    const double left[2] = {rows->root[0][0] * rows->left[0],
                            rows->root[1][0] * rows->left[0] + rows->root[1][1] * rows->left[1]};
    hl_rig_cause *c =
        hl_rig_add(r, HL_RIG_DIRECTION, r->pair[i].name, r->pair[i].reference, r->pair[i].current);
    for (int k = 0; k < 3; k++)
      c->change[k] = left[0] * rows->tangent[0][k] + left[1] * rows->tangent[1][k];
    hl_rig_judge(r, c, degrees * hypot(left[0], left[1]), rows->statistic, 2);
  }
}

/* ---- exposure ---- */

static void compare_exposures(hl_rig_run *r)
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
  hl_rig_cause *c =
      hl_rig_add(r, HL_RIG_EXPOSURE, off > 0 && off < known ? furthest->name : "", -1, -1);
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

static void plan_tests(hl_rig_run *r, double false_alarm)
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
    dark += !hl_rig_has_intensity(&r->reference->light[r->pair[i].reference],
                                  &r->current->light[r->pair[i].current]);
  if (dark > 0)
    hl_notes_add(notes, "intensity", "of %d lights not compared: it has no stated deviation", dark);
  r->out->n_tests = n + r->n - dark;
  r->out->false_alarm = false_alarm;
  r->rate = false_alarm / r->out->n_tests;
}

static hl_status compare(hl_ctx *ctx, hl_rig_run *r)
{
  hl_status st = hl_rig_turn_equations(ctx, r->reference, r->current, r->pair, &r->turn);
  if (st == HL_OK)
    st = hl_rig_turn_settle(ctx, hl_significance_limit(r->rate, 2, HUGE_VAL), &r->turn);
  if (st != HL_OK)
    return st;
  compare_mount(r);
  compare_intrinsics(r);
  hl_rig_compare_spheres(r, r->out->cause[0].moved);
  compare_directions(r);
  st = hl_rig_compare_intensities(ctx, r);
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
  hl_rig_run r = {.reference = reference, .current = current, .out = out};
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
