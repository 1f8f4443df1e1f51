/*
 * Least squares for the intrinsics and all poses together.
 *
 * Levenberg and Marquardt's method on the arrow-shaped normal equations. How far an iterate is from
 * the minimum is measured in what it is uncertain by anyway: the Newton decrement
 *
 *   sqrt(g' H^-1 g) / s,   s^2 = SSR / (2 N - p)
 *
 * is the length of the next step in units of the stated deviations. Below `close_enough` an answer
 * is called the minimum; steps go on, while they shrink, to `closest`.
 *
 * The rational model's numerator and denominator D(q) = 1 + k4 q + k5 q^2 + k6 q^3, q = tan^2 of the
 * angle from the axis, can cancel each other: coefficients of some hundreds predict the same pixels
 * as those of a lens, along a valley that bends and ends at poles, so that neither the minimum nor a
 * deviation there would mean anything. So log D is held near 0 at three angles, the last of them
 * beyond the frame's corner, by as many observations of noise s and deviation 1: D within a factor e of 1, and
 * never 0. Lenses are well within that; what the corners tell apart, it hardly moves.
 */
#include <math.h>

#include "intrinsics.h"

enum { STEPS_MAX = 200 };

/* the first of k4 k5 k6 among the rational model's coefficients, the prior's angles, and rounds of
 * prior and noise */
enum { DENOMINATOR = 5, HELD = 3, ROUNDS_MAX = 12 };

#define DAMPING_START 1e-6
#define DAMPING_LEAST 1e-13
#define DAMPING_MOST 1e6

static const double close_enough = 1e-3, closest = 1e-9; /* stated deviations */
static const double rounding = 1e-12;                    /* of a cost */
static const double beyond = 1.5;          /* of the farthest, which a pinhole places too near */
static const double same_prior = 0.01;     /* of itself */
static const double least_prior_px = 1e-3; /* below, corners without noise would leave none */
static const double finest_px = 1e-6;      /* noise below is rounding of the corners */

static double cost_of(const hl_intrinsics *p, const hl_camera *camera, const hl_pose *trial)
{
  double sum = 0;
  for (int i = 0; i < p->n_views; i++) {
    const hl_intrinsics_view *view = &p->view[i];
    if (view->used)
      sum += hl_sightings_cost(camera, trial ? &trial[i] : &view->pose, view->sighting, view->n);
  }
  return sum;
}

/* tan^2 of the angle from the axis at the farthest of the frame's corners, where the lens reaches
 * there, and of the board's. */
static double farthest(const hl_intrinsics *p)
{
  double most = 0;
  for (int i = 0; i < 4; i++) {
    double ray[3];
    if (hl_camera_unproject(NULL, &p->camera, i % 2 ? p->camera.width - 1 : 0,
                            i / 2 ? p->camera.height - 1 : 0, ray) == HL_OK)
      most = fmax(most, (ray[0] * ray[0] + ray[1] * ray[1]) / (ray[2] * ray[2]));
  }
  for (int i = 0; i < p->n_views; i++)
    for (int c = 0; p->view[i].used && c < p->view[i].n; c++) {
      double at[3];
      if (!p->view[i].sighting[c].used)
        continue;
      hl_pose_apply(&p->view[i].pose, p->view[i].sighting[c].board_m, at, NULL, NULL);
      most = fmax(most, (at[0] * at[0] + at[1] * at[1]) / (at[2] * at[2]));
    }
  return most;
}

/* log D at the held angle of that number, and its derivatives by k4 k5 k6; NaN beyond a pole. */
static double log_denominator(const hl_intrinsics *p, const hl_camera *camera, int i,
                              double by[HELD])
{
  const double q = p->farthest * (i + 1) / HELD;
  const double *k = camera->distortion + DENOMINATOR;
  const double d = 1 + q * (k[0] + q * (k[1] + q * k[2]));
  by[0] = q / d;
  by[1] = q * by[0];
  by[2] = q * by[1];
  return d > 0 ? log(d) : NAN;
}

static double penalty(const hl_intrinsics *p, const hl_camera *camera)
{
  double sum = 0;
  for (int i = 0; i < HELD && camera->model == HL_LENS_RATIONAL; i++) {
    double by[HELD];
    const double held = log_denominator(p, camera, i, by);
    sum += held * held;
  }
  return p->prior * sum;
}

