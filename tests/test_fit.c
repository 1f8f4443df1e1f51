/* The fits on samples whose directions and curves are known. */
#include "fit_scene.h"

/* Splines of forty intervals come within a millionth of a smooth curve. */
static const double exact_deg = 1e-5;
static const double exact_share = 1e-6;

static void assert_curve(const scene *s, const hl_fit *fit, int truth, double tolerance)
{
  int i = 0;
  const scene_term *t = &s->term[truth];
  scene_off_deg(fit, t->a, &i);
  assert_int_equal(fit->term[i].foreshortened, t->foreshortened);
  for (int c = 0; c < fit->channels; c++)
    for (int k = 10; k < 99; k++)
      assert_near(hl_term_value(&fit->term[i], c, 0.01 * k), t->strength[c] * t->curve(0.01 * k),
                  tolerance * t->strength[c] * t->curve(1));
}

static void test_an_exact_ridge_is_recovered(void **state)
{
  (void)state;
  static const scene_curve curves[] = {scene_linear, scene_square, scene_cubic, scene_gloss,
                                       scene_growth};
  for (size_t k = 0; k < sizeof curves / sizeof *curves; k++) {
    scene s = scene_of(3000);
    s.channels = k % 2 == 0 ? 1 : 3;
    scene_add(&s, 3, -2, 9, curves[k], 2);
    s.light[2] = 1; /* no samples that the linear curve would make negative */
    memcpy(s.light, s.term[0].a, sizeof s.light);
    hl_fit *fit = scene_fit(&s, HL_FIT_RIDGE, NULL, NULL);
    assert_int_equal(fit->n_terms, 1);
    assert_near(scene_off_deg(fit, s.term[0].a, NULL), 0, exact_deg);
    assert_near(fit->relative_error, 0, 1e-5);
    assert_curve(&s, fit, 0, 1e-3); /* the table is linear between its points */
    assert_true(fit->trusted);
    assert_int_equal(fit->verdict, HL_UNIQUE);
    free(fit);
  }
}

static void test_an_exact_foreshortened_ridge_is_told_from_a_plain_one(void **state)
{
  (void)state;
  scene s = scene_of(2500);
  scene_add(&s, 2, 3, 9, scene_gloss, 1);
  s.term[0].foreshortened = true;
  hl_fit *fit = scene_fit(&s, HL_FIT_RIDGE, NULL, NULL);
  assert_true(fit->term[0].foreshortened);
  assert_near(scene_off_deg(fit, s.term[0].a, NULL), 0, exact_deg);
  free(fit);
  hl_fit_settings plain = hl_fit_defaults();
  plain.lobe = HL_LOBE_PLAIN;
  fit = scene_fit(&s, HL_FIT_RIDGE, NULL, &plain);
  assert_false(fit->term[0].foreshortened);
  assert_true(scene_off_deg(fit, s.term[0].a, NULL) > 0.1);
  free(fit);
}

/* Cubic in the chord u = sqrt(2 - 2t): a spline holds it, so nothing but rounding is left. */
static double soft(double t)
{
  return 1 - pow(1 - t, 1.5);
}

static void test_what_a_spline_holds_is_recovered_to_rounding(void **state)
{
  (void)state;
  scene s = scene_of(2500);
  scene_add(&s, 3, 2, 9, soft, 1);
  hl_fit *fit = scene_fit(&s, HL_FIT_RIDGE, NULL, NULL);
  assert_near(scene_off_deg(fit, s.term[0].a, NULL), 0, 1e-7);
  assert_near(fit->relative_error, 0, 3e-7);
  free(fit);
  scene_add(&s, -5, 3, 8, soft, 0.5);
  const hl_fit_settings two = scene_terms(2);
  fit = scene_fit(&s, HL_FIT_PURSUIT, NULL, &two);
  for (int k = 0; k < 2; k++)
    assert_near(scene_off_deg(fit, s.term[k].a, NULL), 0, 1e-6);
  assert_near(fit->relative_error, 0, 3e-7);
  free(fit);
}

