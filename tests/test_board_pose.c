/* The pose of a board that stands still, from one view of a calibrated camera. */
#include "drift_scene.h"

#include "files.h"

static const hl_pose fixed_pose = {{0.35, -0.3, 0.1}, {-0.12, -0.1, 0.42}};

static hl_calibration calibration_of(const drift_scene *s)
{
  const hl_calibration c = {.camera = s->camera, .noise_px = s->noise_px};
  return c;
}

static hl_corners seen(const drift_scene *s, test_random *r)
{
  hl_corners set = hl_corners_of(&s->target);
  hl_view *view;
  set.width = s->camera.width;
  set.height = s->camera.height;
  assert_int_equal(hl_corners_add(NULL, &set, "fixed.png", &view), HL_OK);
  view->seen = drift_see(&s->camera, &s->target, &fixed_pose, view->corner);
  if (r)
    drift_noise(s, r, view->corner);
  return set;
}

#ifdef HL_HAVE_OPENCV
static void numbers(const hl_pose *p, double out[HL_POSE_SIZE])
{
  memcpy(out, p->rotation_rad, 3 * sizeof *out);
  memcpy(out + 3, p->translation_m, 3 * sizeof *out);
}

static void test_exact_corners_give_the_pose(void **state)
{
  (void)state;
  for (int model = 0; model < 3; model++) {
    const drift_scene s = drift_scene_of((hl_lens_model)model, 1, 1);
    const hl_calibration c = calibration_of(&s);
    hl_corners corners = seen(&s, NULL);
    hl_board_pose pose;
    double got[HL_POSE_SIZE];
    assert_int_equal(hl_board_pose_fit(NULL, &c, &corners, 0, &pose), HL_OK);
    numbers(&pose.cam_from_board, got);
    for (int i = 0; i < 3; i++) {
      assert_near(got[i], fixed_pose.rotation_rad[i], 1e-9);
      assert_near(got[3 + i], fixed_pose.translation_m[i], 1e-9);
    }
    assert_int_equal(pose.corners, corners.view[0].seen);
    assert_near(pose.rms_px, 0, 1e-6);
    assert_true(pose.has_covariance);
    assert_false(pose.camera.has_covariance);
    hl_corners_free(&corners);
  }
}

/* Seen from afar, the other of the two poses that explain a plane is nearly as good. */
static void test_the_better_of_two_poses(void **state)
{
  (void)state;
  drift_scene s = drift_scene_of(HL_LENS_PINHOLE, 1, 1);
  test_random r = {41};
  s.noise_px = 0.02;
  for (int run = 0; run < 10; run++) {
    const hl_pose far = {{0.5, 0.1, 0}, {-0.1, -0.1, 1.5}};
    hl_corners corners = seen(&s, NULL);
    const hl_calibration c = calibration_of(&s);
    hl_board_pose pose;
    corners.view[0].seen = drift_see(&s.camera, &s.target, &far, corners.view[0].corner);
    drift_noise(&s, &r, corners.view[0].corner);
    assert_int_equal(hl_board_pose_fit(NULL, &c, &corners, 0, &pose), HL_OK);
    for (int i = 0; i < 3; i++)
      assert_near(pose.cam_from_board.rotation_rad[i], far.rotation_rad[i], 0.05);
    hl_corners_free(&corners);
  }
}

static void test_covariance_is_the_scatter(void **state)
{
  (void)state;
  const drift_scene s = drift_scene_of(HL_LENS_PINHOLE, 1, 1);
  const hl_calibration c = calibration_of(&s);
  test_random r = {42};
  double sum[HL_POSE_SIZE] = {0}, truth[HL_POSE_SIZE];
  enum { RUNS = 300 };
  numbers(&fixed_pose, truth);
  for (int run = 0; run < RUNS; run++) {
    hl_corners corners = seen(&s, &r);
    hl_board_pose pose;
    double got[HL_POSE_SIZE];
    assert_int_equal(hl_board_pose_fit(NULL, &c, &corners, 0, &pose), HL_OK);
    numbers(&pose.cam_from_board, got);
    for (int i = 0; i < HL_POSE_SIZE; i++) {
      sum[i] += pow(got[i] - truth[i], 2) / pose.covariance[i][i];
    }
    hl_corners_free(&corners);
  }
  for (int i = 0; i < HL_POSE_SIZE; i++) /* 1 / sqrt(600) = 4 %; the larger noise counts */
    assert_near(sqrt(sum[i] / RUNS), 0.98, 0.13);
}

