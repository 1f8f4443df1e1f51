/* Where two cameras see the same points: the difference, its deviations, and what is taken out. */
#include "../calib/drift_projection.h"

#include "drift_scene.h"

static hl_calibration plain_camera(double focal)
{
  hl_calibration c = {.camera = {.model = HL_LENS_PINHOLE,
                                 .width = 640,
                                 .height = 480,
                                 .fx = focal,
                                 .fy = focal,
                                 .cx = 319.5,
                                 .cy = 239.5,
                                 .n_distortion = 5,
                                 .has_covariance = true}};
  static const double deviation[9] = {0.1, 0.1, 0.1, 0.1, 1e-3, 1e-3, 1e-4, 1e-4, 1e-3};
  for (int i = 0; i < 9; i++)
    c.camera.covariance[10 * i] = deviation[i] * deviation[i];
  return c;
}

static hl_drift compared(const hl_calibration *reference, const hl_calibration *current,
                         double distance_m)
{
  const hl_drift_settings s = {.false_alarm = 0.01, .distance_m = distance_m};
  hl_ctx ctx = {0};
  hl_drift d;
  if (hl_drift_cameras(&ctx, reference, current, &s, &d) != HL_OK)
    fail_msg("%s", ctx.msg);
  return d;
}

static void test_grid_covers_the_frame(void **state)
{
  (void)state;
  const hl_calibration a = plain_camera(700);
  const hl_drift d = compared(&a, &a, 0);
  assert_int_equal(d.columns, 25);
  assert_int_equal(d.rows, 19); /* 25 * 480 / 640, rounded */
  assert_int_equal(d.n_nodes, 25 * 19);
  assert_near(d.at_px[0][0], 0, 0);
  assert_near(d.at_px[0][1], 0, 0);
  assert_near(d.at_px[d.n_nodes - 1][0], 639, 1e-12);
  assert_near(d.at_px[d.n_nodes - 1][1], 479, 1e-12);
  assert_near(d.max_px, 0, 1e-9);
  for (int k = 0; k < d.n_nodes; k++)
    assert_true(d.sigma_px[k] > 0);
}

/* Seen narrowly, a centre that moved is a rotation: 3 px at 7000 px, second order left. */
static void test_a_rotation_is_taken_out(void **state)
{
  (void)state;
  const hl_calibration a = plain_camera(7000);
  hl_calibration b = a;
  b.camera.cx += 3;
  const hl_drift d = compared(&a, &b, 0);
  assert_near(d.implied.rotation_rad[1], -3.0 / 7000, 1e-6);
  assert_near(d.implied.rotation_rad[0], 0, 1e-9);
  assert_near(hl_norm(d.implied.translation_m), 0, 0);
  assert_true(d.max_px < 3 * pow(320.0 / 7000, 2) * 2);
  /* the verdict does not let it pass: the rotation is the covariance's to give, not the test's */
  assert_true(d.drifted);
}

/* Of a camera twice as long sighted what is left is no rotation. */
static void test_a_focal_change_stays(void **state)
{
  (void)state;
  const hl_calibration a = plain_camera(700);
  hl_calibration b = a;
  b.camera.fx *= 1.01;
  b.camera.fy *= 1.01;
  const hl_drift d = compared(&a, &b, 0);
  const int corner = 0, middle = 9 * 25 + 12;
  assert_near(d.difference_px[corner][0], -0.01 * 319.5, 0.02);
  assert_near(d.difference_px[corner][1], -0.01 * 239.5, 0.02);
  assert_near(d.difference_px[middle][0], 0, 1e-6);
  assert_near(d.max_px, 0.01 * hypot(319.5, 239.5), 0.03);
}

/* At one distance a nearer camera looks much like a longer lens, so a translation takes most of it. */
static void test_a_translation_is_taken_out_at_a_distance(void **state)
{
  (void)state;
  const hl_calibration a = plain_camera(700);
  hl_calibration b = a;
  b.camera.fx *= 1.01;
  b.camera.fy *= 1.01;
  const hl_drift far = compared(&a, &b, 0), near = compared(&a, &b, 0.5);
  assert_true(near.mean_px < 0.3 * far.mean_px);
  assert_near(near.implied.translation_m[2], 0.005, 0.002);
  assert_near(near.significance, far.significance, 0); /* the verdict is not about the picture */
}

