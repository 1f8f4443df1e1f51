/*
 * From nothing to a solution.
 *
 * OpenCV brings the start: focal length from the homographies of the views (Zhang 2000), then its
 * own minimisation. It weighs all corners alike and stops early, so what it brings is taken to the
 * minimum here. Its time grows with the cube of the views, so of many it is given a part, evenly
 * dealt, and the rest are placed one by one. The rational model begins at the pinhole's answer and
 * is not left to OpenCV, since without a prior its numerator and denominator cancel each other in
 * many ways.
 *
 * Where OpenCV gives up or ends in no minimum (its fisheye calibration does so when one view is
 * ill-conditioned), a row of focal lengths without distortion is tried, every view's pose from its
 * own plane, and the least cost is kept.
 *
 * At the end each view is offered the pose that its corners alone suggest, because a board seen from
 * afar can sit in the wrong one of its two.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/bridge_opencv_calibrate.h"
#include "halflight/lens_names.h"
#include "intrinsics.h"

enum { OPENCV_VIEWS_MAX = 60 };

static const double hopeless = 0.01;   /* rms over the frame's diagonal: no minimum worth having */
static const double better = 1 - 1e-6; /* of a cost: another minimum, not the same one */

static void set_model(hl_camera *camera, hl_lens_model model)
{
  camera->model = model;
  camera->n_distortion = hl_lens_coefficients((int)model);
}

/* ---- through OpenCV ---- */

/* Every how many used views one goes to OpenCV. */
static int stride_of(const hl_intrinsics *p)
{
  return 1 + (hl_intrinsics_views_used(p) - 1) / OPENCV_VIEWS_MAX;
}

/* The used corners of these views; their coordinates in `room`, which the caller frees. */
static int opencv_views(const hl_intrinsics *p, int stride, hl_opencv_view *views,
                        double (*room)[2])
{
  int n_views = 0, used = 0;
  for (int i = 0; i < p->n_views; i++) {
    const hl_intrinsics_view *view = &p->view[i];
    if (!view->used || used++ % stride != 0)
      continue;
    double(*board)[2] = room;
    double(*pixel)[2] = room + view->n;
    int n = 0;
    for (int c = 0; c < view->n; c++) {
      const hl_sighting *s = &view->sighting[c];
      if (!s->used)
        continue;
      memcpy(board[n], s->board_m, sizeof *board);
      memcpy(pixel[n], s->pixel, sizeof *pixel);
      n++;
    }
    views[n_views++] = (hl_opencv_view){n, (const double(*)[2])board, (const double(*)[2])pixel};
    room += 2 * (ptrdiff_t)view->n;
  }
  return n_views;
}

/* A view's pose from its own corners, the camera held. */
static hl_status place(hl_ctx *ctx, const hl_intrinsics *p, hl_intrinsics_view *view)
{
  double cost;
  return hl_sightings_pose(ctx, &p->camera, view->sighting, view->n, &view->pose, &cost);
}

/* OpenCV's poses, in p->trial, and the others. */
static hl_status take_poses(hl_ctx *ctx, hl_intrinsics *p, int stride)
{
  int used = 0;
  for (int i = 0; i < p->n_views; i++) {
    hl_intrinsics_view *view = &p->view[i];
    hl_status st = HL_OK;
    if (!view->used)
      continue;
    if (used % stride == 0)
      view->pose = p->trial[used / stride];
    else
      st = place(ctx, p, view);
    if (st != HL_OK)
      return st;
    used++;
  }
  return HL_OK;
}

static hl_status from_opencv(hl_ctx *ctx, hl_intrinsics *p)
{
  const int stride = stride_of(p);
  hl_opencv_view *views = calloc((size_t)OPENCV_VIEWS_MAX + 1, sizeof *views);
  double(*room)[2] = calloc(2 * (size_t)p->n_sightings + 1, sizeof *room);
  hl_camera camera = p->camera;
  if (!views || !room) {
    free(views);
    free(room);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d views", p->n_views);
  }
  hl_status st =
      hl_opencv_calibrate(ctx, views, opencv_views(p, stride, views, room), &camera, p->trial);
  free(views);
  free(room);
  if (st != HL_OK)
    return st;
  p->camera = camera;
  st = take_poses(ctx, p, stride);
  if (st != HL_OK)
    return st;
  p->opencv_off = hl_intrinsics_linearise(NULL, p) == HL_OK ? p->stationarity : HUGE_VAL;
  return hl_intrinsics_solve(ctx, p);
}

/* ---- from a focal length ---- */

