/* The public call: known lights come back, from the axis to behind the rim. */
#include "light_scene.h"

static const double lights_deg[] = {0, 5, 20, 45, 70, 90, 105, 120};
enum { LIGHTS = sizeof lights_deg / sizeof *lights_deg };

static lit_scene scene_of(lit_lobe lobe, double width, double angle_deg)
{
  lit_scene s = lit_glossy();
  s.lobe = lobe;
  s.width = width;
  lit_direction(angle_deg, -60, s.light);
  return s;
}

static void error_within(const lit_scene *s, double deg)
{
  const hl_light light = lit_estimate(s, NULL);
  const double error = lit_error_deg(s, &light);
  if (!(error <= deg))
    print_error("lobe %d, width %g, light (%g, %g, %g)\n", s->lobe, s->width, s->light[0],
                s->light[1], s->light[2]);
  assert_true(light.found);
  assert_near(error, 0, deg);
  assert_near(hl_norm(light.direction), 1, 1e-14);
}

/* Pixels hold the model's own values: what is left is the spline's misfit of the lobe. */
static void test_matte_from_the_axis_to_behind_the_rim(void **state)
{
  (void)state;
  for (int i = 0; i < LIGHTS; i++) {
    const lit_scene s = scene_of(LIT_MATTE, 0, lights_deg[i]);
    error_within(&s, 1e-3);
  }
}

static void test_glossy_from_the_axis_to_behind_the_rim(void **state)
{
  (void)state;
  for (int i = 0; i < LIGHTS; i++) {
    const lit_scene s = scene_of(LIT_PLAIN, 0.15, lights_deg[i]);
    error_within(&s, 1e-3);
  }
}

static void test_foreshortened_from_the_axis_to_behind_the_rim(void **state)
{
  (void)state;
  for (int i = 0; i < LIGHTS; i++) {
    const lit_scene s = scene_of(LIT_FORESHORTENED, 0.15, lights_deg[i]);
    error_within(&s, 1e-3);
  }
}

static void test_satin(void **state)
{
  (void)state;
  for (int lobe = LIT_PLAIN; lobe <= LIT_FORESHORTENED; lobe++)
    for (int i = 2; i < LIGHTS; i += 2) {
      const lit_scene s = scene_of((lit_lobe)lobe, 0.4, lights_deg[i]);
      error_within(&s, 1e-3);
    }
}

/* A highlight three pixels wide: no spline bends as sharply as that, and it still says where. */
static void test_mirror_like(void **state)
{
  (void)state;
  for (int lobe = LIT_PLAIN; lobe <= LIT_FORESHORTENED; lobe++)
    for (int i = 1; i < LIGHTS; i += 2) {
      const lit_scene s = scene_of((lit_lobe)lobe, 0.04, lights_deg[i]);
      error_within(&s, 0.04);
    }
}

/* What a camera sees: means over pixels, which the model takes from the centre. */
static void test_pixels_with_an_area(void **state)
{
  (void)state;
  for (int lobe = LIT_MATTE; lobe <= LIT_FORESHORTENED; lobe++)
    for (int i = 2; i < LIGHTS - 1; i += 2) {
      lit_scene s = lit_ball(45);
      s.lobe = (lit_lobe)lobe;
      lit_direction(lights_deg[i], -60, s.light);
      s.across = 4;
      error_within(&s, 0.05);
    }
}

/* The mirror-like highlight near the limb is the frame's best evidence, not dust. */
static void test_a_steep_highlight_is_no_outlier(void **state)
{
  (void)state;
  lit_scene s = scene_of(LIT_FORESHORTENED, 0.04, 120);
  s.across = 4;
  const hl_light light = lit_estimate(&s, NULL);
  assert_true(light.n_outliers < light.n_pixels / 50);
  assert_true(light.evidence_highlight > 0.3);
  assert_near(lit_error_deg(&s, &light), 0, 0.05);
}

/* Frontal light on a matte ball: the least sure of all, but an answer. */
static void test_frontal_light_on_a_matte_ball_converges(void **state)
{
  (void)state;
  for (int i = 0; i < 2; i++) {
    lit_scene s = scene_of(LIT_MATTE, 0, lights_deg[i]);
    s.across = 4;
    const hl_light light = lit_estimate(&s, NULL);
    for (int k = 0; k < light.reasons.n; k++)
      print_error("%s\n", light.reasons.note[k].why);
    assert_true(light.trusted);
    assert_near(lit_error_deg(&s, &light), 0, 0.1);
  }
}

/* A constant over all of the ball, from 1 % to 25 % of the body's brightest. */
static void ambient_is_told_apart(double ambient)
{
  for (int i = 2; i < LIGHTS; i++) {
    lit_scene s = scene_of(LIT_PLAIN, 0.15, lights_deg[i]);
    s.ambient = ambient;
    s.noise = 0.002;
    test_random random = {(uint64_t)i + 1};
    hl_surface surface = lit_surface(&s);
    hl_frame frame = lit_frame(&s, &surface, &random);
    hl_light_settings settings = hl_light_defaults();
    settings.lobe = HL_LOBE_PLAIN;
    hl_light light;
    assert_int_equal(lit_status(&frame, &surface, &settings, NULL, &light), HL_OK);
    if (!(lit_error_deg(&s, &light) <= 0.1) || !light.trusted)
      print_error("ambient %g, light at %g deg: error %.3f deg, %d outliers\n", ambient,
                  lights_deg[i], lit_error_deg(&s, &light), light.n_outliers);
    assert_near(lit_error_deg(&s, &light), 0, 0.1);
    assert_true(light.trusted);
    assert_true(light.n_outliers < light.n_pixels / 100);
    lit_frame_free(&frame);
    hl_surface_free(&surface);
  }
}