static void test_two_exact_lobes_are_recovered(void **state)
{
  (void)state;
  for (int channels = 1; channels <= 3; channels += 2) {
    scene s = scene_two_lobes(4000);
    s.channels = channels;
    const hl_fit_settings two = scene_terms(2);
    hl_fit *fit = scene_fit(&s, HL_FIT_PURSUIT, NULL, &two);
    for (int k = 0; k < 2; k++) {
      assert_near(scene_off_deg(fit, s.term[k].a, NULL), 0, exact_deg);
      assert_curve(&s, fit, k, 1e-3);
    }
    assert_near(fit->relative_error, 0, exact_share);
    assert_int_equal(fit->verdict, HL_UNIQUE);
    assert_non_null(strstr(fit->proposition, "Proposition 6"));
    free(fit);
  }
}

static void test_terms_are_counted_by_cross_validation(void **state)
{
  (void)state;
  scene s = scene_of(3000);
  s.noise = 0.01;
  scene_add(&s, 3, 2, 9, scene_cubic, 1);
  memcpy(s.light, s.term[0].a, sizeof s.light); /* none so dark that noise would be cut off */
  hl_fit *fit = scene_fit(&s, HL_FIT_PURSUIT, NULL, NULL);
  assert_int_equal(fit->n_terms, 1);
  assert_int_equal(fit->n_sizes, hl_fit_defaults().max_terms);
  free(fit);
  scene_add(&s, -5, 3, 8, scene_growth, 1);
  fit = scene_fit(&s, HL_FIT_PURSUIT, NULL, NULL);
  assert_int_equal(fit->n_terms, 2);
  assert_true(fit->size[1].cross_validated < 0.5 * fit->size[0].cross_validated);
  free(fit);
}

/* Light given: Prop. 5. */
static void test_a_dichromatic_surface_of_known_light(void **state)
{
  (void)state;
  scene s = scene_dichromatic(3000);
  const hl_fit_known known = {.light = s.light};
  hl_fit *fit = scene_fit(&s, HL_FIT_DICHROMATIC, &known, NULL);
  assert_int_equal(fit->n_terms, 2);
  assert_int_equal(fit->term[0].role, HL_TERM_LINEAR);
  assert_string_equal(fit->term[0].name, "s");
  assert_string_equal(fit->term[1].name, "h");
  assert_near(fit->term[0].strength[0], 1, 1e-4);
  assert_near(scene_off_deg(fit, s.term[1].a, NULL), 0, exact_deg);
  assert_curve(&s, fit, 1, 1e-3);
  assert_int_equal(fit->verdict, HL_UNIQUE);
  assert_non_null(strstr(fit->proposition, "Proposition 5"));
  free(fit);
}

/* A lobe that is no half vector's: found where it is, in no plane. */
static void test_a_lobe_off_the_plane_of_light_and_view(void **state)
{
  (void)state;
  scene s = scene_dichromatic(3000);
  s.terms = 1;
  scene_add(&s, -5, 3, 8, scene_gloss, 0.8);
  for (int given = 0; given < 2; given++) {
    const hl_fit_known known = {.light = given ? s.light : NULL};
    hl_fit *fit = scene_fit(&s, HL_FIT_DICHROMATIC, &known, NULL);
    assert_near(SCENE_DEG * hl_angle(fit->term[1].direction, s.term[1].a), 0, 2e-5);
    assert_false(fit->term[1].in_plane);
    assert_string_equal(fit->term[1].name, "");
    assert_int_equal(fit->has_light, given);
    assert_int_equal(fit->verdict, given ? HL_UNIQUE : HL_AMBIGUOUS);
    free(fit);
  }
}

/* Light unknown: Prop. 3, and the light from the half vector. */
static void test_a_dichromatic_surface_of_unknown_light(void **state)
{
  (void)state;
  scene s = scene_dichromatic(3000);
  hl_fit *fit = scene_fit(&s, HL_FIT_DICHROMATIC, NULL, NULL);
  assert_true(fit->has_light);
  assert_false(fit->light_given);
  assert_near(SCENE_DEG * hl_angle(fit->light, s.light), 0, exact_deg);
  assert_int_equal(fit->verdict, HL_AMBIGUOUS);
  assert_non_null(strstr(fit->proposition, "Proposition 3"));
  assert_non_null(strstr(fit->stays_free, "k b.n"));
  free(fit);
}