static hl_status from_focal(hl_ctx *ctx, hl_intrinsics *p, hl_lens_model model, double focal_px)
{
  p->camera = (hl_camera){.width = p->camera.width,
                          .height = p->camera.height,
                          .fx = focal_px,
                          .fy = focal_px,
                          .cx = (p->camera.width - 1) / 2.0,
                          .cy = (p->camera.height - 1) / 2.0};
  set_model(&p->camera, model);
  for (int i = 0; i < p->n_views; i++) {
    hl_intrinsics_view *view = &p->view[i];
    const hl_status st = view->used ? place(ctx, p, view) : HL_OK;
    if (st != HL_OK)
      return st;
  }
  return hl_intrinsics_solve(ctx, p);
}

/* The least cost of a row of focal lengths, or what is kept where none has less. */
static hl_status from_any_focal(hl_ctx *ctx, hl_intrinsics *p, hl_lens_model model,
                                hl_intrinsics_state *kept)
{
  static const double focal[] = {0.3, 0.45, 0.7, 1, 1.5, 2.5, 5}; /* of the frame's longer side */
  const double side = fmax(p->camera.width, p->camera.height);
  hl_status st = HL_OK;
  for (size_t i = 0; i < sizeof focal / sizeof *focal; i++) {
    st = from_focal(ctx, p, model, focal[i] * side);
    if (st == HL_ERR_MEMORY || st == HL_ERR_UNAVAILABLE)
      return st;
    if (st == HL_OK && p->cost < kept->cost)
      hl_intrinsics_save(p, kept);
  }
  if (!isfinite(kept->cost))
    return st;
  hl_intrinsics_restore(p, kept);
  return hl_intrinsics_solve(ctx, p);
}

static bool is_hopeless(const hl_intrinsics *p)
{
  const int n = hl_intrinsics_corners_used(p);
  const double diagonal = hypot(p->camera.width, p->camera.height);
  return !(p->cost < n * pow(hopeless * diagonal, 2));
}

static hl_status from_nothing(hl_ctx *ctx, hl_intrinsics *p, hl_lens_model model,
                              hl_intrinsics_state *kept)
{
  hl_ctx inner = {0};
  set_model(&p->camera, model);
  p->opencv = inner;
  const hl_status st = from_opencv(&inner, p);
  if (st == HL_OK && !is_hopeless(p))
    return st;
  if (st == HL_ERR_MEMORY || st == HL_ERR_UNAVAILABLE)
    return hl_fail(ctx, st, "%s", inner.msg);
  if (st == HL_OK)
    hl_fail(&inner, HL_ERR_RESIDUAL, "rms %.3g px, which is no minimum worth having",
            sqrt(p->cost / hl_intrinsics_corners_used(p)));
  p->opencv = inner;
  hl_intrinsics_save(p, kept);
  kept->cost = st == HL_OK ? p->cost : HUGE_VAL;
  return from_any_focal(ctx, p, model, kept);
}

/* ---- the rational model, from the pinhole's answer ---- */

static hl_status widen(hl_ctx *ctx, hl_intrinsics *p)
{
  set_model(&p->camera, HL_LENS_RATIONAL);
  for (int k = hl_lens_coefficients(HL_LENS_PINHOLE); k < p->camera.n_distortion; k++)
    p->camera.distortion[k] = 0;
  return hl_intrinsics_solve(ctx, p);
}

/* ---- the other pose of a plane ---- */

static hl_status offer_poses(hl_ctx *ctx, hl_intrinsics *p)
{
  bool any = false;
  for (int i = 0; i < p->n_views; i++) {
    hl_intrinsics_view *view = &p->view[i];
    hl_pose pose;
    double cost;
    if (!view->used)
      continue;
    hl_ctx inner = {0}; /* a view that offers none keeps its own */
    const hl_status st =
        hl_sightings_pose(&inner, &p->camera, view->sighting, view->n, &pose, &cost);
    if (st == HL_ERR_MEMORY)
      return hl_fail(ctx, st, "%s", inner.msg);
    if (st == HL_OK && cost < better * view->cost) {
      view->pose = pose;
      any = true;
    }
  }
  return any ? hl_intrinsics_solve(ctx, p) : HL_OK;
}

hl_status hl_intrinsics_start(hl_ctx *ctx, hl_intrinsics *p, hl_lens_model model)
{
  hl_intrinsics_state kept;
  hl_status st = hl_intrinsics_state_new(ctx, p, &kept);
  if (st != HL_OK)
    return st;
  const bool rational = model == HL_LENS_RATIONAL;
  st = from_nothing(ctx, p, rational ? HL_LENS_PINHOLE : model, &kept);
  if (st == HL_OK)
    st = offer_poses(ctx, p);
  if (st == HL_OK && rational)
    st = widen(ctx, p);
  hl_intrinsics_state_free(&kept);
  return st;
}
