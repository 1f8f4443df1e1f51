/* Parametric fits: exact on what they rendered themselves, slopes against differences, the right answer
 * where the form does not fit, every refusal. */
#include <stdlib.h>
#include <string.h>

#include "../src/parametric_model.h"
#include "files.h"
#include "halflight/reflectance.h"
#include "halflight/vec3.h"

static const double toward[3] = {1, 1, 1};

typedef struct truth {
  hl_fit_model model;
  double mu, kd[3], ks[3];
  double noise; /* relative */
} truth;

static double radiance(const truth *t, const double n[3], const double s[3], const double v[3],
                       int c)
{
  double h[3];
  if (hl_dot(n, s) <= 0)
    return 0;
  hl_add_scaled(s, 1, v, h);
  hl_unit(h, h);
  const double angle = hl_angle(n, h);
  const double lobe = t->model == HL_FIT_TORRANCE_SPARROW ? exp(-t->mu * angle * angle)
                                                          : pow(fmax(cos(angle), 0), t->mu);
  return t->kd[c] * hl_dot(n, s) + t->ks[c] * lobe;
}

/* A ball of radius 30 seen from afar, unlit samples too where asked for; with views, each its own. */
static hl_samples ball(const truth *t, int channels, bool unlit, bool views)
{
  enum { R = 30, MOST = 4 * R * R };
  hl_samples out = {.channels = channels};
  test_random random = {8};
  double s[3];
  hl_unit(toward, s);
  out.normal = malloc(3 * MOST * sizeof(double));
  out.view = views ? malloc(3 * MOST * sizeof(double)) : NULL;
  for (int c = 0; c < channels; c++)
    out.value[c] = malloc(MOST * sizeof(double));
  for (int i = 0; i < MOST; i++) {
    const double x = (i % (2 * R) + 0.5) / R - 1, y = (i / (2 * R) + 0.5) / R - 1;
    const double z2 = 1 - x * x - y * y;
    double v[3] = {views ? -0.2 * x : 0, views ? -0.2 * y : 0, 1};
    if (z2 <= 0.0025)
      continue;
    const double n[3] = {x, y, sqrt(z2)};
    hl_unit(v, v);
    if (!unlit && hl_dot(n, s) < 0.02)
      continue;
    memcpy(out.normal + 3 * out.n, n, sizeof n);
    if (views)
      memcpy(out.view + 3 * out.n, v, sizeof v);
    for (int c = 0; c < channels; c++)
      out.value[c][out.n] =
          fmax(0, radiance(t, n, s, v, c) *
                      (1 + (t->noise > 0 ? t->noise * random_normal(&random) : 0)));
    out.n++;
  }
  return out;
}

static hl_fit fit_of(const hl_samples *samples, hl_fit_model model)
{
  hl_ctx ctx = {0};
  hl_fit out;
  if (hl_fit_parametric(&ctx, samples, model, toward, &out) != HL_OK)
    fail_msg("%s", ctx.msg);
  return out;
}

static double mu_of(const hl_fit *fit)
{
  const char *at = strstr(fit->used.note[0].why, "mu = ");
  assert_non_null(at);
  return strtod(at + 5, NULL);
}

/* ---- exact */

static void recovered(const truth *t, int channels, bool unlit, bool views)
{
  hl_samples samples = ball(t, channels, unlit, views);
  const hl_fit fit = fit_of(&samples, t->model);
  assert_true(fit.trusted);
  assert_near(mu_of(&fit), t->mu, 1e-5 * t->mu); /* the note has six digits */
  assert_near(fit.relative_error, 0, 1e-13);
  assert_near(fit.unexplained_variance, 0, 1e-25);
  for (int c = 0; c < channels; c++) {
    assert_near(fit.term[0].strength[c], t->kd[c], 1e-12);
    assert_near(fit.term[1].strength[c], t->ks[c], 1e-12);
    for (int i = 1; i < fit.term[1].n; i++) {
      const double angle = acos(fmin(fit.term[1].t[i], 1));
      const double want = t->model == HL_FIT_TORRANCE_SPARROW ? exp(-t->mu * angle * angle)
                                                              : pow(fit.term[1].t[i], t->mu);
      assert_near(fit.term[1].value[c][i], t->ks[c] * want, 1e-11);
    }
  }
  hl_samples_free(&samples);
}