/* A plain lobe that no light explains: as much as can goes to the linear part, and what they say
 * together stays. */
static void test_the_share_that_can_be_moved_is_moved(void **state)
{
  (void)state;
  scene s = scene_dichromatic(2500);
  s.terms = 1;
  scene_add(&s, -2, 3, 8, scene_cubic, 0.8);
  hl_samples samples = scene_samples(&s);
  int n = 0;
  for (int i = 0; i < samples.n; i++) { /* where the lobe's argument is positive: L1 */
    if (hl_dot(samples.normal + 3 * i, s.term[1].a) <= 0)
      continue;
    memmove(samples.normal + 3 * n, samples.normal + 3 * i, 3 * sizeof(double));
    samples.value[0][n++] = samples.value[0][i];
  }
  samples.n = n;
  hl_fit_settings plain = hl_fit_defaults();
  plain.lobe = HL_LOBE_PLAIN;
  hl_fit *fit = scene_fit_samples(&samples, HL_FIT_DICHROMATIC, NULL, &plain);
  assert_false(fit->has_light);
  double least = HUGE_VAL;
  const hl_term *lobe = &fit->term[1];
  for (int k = 1; k < lobe->n; k++)
    if (lobe->t[k] > lobe->shown[0] && lobe->t[k - 1] < lobe->shown[1])
      least =
          fmin(least, (lobe->value[0][k] - lobe->value[0][k - 1]) / (lobe->t[k] - lobe->t[k - 1]));
  assert_near(least, 0, 1e-6);
  for (int i = 0; i < samples.n; i++) {
    double value[3];
    const double view[3] = {0, 0, 1};
    hl_fit_at(fit, samples.normal + 3 * i, view, value);
    assert_near(value[0], samples.value[0][i], 1e-3);
  }
  free(fit);
  hl_samples_free(&samples);
}

static void test_known_directions(void **state)
{
  (void)state;
  scene s = scene_two_lobes(3000);
  s.term[0].foreshortened = true;
  double directions[6];
  memcpy(directions, s.term[0].a, sizeof s.term[0].a);
  memcpy(directions + 3, s.term[1].a, sizeof s.term[1].a);
  const hl_fit_known known = {.n_directions = 2, .directions = directions};
  hl_fit *fit = scene_fit(&s, HL_FIT_ADDITIVE, &known, NULL);
  for (int k = 0; k < 2; k++)
    assert_curve(&s, fit, k, 1e-3);
  assert_near(fit->relative_error, 0, exact_share);
  assert_int_equal(fit->verdict, HL_UNIQUE);
  free(fit);
}

/* With a light and no directions: s and h. */
static void test_additive_of_a_light_takes_s_and_h(void **state)
{
  (void)state;
  scene s = scene_dichromatic(2000);
  const hl_fit_known known = {.light = s.light};
  hl_fit *fit = scene_fit(&s, HL_FIT_ADDITIVE, &known, NULL);
  assert_int_equal(fit->n_terms, 2);
  assert_string_equal(fit->term[0].name, "s");
  assert_string_equal(fit->term[1].name, "h");
  free(fit);
}

/* Prop. 6: two lobes that are neither linear nor quadratic say where the light is. */
static void test_light_and_reflectance_from_two_lobes(void **state)
{
  (void)state;
  scene s = scene_dichromatic(4000);
  s.term[0].curve = scene_cubic;
  s.term[1].foreshortened = true;
  const hl_fit_settings two = scene_terms(2);
  hl_fit *fit = scene_fit(&s, HL_FIT_PURSUIT, NULL, &two);
  assert_true(fit->has_light);
  assert_near(SCENE_DEG * hl_angle(fit->light, s.light), 0, 1e-4);
  int h = 0;
  assert_near(scene_off_deg(fit, s.term[1].a, &h), 0, 1e-4);
  assert_string_equal(fit->term[h].name, "h");
  assert_string_equal(fit->term[1 - h].name, "s");
  free(fit);
}

