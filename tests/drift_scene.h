/* Calibrations of one camera, made in memory: corners with seeded noise, and the least squares that
 * hl_calibrate ends in, begun at the truth. */
#ifndef HL_TEST_DRIFT_SCENE_H
#define HL_TEST_DRIFT_SCENE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../calib/sightings.h"
#include "halflight/drift.h"
#include "halflight/vec3.h"
#include "near.h"

enum { DRIFT_VIEWS_MAX = 24, DRIFT_CORNERS_MAX = 256 };

/* What stands before the camera. */
typedef struct drift_scene {
  hl_camera camera;
  hl_target target;
  int n_views;
  hl_pose board[DRIFT_VIEWS_MAX]; /* cam_from_board */
  double noise_px;
} drift_scene;

static inline hl_camera drift_camera(hl_lens_model model)
{
  static const double distortion[3][HL_DISTORTION_MAX] = {
      [HL_LENS_PINHOLE] = {-0.18, 0.06, 0.0008, -0.0005, 0.0},
      [HL_LENS_RATIONAL] = {0.2, -0.05, 0.0006, -0.0004, 0.01, 0.45, 0.02, 0.0},
      [HL_LENS_FISHEYE] = {0.02, -0.013, 0.006, -0.0015},
  };
  static const int coefficients[3] = {5, 8, 4};
  hl_camera c = {.model = model,
                 .width = 640,
                 .height = 480,
                 .fx = model == HL_LENS_PINHOLE ? 700 : 450,
                 .fy = model == HL_LENS_PINHOLE ? 700 : 450,
                 .cx = 322.3,
                 .cy = 236.8,
                 .n_distortion = coefficients[model]};
  memcpy(c.distortion, distortion[model], sizeof c.distortion);
  return c;
}

/* A board of 9 x 7 corners in hand-held poses, as accept/camera.py in the world outside holds it. */
static inline hl_pose drift_pose(test_random *r, const hl_camera *camera, const hl_target *target)
{
  const double nearer = camera->fx / 700;
  double last[3], turned[3];
  hl_pose p = {{0}, {0}};
  hl_target_corner(target, hl_target_corners(target) - 1, last);
  const double middle[3] = {last[0] / 2, last[1] / 2, 0};
  for (int i = 0; i < 3; i++)
    p.rotation_rad[i] = random_between(r, -0.55, 0.55);
  hl_pose_apply(&p, middle, turned, NULL, NULL);
  p.translation_m[0] = random_between(r, -0.16, 0.16) - turned[0];
  p.translation_m[1] = random_between(r, -0.12, 0.12) - turned[1];
  p.translation_m[2] = nearer * random_between(r, 0.3, 0.55) - turned[2];
  return p;
}

/* Corners inside the frame, without noise; returns how many. */
static inline int drift_see(const hl_camera *camera, const hl_target *target, const hl_pose *pose,
                            hl_corner *corner)
{
  int seen = 0;
  for (int i = 0; i < hl_target_corners(target); i++) {
    double b[3], at[3], q[2];
    hl_target_corner(target, i, b);
    hl_pose_apply(pose, b, at, NULL, NULL);
    corner[i] = (hl_corner){0};
    if (hl_camera_project(NULL, camera, at, q) != HL_OK ||
        !(q[0] > 0 && q[0] < camera->width - 1) || !(q[1] > 0 && q[1] < camera->height - 1))
      continue;
    /* beyond a fold of the lens a point far outside the field of view lands inside the frame */
    double ray[3];
    if (hl_camera_unproject(NULL, camera, q[0], q[1], ray) != HL_OK || !(hl_angle(ray, at) < 1e-6))
      continue;
    corner[i] = (hl_corner){q[0], q[1], 1};
    seen++;
  }
  return seen;
}

static inline drift_scene drift_scene_of(hl_lens_model model, int n_views, uint64_t seed)
{
  drift_scene s = {.camera = drift_camera(model),
                   .target = {HL_TARGET_CHESSBOARD, 9, 7, 0.03, 0},
                   .noise_px = 0.1};
  test_random r = {seed * 2654435761u + 12345};
  while (s.n_views < n_views) {
    hl_corner corner[DRIFT_CORNERS_MAX];
    s.board[s.n_views] = drift_pose(&r, &s.camera, &s.target);
    const int seen = drift_see(&s.camera, &s.target, &s.board[s.n_views], corner);
    s.n_views += seen >= 0.6 * hl_target_corners(&s.target);
  }
  return s;
}

/* The same boards with the camera moved: current camera from reference camera. */
static inline void drift_move_mount(drift_scene *s, const hl_pose *moved)
{
  for (int v = 0; v < s->n_views; v++)
    hl_pose_compose(moved, &s->board[v], &s->board[v]);
}

