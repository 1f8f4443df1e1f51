/* Fitted reflectances as BRDF tables: what is reciprocal comes back as it was, what is not as the
 * nearest that is; under the fit's light and others. */
#include <stdio.h>
#include <string.h>

#include "files.h"
#include "halflight/brdf.h"
#include "halflight/merl_ball.h"
#include "merl_scene.h"

#define PI 3.14159265358979323846

/* Body k_c (n.s) and a lobe exp(-(angle/width)^2), three channels, fitted under (1,1,1) from (0,0,1).
 * Points quadratic in the angle, as fits write them. */
static hl_reflectance glossy(bool foreshortened, double width)
{
  hl_reflectance r = {.channels = 3, .has_light = true, .n_terms = 2};
  static const double light[3] = {1, 1, 1};
  hl_unit(light, r.light);
  r.view[2] = 1;
  for (int k = 0; k < 2; k++) {
    hl_lobe_term *term = &r.term[k];
    snprintf(term->name, sizeof term->name, "%s", k ? "h" : "s");
    term->cs = 1;
    term->cv = k;
    term->foreshortened = k && foreshortened;
    term->n = HL_CURVE_POINTS;
    for (int i = 0; i < term->n; i++) {
      const double share = 1 - (double)i / (term->n - 1), angle = PI / 2 * share * share;
      term->t[i] = i == 0 ? 0 : cos(angle);
      for (int c = 0; c < 3; c++)
        term->value[c][i] =
            k ? 0.4 * exp(-angle * angle / (width * width)) : 0.1 * (c + 1) * term->t[i];
    }
  }
  return r;
}

static hl_merl table_from(const hl_reflectance *r, const hl_brdf_settings *settings,
                          hl_brdf_summary *summary)
{
  hl_ctx ctx = {0};
  hl_merl merl = {0};
  if (hl_brdf_table(&ctx, r, settings, &merl, summary) != HL_OK)
    fail_msg("%s", ctx.msg);
  return merl;
}

/* ---- the BRDF itself */

static void test_reciprocal_forms_stay(void **state)
{
  (void)state;
  hl_reflectance r = glossy(true, 0.3);
  test_random random = {2};
  r.term[1].masking_exponent = 0.8;
  for (int k = 0; k < 500; k++) {
    double n[3], s[3], v[3], radiance[3], rho[3], back[3];
    random_scene(&random, 0.02, n, s, v);
    hl_reflectance_at(&r, n, s, v, radiance);
    hl_brdf_at(&r, n, s, v, rho);
    hl_brdf_at(&r, n, v, s, back);
    for (int c = 0; c < 3; c++) {
      assert_near(rho[c] * hl_dot(n, s), radiance[c], 1e-12 * radiance[c]);
      assert_near(back[c], rho[c], 1e-12 * rho[c]);
    }
  }
}

/* Of all values for both directions, the one whose radiances are nearest to the two that were fitted. */
static void test_others_become_the_nearest_reciprocal(void **state)
{
  (void)state;
  hl_reflectance r = glossy(false, 0.5);
  test_random random = {2};
  r.term[1].cv = 0.4;
  r.term[0].view_slope[0] = 0.1;
  r.term[0].at_cos_view = 0.5;
  for (int k = 0; k < 500; k++) {
    double n[3], s[3], v[3], there[3], back[3], rho[3], same[3];
    random_scene(&random, 0.02, n, s, v);
    const double ns = hl_dot(n, s), nv = hl_dot(n, v);
    hl_reflectance_at(&r, n, s, v, there);
    hl_reflectance_at(&r, n, v, s, back);
    hl_brdf_at(&r, n, s, v, rho);
    hl_brdf_at(&r, n, v, s, same);
    for (int c = 0; c < 3; c++) {
      assert_near(same[c], rho[c], 1e-12 * rho[c]);
      const double least = pow(rho[c] * ns - there[c], 2) + pow(rho[c] * nv - back[c], 2);
      for (int side = -1; side <= 1; side += 2) {
        const double other = rho[c] * (1 + 0.01 * side);
        assert_true(pow(other * ns - there[c], 2) + pow(other * nv - back[c], 2) > least);
      }
    }
  }
}

static void test_below_the_horizon(void **state)
{
  (void)state;
  const hl_reflectance r = glossy(true, 0.3);
  const double n[3] = {0, 0, 1}, below[3] = {0.6, 0, -0.8}, edge[3] = {1, 0, 0};
  double rho[3] = {7, 7, 7};
  hl_brdf_at(&r, n, below, n, rho);
  assert_near(rho[0], 0, 0);
  hl_brdf_at(&r, n, n, edge, rho);
  assert_near(rho[2], 0, 0);
}