static void test_directions_of_the_plane_get_their_names(void **state)
{
  (void)state;
  scene s = scene_dichromatic(3000);
  const double plane[2][2] = {{2, 1}, {0, 1}};
  s.terms = 0;
  for (int k = 0; k < 2; k++)
    scene_add(&s, plane[k][0] * s.light[0], plane[k][0] * s.light[1],
              plane[k][0] * s.light[2] + plane[k][1], k == 0 ? scene_gloss : scene_cubic, 1);
  const hl_fit_known known = {.light = s.light};
  const hl_fit_settings two = scene_terms(2);
  hl_fit *fit = scene_fit(&s, HL_FIT_PURSUIT, &known, &two);
  int at = 0;
  scene_off_deg(fit, s.term[0].a, &at);
  assert_string_equal(fit->term[at].name, "2s+v");
  assert_near(fit->term[at].cs, 2, 0);
  assert_near(fit->term[at].cv, 1, 0);
  assert_string_equal(fit->term[1 - at].name, "v");
  assert_near(fit->relative_error, 0, exact_share);
  free(fit);
}

/* Views of a camera nearby: the half vector is another for every sample. */
static void test_half_vectors_follow_every_view(void **state)
{
  (void)state;
  scene s = scene_dichromatic(3000);
  hl_samples samples = scene_samples(&s);
  samples.view = malloc(3 * (size_t)samples.n * sizeof(double));
  for (int i = 0; i < samples.n; i++) {
    const double *n = samples.normal + 3 * i;
    double *v = samples.view + 3 * i, h[3];
    for (int k = 0; k < 3; k++)
      v[k] = (k == 2 ? 1 : 0) - 0.1 * n[k];
    hl_unit(v, v);
    hl_add_scaled(v, 1, s.light, h);
    hl_unit(h, h);
    samples.value[0][i] = hl_dot(n, s.light) + scene_gloss(fmax(0, hl_dot(n, h)));
  }
  const hl_fit_known known = {.light = s.light};
  hl_fit *fit = scene_fit_samples(&samples, HL_FIT_DICHROMATIC, &known, NULL);
  assert_string_equal(fit->term[1].name, "h");
  assert_near(fit->relative_error, 0, exact_share);
  free(fit);
  fit = scene_fit_samples(&samples, HL_FIT_DICHROMATIC, NULL, NULL);
  assert_near(SCENE_DEG * hl_angle(fit->light, s.light), 0, 1e-5);
  free(fit);
  hl_samples_free(&samples);
}

static void test_a_product_in_the_log_domain(void **state)
{
  (void)state;
  scene s = scene_two_lobes(3000);
  s.term[0].curve = scene_square;
  for (int divided = 0; divided < 2; divided++) {
    hl_samples samples = scene_samples(&s);
    for (int i = 0; i < samples.n; i++)
      samples.value[0][i] =
          5 * exp(samples.value[0][i]) / (divided ? samples.normal[3 * i + 2] : 1);
    hl_fit_settings log_two = scene_terms(2);
    log_two.domain = HL_DOMAIN_LOG;
    hl_fit *fit = scene_fit_samples(&samples, HL_FIT_PURSUIT, NULL, &log_two);
    assert_true(fit->log_domain);
    assert_int_equal(fit->term[0].foreshortened + fit->term[1].foreshortened, divided);
    assert_near(fit->relative_error, 0, 3e-6);
    for (int k = 0; k < 2; k++)
      assert_near(scene_off_deg(fit, s.term[k].a, NULL), 0, 1e-3);
    const double view[3] = {0, 0, 1};
    for (int i = 0; i < samples.n; i += 17) {
      double value[3];
      hl_fit_at(fit, samples.normal + 3 * i, view, value);
      assert_near(value[0] / samples.value[0][i], 1, 2e-3);
    }
    free(fit);
    hl_samples_free(&samples);
  }
}