static void test_what_it_rendered_comes_back(void **state)
{
  (void)state;
  static const double widths[] = {3, 40, 400, 2000};
  for (int model = HL_FIT_TORRANCE_SPARROW; model <= HL_FIT_BLINN_PHONG; model++)
    for (int k = 0; k < 4; k++) {
      const truth t = {
          .model = (hl_fit_model)model, .mu = widths[k], .kd = {0.3, 0.2, 0}, .ks = {0.5, 0.1, 2}};
      recovered(&t, 3, false, false);
      recovered(&t, 1, true, false);
      recovered(&t, 3, true, true);
    }
}

/* A fit like any other: the reflectance made of it is the formula, under another light too. */
static void test_it_relights(void **state)
{
  (void)state;
  const truth t = {
      .model = HL_FIT_TORRANCE_SPARROW, .mu = 60, .kd = {0.3, 0.2, 0.1}, .ks = {0.5, 0.1, 2}};
  hl_samples samples = ball(&t, 3, false, false);
  const hl_fit fit = fit_of(&samples, t.model);
  hl_reflectance r;
  test_random random = {3};
  assert_int_equal(hl_reflectance_of_fit(NULL, &fit, &r), HL_OK);
  for (int k = 0; k < 500; k++) {
    double n[3], s[3], v[3], got[3];
    for (int i = 0; i < 3; i++) {
      n[i] = random_normal(&random);
      s[i] = random_normal(&random);
      v[i] = random_normal(&random);
    }
    hl_unit(n, n);
    hl_unit(s, s);
    hl_unit(v, v);
    if (hl_dot(n, v) <= 0)
      continue;
    hl_reflectance_at(&r, n, s, v, got);
    for (int c = 0; c < 3; c++) /* between the curve's 121 points */
      assert_near(got[c], radiance(&t, n, s, v, c), 1e-4 * t.ks[c]);
  }
  hl_samples_free(&samples);
}

static void test_terms(void **state)
{
  (void)state;
  const truth t = {.model = HL_FIT_BLINN_PHONG, .mu = 60, .kd = {0.3}, .ks = {0.5}};
  hl_samples samples = ball(&t, 1, false, false);
  const hl_fit fit = fit_of(&samples, t.model);
  double s[3], h[3] = {0, 0, 1};
  hl_unit(toward, s);
  hl_add_scaled(h, 1, s, h);
  hl_unit(h, h);
  assert_int_equal(fit.model, HL_FIT_BLINN_PHONG);
  assert_int_equal(fit.n_samples, samples.n);
  assert_int_equal(fit.n_terms, 2);
  assert_int_equal(fit.term[0].role, HL_TERM_LINEAR);
  assert_int_equal(fit.term[1].role, HL_TERM_LOBE);
  assert_string_equal(fit.term[0].name, "s");
  assert_string_equal(fit.term[1].name, "h");
  for (int i = 0; i < 3; i++) {
    assert_near(fit.term[0].direction[i], s[i], 1e-15);
    assert_near(fit.term[1].direction[i], h[i], 1e-15);
  }
  assert_near(fit.least_angle_rad, hl_angle(s, h), 1e-15);
  for (int k = 0; k < 2; k++) {
    assert_true(fit.term[k].in_plane && !fit.term[k].foreshortened);
    assert_near(fit.term[k].cs, 1, 0);
    assert_near(fit.term[k].cv, k, 0);
    assert_true(fit.term[k].gain > 0.05);
    assert_true(fit.term[k].shown[0] > 0 && fit.term[k].shown[0] < 0.2);
    assert_true(fit.term[k].shown[1] > 0.99 && fit.term[k].shown[1] <= 1);
  }
  /* the body is k t; the lobe of t^60 is neither that nor q t^2 */
  assert_near(fit.term[0].off_linear, 0, 1e-7);
  assert_near(fit.term[0].off_quadratic, 0, 1e-7);
  assert_true(fit.term[1].off_linear > 0.5 && fit.term[1].off_quadratic > 0.5);
  assert_true(fit.term[1].off_quadratic <= fit.term[1].off_linear);
  assert_int_equal(fit.verdict, HL_UNIQUE);
  hl_samples_free(&samples);
}

/* ---- least squares */