static void test_faint_ambient(void **state)
{
  (void)state;
  ambient_is_told_apart(0.004);
}

static void test_strong_ambient(void **state)
{
  (void)state;
  ambient_is_told_apart(0.1);
}

static void test_clipped_highlights(void **state)
{
  (void)state;
  static const double levels[] = {0.9, 0.7, 0.5};
  for (int lobe = LIT_PLAIN; lobe <= LIT_FORESHORTENED; lobe++)
    for (int k = 0; k < 3; k++)
      for (int i = 2; i < 7; i += 2) {
        lit_scene s = scene_of((lit_lobe)lobe, 0.15, lights_deg[i]);
        s.saturation = levels[k];
        error_within(&s, 0.1);
      }
}

/* ---- what is reported */

static void test_fitted_pixels_and_counts(void **state)
{
  (void)state;
  const float *predicted, *measured, *weight;
  lit_scene s = lit_glossy();
  s.saturation = 0.6;
  s.scale = 5;
  lit_shot one = lit_shot_of(&s, 31);
  int clipped = 0, dropped = 0;
  double rr = 0;
  for (int i = 0; i < one.surface.n; i++)
    clipped += one.frame.state[one.surface.pixel[i]] == HL_SAMPLE_CLIPPED;
  for (int i = 7; i < one.surface.n; i += 301, dropped++)
    if (one.frame.state[one.surface.pixel[i]] == HL_SAMPLE_CLIPPED)
      dropped--; /* counted above, so left as they are */
    else
      one.frame.state[one.surface.pixel[i]] = HL_SAMPLE_UNUSABLE;
  hl_light_work *work = NULL;
  hl_light light;
  assert_int_equal(hl_light_work_new(NULL, one.surface.n, 1, &work), HL_OK);
  assert_int_equal(hl_light_estimate(NULL, work, &one.frame, &one.surface, NULL, &light), HL_OK);
  hl_light_fitted(work, &predicted, &measured, &weight);
  hl_light_fitted(work, NULL, NULL, NULL);
  assert_int_equal(light.n_pixels, one.surface.n - dropped);
  assert_int_equal(light.n_clipped, clipped);
  for (int i = 0; i < one.surface.n; i++) {
    const size_t at = (size_t)one.surface.pixel[i];
    if (one.frame.state[at] == HL_SAMPLE_UNUSABLE) {
      assert_near(weight[i], 0, 0);
      continue;
    }
    assert_true(weight[i] >= 0 && weight[i] <= 1);
    assert_near(measured[i], one.frame.radiance[at], 1e-6);
    if (one.frame.state[at] == HL_SAMPLE_CLIPPED)
      assert_true(predicted[i] > 3 - 0.01);
    else
      assert_near(predicted[i], measured[i], 0.01);
    rr += one.frame.state[at] == HL_SAMPLE_OK ? pow(predicted[i] - measured[i], 2) : 0;
  }
  assert_near(light.rms, sqrt(rr / light.n_pixels), 1e-4);
  hl_light_work_free(work);
  lit_shot_free(&one);
}

static void test_frame_of_reference_of_the_covariance(void **state)
{
  (void)state;
  const lit_scene s = lit_usual();
  lit_shot one = lit_shot_of(&s, 32);
  const hl_light l = lit_light_of(&one, NULL);
  double mean[3] = {0};
  for (int k = 0; k < 2; k++) {
    assert_near(hl_norm(l.tangent_basis[k]), 1, 1e-14);
    assert_near(hl_dot(l.tangent_basis[k], l.direction), 0, 1e-14);
  }
  assert_near(hl_dot(l.tangent_basis[0], l.tangent_basis[1]), 0, 1e-14);
  const double a = l.covariance_rad2[0][0], b = l.covariance_rad2[0][1],
               c = l.covariance_rad2[1][1];
  assert_near(l.covariance_rad2[1][0], b, 1e-12 * (a + c));
  assert_true(a > 0 && c > 0 && a * c > b * b);
  /* product and sum of squared half axes: determinant and trace times the 95 % quantile 5.9915 */
  const double p = l.ellipse_95_rad[0], q = l.ellipse_95_rad[1];
  assert_true(p >= q && q > 0);
  assert_near((p * p + q * q) / (5.991464547107982 * (a + c)), 1, 1e-9);
  assert_near(p * q / (5.991464547107982 * sqrt(a * c - b * b)), 1, 1e-9);
  for (int i = 0; i < one.surface.n; i++)
    for (int k = 0; k < 3; k++)
      mean[k] += one.surface.view[3 * i + k];
  hl_unit(mean, mean);
  hl_add_scaled(mean, 1, l.direction, mean);
  assert_near(hl_angle(mean, l.half_angle_direction), 0, 1e-9);
  lit_shot_free(&one);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_matte_from_the_axis_to_behind_the_rim),
      cmocka_unit_test(test_glossy_from_the_axis_to_behind_the_rim),
      cmocka_unit_test(test_foreshortened_from_the_axis_to_behind_the_rim),
      cmocka_unit_test(test_satin),
      cmocka_unit_test(test_mirror_like),
      cmocka_unit_test(test_pixels_with_an_area),
      cmocka_unit_test(test_a_steep_highlight_is_no_outlier),
      cmocka_unit_test(test_frontal_light_on_a_matte_ball_converges),
      cmocka_unit_test(test_faint_ambient),
      cmocka_unit_test(test_strong_ambient),
      cmocka_unit_test(test_clipped_highlights),
      cmocka_unit_test(test_fitted_pixels_and_counts),
      cmocka_unit_test(test_frame_of_reference_of_the_covariance),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
