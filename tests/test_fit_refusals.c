/* What cannot be fitted is refused with the reason, and the output stays untouched. */
#include <string.h>

#include "fit_scene.h"

static void assert_refused(const hl_samples *samples, hl_fit_model model, const hl_fit_known *known,
                           const hl_fit_settings *settings, hl_status status, const char *words)
{
  hl_ctx ctx = {0};
  hl_fit *fit = malloc(sizeof *fit), *before = malloc(sizeof *before);
  assert_true(fit && before);
  memset(fit, 0x5a, sizeof *fit);
  memcpy(before, fit, sizeof *fit);
  assert_int_equal(hl_fit_samples(&ctx, samples, model, known, settings, fit), status);
  if (!strstr(ctx.msg, words)) {
    print_error("'%s' does not say '%s'\n", ctx.msg, words);
    fail();
  }
  assert_memory_equal(fit, before, sizeof *fit);
  free(fit);
  free(before);
}

static hl_samples good(void)
{
  const scene s = scene_two_lobes(300);
  return scene_samples(&s);
}

static void test_samples(void **state)
{
  (void)state;
  hl_samples s = good();
  s.normal[3 * 7] += 0.5;
  assert_refused(&s, HL_FIT_RIDGE, NULL, NULL, HL_ERR_ARG, "sample 7: length of the normal");
  s.normal[3 * 7] = NAN;
  assert_refused(&s, HL_FIT_RIDGE, NULL, NULL, HL_ERR_ARG, "sample 7: length of the normal");
  memset(s.normal + 3 * 7, 0, 3 * sizeof(double));
  assert_refused(&s, HL_FIT_RIDGE, NULL, NULL, HL_ERR_ARG, "sample 7: length of the normal = 0");
  hl_samples_free(&s);
  s = good();
  s.value[0][3] = -1e-9;
  assert_refused(&s, HL_FIT_RIDGE, NULL, NULL, HL_ERR_ARG, "sample 3: value");
  s.value[0][3] = INFINITY;
  assert_refused(&s, HL_FIT_RIDGE, NULL, NULL, HL_ERR_ARG, "sample 3: value");
  s.value[0][3] = 1;
  s.channels = 2;
  assert_refused(&s, HL_FIT_RIDGE, NULL, NULL, HL_ERR_ARG, "2 channels");
  s.channels = 1;
  const int n = s.n;
  s.n = 0;
  assert_refused(&s, HL_FIT_RIDGE, NULL, NULL, HL_ERR_ARG, "0 samples");
  s.n = 5;
  assert_refused(&s, HL_FIT_RIDGE, NULL, NULL, HL_ERR_DEGENERATE, "5 samples");
  s.n = n;
  hl_samples_free(&s);
}

static void test_views(void **state)
{
  (void)state;
  hl_samples s = good();
  s.view = malloc(3 * (size_t)s.n * sizeof(double));
  for (int i = 0; i < s.n; i++)
    for (int k = 0; k < 3; k++)
      s.view[3 * i + k] = k == 2 ? -1 : 0;
  assert_refused(&s, HL_FIT_RIDGE, NULL, NULL, HL_ERR_DEGENERATE, "is seen");
  s.view[2] = 2;
  assert_refused(&s, HL_FIT_RIDGE, NULL, NULL, HL_ERR_ARG, "length of the view");
  hl_samples_free(&s);
}

static void test_one_circle(void **state)
{
  (void)state;
  hl_samples s = good();
  for (int i = 0; i < s.n; i++) {
    const double t = 0.02 * i;
    s.normal[3 * i] = 0.6 * cos(t);
    s.normal[3 * i + 1] = 0.6 * sin(t);
    s.normal[3 * i + 2] = 0.8;
  }
  assert_refused(&s, HL_FIT_RIDGE, NULL, NULL, HL_ERR_DEGENERATE, "one circle");
  for (int i = 0; i < 3 * s.n; i++)
    s.normal[i] = i % 3 == 2;
  assert_refused(&s, HL_FIT_PURSUIT, NULL, NULL, HL_ERR_DEGENERATE, "one circle");
  hl_samples_free(&s);
}

static void test_light(void **state)
{
  (void)state;
  hl_samples s = good();
  const double behind[3] = {0, 0, -2}, none[3] = {0}, bad[3] = {1, NAN, 0};
  hl_fit_known known = {.light = behind};
  assert_refused(&s, HL_FIT_DICHROMATIC, &known, NULL, HL_ERR_DEGENERATE, "is lit");
  known.light = none;
  assert_refused(&s, HL_FIT_DICHROMATIC, &known, NULL, HL_ERR_ARG, "light");
  known.light = bad;
  assert_refused(&s, HL_FIT_DICHROMATIC, &known, NULL, HL_ERR_ARG, "light");
  hl_samples_free(&s);
}

static void test_black(void **state)
{
  (void)state;
  hl_samples s = good();
  memset(s.value[0], 0, (size_t)s.n * sizeof(double));
  assert_refused(&s, HL_FIT_RIDGE, NULL, NULL, HL_ERR_DEGENERATE, "black");
  hl_samples_free(&s);
}

