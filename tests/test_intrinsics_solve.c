/* The minimum itself: found from elsewhere, known when it is there, and where it does not exist. */
#include <stdlib.h>
#include <string.h>

#include "../calib/intrinsics.h"
#include "corner_scene.h"

enum { VIEWS = 8 };

/* A problem at the truth. */
typedef struct solving {
  hl_corners set, noisy;
  hl_pose poses[VIEWS];
  hl_calibration_settings settings;
  hl_intrinsics problem;
} solving;

static void begin(solving *s, hl_lens_model model, double noise)
{
  const hl_camera camera = board_camera(model);
  const hl_target target = board_target();
  const board_hold hold = board_held(&camera);
  s->settings = hl_calibration_defaults();
  s->set = board_views(&camera, &target, VIEWS, 51, &hold, s->poses);
  s->noisy = board_noisy(&s->set, noise, 52);
  assert_int_equal(hl_intrinsics_new(NULL, &s->noisy, &s->settings, &s->problem), HL_OK);
  s->problem.camera = camera;
  for (int v = 0; v < VIEWS; v++)
    s->problem.view[v].pose = s->poses[v];
}

static void end(solving *s)
{
  hl_intrinsics_free(&s->problem);
  hl_corners_free(&s->noisy);
  hl_corners_free(&s->set);
}

/* From a focal length 30 % off and boards 20 cm too near. */
static void test_from_afar(void **state)
{
  (void)state;
  static const hl_lens_model models[] = {HL_LENS_PINHOLE, HL_LENS_FISHEYE};
  for (int m = 0; m < 2; m++) {
    solving s;
    begin(&s, models[m], 0.1);
    assert_int_equal(hl_intrinsics_solve(NULL, &s.problem), HL_OK);
    const hl_camera want = s.problem.camera;
    const double cost = s.problem.cost;
    s.problem.camera.fx *= 0.7;
    s.problem.camera.fy *= 0.7;
    memset(s.problem.camera.distortion, 0, sizeof s.problem.camera.distortion);
    for (int v = 0; v < VIEWS; v++)
      s.problem.view[v].pose.translation_m[2] *= 0.7;
    assert_int_equal(hl_intrinsics_solve(NULL, &s.problem), HL_OK);
    assert_near(s.problem.camera.fx, want.fx, 1e-6);
    assert_near(s.problem.camera.cy, want.cy, 1e-6);
    assert_near(s.problem.camera.distortion[1], want.distortion[1], 1e-6);
    assert_near(s.problem.cost / cost, 1, 1e-12);
    assert_true(s.problem.stationarity < 1e-3);
    end(&s);
  }
}

/* Off by k deviations along the weakest direction of the intrinsics, poses adapted: the distance is
 * stated as k. */
static void test_stationarity(void **state)
{
  (void)state;
  solving s;
  begin(&s, HL_LENS_PINHOLE, 0.1);
  hl_intrinsics *p = &s.problem;
  assert_int_equal(hl_intrinsics_solve(NULL, p), HL_OK);
  const int n = p->arrow.n;
  double theta[HL_INTRINSICS_MAX], covariance[HL_INTRINSICS_MAX * HL_INTRINSICS_MAX];
  hl_spd_inverse(&p->arrow.schur, covariance);
  const double sd = sqrt(p->cost / hl_intrinsics_freedom(p) * covariance[0]);
  hl_camera_intrinsics(&p->camera, theta);
  double move[HL_INTRINSICS_MAX]; /* k deviations of fx, the others following it */
  for (int k = 0; k < n; k++) {
    move[k] = 0.01 * sd * covariance[k] / covariance[0];
    theta[k] += move[k];
  }
  hl_camera_set_intrinsics(&p->camera, theta);
  for (int v = 0; v < VIEWS; v++)
    for (int i = 0; i < 3; i++)
      for (int k = 0; k < n; k++) {
        p->view[v].pose.rotation_rad[i] -= p->block[v].w[k][i] * move[k];
        p->view[v].pose.translation_m[i] -= p->block[v].w[k][3 + i] * move[k];
      }
  assert_int_equal(hl_intrinsics_linearise(NULL, p), HL_OK);
  assert_near(p->stationarity, 0.01, 1e-4);
  end(&s);
}