/* 95 % of the nodes of unchanged cameras are within 2.4477 deviations, and (|d|/sigma)^2 is 2. */
static void test_deviations_are_the_scatter(void **state)
{
  (void)state;
  test_random r = {21};
  double sum = 0;
  int beyond = 0, n = 0;
  for (int run = 0; run < 60; run++) {
    const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 10, (uint64_t)(2 * run + 1));
    const drift_scene b = drift_scene_of(HL_LENS_PINHOLE, 10, (uint64_t)(2 * run + 2));
    hl_calibration ca = drift_calibrate(&a, &r), cb = drift_calibrate(&b, &r);
    const hl_drift d = compared(&ca, &cb, run % 2 ? 0.4 : 0);
    for (int k = 0; k < d.n_nodes; k += 7) {
      const double z = hypot(d.difference_px[k][0], d.difference_px[k][1]) / d.sigma_px[k];
      sum += z * z;
      beyond += z > 2.4477468306808162; /* sqrt of the chi-square's 5.9914645 */
      n++;
    }
    hl_calibration_free(&ca);
    hl_calibration_free(&cb);
  }
  /* nodes of one pair go together: some 60 x 5 independent numbers */
  assert_near(sum / n, 2, 0.4);
  assert_near((double)beyond / n, 0.05, 0.035);
}

/* A lens that folds inside the frame sees nothing beyond; the rest is compared. */
static void test_nodes_that_one_camera_does_not_see(void **state)
{
  (void)state;
  const hl_calibration a = plain_camera(500);
  hl_calibration b = a;
  b.camera.distortion[0] = -0.8; /* folds at 1/sqrt(2.4) = 0.645, the frame's corner is at 0.8 */
  const hl_drift d = compared(&a, &b, 0);
  assert_true(isnan(d.difference_px[0][0]));
  assert_true(isnan(d.sigma_px[0]));
  assert_true(isfinite(d.difference_px[9 * 25 + 12][0]));
  assert_true(isfinite(d.mean_px) && isfinite(d.max_px));
}

static void test_effect_matches_finite_differences(void **state)
{
  (void)state;
  for (int model = 0; model < 3; model++) {
    const hl_camera c = drift_camera((hl_lens_model)model);
    double metric[HL_DISTORTION_MAX][HL_DISTORTION_MAX];
    hl_drift_effect(&c, 4, c.n_distortion, metric);
    for (int k = 0; k < c.n_distortion; k++) {
      const double h = 1e-6;
      hl_camera up = c, down = c;
      double sum = 0;
      int n = 0;
      up.distortion[k] += h;
      down.distortion[k] -= h;
      for (int y = 0; y < 19; y++)
        for (int x = 0; x < 25; x++) {
          double ray[3], p[2], q[2];
          assert_int_equal(hl_camera_unproject(NULL, &c, x * 639.0 / 24, y * 479.0 / 18, ray),
                           HL_OK);
          assert_int_equal(hl_camera_project(NULL, &up, ray, p), HL_OK);
          assert_int_equal(hl_camera_project(NULL, &down, ray, q), HL_OK);
          sum += pow((p[0] - q[0]) / (2 * h), 2) + pow((p[1] - q[1]) / (2 * h), 2);
          n++;
        }
      assert_near(metric[k][k] / (sum / n), 1, 1e-5);
      for (int j = 0; j < c.n_distortion; j++)
        assert_near(metric[k][j], metric[j][k], 1e-9 * fabs(metric[k][j]));
    }
  }
}

static void test_deviation_in_a_direction(void **state)
{
  (void)state;
  const double c[2][2] = {{4, 0}, {0, 1}};
  const double x[2] = {3, 0}, y[2] = {0, -2}, none[2] = {0, 0}, both[2] = {1, 1};
  assert_near(hl_drift_deviation(x, c), 2, 1e-15);
  assert_near(hl_drift_deviation(y, c), 1, 1e-15);
  assert_near(hl_drift_deviation(none, c), 2, 1e-15);
  /* 1/s^2 = (1/2)(1/4) + (1/2)(1/1) */
  assert_near(hl_drift_deviation(both, c), 1 / sqrt(0.625), 1e-15);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_grid_covers_the_frame),
      cmocka_unit_test(test_a_rotation_is_taken_out),
      cmocka_unit_test(test_a_focal_change_stays),
      cmocka_unit_test(test_a_translation_is_taken_out_at_a_distance),
      cmocka_unit_test(test_deviations_are_the_scatter),
      cmocka_unit_test(test_nodes_that_one_camera_does_not_see),
      cmocka_unit_test(test_effect_matches_finite_differences),
      cmocka_unit_test(test_deviation_in_a_direction),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
