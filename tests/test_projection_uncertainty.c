/* How far a pixel may be off: against calibrations of repeated noise, and what is refused. */
#include <string.h>

#include "corner_scene.h"

enum { VIEWS = 10, DRAWS = 40, POINTS = 10 };

static hl_corners scene(hl_pose *poses)
{
  const hl_camera camera = board_camera(HL_LENS_PINHOLE);
  const hl_target target = board_target();
  const board_hold hold = board_held(&camera);
  return board_views(&camera, &target, VIEWS, 41, &hold, poses);
}

/* Where another calibration sees the point that is fixed to the boards as the truth has them: the
 * mean over the boards, then projected. A direction does not feel translations. */
static void seen_again(const hl_calibration *c, const hl_pose *truth, const double point[3],
                       bool direction, double pixel[2])
{
  double mean[3] = {0};
  for (int v = 0; v < c->n_views; v++) {
    hl_pose before = truth[v], now = c->view[v].cam_from_board, to_board;
    double fixed[3], moved[3];
    if (direction) {
      memset(before.translation_m, 0, sizeof before.translation_m);
      memset(now.translation_m, 0, sizeof now.translation_m);
    }
    hl_pose_inverse(&before, &to_board);
    hl_pose_apply(&to_board, point, fixed, NULL, NULL);
    hl_pose_apply(&now, fixed, moved, NULL, NULL);
    for (int i = 0; i < 3; i++)
      mean[i] += moved[i] / c->n_views;
  }
  assert_int_equal(hl_camera_project(NULL, &c->camera, mean, pixel), HL_OK);
}

/* d' C^-1 d of two numbers. */
static double mahalanobis(double c[2][2], const double d[2])
{
  const double det = c[0][0] * c[1][1] - c[0][1] * c[1][0];
  return (d[0] * d[0] * c[1][1] - 2 * d[0] * d[1] * c[0][1] + d[1] * d[1] * c[0][0]) / det;
}

/* Centre and corners of the frame, as directions and at the boards' mean distance: the squared
 * distance in units of the stated covariance is 2 on the mean. */
static void test_against_repeated_noise(void **state)
{
  (void)state;
  hl_pose poses[VIEWS];
  const hl_camera camera = board_camera(HL_LENS_PINHOLE);
  hl_corners set = scene(poses);
  double sum[POINTS] = {0}, all = 0;
  for (uint64_t draw = 0; draw < DRAWS; draw++) {
    hl_corners noisy = board_noisy(&set, 0.1, 500 + draw);
    hl_calibration c = board_calibrated(&noisy, HL_MODEL_PINHOLE);
    assert_int_equal(c.n_projections, POINTS);
    for (int i = 0; i < POINTS; i++) {
      hl_projection *p = &c.projection[i];
      const bool direction = !isfinite(p->distance_m);
      double ray[3], again[2];
      assert_int_equal(hl_camera_unproject(NULL, &camera, p->pixel[0], p->pixel[1], ray), HL_OK);
      for (int k = 0; k < 3; k++)
        ray[k] *= direction ? 1 : p->distance_m;
      seen_again(&c, poses, ray, direction, again);
      const double d[2] = {again[0] - p->pixel[0], again[1] - p->pixel[1]};
      sum[i] += mahalanobis(p->covariance_px2, d) / 2 / DRAWS;
      all += mahalanobis(p->covariance_px2, d) / 2 / DRAWS / POINTS;
    }
    hl_calibration_free(&c);
    hl_corners_free(&noisy);
  }
  for (int i = 0; i < POINTS; i++)
    assert_near(sum[i], 1, 4 / sqrt(DRAWS)); /* deviation of the mean of DRAWS chi-squared / 2 */
  assert_near(all, 1, 0.25);                 /* they share the draws */
  hl_corners_free(&set);
}

/* Where the boards were, a pixel is surer than at infinity. */
static void test_surest_among_the_boards(void **state)
{
  (void)state;
  hl_corners set = scene(NULL);
  hl_corners noisy = board_noisy(&set, 0.1, 1);
  hl_calibration c = board_calibrated(&noisy, HL_MODEL_PINHOLE);
  const double middle[2] = {320, 240};
  double at[2][2], infinity[2][2], far_away[2][2];
  assert_int_equal(hl_projection_covariance(NULL, &c, middle, 0.42, at), HL_OK);
  assert_int_equal(hl_projection_covariance(NULL, &c, middle, HUGE_VAL, infinity), HL_OK);
  assert_int_equal(hl_projection_covariance(NULL, &c, middle, 1e5, far_away), HL_OK);
  assert_true(at[0][0] < infinity[0][0] / 9);
  assert_true(at[1][1] < infinity[1][1] / 9);
  /* directions are the limit of far points, up to how the poses' translations move them */
  assert_near(far_away[0][0] / infinity[0][0], 1, 1e-3);
  assert_near(far_away[0][1] / infinity[0][0], infinity[0][1] / infinity[0][0], 1e-3);
  assert_near(infinity[0][1], infinity[1][0], 0);
  hl_calibration_free(&c);
  hl_corners_free(&noisy);
  hl_corners_free(&set);
}

static void test_refusals(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  const double pixel[2] = {320, 240};
  double out[2][2] = {{7, 7}, {7, 7}};
  hl_calibration bare = {.camera = board_camera(HL_LENS_PINHOLE)};
  assert_int_equal(hl_projection_covariance(&ctx, &bare, pixel, HUGE_VAL, out), HL_ERR_DEGENERATE);
  assert_non_null(strstr(ctx.msg, "has no views"));
  assert_int_equal(hl_projection_covariance(&ctx, &bare, pixel, 0, out), HL_ERR_ARG);
  assert_int_equal(hl_projection_covariance(&ctx, &bare, pixel, NAN, out), HL_ERR_ARG);
  hl_corners set = scene(NULL);
  hl_calibration c = board_calibrated(&set, HL_MODEL_PINHOLE);
  const double nowhere[2] = {1e6, 0};
  assert_int_equal(hl_projection_covariance(&ctx, &c, nowhere, 1, out), HL_ERR_NOT_CONVERGED);
  c.camera.has_covariance = false;
  assert_int_equal(hl_projection_covariance(&ctx, &c, pixel, 1, out), HL_ERR_DEGENERATE);
  assert_non_null(strstr(ctx.msg, "has no covariance"));
  assert_near(out[0][0] + out[0][1] + out[1][0] + out[1][1], 28, 0);
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

static void test_full_list(void **state)
{
  (void)state;
  hl_corners set = scene(NULL);
  hl_calibration c = board_calibrated(&set, HL_MODEL_PINHOLE);
  const double pixel[2] = {100, 50};
  while (c.n_projections < HL_PROJECTIONS_MAX)
    assert_int_equal(hl_calibration_project(NULL, &c, pixel, 2), HL_OK);
  assert_near(c.projection[20].distance_m, 2, 0);
  assert_near(c.projection[20].pixel[1], 50, 0);
  assert_int_equal(hl_calibration_project(NULL, &c, pixel, 2), HL_ERR_ARG);
  assert_int_equal(c.n_projections, HL_PROJECTIONS_MAX);
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_against_repeated_noise),
      cmocka_unit_test(test_surest_among_the_boards),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_full_list),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