/* ---- its table */

/* Mean error of a ball drawn from the table against the reflectance, of its mean radiance. */
static double drawn_error(const hl_merl *merl, const hl_reflectance *r, const double light[3],
                          bool reciprocal)
{
  hl_merl_ball ball;
  const double v[3] = {0, 0, 1};
  double s[3], difference = 0, sum = 0;
  hl_unit(light, s);
  assert_int_equal(hl_merl_ball_from_afar(NULL, merl, 40, light, NULL, &ball), HL_OK);
  for (int i = 0; i < ball.samples.n; i++) {
    const double *n = ball.samples.normal + 3 * i;
    double want[3];
    if (reciprocal)
      hl_reflectance_at(r, n, s, v, want);
    else
      hl_brdf_at(r, n, s, v, want);
    for (int c = 0; c < 3; c++) {
      const double radiance = want[c] * (reciprocal ? 1 : hl_dot(n, s));
      difference += fabs(ball.samples.value[c][i] - radiance);
      sum += radiance;
    }
  }
  hl_merl_ball_free(&ball);
  return difference / sum;
}

static const double lights[4][3] = {{1, 1, 1}, {-1, 1, 1}, {0.2, -0.1, 1}, {10, 4, 1}};

/* The fit, its table, read back and drawn under the fit's light and others: within the table's
 * resolution. */
static void test_there_and_back(void **state)
{
  /* ours, rounded up; a lobe of 3 degrees is as wide as few cells */
  static const double widths[3] = {0.5, 0.15, 0.05}, limits[3] = {3e-4, 4e-4, 1e-3};
  char path[TEST_PATH_MAX];
  path_in(state, "t.binary", path);
  for (int k = 0; k < 3; k++) {
    const hl_reflectance r = glossy(true, widths[k]);
    hl_brdf_summary summary;
    hl_merl merl = table_from(&r, NULL, &summary), back = {0};
    assert_near(summary.asymmetry, 0, 1e-12);
    assert_near(summary.irradiance, 1, 0);
    assert_near(hl_merl_measured(&merl), 1, 0);
    assert_int_equal(hl_merl_write(NULL, path, &merl), HL_OK);
    hl_merl_free(&merl);
    assert_int_equal(hl_merl_read(NULL, path, &back), HL_OK);
    for (int i = 0; i < 4; i++)
      assert_near(drawn_error(&back, &r, lights[i], true), 0, limits[k]);
    hl_merl_free(&back);
  }
  unlink(path);
}

/* What is not reciprocal: the table is its nearest reciprocal BRDF, and the summary says how far that
 * is from the fit. */
static void test_a_plain_lobe(void **state)
{
  (void)state;
  const hl_reflectance r = glossy(false, 0.3);
  hl_brdf_summary summary;
  hl_merl merl = table_from(&r, NULL, &summary);
  for (int i = 0; i < 4; i++)
    assert_near(drawn_error(&merl, &r, lights[i], false), 0, 1e-3); /* ours, rounded up */
  const double off = drawn_error(&merl, &r, lights[0], true);
  assert_near(summary.asymmetry, off, 0.1 * off);
  assert_true(off > 0.01);
  assert_string_equal(summary.notes.note[0].what, "not reciprocal");
  hl_merl_free(&merl);
}

/* Every cell is filled, below the horizon too: readers that take the nearest find no holes. */
static void test_every_cell_is_filled(void **state)
{
  (void)state;
  const hl_reflectance r = glossy(true, 0.3);
  hl_merl merl = table_from(&r, NULL, NULL);
  for (size_t i = 0; i < 3 * (size_t)HL_MERL_CELLS; i++)
    if (!(merl.value[i] >= 0 && isfinite(merl.value[i])))
      fail_msg("cell %zu holds %g", i, merl.value[i]);
  hl_merl_free(&merl);
}