/* Error of the direction grows with the noise, as the fit's own deviation says. */
static void test_error_follows_the_noise(void **state)
{
  (void)state;
  enum { RUNS = 24 };
  double rms[2] = {0}, stated[2] = {0};
  for (int level = 0; level < 2; level++)
    for (unsigned seed = 1; seed <= RUNS; seed++) {
      scene s = scene_of(800);
      scene_add(&s, 3, 2, 9, scene_gloss, 1);
      scene_add(&s, 3, 2, 9, scene_linear, 1);
      s.noise = level == 0 ? 0.005 : 0.02;
      s.seed = 77 * seed;
      for (int k = 0; k < 3; k++)
        s.light[k] = s.term[0].a[k];
      hl_fit_settings plain = hl_fit_defaults();
      plain.lobe = HL_LOBE_PLAIN;
      hl_fit *fit = scene_fit(&s, HL_FIT_RIDGE, NULL, &plain);
      const double off = hl_angle(fit->term[0].direction, s.term[0].a);
      rms[level] += off * off / RUNS;
      stated[level] += fit->direction_sigma_rad / RUNS;
      free(fit);
    }
  /* two degrees of freedom; weights are not those of this even noise */
  assert_near(log(sqrt(rms[1] / rms[0]) / 4), 0, 0.4);
  for (int level = 0; level < 2; level++)
    assert_near(log(sqrt(rms[level] / 2) / stated[level]), 0, 0.5);
}

static void test_loess_smooths_the_ridge(void **state)
{
  (void)state;
  scene s = scene_of(4000);
  scene_add(&s, 3, 2, 9, scene_gloss, 1);
  s.noise = 0.02;
  hl_fit_settings loess = hl_fit_defaults();
  loess.smoother = HL_SMOOTHER_LOESS;
  hl_fit *fit = scene_fit(&s, HL_FIT_RIDGE, NULL, &loess);
  assert_curve(&s, fit, 0, 0.02);
  for (int k = 1; k < fit->term[0].n; k++)
    assert_true(fit->term[0].value[0][k] >= fit->term[0].value[0][k - 1]);
  free(fit);
}

/* A million samples would need 16 times the memory of this in 16 times the time: no more is kept of a
 * sample than its numbers. Here only that many blocks and all sizes of sets work together. */
static void test_many_samples(void **state)
{
  (void)state;
  scene s = scene_two_lobes(60000);
  const hl_fit_settings two = scene_terms(2);
  hl_fit *fit = scene_fit(&s, HL_FIT_PURSUIT, NULL, &two);
  for (int k = 0; k < 2; k++)
    assert_near(scene_off_deg(fit, s.term[k].a, NULL), 0, exact_deg);
  free(fit);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_an_exact_ridge_is_recovered),
      cmocka_unit_test(test_an_exact_foreshortened_ridge_is_told_from_a_plain_one),
      cmocka_unit_test(test_what_a_spline_holds_is_recovered_to_rounding),
      cmocka_unit_test(test_two_exact_lobes_are_recovered),
      cmocka_unit_test(test_terms_are_counted_by_cross_validation),
      cmocka_unit_test(test_a_dichromatic_surface_of_known_light),
      cmocka_unit_test(test_a_lobe_off_the_plane_of_light_and_view),
      cmocka_unit_test(test_a_dichromatic_surface_of_unknown_light),
      cmocka_unit_test(test_the_share_that_can_be_moved_is_moved),
      cmocka_unit_test(test_known_directions),
      cmocka_unit_test(test_additive_of_a_light_takes_s_and_h),
      cmocka_unit_test(test_light_and_reflectance_from_two_lobes),
      cmocka_unit_test(test_directions_of_the_plane_get_their_names),
      cmocka_unit_test(test_half_vectors_follow_every_view),
      cmocka_unit_test(test_a_product_in_the_log_domain),
      cmocka_unit_test(test_error_follows_the_noise),
      cmocka_unit_test(test_loess_smooths_the_ridge),
      cmocka_unit_test(test_many_samples),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
