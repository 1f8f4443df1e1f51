/* The ellipse against what it foretells: scatter under noise, and under a ball that moves. */
#include "light_scene.h"

/* Departure from `from` in the light's own tangents. */
static void offset(const hl_light *light, const double from[3], double out[2])
{
  for (int k = 0; k < 2; k++)
    out[k] =
        hl_dot(light->tangent_basis[k], light->direction) - hl_dot(light->tangent_basis[k], from);
}

/* d' C^-1 d / 2, of mean 1 where the covariance is the truth. */
static double mahalanobis(const double c[2][2], const double d[2])
{
  const double det = c[0][0] * c[1][1] - c[0][1] * c[1][0];
  return 0.5 * (c[1][1] * d[0] * d[0] - 2 * c[0][1] * d[0] * d[1] + c[0][0] * d[1] * d[1]) / det;
}

/* The mean of 60 chi-square variables of 2 degrees, halved, has deviation 0.13. */
static void covariance_foretells_scatter(lit_lobe lobe, double angle_deg, double noise)
{
  enum { DRAWS = LIT_SANITIZED ? 20 : 60 };
  const double tolerance = 0.35 * sqrt(60.0 / DRAWS);
  lit_scene s = lit_ball(20);
  s.lobe = lobe;
  s.width = 0.3;
  s.noise = noise;
  lit_direction(angle_deg, 30, s.light);
  hl_surface surface = lit_surface(&s);
  hl_light_work *work = NULL;
  assert_int_equal(hl_light_work_new(NULL, surface.n, 1, &work), HL_OK);
  double sum = 0;
  int outside = 0;
  for (uint64_t draw = 1; draw <= DRAWS; draw++) {
    test_random random = {draw * 0x9E3779B97F4A7C15u};
    double d[2];
    hl_light light;
    hl_frame frame = lit_frame(&s, &surface, &random);
    assert_int_equal(hl_light_estimate(NULL, work, &frame, &surface, NULL, &light), HL_OK);
    offset(&light, s.light, d);
    const double m = mahalanobis(light.covariance_rad2, d);
    sum += m;
    outside += m > 5.991464547107982 / 2; /* chi-square, 2 degrees, 95 % */
    lit_frame_free(&frame);
  }
  if (!is_near(sum / DRAWS, 1.05, tolerance) || outside > 3 + DRAWS / 10)
    print_error("lobe %d, light at %g deg: mean %.3f, %d of %d outside\n", lobe, angle_deg,
                sum / DRAWS, outside, DRAWS);
  assert_near(sum / DRAWS, 1.05, tolerance);
  assert_true(outside <= 3 + DRAWS / 10); /* 3 of 60 expected; over 9 has a chance of 0.001 */
  hl_light_work_free(work);
  hl_surface_free(&surface);
}

static void test_scatter_of_a_plain_lobe(void **state)
{
  (void)state;
  covariance_foretells_scatter(LIT_PLAIN, 45, 0.01);
}

static void test_scatter_of_a_foreshortened_lobe(void **state)
{
  (void)state;
  covariance_foretells_scatter(LIT_FORESHORTENED, 70, 0.01);
}

static void test_scatter_of_a_matte_ball(void **state)
{
  (void)state;
  covariance_foretells_scatter(LIT_MATTE, 45, 0.01);
}

/* Twice the noise, twice the ellipse; four times the pixels, half of it. */
static void test_ellipse_scales_with_noise_and_size(void **state)
{
  (void)state;
  double major[3] = {0};
  for (uint64_t draw = 1; draw <= 6; draw++)
    for (int k = 0; k < 3; k++) {
      lit_scene s = lit_ball(k == 2 ? 40 : 20);
      test_random random = {draw * 0x9E3779B97F4A7C15u};
      s.width = 0.3;
      s.noise = k == 1 ? 0.008 : 0.004;
      hl_surface surface = lit_surface(&s);
      hl_frame frame = lit_frame(&s, &surface, &random);
      hl_light light;
      assert_int_equal(lit_status(&frame, &surface, NULL, NULL, &light), HL_OK);
      major[k] += light.ellipse_95_rad[0] / 6;
      lit_frame_free(&frame);
      hl_surface_free(&surface);
    }
  assert_near(major[1] / major[0], 2, 0.3);
  assert_near(major[0] / major[2], 2, 0.3);
}

/* The ball's pose is off by one deviation at a time, the frame stays: what the light moves by. The
 * deviations are small, so that the same terms are kept throughout. */