static void test_scale(void **state)
{
  (void)state;
  hl_reflectance r = glossy(true, 0.3);
  hl_brdf_settings settings = hl_brdf_defaults();
  hl_brdf_summary summary;
  const size_t cell = hl_merl_cell(30, 20, 50);
  r.n_terms = 1;
  hl_merl merl = table_from(&r, NULL, &summary);
  /* Lambert: albedo pi k */
  for (int c = 0; c < 3; c++) {
    assert_near(summary.albedo[c], PI * 0.1 * (c + 1), 1e-6);
    assert_near(merl.value[(size_t)c * HL_MERL_CELLS + cell] * hl_merl_scale(c), 0.1 * (c + 1),
                1e-14);
  }
  hl_merl_free(&merl);
  settings.irradiance = 4;
  merl = table_from(&r, &settings, &summary);
  assert_near(summary.irradiance, 4, 0);
  assert_near(summary.albedo[1], PI * 0.05, 1e-6);
  assert_near(merl.value[cell] * hl_merl_scale(0), 0.025, 1e-14);
  hl_merl_free(&merl);
  settings.albedo = 0.6;
  merl = table_from(&r, &settings, &summary);
  assert_near(summary.albedo[2], 0.6, 1e-12);
  assert_near(summary.albedo[0], 0.2, 1e-12);
  assert_near(summary.irradiance, PI * 0.3 / 0.6, 1e-5);
  assert_near(merl.value[cell] * hl_merl_scale(0), 0.2 / PI, 1e-6);
  hl_merl_free(&merl);
}

/* Analytic: 2 pi int (k + g(theta/2) / cos theta) cos theta sin theta dtheta, by another rule. */
static void test_albedo_of_a_lobe(void **state)
{
  (void)state;
  const hl_reflectance r = glossy(true, 0.2);
  hl_brdf_summary summary;
  hl_merl merl = table_from(&r, NULL, &summary);
  double lobe = 0;
  enum { STEPS = 20000 };
  for (int i = 0; i < STEPS; i++) {
    const double theta = (i + 0.5) * PI / 2 / STEPS;
    lobe += 2 * PI * 0.4 * exp(-theta * theta / 4 / 0.04) * sin(theta) * PI / 2 / STEPS;
  }
  assert_near(summary.albedo[0], PI * 0.1 + lobe, 1e-4);
  hl_merl_free(&merl);
}

static void test_what_is_noted(void **state)
{
  (void)state;
  hl_reflectance r = glossy(true, 0.3);
  hl_brdf_summary summary;
  for (int i = 0; i < HL_CURVE_POINTS; i++) {
    r.term[0].value[0][i] *= 10;
    r.term[1].value[1][i] = -1;
  }
  hl_merl merl = table_from(&r, NULL, &summary);
  assert_int_equal(summary.notes.n, 2);
  assert_string_equal(summary.notes.note[0].what, "below 0");
  assert_string_equal(summary.notes.note[1].what, "albedo above 1");
  assert_near(merl.value[HL_MERL_CELLS], 0, 0);
  hl_merl_free(&merl);
}

static void refused(const hl_reflectance *r, const hl_brdf_settings *settings, hl_status want,
                    const char *part)
{
  hl_ctx ctx = {0};
  hl_merl merl = {0};
  assert_int_equal(hl_brdf_table(&ctx, r, settings, &merl, NULL), want);
  assert_says(ctx.msg, part);
  assert_null(merl.value);
}

static void test_refusals(void **state)
{
  (void)state;
  hl_reflectance r = glossy(true, 0.3);
  hl_brdf_settings settings = hl_brdf_defaults();
  settings.irradiance = 0;
  refused(&r, &settings, HL_ERR_ARG, "irradiance = 0");
  settings.irradiance = NAN;
  refused(&r, &settings, HL_ERR_ARG, "irradiance = nan");
  settings = hl_brdf_defaults();
  settings.albedo = 1.5;
  refused(&r, &settings, HL_ERR_ARG, "albedo = 1.5");
  settings.albedo = 0.5;
  memset(r.term[0].value, 0, sizeof r.term[0].value);
  memset(r.term[1].value, 0, sizeof r.term[1].value);
  refused(&r, &settings, HL_ERR_ARG, "albedo = 0.5 for a reflectance whose own is 0");
  r.term[1].fixed_axis = true;
  refused(&r, NULL, HL_ERR_DEGENERATE, "the axis of 'h' is not known in terms of light and view");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_reciprocal_forms_stay),
      cmocka_unit_test(test_others_become_the_nearest_reciprocal),
      cmocka_unit_test(test_below_the_horizon),
      cmocka_unit_test(test_there_and_back),
      cmocka_unit_test(test_a_plain_lobe),
      cmocka_unit_test(test_every_cell_is_filled),
      cmocka_unit_test(test_scale),
      cmocka_unit_test(test_albedo_of_a_lobe),
      cmocka_unit_test(test_what_is_noted),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
