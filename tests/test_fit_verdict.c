/* What may be claimed: the paper's propositions and the counterexamples of its remarks. */
#include "fit_scene.h"

static hl_fit *fit_of(const scene *s, hl_fit_model model, const double *light, int terms)
{
  const hl_fit_known known = {.light = light};
  const hl_fit_settings settings = terms > 0 ? scene_terms(terms) : hl_fit_defaults();
  return scene_fit(s, model, &known, &settings);
}

static void assert_verdict(const hl_fit *fit, hl_identifiability verdict, const char *words)
{
  if (fit->verdict != verdict || !strstr(fit->proposition, words)) {
    print_error("verdict %d, '%s'; wanted %d, '%s'\n", (int)fit->verdict, fit->proposition,
                (int)verdict, words);
    fail();
  }
  assert_true(fit->stays_free[0] != '\0');
}

static void test_one_curve_is_unique(void **state)
{
  (void)state;
  scene s = scene_of(1500);
  scene_add(&s, 3, 2, 9, scene_gloss, 1);
  hl_fit *fit = fit_of(&s, HL_FIT_RIDGE, NULL, 0);
  assert_verdict(fit, HL_UNIQUE, "Propositions 1 and 2");
  free(fit);
  fit = fit_of(&s, HL_FIT_PURSUIT, NULL, 1);
  assert_verdict(fit, HL_UNIQUE, "Propositions 1 and 2");
  free(fit);
}

/* Remark 1: a + b of two linear terms can be divided in any way. */
static void test_a_linear_lobe_is_ambiguous_and_not_trusted(void **state)
{
  (void)state;
  scene s = scene_dichromatic(1500);
  s.term[1].curve = scene_linear;
  for (int given = 0; given < 2; given++) {
    hl_fit *fit = fit_of(&s, HL_FIT_DICHROMATIC, given ? s.light : NULL, 0);
    assert_verdict(fit, HL_AMBIGUOUS, "Remark 1");
    assert_false(fit->trusted);
    assert_near(fit->term[1].off_linear, 0, 1e-4);
    free(fit);
  }
}

/* The light's direction makes the same surface, with a lobe that bends, unique. */
static void test_a_known_light_makes_the_difference(void **state)
{
  (void)state;
  const scene s = scene_dichromatic(1500);
  hl_fit *known = fit_of(&s, HL_FIT_DICHROMATIC, s.light, 0);
  hl_fit *unknown = fit_of(&s, HL_FIT_DICHROMATIC, NULL, 0);
  assert_verdict(known, HL_UNIQUE, "Proposition 5");
  assert_verdict(unknown, HL_AMBIGUOUS, "Proposition 3");
  assert_true(known->trusted && unknown->trusted);
  free(known);
  free(unknown);
}

/* Proposition 5 is about a linear part along the light; one elsewhere leaves k b.n free all the same. */
static void test_a_linear_part_off_the_light(void **state)
{
  (void)state;
  scene s = scene_of(1500);
  const double light[3] = {1, 1, 1};
  scene_add(&s, 1, -2, 5, scene_linear, 1);
  scene_add(&s, 3, 2, 9, scene_gloss, 0.8);
  hl_fit *fit = fit_of(&s, HL_FIT_PURSUIT, light, 2);
  assert_verdict(fit, HL_AMBIGUOUS, "Proposition 3");
  free(fit);
}

/* Without constraints a curve has a constant too, which says nothing of its shape. */
static void test_shape_of_a_free_curve(void **state)
{
  (void)state;
  scene s = scene_of(1500);
  hl_fit_settings settings = hl_fit_defaults();
  settings.free_curves = 1;
  scene_add(&s, 0, 0, 1, scene_linear, 1);
  hl_fit *fit = scene_fit(&s, HL_FIT_RIDGE, NULL, &settings);
  assert_near(fit->term[0].off_linear, 0, 1e-4);
  free(fit);
}

/* A half vector of eight digits is one. */
static void test_given_directions_are_named(void **state)
{
  (void)state;
  const scene s = scene_dichromatic(1500);
  const double directions[6] = {1, 1, 1, 1, 1, 2.7320508};
  const hl_fit_known known = {s.light, 2, directions};
  const hl_fit_settings settings = hl_fit_defaults();
  hl_fit *fit = scene_fit(&s, HL_FIT_ADDITIVE, &known, &settings);
  assert_string_equal(fit->term[0].name, "s");
  assert_string_equal(fit->term[1].name, "h");
  free(fit);
}

/* Remark 2: a sum of quadratics is a quadratic form, and has other pairs. */
static void test_two_quadratics_are_ambiguous(void **state)
{
  (void)state;
  scene s = scene_of(2000);
  scene_add(&s, 3, 2, 9, scene_square, 1);
  scene_add(&s, -2, 3, 9, scene_square, 0.7);
  hl_fit *fit = fit_of(&s, HL_FIT_PURSUIT, NULL, 2);
  assert_verdict(fit, HL_AMBIGUOUS, "Remark 2");
  for (int i = 0; i < 2; i++) {
    assert_true(fit->term[i].off_quadratic < 0.02);
    assert_true(fit->term[i].off_linear > 0.05);
  }
  free(fit);
}

