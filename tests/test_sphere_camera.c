/* A ball found through an uncertain camera: the derivative against finding it again, the covariance
 * against the scatter over cameras. */
#include <string.h>

#include "ball_scene.h"
#include "camera_draws.h"

static hl_sphere locate(const ball_scene *s, const hl_frame *f, const hl_camera *camera)
{
  hl_ctx ctx = {0};
  hl_sphere out;
  if (hl_sphere_locate(&ctx, f, camera, s->ball.radius_m, NULL, &out, NULL) != HL_OK)
    fail_msg("%s", ctx.msg);
  return out;
}

/* What `scale` times one of the causes moves the centre by, found again through two cameras. */
static void relocated(const ball_scene *s, const hl_frame *f, int cause, double scale,
                      double out[3])
{
  hl_sphere at[2];
  for (int side = 0; side < 2; side++) {
    double theta[HL_INTRINSICS_MAX];
    hl_camera moved = s->camera;
    hl_camera_intrinsics(&s->camera, theta);
    for (int i = 0; i < 9; i++)
      theta[i] += (side == 0 ? -scale : scale) * camera_causes[i][cause];
    hl_camera_set_intrinsics(&moved, theta);
    at[side] = locate(s, f, &moved);
  }
  for (int k = 0; k < 3; k++)
    out[k] = (at[1].center_m[k] - at[0].center_m[k]) / (2 * scale);
}

/* The outline is found again to some thousandths of a pixel, of which the distance sees most. */
static void follows(double x, double y, double radius_px, double background)
{
  ball_scene s = scene_of(x, y, radius_px);
  s.background = background;
  s.noise = 1e-4;
  hl_frame f = scene_frame(&s);
  hl_camera uncertain = s.camera;
  camera_uncertain(&uncertain, 1);
  const hl_sphere ball = locate(&s, &f, &uncertain);
  assert_int_equal(ball.n_intrinsics, 9);
  const double px_m = s.ball.center_m[2] / s.camera.fx;
  for (int cause = 0; cause < 9; cause++) {
    double want[3];
    relocated(&s, &f, cause, 1, want);
    for (int k = 0; k < 3; k++) {
      double got = 0;
      for (int i = 0; i < 9; i++)
        got += ball.by_intrinsics[k][i] * camera_causes[i][cause];
      const double along = k < 2 ? 1 : s.ball.center_m[2] / s.ball.radius_m;
      assert_near(got, want[k], 0.02 * hl_norm(want) + 0.003 * px_m * along);
    }
  }
  scene_free(&f);
}

static void test_derivative_on_the_axis(void **state)
{
  (void)state;
  follows(119.5, 99.5, 60, 1);
}

static void test_derivative_off_the_axis(void **state)
{
  (void)state;
  follows(70, 65, 50, 1);
}

/* Half of the rim dark: the points that are left hold the cone unevenly. */
static void test_derivative_with_half_a_rim(void **state)
{
  (void)state;
  follows(120, 110, 60, 0);
}

/* The outline's own part is what a camera without a covariance gives, the rest the camera's; without one,
 * or with one of zeros, not a bit changes. */
static void test_parts(void **state)
{
  (void)state;
  const ball_scene s = scene_of(90, 80, 50);
  hl_frame f = scene_frame(&s);
  hl_camera camera = s.camera;
  const hl_sphere exact = locate(&s, &f, &camera);
  assert_int_equal(exact.n_intrinsics, 0);
  camera_uncertain(&camera, 0);
  const hl_sphere zero = locate(&s, &f, &camera);
  assert_memory_equal(zero.center_m, exact.center_m, sizeof zero.center_m);
  assert_memory_equal(zero.covariance_m2, exact.covariance_m2, sizeof zero.covariance_m2);
  camera_uncertain(&camera, 1);
  const hl_sphere both = locate(&s, &f, &camera);
  assert_memory_equal(both.center_m, exact.center_m, sizeof both.center_m);
  assert_memory_equal(both.held_covariance_m2, exact.covariance_m2, sizeof exact.covariance_m2);
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) {
      double want = exact.covariance_m2[i][k];
      for (int a = 0; a < 9; a++)
        for (int b = 0; b < 9; b++)
          want +=
              both.by_intrinsics[i][a] * camera.covariance[a * 9 + b] * both.by_intrinsics[k][b];
      assert_near(both.covariance_m2[i][k], want, 1e-9 * both.covariance_m2[2][2]);
    }
  scene_free(&f);
}

/* Errors of the pose through drawn cameras, weighed by the covariance that the true one states. */
static void test_scatter_over_cameras(void **state)
{
  (void)state;
  enum { DRAWS = 200 };
  const ball_scene s = scene_of(75, 70, 50);
  hl_frame f = scene_frame(&s);
  hl_camera camera = s.camera;
  camera_uncertain(&camera, 1);
  const hl_sphere ball = locate(&s, &f, &camera);
  test_random random = scene_random(5);
  double variance[3] = {0}, mean[3] = {0};
  for (int d = 0; d < DRAWS; d++) {
    const hl_camera drawn = camera_drawn(&s.camera, 1, &random);
    const hl_sphere found = locate(&s, &f, &drawn);
    for (int k = 0; k < 3; k++) {
      const double e = found.center_m[k] - ball.center_m[k];
      mean[k] += e / DRAWS;
      variance[k] += e * e / DRAWS;
    }
  }
  for (int k = 0; k < 3; k++) {
    const double stated = ball.covariance_m2[k][k] - ball.held_covariance_m2[k][k];
    /* a variance from 200 draws has deviation 0.1 */
    assert_near((variance[k] - mean[k] * mean[k]) / stated, 1, 0.35);
  }
  scene_free(&f);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_derivative_on_the_axis),
      cmocka_unit_test(test_derivative_off_the_axis),
      cmocka_unit_test(test_derivative_with_half_a_rim),
      cmocka_unit_test(test_parts),
      cmocka_unit_test(test_scatter_over_cameras),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