static void add_prior(hl_intrinsics *p)
{
  const int n = p->arrow.n;
  for (int i = 0; i < HELD && p->camera.model == HL_LENS_RATIONAL; i++) {
    double by[HELD];
    const double held = log_denominator(p, &p->camera, i, by);
    for (int k = 0; k < HELD; k++) {
      const int row = 4 + DENOMINATOR + k;
      p->arrow.gradient[row] += p->prior * by[k] * held;
      for (int j = 0; j <= k; j++)
        p->arrow.a[row * n + row - k + j] += p->prior * by[k] * by[j];
    }
  }
}

static hl_status assemble(hl_ctx *ctx, hl_intrinsics *p)
{
  hl_arrow_clear(&p->arrow, hl_camera_intrinsics_count(&p->camera));
  p->n_active = 0;
  for (int i = 0; i < p->n_views; i++) {
    hl_intrinsics_view *view = &p->view[i];
    if (!view->used)
      continue;
    hl_arrow_view *block = &p->block[i];
    hl_arrow_view_clear(block);
    p->active[p->n_active++] = block;
    if (!hl_sightings_rows(&p->camera, &view->pose, view->sighting, view->n, &p->arrow, block))
      return hl_fail(ctx, HL_ERR_DEGENERATE, "%.80s: its board is not in front of the camera",
                     view->source->name);
  }
  add_prior(p);
  return HL_OK;
}

static hl_status singular(hl_ctx *ctx, const hl_intrinsics *p, hl_arrow_fault fault)
{
  static const char *const names[] = {"fx", "fy", "cx", "cy"};
  if (fault.view >= 0)
    return hl_fail(ctx, HL_ERR_DEGENERATE, "%.80s: its corners do not determine where its board is",
                   p->view[p->active[fault.view] - p->block].source->name);
  if (fault.unknown < 4)
    return hl_fail(
        ctx, HL_ERR_DEGENERATE,
        "the views do not determine the camera: %s cannot be told apart from the boards' "
        "places; boards tilted by 20 to 45 deg, in several directions, are needed",
        names[fault.unknown]);
  return hl_fail(ctx, HL_ERR_DEGENERATE,
                 "the views do not determine the camera: distortion[%d] cannot be told apart from "
                 "the rest; corners over the whole frame, or a smaller model, are needed",
                 fault.unknown - 4);
}

/* The step at this damping from the assembled arrow; camera and poses after it in *to and p->trial.
 * Returns g' H^-1 g, or -1 where a block is singular. */
static double propose(hl_intrinsics *p, double damping, hl_camera *to, hl_arrow_fault *fault)
{
  const int n = p->arrow.n;
  double by[HL_INTRINSICS_MAX], theta[HL_INTRINSICS_MAX], step[HL_POSE_SIZE];
  if (!hl_arrow_factor(&p->arrow, p->active, p->n_active, damping, fault))
    return -1;
  hl_arrow_step(&p->arrow, p->active, p->n_active, by);
  hl_camera_intrinsics(&p->camera, theta);
  double gain = 0;
  for (int k = 0; k < n; k++) {
    theta[k] += by[k];
    gain -= p->arrow.gradient[k] * by[k];
  }
  *to = p->camera;
  hl_camera_set_intrinsics(to, theta);
  for (int i = 0; i < p->n_views; i++) {
    const hl_intrinsics_view *view = &p->view[i];
    if (!view->used)
      continue;
    hl_arrow_view_step(&p->block[i], n, by, step);
    for (int k = 0; k < 3; k++) {
      p->trial[i].rotation_rad[k] = view->pose.rotation_rad[k] + step[k];
      p->trial[i].translation_m[k] = view->pose.translation_m[k] + step[3 + k];
    }
    for (int k = 0; k < HL_POSE_SIZE; k++)
      gain -= p->block[i].gradient[k] * step[k];
  }
  return fmax(gain, 0);
}

static void accept(hl_intrinsics *p, const hl_camera *to, double cost)
{
  p->camera = *to;
  p->cost = cost;
  for (int i = 0; i < p->n_views; i++)
    if (p->view[i].used)
      p->view[i].pose = p->trial[i];
}

