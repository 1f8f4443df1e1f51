/* A camera from corners: exact on exact ones, deviations that are those of repeated noise, and what
 * the answer must not depend on. */
#include <stdlib.h>

#include "corner_scene.h"

enum { VIEWS = 12, DRAWS = 30 };

static hl_corners scene_of(hl_lens_model model, int views, hl_pose *poses)
{
  const hl_camera camera = board_camera(model);
  const hl_target target = board_target();
  const board_hold hold = board_held(&camera);
  assert_int_equal(hl_camera_check(NULL, &camera), HL_OK);
  return board_views(&camera, &target, views, 7, &hold, poses);
}

/* analytic: corners without noise give the camera and the poses back */
static void test_exact(void **state)
{
  (void)state;
  static const hl_lens_model models[] = {HL_LENS_PINHOLE, HL_LENS_FISHEYE};
  for (int m = 0; m < 2; m++) {
    hl_pose poses[VIEWS];
    hl_corners set = scene_of(models[m], VIEWS, poses);
    const hl_camera truth = board_camera(models[m]);
    hl_calibration c = board_calibrated(&set, m == 0 ? HL_MODEL_PINHOLE : HL_MODEL_FISHEYE);
    double got[HL_INTRINSICS_MAX], want[HL_INTRINSICS_MAX];
    hl_camera_intrinsics(&c.camera, got);
    hl_camera_intrinsics(&truth, want);
    for (int k = 0; k < hl_camera_intrinsics_count(&truth); k++)
      assert_near(got[k], want[k], k < 4 ? 1e-8 : 1e-10);
    for (int v = 0; v < VIEWS; v++)
      for (int i = 0; i < 3; i++) {
        assert_near(c.view[v].cam_from_board.rotation_rad[i], poses[v].rotation_rad[i], 1e-9);
        assert_near(c.view[v].cam_from_board.translation_m[i], poses[v].translation_m[i], 1e-9);
      }
    assert_true(c.trusted);
    assert_int_equal(c.corners_left_out, 0);
    assert_near(c.camera.rms_px, 0, 1e-9);
    hl_calibration_free(&c);
    hl_corners_free(&set);
  }
}

/* The rational model's coefficients are not unique, what it projects is. */
static void test_exact_rational(void **state)
{
  (void)state;
  hl_corners set = scene_of(HL_LENS_RATIONAL, VIEWS, NULL);
  const hl_camera truth = board_camera(HL_LENS_RATIONAL);
  hl_calibration c = board_calibrated(&set, HL_MODEL_RATIONAL);
  assert_near(c.camera.fx, truth.fx, 2e-3);
  assert_near(c.camera.fy, truth.fy, 2e-3);
  assert_near(c.camera.cx, truth.cx, 2e-3);
  assert_near(c.camera.cy, truth.cy, 2e-3);
  for (int y = 20; y < truth.height; y += 40)
    for (int x = 20; x < truth.width; x += 40) {
      double ray[3], q[2];
      assert_int_equal(hl_camera_unproject(NULL, &truth, x, y, ray), HL_OK);
      assert_int_equal(hl_camera_project(NULL, &c.camera, ray, q), HL_OK);
      assert_near(q[0], x, 1e-3);
      assert_near(q[1], y, 1e-3);
    }
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

/* d' C^-1 d by Gauss's elimination; C is n x n with rows `stride` apart. */
static double mahalanobis(const double *covariance, int n, const double *d)
{
  double a[HL_INTRINSICS_MAX + HL_POSE_SIZE][HL_INTRINSICS_MAX + HL_POSE_SIZE + 1];
  double scale[HL_INTRINSICS_MAX + HL_POSE_SIZE], sum = 0;
  for (int i = 0; i < n; i++)
    scale[i] = 1 / sqrt(covariance[i * n + i]);
  for (int i = 0; i < n; i++) {
    for (int k = 0; k < n; k++)
      a[i][k] = covariance[i * n + k] * scale[i] * scale[k];
    a[i][n] = d[i] * scale[i];
  }
  for (int c = 0; c < n; c++)
    for (int i = c + 1; i < n; i++) {
      const double f = a[i][c] / a[c][c];
      for (int k = c; k <= n; k++)
        a[i][k] -= f * a[c][k];
    }
  double x[HL_INTRINSICS_MAX + HL_POSE_SIZE];
  for (int i = n - 1; i >= 0; i--) {
    x[i] = a[i][n];
    for (int k = i + 1; k < n; k++)
      x[i] -= a[i][k] * x[k];
    x[i] /= a[i][i];
  }
  for (int i = 0; i < n; i++)
    sum += x[i] * scale[i] * d[i];
  return sum;
}

/* Own covariance and G into the pose's, as calibration.h has it. */
static void pose_covariance(const hl_calibration *c, int view,
                            double out[HL_POSE_SIZE * HL_POSE_SIZE])
{
  const hl_view_pose *v = &c->view[view];
  const int n = hl_camera_intrinsics_count(&c->camera);
  for (int i = 0; i < HL_POSE_SIZE; i++)
    for (int k = 0; k < HL_POSE_SIZE; k++) {
      double sum = v->own_covariance[i][k];
      for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++)
          sum += v->by_intrinsics[i][a] * c->camera.covariance[a * n + b] * v->by_intrinsics[k][b];
      out[i * HL_POSE_SIZE + k] = sum;
    }
}

