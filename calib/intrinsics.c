/*
 * A camera from corners: solved, sifted, and what is said about the answer.
 *
 * The covariances are those of include/halflight/calibration.h, read off the factored arrow at the
 * minimum. Beside them stands a test of their own premise, that corners err independently: with
 * q_i the pull of view i on the intrinsics, its pose having followed, and S the information,
 *
 *   scatter = sum q_i' S^-1 q_i / (s^2 n)
 *
 * is 1 +- sqrt(2 / (n V)) over V views where they do; errors that a view's corners share (a bent
 * board, blur, a lens that is not of the model) make the pulls larger than s^2 explains.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/vec3.h"
#include "intrinsics.h"

static const char *const models[] = {"auto", "pinhole", "rational", "fisheye", NULL};

static const hl_field fields[] = {
    {"model", HL_FIELD_CHOICE, offsetof(hl_calibration_settings, model), 0, 3, "",
     "lens model; auto keeps the smallest that explains the corners", models},
    {"min_views", HL_FIELD_INT, offsetof(hl_calibration_settings, min_views), 3, 1000, "",
     "fewer usable views are refused", NULL},
    {"outlier_sigmas", HL_FIELD_DOUBLE, offsetof(hl_calibration_settings, outlier_sigmas), 0, 1e6,
     "", "corners off by so many deviations are left out; 0 = never", NULL},
    {"view_ratio", HL_FIELD_DOUBLE, offsetof(hl_calibration_settings, view_ratio), 0, 1e6, "",
     "views whose rms is so many times the median are left out; 0 = never", NULL},
    {"model_gain", HL_FIELD_DOUBLE, offsetof(hl_calibration_settings, model_gain), 0, 1, "",
     "a larger model must predict left-out views better by this share", NULL},
};

hl_calibration_settings hl_calibration_defaults(void)
{
  const hl_calibration_settings s = {.model = HL_MODEL_PINHOLE,
                                     .min_views = 4,
                                     .outlier_sigmas = 5,
                                     .view_ratio = 2.5,
                                     .model_gain = 0.01};
  return s;
}

const hl_field_table *hl_calibration_fields(void)
{
  static const hl_field_table table = {"calibration", fields, sizeof fields / sizeof *fields};
  return &table;
}

void hl_calibration_free(hl_calibration *calibration)
{
  if (!calibration)
    return;
  free(calibration->view);
  *calibration = (hl_calibration){0};
}

/* ---- what is needed ---- */

static hl_status check_enough(hl_ctx *ctx, const hl_intrinsics *p)
{
  const int usable = hl_intrinsics_views_used(p);
  if (usable >= p->settings->min_views)
    return HL_OK;
  for (int i = 0; i < p->n_views; i++) {
    const hl_intrinsics_view *view = &p->view[i];
    if (!view->used)
      return hl_fail(ctx, HL_ERR_DEGENERATE,
                     "%d of %d views can be used; at least %d are needed; %.60s: %s", usable,
                     p->n_views, p->settings->min_views, view->source->name, view->why);
  }
  return hl_fail(ctx, HL_ERR_DEGENERATE, "%d views; at least %d are needed", usable,
                 p->settings->min_views);
}

/* ---- what is said about it ---- */

static double variance_of(const hl_intrinsics *p)
{
  return p->cost / hl_intrinsics_freedom(p);
}

static void fill_camera(const hl_intrinsics *p, hl_camera *out)
{
  const int n = p->arrow.n;
  const int corners = hl_intrinsics_corners_used(p);
  *out = p->camera;
  hl_spd_inverse(&p->arrow.schur, out->covariance);
  for (int i = 0; i < n * n; i++)
    out->covariance[i] *= variance_of(p);
  out->has_covariance = true;
  out->observations = corners;
  out->rms_px = sqrt(p->cost / corners);
}

/* A view that was left out keeps what its corners say about its pose, for the record. */
static void fill_rejected(const hl_intrinsics *p, const hl_intrinsics_view *view, hl_view_pose *out)
{
  double cost;
  for (int c = 0; c < view->n; c++)
    view->sighting[c].used = true;
  if (view->n > 0 && hl_sightings_pose(NULL, &p->camera, view->sighting, view->n,
                                       &out->cam_from_board, &cost) == HL_OK)
    out->rms_px = sqrt(cost / view->n);
  snprintf(out->why, sizeof out->why, "%s", view->why);
}

static void fill_view(const hl_intrinsics *p, int i, hl_view_pose *out)
{
  const hl_intrinsics_view *view = &p->view[i];
  const hl_arrow_view *block = &p->block[i];
  snprintf(out->name, sizeof out->name, "%s", view->source->name);
  out->used = view->used;
  out->seen = view->n;
  if (!view->used) {
    fill_rejected(p, view, out);
    return;
  }
  out->corners = hl_sightings_used(view->sighting, view->n);
  out->rms_px = sqrt(view->cost / out->corners);
  out->cam_from_board = view->pose;
  hl_spd_inverse(&block->factor, out->own_covariance[0]);
  for (int k = 0; k < HL_POSE_SIZE; k++) {
    for (int j = 0; j < HL_POSE_SIZE; j++)
      out->own_covariance[k][j] *= variance_of(p);
    for (int j = 0; j < p->arrow.n; j++)
      out->by_intrinsics[k][j] = -block->w[j][k];
  }
}