/* One board held still in all views: nothing tells its distance from the focal length. */
static void test_singular(void **state)
{
  (void)state;
  solving s;
  hl_ctx ctx = {0};
  begin(&s, HL_LENS_PINHOLE, 0);
  hl_intrinsics *p = &s.problem;
  for (int v = 0; v < VIEWS; v++)
    p->view[v].used = v == 0;
  for (int i = 0; i < p->view[0].n; i++) /* four corners: 8 numbers for 15 unknowns */
    p->view[0].sighting[i].used = i % 30 == 0 && i < 120;
  assert_int_equal(hl_intrinsics_linearise(&ctx, p), HL_ERR_DEGENERATE);
  assert_non_null(strstr(ctx.msg, "the views do not determine the camera"));
  end(&s);
}

static void test_behind(void **state)
{
  (void)state;
  solving s;
  hl_ctx ctx = {0};
  begin(&s, HL_LENS_PINHOLE, 0.1);
  s.problem.view[2].pose.translation_m[2] = -1;
  assert_int_equal(hl_intrinsics_solve(&ctx, &s.problem), HL_ERR_DEGENERATE);
  assert_non_null(strstr(ctx.msg, "in front of the camera"));
  end(&s);
}

/* OpenCV's answer, and ours where OpenCV has none to give. */
static void test_start(void **state)
{
  (void)state;
  for (int model = 0; model < 3; model++) {
    solving s;
    hl_ctx ctx = {0};
    begin(&s, (hl_lens_model)model, 0.1);
    const hl_camera truth = s.problem.camera;
    s.problem.camera = (hl_camera){.width = truth.width, .height = truth.height};
    for (int v = 0; v < VIEWS; v++)
      memset(&s.problem.view[v].pose, 0, sizeof s.problem.view[v].pose);
    assert_int_equal(hl_intrinsics_start(&ctx, &s.problem, (hl_lens_model)model), HL_OK);
    assert_near(s.problem.camera.fx, truth.fx, 2);
    assert_near(s.problem.camera.cx, truth.cx, 2);
    assert_near(sqrt(s.problem.cost / hl_intrinsics_freedom(&s.problem)), 0.1, 0.01);
    end(&s);
  }
}

/* A pinhole seen as a fisheye, where OpenCV gives up: the row of focal lengths finds the minimum. */
static void test_start_without_opencv(void **state)
{
  (void)state;
  solving s;
  begin(&s, HL_LENS_PINHOLE, 0.1);
  s.problem.camera = (hl_camera){.width = 640, .height = 480};
  assert_int_equal(hl_intrinsics_start(NULL, &s.problem, HL_LENS_FISHEYE), HL_OK);
  assert_true(strlen(s.problem.opencv.msg) > 0);
  assert_near(s.problem.camera.fx, 700, 5);
  assert_near(sqrt(s.problem.cost / hl_intrinsics_freedom(&s.problem)), 0.1, 0.01);
  end(&s);
}

static void test_states(void **state)
{
  (void)state;
  solving s;
  hl_intrinsics_state kept;
  begin(&s, HL_LENS_PINHOLE, 0.1);
  assert_int_equal(hl_intrinsics_solve(NULL, &s.problem), HL_OK);
  assert_int_equal(hl_intrinsics_state_new(NULL, &s.problem, &kept), HL_OK);
  hl_intrinsics_save(&s.problem, &kept);
  const hl_camera camera = s.problem.camera;
  s.problem.camera.fx = 1;
  hl_intrinsics_leave_out(&s.problem.view[1], "for %s", "nothing");
  s.problem.view[0].sighting[0].used = false;
  assert_int_equal(hl_intrinsics_views_used(&s.problem), VIEWS - 1);
  hl_intrinsics_restore(&s.problem, &kept);
  assert_memory_equal(&s.problem.camera, &camera, sizeof camera);
  assert_int_equal(hl_intrinsics_views_used(&s.problem), VIEWS);
  assert_true(s.problem.view[0].sighting[0].used);
  hl_intrinsics_state_free(&kept);
  end(&s);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_from_afar), cmocka_unit_test(test_stationarity),
      cmocka_unit_test(test_singular),  cmocka_unit_test(test_behind),
      cmocka_unit_test(test_start),     cmocka_unit_test(test_start_without_opencv),
      cmocka_unit_test(test_states),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