/* Noise of 0.1 px times each corner's own deviation (every third has 3), many times: the squared
 * distances to the truth, in units of the stated covariance, have the mean that their number of
 * unknowns makes, to 3.5 of their own deviations sqrt(2 / (DRAWS unknowns)). */
static void test_stated_deviations(void **state)
{
  (void)state;
  static const hl_lens_model models[] = {HL_LENS_PINHOLE, HL_LENS_FISHEYE};
  for (int m = 0; m < 2; m++) {
    hl_pose poses[VIEWS];
    hl_corners set = scene_of(models[m], VIEWS, poses);
    const hl_camera truth = board_camera(models[m]);
    const int n = hl_camera_intrinsics_count(&truth);
    double want[HL_INTRINSICS_MAX], camera = 0, pose = 0, noise = 0;
    hl_camera_intrinsics(&truth, want);
    for (int v = 0; v < VIEWS; v++)
      for (int i = 0; i < hl_target_corners(&set.target); i++)
        set.view[v].corner[i].sigma *= i % 3 == 0 ? 3 : 1;
    for (uint64_t draw = 0; draw < DRAWS; draw++) {
      hl_corners noisy = board_noisy(&set, 0.1, 100 + draw);
      hl_calibration c = board_calibrated(&noisy, m == 0 ? HL_MODEL_PINHOLE : HL_MODEL_FISHEYE);
      double d[HL_INTRINSICS_MAX], p[HL_POSE_SIZE], cov[HL_POSE_SIZE * HL_POSE_SIZE];
      hl_camera_intrinsics(&c.camera, d);
      for (int k = 0; k < n; k++)
        d[k] -= want[k];
      camera += mahalanobis(c.camera.covariance, n, d) / n / DRAWS;
      for (int v = 0; v < VIEWS; v++) {
        for (int i = 0; i < 3; i++) {
          p[i] = c.view[v].cam_from_board.rotation_rad[i] - poses[v].rotation_rad[i];
          p[3 + i] = c.view[v].cam_from_board.translation_m[i] - poses[v].translation_m[i];
        }
        pose_covariance(&c, v, cov);
        pose += mahalanobis(cov, HL_POSE_SIZE, p) / HL_POSE_SIZE / VIEWS / DRAWS;
      }
      noise += c.noise_px / DRAWS;
      assert_near(c.scatter, 1, 0.6);
      hl_calibration_free(&c);
      hl_corners_free(&noisy);
    }
    assert_near(camera, 1, 3.5 * sqrt(2.0 / (DRAWS * n)));
    assert_near(pose, 1, 0.2); /* the views share the camera */
    assert_near(noise, 0.1, 0.001);
    hl_corners_free(&set);
  }
}

static void near_cameras(const hl_calibration *a, const hl_calibration *b, double deviations)
{
  const int n = hl_camera_intrinsics_count(&a->camera);
  double x[HL_INTRINSICS_MAX], y[HL_INTRINSICS_MAX];
  hl_camera_intrinsics(&a->camera, x);
  hl_camera_intrinsics(&b->camera, y);
  for (int k = 0; k < n; k++) {
    const double sd = sqrt(a->camera.covariance[k * n + k]);
    assert_near(x[k] / sd, y[k] / sd, deviations);
    assert_near(sqrt(b->camera.covariance[k * n + k]) / sd, 1, 1e-4);
  }
}

/* The order of views changes nothing beyond rounding, nor does turning every board by half a turn,
 * which counts the same corners from the other end. */
static void test_order(void **state)
{
  (void)state;
  hl_corners set = scene_of(HL_LENS_PINHOLE, VIEWS, NULL);
  hl_corners noisy = board_noisy(&set, 0.1, 1);
  hl_calibration a = board_calibrated(&noisy, HL_MODEL_PINHOLE);
  const int corners = hl_target_corners(&set.target);
  for (int i = 0; i < VIEWS / 2; i++) {
    const hl_view swap = noisy.view[i];
    noisy.view[i] = noisy.view[VIEWS - 1 - i];
    noisy.view[VIEWS - 1 - i] = swap;
  }
  hl_calibration b = board_calibrated(&noisy, HL_MODEL_PINHOLE);
  near_cameras(&a, &b, 1e-5);
  for (int v = 0; v < VIEWS; v++)
    for (int i = 0; i < corners / 2; i++) {
      const hl_corner swap = noisy.view[v].corner[i];
      noisy.view[v].corner[i] = noisy.view[v].corner[corners - 1 - i];
      noisy.view[v].corner[corners - 1 - i] = swap;
    }
  hl_calibration c = board_calibrated(&noisy, HL_MODEL_PINHOLE);
  near_cameras(&a, &c, 1e-5);
  hl_calibration_free(&a);
  hl_calibration_free(&b);
  hl_calibration_free(&c);
  hl_corners_free(&noisy);
  hl_corners_free(&set);
}