static double scatter_of(const hl_intrinsics *p)
{
  const int n = p->arrow.n;
  double sum = 0;
  for (int v = 0; v < p->n_active; v++) {
    double pull[HL_INTRINSICS_MAX], moved[HL_INTRINSICS_MAX];
    hl_arrow_view_pull(p->active[v], n, pull);
    hl_spd_solve(&p->arrow.schur, pull, moved);
    for (int i = 0; i < n; i++)
      sum += pull[i] * moved[i];
  }
  const double variance = variance_of(p);
  return variance > 0 ? sum / (variance * n) : 1;
}

/* Mean distance of the boards' centres. */
static double mean_distance(const hl_calibration *c)
{
  double first[3], last[3], sum = 0;
  int n = 0;
  hl_target_corner(&c->target, 0, first);
  hl_target_corner(&c->target, hl_target_corners(&c->target) - 1, last);
  const double middle[3] = {(first[0] + last[0]) / 2, (first[1] + last[1]) / 2, 0};
  for (int i = 0; i < c->n_views; i++) {
    double at[3];
    if (!c->view[i].used)
      continue;
    hl_pose_apply(&c->view[i].cam_from_board, middle, at, NULL, NULL);
    sum += hl_norm(at);
    n++;
  }
  return sum / n;
}

static void project_frame(hl_calibration *c)
{
  const double w = c->camera.width - 1, h = c->camera.height - 1;
  const double at[5][2] = {{w / 2, h / 2}, {0, 0}, {w, 0}, {0, h}, {w, h}};
  const double distance[2] = {HUGE_VAL, mean_distance(c)};
  for (int d = 0; d < 2; d++)
    for (int i = 0; i < 5; i++)
      hl_calibration_project(NULL, c, at[i], distance[d]);
}

static hl_status fill(hl_ctx *ctx, const hl_intrinsics *p, hl_calibration *out)
{
  hl_calibration c = *out;
  c.view = calloc(p->n_views > 0 ? (size_t)p->n_views : 1, sizeof *c.view);
  if (!c.view)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d views", p->n_views);
  c.n_views = p->n_views;
  c.target = p->corners->target;
  c.coverage = hl_intrinsics_coverage(p);
  c.noise_px = sqrt(variance_of(p));
  c.scatter = scatter_of(p);
  c.condition = hl_spd_condition(p->arrow.s, &p->arrow.schur, NULL, NULL);
  fill_camera(p, &c.camera);
  for (int i = 0; i < p->n_views; i++) {
    if (p->view[i].used)
      c.corners_left_out += p->view[i].n - hl_sightings_used(p->view[i].sighting, p->view[i].n);
    fill_view(p, i, &c.view[i]);
  }
  c.corners_used = c.camera.observations;
  c.tilt_deg = hl_intrinsics_tilt_deg(p);
  project_frame(&c);
  *out = c;
  return HL_OK;
}

static hl_status check_arguments(hl_ctx *ctx, const hl_corners *corners,
                                 const hl_calibration_settings *settings)
{
  hl_status st = hl_fields_check(ctx, hl_calibration_fields(), settings);
  if (st == HL_OK)
    st = hl_target_check(ctx, &corners->target);
  if (st == HL_OK && (corners->width < 2 || corners->height < 2))
    st = hl_fail(ctx, HL_ERR_ARG,
                 "the frames' size is %d x %d px; the size of the frames the corners were seen in "
                 "is needed",
                 corners->width, corners->height);
  return st;
}

static hl_status solve(hl_ctx *ctx, hl_intrinsics *p, hl_calibration *out)
{
  hl_ctx inner = {0};
  const hl_status st = hl_intrinsics_choose(&inner, p, &out->used, &out->left_out);
  return st == HL_OK ? st : hl_intrinsics_explain(ctx, p, st, inner.msg);
}

hl_status hl_calibrate(hl_ctx *ctx, const hl_corners *corners,
                       const hl_calibration_settings *settings, hl_calibration *out)
{
  const hl_calibration_settings s = settings ? *settings : hl_calibration_defaults();
  hl_intrinsics problem;
  hl_status st = check_arguments(ctx, corners, &s);
  if (st == HL_OK)
    st = hl_intrinsics_new(ctx, corners, &s, &problem);
  if (st != HL_OK)
    return st;
  hl_calibration c = {0};
  st = check_enough(ctx, &problem);
  if (st == HL_OK)
    st = solve(ctx, &problem, &c);
  if (st == HL_OK)
    st = hl_intrinsics_refuse(ctx, &problem);
  if (st == HL_OK)
    st = fill(ctx, &problem, &c);
  if (st == HL_OK) {
    hl_intrinsics_judge(&problem, &c);
    *out = c;
  }
  hl_intrinsics_free(&problem);
  return st;
}