static void test_directions(void **state)
{
  (void)state;
  hl_samples s = good();
  const double two[6] = {1, 0, 1, 0, 0, 0};
  hl_fit_known known = {.n_directions = 2, .directions = two};
  assert_refused(&s, HL_FIT_ADDITIVE, &known, NULL, HL_ERR_ARG, "a direction");
  known.n_directions = 0;
  assert_refused(&s, HL_FIT_ADDITIVE, &known, NULL, HL_ERR_ARG, "directions = 0");
  known.n_directions = HL_TERMS_MAX + 1;
  assert_refused(&s, HL_FIT_ADDITIVE, &known, NULL, HL_ERR_ARG, "directions = 9");
  known.n_directions = 1;
  assert_refused(&s, HL_FIT_RIDGE, &known, NULL, HL_ERR_ARG, "additive");
  assert_refused(&s, HL_FIT_ADDITIVE, NULL, NULL, HL_ERR_ARG, "needs directions");
  hl_samples_free(&s);
}

static void test_settings(void **state)
{
  (void)state;
  hl_samples s = good();
  hl_fit_settings bad = hl_fit_defaults();
  bad.terms = HL_TERMS_MAX + 1;
  assert_refused(&s, HL_FIT_PURSUIT, NULL, &bad, HL_ERR_ARG, "terms = 9");
  bad = hl_fit_defaults();
  bad.smoother = HL_SMOOTHER_LOESS;
  assert_refused(&s, HL_FIT_PURSUIT, NULL, &bad, HL_ERR_ARG, "loess");
  bad = hl_fit_defaults();
  bad.domain = HL_DOMAIN_LOG;
  assert_refused(&s, HL_FIT_DICHROMATIC, NULL, &bad, HL_ERR_ARG, "log domain");
  assert_refused(&s, HL_FIT_TORRANCE_SPARROW, NULL, NULL, HL_ERR_ARG, "model");
  bad = hl_fit_defaults();
  bad.terms = 8;
  s.n = 40;
  assert_refused(&s, HL_FIT_PURSUIT, NULL, &bad, HL_ERR_DEGENERATE, "48 unknowns");
  s.n = 300;
  hl_samples_free(&s);
}

static void test_defaults_pass_their_own_check(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  const hl_field_table *table = hl_fit_fields();
  hl_fit_settings s = hl_fit_defaults();
  assert_int_equal(hl_fields_check(&ctx, table, &s), HL_OK);
  assert_int_equal(table->n * (int)sizeof(int), (int)sizeof s); /* every member has its field */
  for (int i = 0; i < table->n; i++) {
    int beyond = (int)table->fields[i].max + 1;
    hl_fit_settings t = hl_fit_defaults();
    memcpy((char *)&t + table->fields[i].offset, &beyond, sizeof beyond);
    assert_int_equal(hl_fields_check(&ctx, table, &t), HL_ERR_ARG);
    assert_non_null(strstr(ctx.msg, table->fields[i].name));
  }
}

/* Few samples, no structure, repeated ones: no crash, and numbers that are numbers. */
static void test_poor_samples_end_well(void **state)
{
  (void)state;
  static const hl_fit_model models[] = {HL_FIT_RIDGE, HL_FIT_DICHROMATIC, HL_FIT_PURSUIT};
  for (int kind = 0; kind < 4; kind++) {
    scene sc = scene_two_lobes(kind == 0 ? 14 : kind == 1 ? 60 : 400);
    hl_samples s = scene_samples(&sc);
    test_random r = {3};
    for (int i = 0; i < s.n; i++) {
      if (kind == 2)
        s.value[0][i] = random_uniform(&r);
      if (kind == 3) /* one mirror-like sample */
        s.value[0][i] = i == 11 ? 1e9 : 1e-3;
    }
    for (size_t m = 0; m < sizeof models / sizeof *models; m++) {
      hl_ctx ctx = {0};
      hl_fit *fit = malloc(sizeof *fit);
      assert_non_null(fit);
      const hl_fit_settings two = scene_terms(2);
      const hl_status st = hl_fit_samples(&ctx, &s, models[m], NULL, &two, fit);
      assert_int_equal(st, HL_OK);
      assert_true(isfinite(fit->relative_error) && isfinite(fit->unexplained_variance));
      for (int i = 0; i < fit->n_terms; i++) {
        assert_near(hl_norm(fit->term[i].direction), 1, 1e-9);
        for (int k = 0; k < fit->term[i].n; k++)
          assert_true(isfinite(fit->term[i].value[0][k]));
      }
      free(fit);
    }
    hl_samples_free(&s);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_samples),
      cmocka_unit_test(test_views),
      cmocka_unit_test(test_one_circle),
      cmocka_unit_test(test_light),
      cmocka_unit_test(test_black),
      cmocka_unit_test(test_directions),
      cmocka_unit_test(test_settings),
      cmocka_unit_test(test_defaults_pass_their_own_check),
      cmocka_unit_test(test_poor_samples_end_well),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