/* Frames turned by half a turn: the centre turns with them, the decentring changes sign. */
static void test_turned_frames(void **state)
{
  (void)state;
  hl_corners set = scene_of(HL_LENS_PINHOLE, VIEWS, NULL);
  hl_corners noisy = board_noisy(&set, 0.1, 2);
  hl_calibration a = board_calibrated(&noisy, HL_MODEL_PINHOLE);
  for (int v = 0; v < VIEWS; v++)
    for (int i = 0; i < hl_target_corners(&set.target); i++) {
      noisy.view[v].corner[i].x = noisy.width - 1 - noisy.view[v].corner[i].x;
      noisy.view[v].corner[i].y = noisy.height - 1 - noisy.view[v].corner[i].y;
    }
  hl_calibration b = board_calibrated(&noisy, HL_MODEL_PINHOLE);
  b.camera.cx = noisy.width - 1 - b.camera.cx;
  b.camera.cy = noisy.height - 1 - b.camera.cy;
  b.camera.distortion[2] = -b.camera.distortion[2];
  b.camera.distortion[3] = -b.camera.distortion[3];
  near_cameras(&a, &b, 1e-5);
  hl_calibration_free(&a);
  hl_calibration_free(&b);
  hl_corners_free(&noisy);
  hl_corners_free(&set);
}

/* Relative deviations are relative: twice all of them says nothing else about the camera. */
static void test_levels_are_relative(void **state)
{
  (void)state;
  hl_corners set = scene_of(HL_LENS_PINHOLE, VIEWS, NULL);
  hl_corners noisy = board_noisy(&set, 0.1, 3);
  hl_calibration a = board_calibrated(&noisy, HL_MODEL_PINHOLE);
  for (int v = 0; v < VIEWS; v++)
    for (int i = 0; i < hl_target_corners(&set.target); i++)
      noisy.view[v].corner[i].sigma *= 2;
  hl_calibration b = board_calibrated(&noisy, HL_MODEL_PINHOLE);
  near_cameras(&a, &b, 1e-5);
  assert_near(b.noise_px, a.noise_px / 2, 1e-8);
  hl_calibration_free(&a);
  hl_calibration_free(&b);
  hl_corners_free(&noisy);
  hl_corners_free(&set);
}

static void test_repeats(void **state)
{
  (void)state;
  hl_corners set = scene_of(HL_LENS_PINHOLE, VIEWS, NULL);
  hl_corners noisy = board_noisy(&set, 0.1, 4);
  hl_calibration a = board_calibrated(&noisy, HL_MODEL_AUTO);
  hl_calibration b = board_calibrated(&noisy, HL_MODEL_AUTO);
  assert_memory_equal(&a.camera, &b.camera, sizeof a.camera);
  assert_memory_equal(a.view, b.view, VIEWS * sizeof *a.view);
  assert_memory_equal(a.projection, b.projection, sizeof a.projection);
  hl_calibration_free(&a);
  hl_calibration_free(&b);
  hl_corners_free(&noisy);
  hl_corners_free(&set);
}

static void test_figures(void **state)
{
  (void)state;
  hl_pose poses[VIEWS];
  hl_corners set = scene_of(HL_LENS_PINHOLE, VIEWS, poses);
  hl_corners noisy = board_noisy(&set, 0.1, 5);
  hl_calibration c = board_calibrated(&noisy, HL_MODEL_PINHOLE);
  int seen = 0;
  double squares = 0;
  for (int v = 0; v < VIEWS; v++) {
    seen += set.view[v].seen;
    squares += c.view[v].rms_px * c.view[v].rms_px * c.view[v].corners;
    assert_int_equal(c.view[v].seen, set.view[v].seen);
    assert_string_equal(c.view[v].name, set.view[v].name);
  }
  assert_int_equal(c.n_views, VIEWS);
  assert_int_equal(c.corners_used + c.corners_left_out, seen);
  assert_int_equal(c.camera.observations, c.corners_used);
  assert_near(c.camera.rms_px, sqrt(squares / c.corners_used), 1e-9);
  const int freedom = 2 * c.corners_used - 9 - 6 * VIEWS;
  assert_near(c.noise_px, c.camera.rms_px * sqrt((double)c.corners_used / freedom), 1e-12);
  assert_true(c.coverage > 0.8 && c.coverage <= 1);
  assert_true(c.tilt_deg > 30 && c.tilt_deg < 100);
  assert_true(c.condition > 1 && c.condition < 1e6);
  assert_int_equal(c.n_projections, 10);
  assert_memory_equal(&c.target, &set.target, sizeof c.target);
  hl_calibration_free(&c);
  hl_corners_free(&noisy);
  hl_corners_free(&set);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_exact),
      cmocka_unit_test(test_exact_rational),
      cmocka_unit_test(test_stated_deviations),
      cmocka_unit_test(test_order),
      cmocka_unit_test(test_turned_frames),
      cmocka_unit_test(test_levels_are_relative),
      cmocka_unit_test(test_repeats),
      cmocka_unit_test(test_figures),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