static void test_by_intrinsics_matches_finite_differences(void **state)
{
  (void)state;
  const drift_scene s = drift_scene_of(HL_LENS_PINHOLE, 1, 1);
  const hl_calibration c = calibration_of(&s);
  hl_corners corners = seen(&s, NULL);
  hl_board_pose pose;
  assert_int_equal(hl_board_pose_fit(NULL, &c, &corners, 0, &pose), HL_OK);
  for (int k = 0; k < 9; k++) {
    const double h = k < 4 ? 1e-2 : 1e-5;
    double end[2][HL_POSE_SIZE];
    for (int side = 0; side < 2; side++) {
      hl_calibration moved = c;
      hl_board_pose at;
      double theta[HL_INTRINSICS_MAX];
      hl_camera_intrinsics(&c.camera, theta);
      theta[k] += side ? h : -h;
      hl_camera_set_intrinsics(&moved.camera, theta);
      assert_int_equal(hl_board_pose_fit(NULL, &moved, &corners, 0, &at), HL_OK);
      numbers(&at.cam_from_board, end[side]);
    }
    double size = 0;
    for (int i = 0; i < HL_POSE_SIZE; i++)
      size = fmax(size, fabs(pose.by_intrinsics[i][k]));
    for (int i = 0; i < HL_POSE_SIZE; i++)
      assert_near(pose.by_intrinsics[i][k], (end[1][i] - end[0][i]) / (2 * h), 2e-4 * size);
  }
  hl_corners_free(&corners);
}

/* The view's own noise counts where it is more than the calibration's. */
static void test_a_noisier_view_is_less_sure(void **state)
{
  (void)state;
  drift_scene s = drift_scene_of(HL_LENS_PINHOLE, 1, 1);
  const hl_calibration c = calibration_of(&s);
  test_random r = {43};
  hl_board_pose calm, noisy;
  hl_corners corners = seen(&s, NULL);
  assert_int_equal(hl_board_pose_fit(NULL, &c, &corners, 0, &calm), HL_OK);
  hl_corners_free(&corners);
  s.noise_px *= 5;
  corners = seen(&s, &r);
  assert_int_equal(hl_board_pose_fit(NULL, &c, &corners, 0, &noisy), HL_OK);
  hl_corners_free(&corners);
  for (int i = 0; i < HL_POSE_SIZE; i++) /* 114 residuals: 7 % */
    assert_near(sqrt(noisy.covariance[i][i] / calm.covariance[i][i]), 5, 1);
}
#else
static void test_needs_opencv(void **state)
{
  (void)state;
  const drift_scene s = drift_scene_of(HL_LENS_PINHOLE, 1, 1);
  const hl_calibration c = calibration_of(&s);
  hl_corners corners = seen(&s, NULL);
  hl_board_pose pose;
  hl_ctx ctx = {0};
  assert_int_equal(hl_board_pose_fit(&ctx, &c, &corners, 0, &pose), HL_ERR_UNAVAILABLE);
  assert_says(ctx.msg, "-DHL_WITH_OPENCV=ON");
  hl_corners_free(&corners);
}
#endif

static void refused(const hl_calibration *c, const hl_corners *corners, int view, hl_status status,
                    const char *part)
{
  hl_ctx ctx = {0};
  static hl_board_pose out, before;
  memset(&out, 0x5a, sizeof out);
  before = out;
  assert_int_equal(hl_board_pose_fit(&ctx, c, corners, view, &out), status);
  assert_says(ctx.msg, part);
  assert_memory_equal(&out, &before, sizeof out);
}

static void test_refusals(void **state)
{
  (void)state;
  const drift_scene s = drift_scene_of(HL_LENS_PINHOLE, 1, 1);
  hl_calibration c = calibration_of(&s);
  hl_corners corners = seen(&s, NULL);
  refused(&c, &corners, -1, HL_ERR_ARG, "view -1 of 1 views");
  corners.height = 200;
  refused(&c, &corners, 0, HL_ERR_FORMAT, "fixed.png has 640 x 200 px, the camera 640 x 480");
  corners.height = 480;
  corners.view[0].used = false;
  snprintf(corners.view[0].why, sizeof corners.view[0].why, "seen mirrored");
  refused(&c, &corners, 0, HL_ERR_DEGENERATE, "fixed.png: seen mirrored");
  corners.view[0].used = true;
  corners.view[0].seen = 4;
  refused(&c, &corners, 0, HL_ERR_DEGENERATE, "4 corners of the board are seen; 12 are needed");
  hl_corners_free(&corners);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
#ifdef HL_HAVE_OPENCV
      cmocka_unit_test(test_exact_corners_give_the_pose),
      cmocka_unit_test(test_the_better_of_two_poses),
      cmocka_unit_test(test_covariance_is_the_scatter),
      cmocka_unit_test(test_by_intrinsics_matches_finite_differences),
      cmocka_unit_test(test_a_noisier_view_is_less_sure),
#else
      cmocka_unit_test(test_needs_opencv),
#endif
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
