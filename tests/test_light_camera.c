/* The camera's share of the light's ellipse against the scatter over cameras that a calibration could have
 * given: of a ball whose pose is given, and of one that is found through them. */
#include "ball_scene.h"
#include "camera_draws.h"
#include "light_scene.h"

/* The light through one camera, of a ball at `given`, or, where that is NULL, found in the frame. */
static hl_light light_through(const hl_frame *frame, const hl_camera *camera, double radius_m,
                              const hl_sphere *given)
{
  hl_ctx ctx = {0};
  hl_sphere ball;
  hl_surface surface = {0};
  hl_light_work *work = NULL;
  hl_light out = {0};
  hl_status st = HL_OK;
  if (given)
    ball = *given;
  else
    st = hl_sphere_locate(&ctx, frame, camera, radius_m, NULL, &ball, NULL);
  if (st == HL_OK)
    st = hl_surface_of_sphere(&ctx, camera, &ball, 0.1, &surface);
  if (st == HL_OK)
    st = hl_light_work_new(&ctx, surface.n, frame->channels, &work);
  if (st == HL_OK)
    st = hl_light_estimate(&ctx, work, frame, &surface, NULL, &out);
  if (st != HL_OK)
    fail_msg("%s", ctx.msg);
  hl_light_work_free(work);
  hl_surface_free(&surface);
  return out;
}

/* One frame, made through the true camera, read through drawn ones. `scale` is of the deviations. */
static void share_is_scatter(ball_scene s, bool given, double scale)
{
  enum { DRAWS = LIT_SANITIZED ? 12 : 200 };
  hl_frame frame = scene_frame(&s);
  hl_camera camera = s.camera;
  camera_uncertain(&camera, scale);
  const hl_sphere *ball = given ? &s.ball : NULL;
  const hl_light at = light_through(&frame, &camera, s.ball.radius_m, ball);
  assert_true(at.part_stated[HL_PART_CAMERA] && at.part_stated[HL_PART_POSE] == !given);
  test_random random = scene_random(77);
  double mean[2] = {0}, m[2][2] = {{0}};
  for (int d = 0; d < DRAWS; d++) {
    const hl_camera drawn = camera_drawn(&s.camera, scale, &random);
    const hl_light light = light_through(&frame, &drawn, s.ball.radius_m, ball);
    double e[2];
    for (int u = 0; u < 2; u++)
      e[u] = hl_dot(at.tangent_basis[u], light.direction);
    for (int u = 0; u < 2; u++) {
      mean[u] += e[u] / DRAWS;
      for (int v = 0; v < 2; v++)
        m[u][v] += e[u] * e[v] / DRAWS;
    }
  }
  /* the stated covariance's own frame: sum and product of the scatter's relative sizes */
  const double(*c)[2] = at.part_rad2[HL_PART_CAMERA];
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++)
      m[u][v] = (m[u][v] - mean[u] * mean[v]) * DRAWS / (DRAWS - 1);
  const double det = c[0][0] * c[1][1] - c[0][1] * c[1][0];
  const double half = 0.5 * (c[1][1] * m[0][0] - 2 * c[0][1] * m[0][1] + c[0][0] * m[1][1]) / det;
  const double product = (m[0][0] * m[1][1] - m[0][1] * m[1][0]) / det;
  const double root = sqrt(fmax(0, half * half - product));
  /* Wishart, 200 draws: both sizes lie within 0.7 .. 1.35 but for a chance of some 0.001 */
  const double few = LIT_SANITIZED ? 0.6 : 0;
  if (!(half - root > 0.7 - few && half + root < 1.35 + 3 * few))
    print_error("relative sizes %.3f and %.3f\n", half - root, half + root);
  assert_true(half - root > 0.7 - few && half + root < 1.35 + 3 * few);
  scene_free(&frame);
}

static void test_camera_share_of_a_given_pose(void **state)
{
  (void)state;
  share_is_scatter(scene_of(70, 70, 32), true, 0.02);
}

static void test_camera_share_of_a_ball_found_on_the_axis(void **state)
{
  (void)state;
  share_is_scatter(scene_of(119.5, 99.5, 32), false, 0.5);
}

/* 70 degrees across. */
static void test_camera_share_of_a_ball_found_aside_in_a_wide_lens(void **state)
{
  (void)state;
  share_is_scatter(scene_through(170, 60, 55, 32), false, 0.25);
}

/* A ball found through the camera it is judged by moves along, and most of the share cancels. */
static void test_a_ball_that_follows_cancels_most(void **state)
{
  (void)state;
  const ball_scene s = scene_of(70, 70, 40);
  hl_frame frame = scene_frame(&s);
  hl_camera camera = s.camera;
  camera_uncertain(&camera, 0.5);
  hl_sphere ball;
  assert_int_equal(hl_sphere_locate(NULL, &frame, &camera, s.ball.radius_m, NULL, &ball, NULL),
                   HL_OK);
  const hl_light follows = light_through(&frame, &camera, s.ball.radius_m, &ball);
  ball.n_intrinsics = 0;
  const hl_light stays = light_through(&frame, &camera, s.ball.radius_m, &ball);
  ball.n_intrinsics = 12; /* of a rational camera */
  const hl_light other = light_through(&frame, &camera, s.ball.radius_m, &ball);
  assert_true(follows.part_95_rad[HL_PART_CAMERA][0] < 0.1 * stays.part_95_rad[HL_PART_CAMERA][0]);
  assert_memory_equal(other.part_rad2, stays.part_rad2, sizeof stays.part_rad2);
  /* the pose's own share is then that of the whole covariance */
  assert_true(follows.part_95_rad[HL_PART_POSE][0] < 0.2 * stays.part_95_rad[HL_PART_POSE][0]);
  scene_free(&frame);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_camera_share_of_a_given_pose),
      cmocka_unit_test(test_camera_share_of_a_ball_found_on_the_axis),
      cmocka_unit_test(test_camera_share_of_a_ball_found_aside_in_a_wide_lens),
      cmocka_unit_test(test_a_ball_that_follows_cancels_most),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
