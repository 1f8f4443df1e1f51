/* Views of a board by a camera of known intrinsics: corners made in memory, with seeded noise. */
#ifndef HL_TEST_CORNER_SCENE_H
#define HL_TEST_CORNER_SCENE_H

#include <stdio.h>
#include <string.h>

#include "halflight/calibration.h"
#include "near.h"

/* A 6 x 6 AprilGrid as hand-held in front of a VGA camera. */
static inline hl_target board_target(void)
{
  const hl_target t = {HL_TARGET_APRILGRID, 6, 6, 0.03, 0.3};
  return t;
}

static inline hl_camera board_camera(hl_lens_model model)
{
  static const double distortion[3][HL_DISTORTION_MAX] = {
      [HL_LENS_PINHOLE] = {-0.18, 0.06, 0.0008, -0.0005, 0.0},
      [HL_LENS_RATIONAL] = {0.99, 0.236, 0.002, -0.0015, 0.0057, 1.306, 0.478, 0.0373},
      [HL_LENS_FISHEYE] = {0.02, -0.013, 0.006, -0.0015},
  };
  static const int coefficients[3] = {5, 8, 4};
  static const double focal[3] = {700, 400, 300};
  hl_camera c = {.model = model,
                 .width = 640,
                 .height = 480,
                 .fx = focal[model],
                 .fy = focal[model] + 2,
                 .cx = 322.3,
                 .cy = 236.8,
                 .n_distortion = coefficients[model]};
  memcpy(c.distortion, distortion[model], sizeof c.distortion);
  return c;
}

/* How the boards are held. */
typedef struct board_hold {
  double tilt_rad; /* each component of the rotation vector, at most */
  double nearest_m, farthest_m;
  double aside_m;     /* of the board's middle, at most */
  double least_share; /* of its corners inside the frame */
} board_hold;

static inline board_hold board_held(const hl_camera *camera)
{
  const double k = camera->fx / 700;
  const board_hold h = {0.55, 0.3 * k, 0.55 * k, 0.16, 0.6};
  return h;
}

/* A pose whose board's middle is where it is held. */
static inline hl_pose board_pose(test_random *r, const hl_target *target, const board_hold *hold)
{
  double last[3], turned[3];
  hl_pose p = {{0}, {0}};
  hl_target_corner(target, hl_target_corners(target) - 1, last);
  const double middle[3] = {last[0] / 2, last[1] / 2, 0};
  for (int i = 0; i < 3; i++)
    p.rotation_rad[i] = random_between(r, -hold->tilt_rad, hold->tilt_rad);
  hl_pose_apply(&p, middle, turned, NULL, NULL);
  p.translation_m[0] = random_between(r, -hold->aside_m, hold->aside_m) - turned[0];
  p.translation_m[1] = random_between(r, -0.75 * hold->aside_m, 0.75 * hold->aside_m) - turned[1];
  p.translation_m[2] = random_between(r, hold->nearest_m, hold->farthest_m) - turned[2];
  return p;
}

/* Corners of a pose inside the frame, without noise; returns how many. */
static inline int board_see(const hl_camera *camera, const hl_target *target, const hl_pose *pose,
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
    if (hl_camera_unproject(NULL, camera, q[0], q[1], ray) != HL_OK ||
        !(fabs(ray[0] / ray[2] - at[0] / at[2]) < 1e-6) ||
        !(fabs(ray[1] / ray[2] - at[1] / at[2]) < 1e-6))
      continue;
    corner[i] = (hl_corner){q[0], q[1], 1};
    seen++;
  }
  return seen;
}

/* `n` views without noise; the poses go to `poses` where that is not NULL. */
static inline hl_corners board_views(const hl_camera *camera, const hl_target *target, int n,
                                     uint64_t seed, const board_hold *hold, hl_pose *poses)
{
  test_random r = {seed * 2654435761u + 12345};
  hl_corners set = hl_corners_of(target);
  hl_corner corner[64 * 64];
  set.width = camera->width;
  set.height = camera->height;
  for (int v = 0; v < n;) {
    const hl_pose pose = board_pose(&r, target, hold);
    const int seen = board_see(camera, target, &pose, corner);
    char name[32];
    hl_view *view;
    if (seen < hold->least_share * hl_target_corners(target))
      continue;
    snprintf(name, sizeof name, "view%02d.png", v);
    assert_int_equal(hl_corners_add(NULL, &set, name, &view), HL_OK);
    memcpy(view->corner, corner, (size_t)hl_target_corners(target) * sizeof *corner);
    view->seen = seen;
    if (poses)
      poses[v] = pose;
    v++;
  }
  return set;
}

/* A copy with noise of `sigma` px times each corner's own deviation. */
static inline hl_corners board_noisy(const hl_corners *set, double sigma, uint64_t seed)
{
  test_random r = {seed * 6364136223846793005u + 1442695040888963407u};
  hl_corners out = hl_corners_of(&set->target);
  out.width = set->width;
  out.height = set->height;
  for (int v = 0; v < set->n_views; v++) {
    hl_view *view;
    assert_int_equal(hl_corners_add(NULL, &out, set->view[v].name, &view), HL_OK);
    view->seen = set->view[v].seen;
    for (int i = 0; i < hl_target_corners(&set->target); i++) {
      hl_corner c = set->view[v].corner[i];
      if (c.sigma > 0) {
        c.x += sigma * c.sigma * random_normal(&r);
        c.y += sigma * c.sigma * random_normal(&r);
      }
      view->corner[i] = c;
    }
  }
  return out;
}

/* Calibrated with the defaults and this model, which must work. */
static inline hl_calibration board_calibrated(const hl_corners *corners, hl_model_choice model)
{
  hl_calibration_settings s = hl_calibration_defaults();
  hl_calibration out;
  hl_ctx ctx = {0};
  s.model = model;
  const hl_status st = hl_calibrate(&ctx, corners, &s, &out);
  if (st != HL_OK)
    print_error("%s\n", ctx.msg);
  assert_int_equal(st, HL_OK);
  return out;
}

#endif
