/* What shading says about the ball's pose, against balls whose pose is known. */
#include "../src/cholesky.h"
#include "../src/light_pose.h"
#include "halflight/replay.h"
#include "light_scene.h"

enum { LIGHTS = 12 };

/* Estimate at a ball that is off by `off`, add the score. */
static void add(lit_scene *s, const double off[3], hl_light_pose *sum, hl_light_pose *one,
                double light[3])
{
  hl_surface truth = lit_surface(s);
  test_random random = {7};
  hl_frame frame = lit_frame(s, &truth, &random);
  lit_scene moved = *s;
  hl_add_scaled(s->ball.center_m, 1, off, moved.ball.center_m);
  hl_surface surface = lit_surface(&moved);
  surface.is_ball = true;
  hl_light_work *work = NULL;
  hl_light_pose_work *pose = NULL;
  hl_light out;
  hl_light_settings settings = hl_light_defaults();
  settings.lobe = HL_LOBE_PLAIN;
  settings.without = hl_replay_defaults().light.without;
  assert_int_equal(hl_light_work_new(NULL, surface.n, 1, &work), HL_OK);
  assert_int_equal(hl_light_pose_new(NULL, surface.n, 1, &pose), HL_OK);
  assert_int_equal(hl_light_estimate(NULL, work, &frame, &surface, &settings, &out), HL_OK);
  assert_true(hl_light_pose_score(work, &surface, pose, one));
  for (int i = 0; i < 3; i++) {
    sum->gradient[i] += one->gradient[i];
    for (int j = 0; j < 3; j++)
      sum->information[i][j] += one->information[i][j];
  }
  memcpy(light, out.direction, sizeof out.direction);
  hl_light_pose_free(pose);
  hl_light_work_free(work);
  hl_surface_free(&surface);
  hl_surface_free(&truth);
  lit_frame_free(&frame);
}

/* A third of a pixel aside, and as much in the radius. */
static void test_many_lights_find_the_pose(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  s.noise = 0.001;
  const double pixel = s.ball.center_m[2] / s.camera.fx;
  const double off[3] = {0.3 * pixel, -0.2 * pixel, 0.2 * pixel * s.camera.fx / 35};
  hl_light_pose sum = {{0}, {{0}}, {{0}}}, one[LIGHTS];
  double light[LIGHTS][3], truth[LIGHTS][3], before = 0, after = 0;
  for (int i = 0; i < LIGHTS; i++) {
    lit_direction(25 + 4 * (i % 6), 137.5 * i, s.light);
    memcpy(truth[i], s.light, sizeof s.light);
    add(&s, off, &sum, &one[i], light[i]);
  }
  double factor[9], step[3];
  memcpy(factor, sum.information, sizeof factor);
  memcpy(step, sum.gradient, sizeof step);
  assert_int_equal(hl_cholesky(factor, 3, 3, 1e-14), 0);
  hl_cholesky_solve(factor, 3, 3, step);
  for (int k = 0; k < 2; k++)
    assert_near(step[k], -off[k], 0.05 * pixel);
  for (int i = 0; i < LIGHTS; i++) {
    double t[2][3], turned[3];
    hl_tangent_basis(light[i], t[0], t[1]);
    memcpy(turned, light[i], sizeof turned);
    for (int u = 0; u < 2; u++)
      hl_add_scaled(turned, hl_dot(one[i].by_center[u], step), t[u], turned);
    before += hl_angle(light[i], truth[i]);
    after += hl_angle(turned, truth[i]);
  }
  assert_true(after < 0.3 * before);
}

/* ds/dc against the light found at a ball moved by it. */
static void test_direction_follows_the_center(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  const double pixel = s.ball.center_m[2] / s.camera.fx;
  hl_light_pose sum = {{0}, {{0}}, {{0}}}, one;
  double here[3], t[2][3];
  const double none[3] = {0};
  add(&s, none, &sum, &one, here);
  hl_tangent_basis(here, t[0], t[1]);
  for (int axis = 0; axis < 2; axis++) {
    hl_light_pose other;
    double off[3] = {0}, there[3], change[3];
    off[axis] = 0.1 * pixel;
    add(&s, off, &sum, &other, there);
    hl_add_scaled(there, -1, here, change);
    for (int u = 0; u < 2; u++)
      assert_near(hl_dot(change, t[u]), one.by_center[u][axis] * off[axis], 3e-4);
  }
}

static void test_maps_have_no_center(void **state)
{
  (void)state;
  hl_surface map = {.is_ball = false};
  hl_light_work *work = NULL;
  hl_light_pose_work *pose = NULL;
  hl_light_pose out;
  assert_int_equal(hl_light_work_new(NULL, 1, 1, &work), HL_OK);
  assert_int_equal(hl_light_pose_new(NULL, 1, 1, &pose), HL_OK);
  assert_false(hl_light_pose_score(work, &map, pose, &out));
  hl_light_pose_free(pose);
  hl_light_work_free(work);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_many_lights_find_the_pose),
      cmocka_unit_test(test_direction_follows_the_center),
      cmocka_unit_test(test_maps_have_no_center),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