/* One quadratic curve is no obstacle beside a known light. */
static void test_one_quadratic_lobe(void **state)
{
  (void)state;
  scene s = scene_dichromatic(1500);
  s.term[1].curve = scene_square;
  hl_fit *fit = fit_of(&s, HL_FIT_DICHROMATIC, s.light, 0);
  assert_verdict(fit, HL_UNIQUE, "Proposition 5");
  assert_near(fit->term[1].off_quadratic, 0, 1e-4);
  free(fit);
}

/* Remark 3: lobe and light point the same way. */
static void test_coinciding_directions_are_ambiguous(void **state)
{
  (void)state;
  scene s = scene_dichromatic(1500);
  memcpy(s.term[1].a, s.light, sizeof s.light);
  hl_fit *fit = fit_of(&s, HL_FIT_DICHROMATIC, s.light, 0);
  assert_verdict(fit, HL_AMBIGUOUS, "Remark 3");
  assert_near(fit->least_angle_rad, 0, 1e-6);
  free(fit);
}

static void test_dependent_known_directions_are_ambiguous(void **state)
{
  (void)state;
  scene s = scene_dichromatic(1500);
  const double plane[9] = {s.light[0],     s.light[1],     s.light[2],    0, 0, 1,
                           s.term[1].a[0], s.term[1].a[1], s.term[1].a[2]};
  const double apart[9] = {1, 0, 1, 0, 1, 1, -1, -1, 1};
  for (int k = 0; k < 2; k++) {
    const hl_fit_known known = {.n_directions = 3, .directions = k == 0 ? plane : apart};
    hl_fit *fit = scene_fit(&s, HL_FIT_ADDITIVE, &known, NULL);
    if (k == 0) {
      assert_verdict(fit, HL_AMBIGUOUS, "Remark 3");
      assert_near(fit->coplanarity, 0, 1e-9);
    } else {
      assert_verdict(fit, HL_UNIQUE, "known");
      assert_true(fit->coplanarity > 0.3);
    }
    free(fit);
  }
}

static void test_two_lobes_are_unique(void **state)
{
  (void)state;
  const scene s = scene_two_lobes(2000);
  hl_fit *fit = fit_of(&s, HL_FIT_PURSUIT, NULL, 2);
  assert_verdict(fit, HL_UNIQUE, "Proposition 6");
  free(fit);
}

static void test_three_lobes_are_not_guaranteed(void **state)
{
  (void)state;
  scene s = scene_two_lobes(2500);
  scene_add(&s, 5, 5, 5, scene_gloss, 0.5);
  for (int terms = 3; terms <= 5; terms++) {
    hl_fit *fit = fit_of(&s, HL_FIT_PURSUIT, NULL, terms);
    assert_int_equal(fit->n_terms, terms);
    assert_verdict(fit, HL_NOT_GUARANTEED, "Section 4.4");
    free(fit);
  }
}

/* Even radiance has no direction. */
static void test_a_constant_surface_is_not_trusted(void **state)
{
  (void)state;
  scene s = scene_of(1500);
  scene_add(&s, 0, 0, 1, scene_linear, 1);
  hl_samples samples = scene_samples(&s);
  test_random r = {4};
  for (int i = 0; i < samples.n; i++)
    samples.value[0][i] = 1 + 0.3 * random_normal(&r);
  for (int i = 0; i < samples.n; i++)
    samples.value[0][i] = fmax(0, samples.value[0][i]);
  hl_fit *fit = scene_fit_samples(&samples, HL_FIT_RIDGE, NULL, NULL);
  assert_false(fit->trusted);
  assert_true(fit->reasons.n > 0);
  free(fit);
  hl_samples_free(&samples);
}

/* What each term gains is what the fit loses without it. */
static void test_gains(void **state)
{
  (void)state;
  scene s = scene_two_lobes(2000);
  hl_fit *strong = fit_of(&s, HL_FIT_PURSUIT, NULL, 2);
  s.term[0].strength[0] = 0.05;
  hl_fit *weak = fit_of(&s, HL_FIT_PURSUIT, NULL, 2);
  int i = 0, j = 0;
  scene_off_deg(strong, s.term[0].a, &i);
  scene_off_deg(weak, s.term[0].a, &j);
  assert_true(strong->term[i].gain > 20 * weak->term[j].gain);
  assert_true(weak->term[j].gain > 0);
  free(strong);
  free(weak);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_one_curve_is_unique),
      cmocka_unit_test(test_a_linear_lobe_is_ambiguous_and_not_trusted),
      cmocka_unit_test(test_a_known_light_makes_the_difference),
      cmocka_unit_test(test_a_linear_part_off_the_light),
      cmocka_unit_test(test_shape_of_a_free_curve),
      cmocka_unit_test(test_given_directions_are_named),
      cmocka_unit_test(test_two_quadratics_are_ambiguous),
      cmocka_unit_test(test_one_quadratic_lobe),
      cmocka_unit_test(test_coinciding_directions_are_ambiguous),
      cmocka_unit_test(test_dependent_known_directions_are_ambiguous),
      cmocka_unit_test(test_two_lobes_are_unique),
      cmocka_unit_test(test_three_lobes_are_not_guaranteed),
      cmocka_unit_test(test_a_constant_surface_is_not_trusted),
      cmocka_unit_test(test_gains),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