/* s^2, but no less than what rounding leaves. */
static double variance_of(const hl_intrinsics *p)
{
  const int freedom = hl_intrinsics_freedom(p);
  return fmax(freedom > 0 ? p->cost / freedom : 0, finest_px * finest_px);
}

/* A decrement in units of the stated deviations. */
static double in_deviations(const hl_intrinsics *p, double gain)
{
  return sqrt(gain / variance_of(p));
}

static double prior_of(const hl_intrinsics *p)
{
  return fmax(variance_of(p), least_prior_px * least_prior_px);
}

static bool try_step(hl_intrinsics *p, double damping, double *gain, hl_arrow_fault *fault)
{
  hl_camera to = p->camera;
  *gain = propose(p, damping, &to, fault);
  if (*gain < 0)
    return false;
  const double cost = cost_of(p, &to, p->trial);
  const double now = p->cost + penalty(p, &p->camera);
  if (!(cost + penalty(p, &to) <= now * (1 + rounding)))
    return false;
  accept(p, &to, cost);
  return true;
}

/* One step from the present state, assembled: Gauss and Newton's own, or a damped one where that
 * leads astray. False at the minimum, or where nothing helps. */
static bool descend(hl_intrinsics *p, double *damping)
{
  hl_arrow_fault fault;
  double gain, own_gain;
  const bool good = try_step(p, 0, &own_gain, &fault);
  if (own_gain >= 0) {
    const double off = in_deviations(p, own_gain);
    const bool shrinks = off < p->stationarity;
    p->stationarity = off;
    if (off < closest || (off < close_enough && !shrinks))
      return false;
  }
  while (!good && *damping < DAMPING_MOST) {
    if (try_step(p, *damping, &gain, &fault)) {
      *damping = fmax(*damping / 10, DAMPING_LEAST);
      return true;
    }
    *damping *= 10;
  }
  return good;
}

hl_status hl_intrinsics_linearise(hl_ctx *ctx, hl_intrinsics *p)
{
  hl_arrow_fault fault;
  hl_camera to;
  hl_status st = assemble(ctx, p);
  if (st != HL_OK)
    return st;
  p->cost = cost_of(p, &p->camera, NULL);
  const double gain = propose(p, 0, &to, &fault);
  if (gain < 0)
    return singular(ctx, p, fault);
  p->stationarity = in_deviations(p, gain);
  return HL_OK;
}

/* To the minimum at the present prior, which is looked at once more there. */
static hl_status minimise(hl_ctx *ctx, hl_intrinsics *p)
{
  double damping = DAMPING_START;
  p->stationarity = HUGE_VAL;
  for (p->iterations = 0; p->iterations < STEPS_MAX; p->iterations++) {
    const hl_status st = assemble(ctx, p);
    if (st != HL_OK)
      return st;
    if (!descend(p, &damping))
      break;
  }
  return hl_intrinsics_linearise(ctx, p);
}

hl_status hl_intrinsics_solve(hl_ctx *ctx, hl_intrinsics *p)
{
  p->cost = cost_of(p, &p->camera, NULL);
  if (!isfinite(p->cost))
    return hl_fail(ctx, HL_ERR_DEGENERATE, "a board is not in front of the camera");
  p->solved_once = true;
  for (int round = 0; round < ROUNDS_MAX; round++) {
    p->prior = prior_of(p);
    if (p->camera.model == HL_LENS_RATIONAL)
      p->farthest = beyond * farthest(p);
    const hl_status st = minimise(ctx, p);
    if (st != HL_OK)
      return st;
    if (p->camera.model != HL_LENS_RATIONAL ||
        fabs(prior_of(p) - p->prior) <= same_prior * p->prior)
      break;
  }
  for (int i = 0; i < p->n_views; i++) {
    hl_intrinsics_view *view = &p->view[i];
    if (view->used)
      view->cost = hl_sightings_cost(&p->camera, &view->pose, view->sighting, view->n);
  }
  if (!(p->stationarity < close_enough))
    return hl_fail(
        ctx, HL_ERR_NOT_CONVERGED,
        "the calibration is still %.2g stated deviations from its minimum after %d steps",
        p->stationarity, p->iterations);
  return HL_OK;
}