/* The gradient of the squares, from residuals and slopes, against differences of the squares. */
static void test_slopes_against_differences(void **state)
{
  (void)state;
  for (int model = HL_FIT_TORRANCE_SPARROW; model <= HL_FIT_BLINN_PHONG; model++) {
    const truth t = {.model = (hl_fit_model)(HL_FIT_TORRANCE_SPARROW + HL_FIT_BLINN_PHONG - model),
                     .mu = 30,
                     .kd = {0.3, 0.2, 0},
                     .ks = {0.5, 0.1, 0}, /* channel 2 black: nothing of it may matter */
                     .noise = 0.1};
    hl_samples samples = ball(&t, 3, false, false);
    const int n = samples.n;
    double *residual = malloc(6 * (size_t)n * sizeof *residual), *slope = residual + 3 * n;
    hl_parametric m = {.model = (hl_fit_model)model, .n = n, .channels = 3};
    double s[3], h[3] = {0, 0, 1};
    hl_unit(toward, s);
    hl_add_scaled(h, 1, s, h);
    hl_unit(h, h);
    m.body = malloc((size_t)n * sizeof(double));
    m.abscissa = malloc((size_t)n * sizeof(double));
    m.lobe = malloc((size_t)n * sizeof(double));
    for (int i = 0; i < n; i++) {
      const double angle = hl_angle(samples.normal + 3 * i, h);
      m.body[i] = hl_dot(samples.normal + 3 * i, s);
      m.abscissa[i] = model == HL_FIT_TORRANCE_SPARROW ? angle * angle : -log(cos(angle));
    }
    for (int c = 0; c < 3; c++)
      m.value[c] = samples.value[c];
    for (int k = 0; k < 9; k++) {
      const double p = k - 1, step = 1e-5;
      double gradient = 0, squares = 0;
      const double ahead = hl_parametric_solve(&m, p + step);
      const double behind = hl_parametric_solve(&m, p - step);
      hl_parametric_residuals(&m, p, residual);
      hl_parametric_slopes(&m, p, slope);
      for (int i = 0; i < 3 * n; i++) {
        gradient += 2 * residual[i] * slope[i];
        squares += residual[i] * residual[i];
      }
      assert_near(squares, hl_parametric_solve(&m, p), 1e-12 * squares);
      assert_near(gradient, (ahead - behind) / (2 * step), 1e-6 * squares);
    }
    free(m.body);
    free(m.abscissa);
    free(m.lobe);
    free(residual);
    hl_samples_free(&samples);
  }
}

/* On data of another form: no width near or far leaves smaller squares. */
static void test_the_best_of_all_widths(void **state)
{
  (void)state;
  truth t = {.model = HL_FIT_BLINN_PHONG, .mu = 8, .kd = {0.3}, .ks = {0.5}, .noise = 0.02};
  hl_samples samples = ball(&t, 1, false, false);
  /* a second, narrower lobe makes a second valley */
  const truth second = {.model = HL_FIT_BLINN_PHONG, .mu = 3000, .ks = {0.6}};
  const double v[3] = {0, 0, 1};
  double s[3];
  hl_unit(toward, s);
  for (int i = 0; i < samples.n; i++)
    samples.value[0][i] += radiance(&second, samples.normal + 3 * i, s, v, 0);
  const hl_fit fit = fit_of(&samples, HL_FIT_TORRANCE_SPARROW);
  double least = HUGE_VAL, reached = 0;
  for (int i = 0; i < samples.n; i++) {
    double got[3];
    hl_reflectance r;
    if (i == 0)
      assert_int_equal(hl_reflectance_of_fit(NULL, &fit, &r), HL_OK);
    hl_fit_at(&fit, samples.normal + 3 * i, v, got);
    reached += pow(got[0] - samples.value[0][i], 2);
  }
  for (int k = 0; k <= 400; k++) {
    const double mu = exp(-4 + 0.05 * k);
    double dd = 0, de = 0, ee = 0, dy = 0, ey = 0, yy = 0;
    for (int i = 0; i < samples.n; i++) {
      double h[3];
      hl_add_scaled(s, 1, v, h);
      hl_unit(h, h);
      const double angle = hl_angle(samples.normal + 3 * i, h);
      const double d = hl_dot(samples.normal + 3 * i, s), e = exp(-mu * angle * angle);
      const double y = samples.value[0][i];
      dd += d * d;
      de += d * e;
      ee += e * e;
      dy += d * y;
      ey += e * y;
      yy += y * y;
    }
    const double q = dd * ee - de * de, kd = (ee * dy - de * ey) / q, ks = (dd * ey - de * dy) / q;
    if (kd >= 0 && ks >= 0)
      least = fmin(least, yy - kd * dy - ks * ey);
  }
  assert_true(reached <= least * (1 + 1e-4)); /* the table of the curve costs a little */
  hl_samples_free(&samples);
}

