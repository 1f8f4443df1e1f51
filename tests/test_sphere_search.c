/* Edge points of a frame and the circles among them. */
#include "../calib/sphere_search.h"

#include "ball_scene.h"
#include "near.h"

static void test_edge_points_lie_on_the_rim(void **state)
{
  (void)state;
  ball_scene s = scene_of(119.5, 99.5, 60);
  s.background = 1.2; /* brighter than the ball all round */
  hl_frame f = scene_frame(&s);
  hl_edges e;
  assert_int_equal(hl_edges_find(NULL, &f, &e), HL_OK);
  assert_int_equal(e.shrink, 1);
  int on_rim = 0;
  for (int i = 0; i < e.n; i++) {
    const double dx = e.edge[i].x - 119.5, dy = e.edge[i].y - 99.5, d = hypot(dx, dy);
    assert_near(hypot(e.edge[i].gx, e.edge[i].gy), 1, 1e-4);
    if (fabs(d - 59.8) < 1.5) { /* analytic: 60 px less the lens's 0.2 */
      on_rim++;
      assert_true((dx * e.edge[i].gx + dy * e.edge[i].gy) / d > 0.9); /* brighter outside */
    }
  }
  assert_true(on_rim > 280); /* of a circumference of 376 px */
  hl_edges_free(&e);
  scene_free(&f);
}

static void test_noise_has_hardly_an_edge(void **state)
{
  (void)state;
  ball_scene s = scene_of(120, 100, 50);
  hl_frame f = scene_frame(&s);
  test_random random = scene_random(6);
  for (int i = 0; i < f.width * f.height; i++)
    f.radiance[i] = (float)(0.4 + 0.02 * random_normal(&random));
  hl_edges e;
  assert_int_equal(hl_edges_find(NULL, &f, &e), HL_OK);
  assert_true(e.found < 20); /* of 48 000 pixels */
  hl_edges_free(&e);
  scene_free(&f);
}

static void test_large_frames_are_searched_small(void **state)
{
  (void)state;
  hl_frame f = {.width = 1700, .height = 60, .channels = 1, .bits = 32};
  f.radiance = calloc(1700 * 60, sizeof *f.radiance);
  f.state = calloc(1700 * 60, 1);
  assert_true(f.radiance && f.state);
  for (int i = 0; i < 1700 * 60; i++)
    f.radiance[i] = i % 1700 < 900 ? 0.1f : 0.5f; /* a step between columns 899 and 900 */
  hl_edges e;
  assert_int_equal(hl_edges_find(NULL, &f, &e), HL_OK);
  assert_int_equal(e.shrink, 3);
  assert_true(e.n > 8);
  for (int i = 0; i < e.n; i++)
    assert_near(e.edge[i].x, 899.5, 0.8);
  hl_edges_free(&e);
  scene_free(&f);
}

static void search(const ball_scene *s, const double hint[3], hl_candidate *best)
{
  hl_frame f = scene_frame(s);
  hl_edges e;
  hl_candidate found[HL_CANDIDATES_MAX];
  int n = 0;
  const hl_search_range range = {8, 150, {hint[0], hint[1], hint[2]}};
  assert_int_equal(hl_edges_find(NULL, &f, &e), HL_OK);
  assert_int_equal(hl_search_circles(NULL, &e, &s->camera, &range, found, &n), HL_OK);
  assert_true(n > 0);
  for (int i = 1; i < n; i++)
    assert_true(found[i].score <= found[i - 1].score);
  *best = found[0];
  hl_edges_free(&e);
  scene_free(&f);
}

static void test_best_circle_is_the_ball(void **state)
{
  (void)state;
  static const double hints[][3] = {{0, 0, 0}, {144, 83, 53}};
  ball_scene s = scene_of(141.2, 85.6, 50);
  for (int i = 0; i < 2; i++) {
    hl_candidate best;
    search(&s, hints[i], &best);
    const double half = asin(s.ball.radius_m / hl_norm(s.ball.center_m));
    /* a pixel is 1/600 rad: within one, which is what the sub-pixel reading starts from */
    assert_near(hl_angle(best.cone.axis, s.ball.center_m) * 600, 0, 1);
    assert_near((best.cone.half_angle_rad - half) * 600, 0, 1);
    assert_true(best.coverage > 0.7);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_edge_points_lie_on_the_rim),
      cmocka_unit_test(test_noise_has_hardly_an_edge),
      cmocka_unit_test(test_large_frames_are_searched_small),
      cmocka_unit_test(test_best_circle_is_the_ball),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
