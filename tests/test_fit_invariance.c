/* The same scene, turned, brighter, in another order or with other threads, gives the same fit. */
#include "fit_scene.h"

static scene noisy_pair(void)
{
  scene s = scene_two_lobes(3000);
  s.noise = 0.01;
  s.channels = 3;
  return s;
}

static hl_fit *pursue(const hl_samples *samples, int threads)
{
  hl_fit_settings two = scene_terms(2);
  two.threads = threads;
  return scene_fit_samples(samples, HL_FIT_PURSUIT, NULL, &two);
}

static void test_turning_the_scene_turns_the_directions(void **state)
{
  (void)state;
  const scene s = noisy_pair();
  hl_samples samples = scene_samples(&s);
  hl_fit *before = pursue(&samples, 1);
  /* x to y, y to -x: a quarter about the view */
  for (int i = 0; i < samples.n; i++) {
    double *n = samples.normal + 3 * i;
    const double x = n[0];
    n[0] = -n[1];
    n[1] = x;
  }
  hl_fit *after = pursue(&samples, 1);
  for (int i = 0; i < 2; i++) {
    const double *a = before->term[i].direction;
    const double turned[3] = {-a[1], a[0], a[2]};
    assert_near(scene_off_deg(after, turned, NULL), 0, 0.15);
  }
  assert_near(after->relative_error / before->relative_error, 1, 0.01);
  free(before);
  free(after);
  hl_samples_free(&samples);
}

/* Without noise the turn shows to rounding of the splines. */
static void test_turning_a_clean_scene(void **state)
{
  (void)state;
  for (int turn = 0; turn < 3; turn++) {
    scene s = scene_of(2500);
    const double c = cos(turn), d = sin(turn);
    scene_add(&s, 3 * c - 2 * d, 3 * d + 2 * c, 9, scene_gloss, 1);
    scene_add(&s, -5 * c - 3 * d, -5 * d + 3 * c, 8, scene_growth, 1);
    const hl_fit_settings two = scene_terms(2);
    hl_fit *fit = scene_fit(&s, HL_FIT_PURSUIT, NULL, &two);
    for (int k = 0; k < 2; k++)
      assert_near(scene_off_deg(fit, s.term[k].a, NULL), 0, 1e-5);
    free(fit);
  }
}

static void test_brightness_scales_the_curves_alone(void **state)
{
  (void)state;
  const scene s = noisy_pair();
  hl_samples samples = scene_samples(&s);
  hl_fit *before = pursue(&samples, 1);
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < samples.n; i++)
      samples.value[c][i] = ldexp(samples.value[c][i], 40);
  hl_fit *after = pursue(&samples, 1);
  for (int i = 0; i < 2; i++) {
    assert_memory_equal(before->term[i].direction, after->term[i].direction, 3 * sizeof(double));
    for (int k = 0; k < before->term[i].n; k++)
      assert_near(ldexp(after->term[i].value[1][k], -40), before->term[i].value[1][k], 0);
  }
  free(before);
  free(after);
  hl_samples_free(&samples);
}

static void test_order_does_not_matter(void **state)
{
  (void)state;
  const scene s = noisy_pair();
  hl_samples samples = scene_samples(&s);
  hl_fit *before = pursue(&samples, 1);
  test_random r = {9};
  for (int i = samples.n - 1; i > 0; i--) {
    const int j = (int)(random_uniform(&r) * (i + 1));
    for (int k = 0; k < 3; k++) {
      const double n = samples.normal[3 * i + k], y = samples.value[k][i];
      samples.normal[3 * i + k] = samples.normal[3 * j + k];
      samples.normal[3 * j + k] = n;
      samples.value[k][i] = samples.value[k][j];
      samples.value[k][j] = y;
    }
  }
  hl_fit *after = pursue(&samples, 1);
  for (int i = 0; i < 2; i++)
    assert_near(scene_off_deg(after, before->term[i].direction, NULL), 0, 1e-4);
  assert_near(after->relative_error / before->relative_error, 1, 1e-5);
  free(before);
  free(after);
  hl_samples_free(&samples);
}

static void test_threads_do_not_change_a_bit(void **state)
{
  (void)state;
  scene s = noisy_pair();
  s.n = 12000;
  hl_samples samples = scene_samples(&s);
  hl_fit *one = pursue(&samples, 1), *four = pursue(&samples, 4);
  assert_memory_equal(one->term, four->term, sizeof one->term);
  assert_true(one->relative_error == four->relative_error);
  assert_true(one->condition == four->condition);
  free(one);
  free(four);
  hl_samples_free(&samples);
}

static void test_repeating_does_not_change_a_bit(void **state)
{
  (void)state;
  const scene s = noisy_pair();
  hl_fit *one = scene_fit(&s, HL_FIT_PURSUIT, NULL, NULL);
  hl_fit *again = scene_fit(&s, HL_FIT_PURSUIT, NULL, NULL);
  assert_memory_equal(one, again, sizeof *one);
  free(one);
  free(again);
}

/* Grey repeated three times is the grey fit, three times. */
static void test_equal_channels(void **state)
{
  (void)state;
  scene s = scene_two_lobes(2000);
  s.noise = 0.005;
  hl_samples grey = scene_samples(&s);
  hl_fit *one = pursue(&grey, 1);
  hl_samples colour = grey;
  colour.channels = 3;
  colour.value[1] = colour.value[2] = grey.value[0];
  hl_fit *three = pursue(&colour, 1);
  for (int i = 0; i < 2; i++)
    assert_near(scene_off_deg(three, one->term[i].direction, NULL), 0, 1e-3);
  for (int k = 0; k < three->term[0].n; k++)
    assert_near(three->term[0].value[2][k], three->term[0].value[0][k], 0);
  free(one);
  free(three);
  hl_samples_free(&grey);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_turning_the_scene_turns_the_directions),
      cmocka_unit_test(test_turning_a_clean_scene),
      cmocka_unit_test(test_brightness_scales_the_curves_alone),
      cmocka_unit_test(test_order_does_not_matter),
      cmocka_unit_test(test_threads_do_not_change_a_bit),
      cmocka_unit_test(test_repeating_does_not_change_a_bit),
      cmocka_unit_test(test_equal_channels),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
