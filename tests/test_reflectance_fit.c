/* Fits as reflectances: which axes follow the light, what is noted, what is refused. */
#include <stdio.h>
#include <string.h>

#include "files.h"
#include "halflight/reflectance.h"
#include "halflight/vec3.h"

static hl_term term_of(hl_term_role role, const char *name, double cs, double cv)
{
  hl_term t = {.role = role, .in_plane = true, .cs = cs, .cv = cv, .n = 3};
  snprintf(t.name, sizeof t.name, "%s", name);
  for (int i = 0; i < 3; i++) {
    t.t[i] = 0.2 + 0.3 * i;
    for (int c = 0; c < 3; c++)
      t.value[c][i] = (c + 1) * t.t[i] * (role == HL_TERM_LINEAR ? 1 : t.t[i]);
  }
  t.direction[2] = 1;
  return t;
}

static hl_fit dichromatic(void)
{
  hl_fit f = {.trusted = true, .model = HL_FIT_DICHROMATIC, .channels = 3, .n_terms = 2};
  f.has_light = f.light_given = true;
  f.light[0] = 0.6;
  f.light[2] = 0.8;
  f.view[2] = 1;
  f.term[0] = term_of(HL_TERM_LINEAR, "s", 1, 0);
  f.term[1] = term_of(HL_TERM_LOBE, "h", 1, 1);
  f.term[1].foreshortened = true;
  return f;
}

static void test_terms(void **state)
{
  (void)state;
  const hl_fit fit = dichromatic();
  hl_reflectance r;
  assert_int_equal(hl_reflectance_of_fit(NULL, &fit, &r), HL_OK);
  assert_int_equal(r.channels, 3);
  assert_int_equal(r.n_terms, 2);
  assert_int_equal(r.notes.n, 0);
  assert_true(r.has_light);
  assert_false(r.camera_frame);
  assert_false(r.log_domain);
  assert_near(r.light[0], 0.6, 0);
  assert_near(r.view[2], 1, 0);
  assert_string_equal(r.term[0].name, "s");
  assert_string_equal(r.term[1].name, "h");
  for (int k = 0; k < 2; k++) {
    assert_false(r.term[k].fixed_axis);
    assert_near(r.term[k].cs, 1, 0);
    assert_near(r.term[k].cv, k, 0);
    assert_int_equal(r.term[k].foreshortened, k);
    assert_near(r.term[k].masking_exponent, 0, 0);
  }
  assert_int_equal(r.term[1].n, 3);
  assert_memory_equal(r.term[1].t, fit.term[1].t, sizeof fit.term[1].t);
  assert_memory_equal(r.term[1].value, fit.term[1].value, sizeof fit.term[1].value);
}

/* A linear term is k t to the ends of its domain, whatever the samples showed of it. */
static void test_a_linear_term_is_straight(void **state)
{
  (void)state;
  hl_fit fit = dichromatic();
  fit.n_terms = 1;
  hl_reflectance r;
  assert_int_equal(hl_reflectance_of_fit(NULL, &fit, &r), HL_OK);
  const double s[3] = {0.6, 0, 0.8}, v[3] = {0, 0, 1};
  for (int i = 0; i < 15; i++) {
    const double a = 0.1 * i, n[3] = {sin(a), 0, cos(a)};
    double out[3];
    hl_reflectance_at(&r, n, s, v, out);
    assert_near(out[2], 3 * fmax(0, hl_dot(n, s)), 1e-14);
  }
}

static void test_fixed_axes(void **state)
{
  (void)state;
  hl_fit fit = dichromatic();
  hl_reflectance r;
  fit.term[1].in_plane = false;
  fit.term[1].name[0] = '\0';
  assert_int_equal(hl_reflectance_of_fit(NULL, &fit, &r), HL_OK);
  assert_false(r.term[0].fixed_axis);
  assert_true(r.term[1].fixed_axis);
  assert_near(r.term[1].axis[2], 1, 0);
  assert_string_equal(r.term[1].name, "term2");
  assert_int_equal(r.notes.n, 1);
  assert_string_equal(r.notes.note[0].what, "fixed axis");
  assert_non_null(strstr(r.notes.note[0].why, "term2 is not in the plane of light and view"));
  fit = dichromatic();
  fit.has_light = false;
  fit.trusted = false;
  assert_int_equal(hl_reflectance_of_fit(NULL, &fit, &r), HL_OK);
  assert_true(r.term[0].fixed_axis && r.term[1].fixed_axis);
  assert_false(r.has_light);
  assert_int_equal(r.notes.n, 3);
  assert_non_null(strstr(r.notes.note[0].why, "not known in terms of light and view"));
  assert_string_equal(r.notes.note[2].what, "untrusted fit");
}

/* The fit's own value at its samples, between the points of the curve up to its curvature. */
static void test_it_says_what_the_fit_says(void **state)
{
  (void)state;
  for (int log_domain = 0; log_domain < 2; log_domain++) {
    hl_fit fit = dichromatic();
    fit.log_domain = log_domain == 1;
    hl_reflectance r;
    assert_int_equal(hl_reflectance_of_fit(NULL, &fit, &r), HL_OK);
    for (int i = 0; i < 3; i++) {
      /* the normal that has n.h at the i-th point; the linear term is a line everywhere */
      double h[3], across[3] = {0, 1, 0}, n[3], want[3], got[3];
      hl_add_scaled(fit.light, 1, fit.view, h);
      hl_unit(h, h);
      for (int k = 0; k < 3; k++)
        n[k] = fit.term[1].t[i] * h[k] + sqrt(1 - fit.term[1].t[i] * fit.term[1].t[i]) * across[k];
      hl_fit_at(&fit, n, fit.view, want);
      hl_reflectance_at(&r, n, fit.light, fit.view, got);
      if (hl_dot(n, fit.light) < 0.2 || hl_dot(n, fit.light) > 0.8)
        continue; /* where the fit's table of its linear term ends */
      for (int c = 0; c < 3; c++)
        assert_near(got[c], want[c], 1e-12 + (log_domain ? 0.01 * want[c] : 0));
    }
  }
}

static void test_refusals(void **state)
{
  (void)state;
  hl_fit fit = dichromatic();
  hl_reflectance r = {.n_terms = -7};
  hl_ctx ctx = {0};
  fit.n_terms = 0;
  assert_int_equal(hl_reflectance_of_fit(&ctx, &fit, &r), HL_ERR_ARG);
  assert_says(ctx.msg, "the fit has 0 terms; 1 to 8 are needed");
  fit = dichromatic();
  fit.term[1].n = 1;
  assert_int_equal(hl_reflectance_of_fit(&ctx, &fit, &r), HL_ERR_ARG);
  assert_says(ctx.msg, "terms[1]: its curve has 1 points; 2 to 121 are needed");
  fit = dichromatic();
  fit.term[0].t[2] = fit.term[0].t[1];
  assert_int_equal(hl_reflectance_of_fit(&ctx, &fit, &r), HL_ERR_ARG);
  assert_says(ctx.msg, "terms[0]: t[2] = 0.5 follows 0.5; an ascending t is needed");
  assert_int_equal(r.n_terms, -7);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_terms),      cmocka_unit_test(test_a_linear_term_is_straight),
      cmocka_unit_test(test_fixed_axes), cmocka_unit_test(test_it_says_what_the_fit_says),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