static void test_scaling_the_radiance(void **state)
{
  (void)state;
  const truth t = {.model = HL_FIT_TORRANCE_SPARROW,
                   .mu = 60,
                   .kd = {0.3, 0.2, 0.1},
                   .ks = {0.5, 0.1, 2},
                   .noise = 0.05};
  hl_samples samples = ball(&t, 3, false, false);
  const hl_fit fit = fit_of(&samples, t.model);
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < samples.n; i++)
      samples.value[c][i] *= 1e-6;
  const hl_fit small = fit_of(&samples, t.model);
  assert_near(mu_of(&small), mu_of(&fit), 1e-5 * mu_of(&fit));
  assert_near(small.relative_error, fit.relative_error, 1e-9);
  for (int c = 0; c < 3; c++)
    assert_near(small.term[1].strength[c], 1e-6 * fit.term[1].strength[c], 1e-13);
  hl_samples_free(&samples);
}

/* Same bits again; the error is the noise's. */
static void test_deterministic(void **state)
{
  (void)state;
  const truth t = {.model = HL_FIT_TORRANCE_SPARROW,
                   .mu = 60,
                   .kd = {0.3, 0.2, 0.1},
                   .ks = {0.5, 0.1, 2},
                   .noise = 0.05};
  hl_samples samples = ball(&t, 3, false, false);
  const hl_fit one = fit_of(&samples, t.model), two = fit_of(&samples, t.model);
  assert_memory_equal(&one.term, &two.term, sizeof one.term);
  /* mean |noise| is sqrt(2/pi) of its deviation */
  assert_near(one.relative_error, 0.05 * 0.798, 0.003);
  assert_near(mu_of(&one), 60, 1);
  hl_samples_free(&samples);
}

/* ---- where there is no such lobe */

static void test_a_matte_ball(void **state)
{
  (void)state;
  const truth t = {.model = HL_FIT_TORRANCE_SPARROW, .mu = 60, .kd = {0.3}};
  hl_samples samples = ball(&t, 1, false, false);
  double s[3], h[3] = {0, 0, 1};
  hl_unit(toward, s);
  hl_add_scaled(h, 1, s, h);
  hl_unit(h, h);
  for (int i = 0; i < samples.n; i++) /* darker towards the highlight than Lambert */
    samples.value[0][i] = 0.3 * hl_dot(samples.normal + 3 * i, s) *
                          (1 - 0.3 * pow(fmax(0, hl_dot(samples.normal + 3 * i, h)), 4));
  const hl_fit fit = fit_of(&samples, t.model);
  assert_false(fit.trusted);
  assert_int_equal(fit.reasons.n, 1);
  assert_true(fit.term[0].strength[0] > 0.2);
  hl_samples_free(&samples);
}

static void refused(const hl_samples *samples, hl_fit_model model, const double light[3],
                    hl_status want, const char *part)
{
  hl_ctx ctx = {0};
  hl_fit fit = {.n_terms = -7};
  assert_int_equal(hl_fit_parametric(&ctx, samples, model, light, &fit), want);
  assert_says(ctx.msg, part);
  assert_int_equal(fit.n_terms, -7);
}

static void test_refusals(void **state)
{
  (void)state;
  const truth t = {.model = HL_FIT_TORRANCE_SPARROW, .mu = 60, .kd = {0.3}, .ks = {0.5}};
  const double none[3] = {0, 0, 0}, nan[3] = {NAN, 0, 1}, behind[3] = {-1, -1, -1};
  hl_samples samples = ball(&t, 1, false, false);
  refused(&samples, HL_FIT_RIDGE, toward, HL_ERR_ARG, "model 0 is not parametric");
  refused(&samples, t.model, none, HL_ERR_ARG, "light (0, 0, 0); a direction is needed");
  refused(&samples, t.model, nan, HL_ERR_ARG, "light (nan, 0, 1)");
  refused(&samples, t.model, behind, HL_ERR_DEGENERATE, "0 of ");
  const int n = samples.n;
  samples.n = 3;
  refused(&samples, t.model, toward, HL_ERR_DEGENERATE, "3 of 3 samples are lit by light");
  samples.n = 0;
  refused(&samples, t.model, toward, HL_ERR_ARG, "0 samples");
  samples.n = n;
  samples.value[0][7] = NAN;
  refused(&samples, t.model, toward, HL_ERR_ARG, "sample 7: value of channel 0 = nan");
  for (int i = 0; i < n; i++)
    samples.value[0][i] = 0;
  refused(&samples, t.model, toward, HL_ERR_DEGENERATE, "lit samples are black");
  hl_samples_free(&samples);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_what_it_rendered_comes_back),
      cmocka_unit_test(test_it_relights),
      cmocka_unit_test(test_terms),
      cmocka_unit_test(test_slopes_against_differences),
      cmocka_unit_test(test_the_best_of_all_widths),
      cmocka_unit_test(test_scaling_the_radiance),
      cmocka_unit_test(test_deterministic),
      cmocka_unit_test(test_a_matte_ball),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