static void moved_balls(const lit_scene *s, const double deviation_m[3], double out[2][2],
                        hl_light *without, hl_light *with)
{
  test_random random = {4};
  hl_surface surface = lit_surface(s);
  hl_frame frame = lit_frame(s, &surface, &random);
  hl_light_settings settings = hl_light_defaults();
  settings.lobe = s->lobe == LIT_FORESHORTENED ? HL_LOBE_FORESHORTENED : HL_LOBE_PLAIN;
  hl_light_work *work = NULL;
  assert_int_equal(hl_light_work_new(NULL, LIT_SIDE * LIT_SIDE, s->channels, &work), HL_OK);
  assert_int_equal(hl_light_estimate(NULL, work, &frame, &surface, &settings, without), HL_OK);
  surface.ball.has_covariance = true;
  for (int k = 0; k < 3; k++)
    surface.ball.covariance_m2[k][k] = deviation_m[k] * deviation_m[k];
  assert_int_equal(hl_light_estimate(NULL, work, &frame, &surface, &settings, with), HL_OK);
  memset(out, 0, sizeof(double[2][2]));
  for (int k = 0; k < 3; k++) {
    double d[2][2];
    for (int side = 0; side < 2; side++) {
      lit_scene moved = *s;
      hl_light light;
      moved.ball.center_m[k] += side == 0 ? deviation_m[k] : -deviation_m[k];
      hl_surface other = lit_surface(&moved);
      assert_int_equal(hl_light_estimate(NULL, work, &frame, &other, &settings, &light), HL_OK);
      for (int u = 0; u < 2; u++)
        d[side][u] = hl_dot(with->tangent_basis[u], light.direction);
      hl_surface_free(&other);
    }
    for (int u = 0; u < 2; u++)
      for (int v = 0; v < 2; v++)
        out[u][v] += 0.25 * (d[0][u] - d[1][u]) * (d[0][v] - d[1][v]);
  }
  hl_light_work_free(work);
  lit_frame_free(&frame);
  hl_surface_free(&surface);
}

static void pose_enlarges(lit_lobe lobe, double width, double angle_deg)
{
  lit_scene s = lit_glossy();
  s.lobe = lobe;
  s.width = width;
  s.noise = 0.002;
  s.across = 3;
  lit_direction(angle_deg, 200, s.light);
  const double px_m = s.ball.center_m[2] / s.camera.fx;
  const double deviation_m[3] = {0.025 * px_m, 0.0125 * px_m, 0.1 * px_m};
  hl_light without, with;
  double want[2][2];
  moved_balls(&s, deviation_m, want, &without, &with);
  const double trace = want[0][0] + want[1][1];
  double share[2][2];
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++)
      share[u][v] = with.covariance_rad2[u][v] - without.covariance_rad2[u][v];
  if (!is_near((share[0][0] + share[1][1]) / trace, 1, 0.15))
    print_error("lobe %d, light at %g deg: stated (%.3g %.3g %.3g), moved (%.3g %.3g %.3g)\n", lobe,
                angle_deg, share[0][0], share[0][1], share[1][1], want[0][0], want[0][1],
                want[1][1]);
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++)
      assert_near(share[u][v], want[u][v], 0.15 * trace);
  assert_true(with.ellipse_95_rad[0] > without.ellipse_95_rad[0]);
}

static void test_pose_enlarges_the_ellipse_of_a_glossy_ball(void **state)
{
  (void)state;
  pose_enlarges(LIT_PLAIN, 0.15, 45);
}

static void test_pose_enlarges_the_ellipse_of_a_metal_ball(void **state)
{
  (void)state;
  pose_enlarges(LIT_FORESHORTENED, 0.15, 75);
}

static void test_pose_enlarges_the_ellipse_of_a_matte_ball(void **state)
{
  (void)state;
  pose_enlarges(LIT_MATTE, 0, 45);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_scatter_of_a_plain_lobe),
      cmocka_unit_test(test_scatter_of_a_foreshortened_lobe),
      cmocka_unit_test(test_scatter_of_a_matte_ball),
      cmocka_unit_test(test_ellipse_scales_with_noise_and_size),
      cmocka_unit_test(test_pose_enlarges_the_ellipse_of_a_glossy_ball),
      cmocka_unit_test(test_pose_enlarges_the_ellipse_of_a_metal_ball),
      cmocka_unit_test(test_pose_enlarges_the_ellipse_of_a_matte_ball),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