static inline void drift_noise(const drift_scene *s, test_random *r, hl_corner *corner)
{
  for (int i = 0; i < hl_target_corners(&s->target); i++) {
    if (!(corner[i].sigma > 0))
      continue;
    corner[i].x += s->noise_px * random_normal(r);
    corner[i].y += s->noise_px * random_normal(r);
  }
}

typedef struct drift_view {
  hl_sighting sighting[DRIFT_CORNERS_MAX];
  int n;
  hl_pose pose;
  hl_arrow_view block;
} drift_view;

static inline void drift_linearise(const hl_camera *camera, drift_view *view, int n_views,
                                   hl_arrow *arrow)
{
  hl_arrow_view *block[DRIFT_VIEWS_MAX];
  hl_arrow_fault fault;
  hl_arrow_clear(arrow, hl_camera_intrinsics_count(camera));
  for (int v = 0; v < n_views; v++) {
    block[v] = &view[v].block;
    hl_arrow_view_clear(block[v]);
    assert_true(
        hl_sightings_rows(camera, &view[v].pose, view[v].sighting, view[v].n, arrow, block[v]));
  }
  assert_true(hl_arrow_factor(arrow, block, n_views, 0, &fault));
}

static inline void drift_step(hl_camera *camera, drift_view *view, int n_views,
                              const hl_arrow *arrow)
{
  hl_arrow_view *block[DRIFT_VIEWS_MAX];
  double theta[HL_INTRINSICS_MAX], step[HL_INTRINSICS_MAX];
  for (int v = 0; v < n_views; v++)
    block[v] = &view[v].block;
  hl_arrow_step(arrow, block, n_views, step);
  hl_camera_intrinsics(camera, theta);
  for (int k = 0; k < arrow->n; k++)
    theta[k] += step[k];
  hl_camera_set_intrinsics(camera, theta);
  for (int v = 0; v < n_views; v++) {
    double by[HL_POSE_SIZE];
    hl_arrow_view_step(block[v], arrow->n, step, by);
    for (int k = 0; k < 3; k++) {
      view[v].pose.rotation_rad[k] += by[k];
      view[v].pose.translation_m[k] += by[3 + k];
    }
  }
}

/* What hl_calibrate would state; hl_calibration_free releases it. */
static inline hl_calibration drift_calibrate(const drift_scene *s, test_random *r)
{
  static drift_view view[DRIFT_VIEWS_MAX];
  static hl_arrow arrow;
  hl_calibration out = {.trusted = true, .target = s->target, .n_views = s->n_views, .scatter = 1};
  const int n = hl_camera_intrinsics_count(&s->camera);
  double cost = 0;
  int corners = 0;
  out.camera = s->camera;
  for (int v = 0; v < s->n_views; v++) {
    hl_corner corner[DRIFT_CORNERS_MAX];
    hl_view seen = {.corner = corner};
    drift_see(&s->camera, &s->target, &s->board[v], corner);
    drift_noise(s, r, corner);
    view[v].n = hl_sightings_of(&s->target, &seen, view[v].sighting);
    view[v].pose = s->board[v];
    corners += view[v].n;
  }
  for (int i = 0; i < 3; i++) { /* from the truth, noise away */
    drift_linearise(&out.camera, view, s->n_views, &arrow);
    drift_step(&out.camera, view, s->n_views, &arrow);
  }
  drift_linearise(&out.camera, view, s->n_views, &arrow);
  for (int v = 0; v < s->n_views; v++)
    cost += hl_sightings_cost(&out.camera, &view[v].pose, view[v].sighting, view[v].n);
  const double variance = cost / (2 * corners - n - HL_POSE_SIZE * s->n_views);
  hl_spd_inverse(&arrow.schur, out.camera.covariance);
  for (int i = 0; i < n * n; i++)
    out.camera.covariance[i] *= variance;
  out.camera.has_covariance = true;
  out.camera.observations = out.corners_used = corners;
  out.camera.rms_px = sqrt(cost / corners);
  out.noise_px = sqrt(variance);
  out.view = calloc((size_t)s->n_views, sizeof *out.view);
  assert_non_null(out.view);
  for (int v = 0; v < s->n_views; v++) {
    hl_view_pose *to = &out.view[v];
    snprintf(to->name, sizeof to->name, "view%02d.png", v);
    to->used = true;
    to->corners = to->seen = view[v].n;
    to->cam_from_board = view[v].pose;
    hl_spd_inverse(&view[v].block.factor, to->own_covariance[0]);
    for (int i = 0; i < HL_POSE_SIZE; i++) {
      for (int k = 0; k < HL_POSE_SIZE; k++)
        to->own_covariance[i][k] *= variance;
      for (int k = 0; k < n; k++)
        to->by_intrinsics[i][k] = -view[v].block.w[k][i];
    }
  }
  return out;
}

#endif
