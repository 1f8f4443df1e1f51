/* A reflectance asked at a point: its curves between their points, its axes, its factors. */
#include <string.h>

#include "../src/light_rows.h"
#include "halflight/reflectance.h"
#include "halflight/vec3.h"
#include "near.h"

static const double half_pi = 1.5707963267948966;

/* One term, three channels, its curve f(t) times 1, 2, 3 at points of ascending t. */
static hl_reflectance one_term(double (*f)(double), int n, const double *t)
{
  hl_reflectance r = {.channels = 3, .n_terms = 1};
  hl_lobe_term *term = &r.term[0];
  term->cs = term->cv = 1;
  term->n = n;
  for (int i = 0; i < n; i++) {
    term->t[i] = t[i];
    for (int c = 0; c < 3; c++)
      term->value[c][i] = (c + 1) * f(t[i]);
  }
  return r;
}

/* Normal, light and view with n.h = t and n.s = n.v. */
static void at_cosine(double t, double n[3], double s[3], double v[3])
{
  const double a = 0.3;
  const double unturned[3] = {sqrt(1 - t * t), 0, t};
  memcpy(n, unturned, sizeof unturned);
  for (int i = 0; i < 3; i++)
    s[i] = v[i] = 0;
  s[1] = sin(a);
  v[1] = -sin(a);
  s[2] = v[2] = cos(a);
}

static double curve_at(const hl_reflectance *r, double t, int channel)
{
  double n[3], s[3], v[3], out[3];
  at_cosine(t, n, s, v);
  hl_reflectance_at(r, n, s, v, out);
  return out[channel];
}

static double line(double t)
{
  return 0.25 + 2 * t;
}

static double sharp(double t)
{
  return pow(t, 40);
}

static double step(double t)
{
  return t > 0.5 ? 1 : 0.125;
}

static void test_a_line_comes_back(void **state)
{
  (void)state;
  const double t[] = {0.1, 0.15, 0.4, 0.41, 0.8, 1};
  for (int n = 2; n <= 6; n++) {
    const hl_reflectance r = one_term(line, n, t + 6 - n);
    for (int i = 0; i <= 70; i++) {
      const double x = t[6 - n] + (1 - t[6 - n]) * i / 70;
      for (int c = 0; c < 3; c++)
        assert_near(curve_at(&r, x, c), (c + 1) * line(x), 1e-13);
    }
  }
}

static void test_points_come_back(void **state)
{
  (void)state;
  const double t[] = {0.02, 0.1, 0.3, 0.35, 0.6, 0.9, 0.95, 1};
  const hl_reflectance r = one_term(sharp, 8, t);
  for (int i = 0; i < 8; i++)
    assert_near(curve_at(&r, t[i], 1), 2 * sharp(t[i]), 1e-14);
}

/* The points that curves of a lobe are exported at: quadratic in the angle. */
static void lobe_points(double t[HL_CURVE_POINTS])
{
  for (int i = 0; i < HL_CURVE_POINTS; i++) {
    const double share = 1 - (double)i / (HL_CURVE_POINTS - 1);
    t[i] = i == 0 ? 0 : cos(half_pi * share * share);
  }
}

static void test_a_lobe_between_its_points(void **state)
{
  (void)state;
  double t[HL_CURVE_POINTS], most = 0;
  lobe_points(t);
  const hl_reflectance r = one_term(sharp, HL_CURVE_POINTS, t);
  for (int i = 0; i <= 10000; i++)
    most = fmax(most, fabs(curve_at(&r, i / 10000.0, 0) - sharp(i / 10000.0)));
  /* what another monotone cubic (scipy's PCHIP) leaves on these points is 6.7e-6; straight lines leave
   * 4e-4 */
  assert_near(most, 6.7e-6, 1e-7);
}

/* Rising points make a rising curve, without overshoot. */
static void test_between_points_it_rises_as_they_do(void **state)
{
  (void)state;
  const double t[] = {0, 0.2, 0.45, 0.5, 0.55, 0.9, 1};
  const hl_reflectance r = one_term(step, 7, t);
  double before = 0;
  for (int i = 1; i < 1000; i++) {
    const double y = curve_at(&r, i / 1000.0, 0);
    assert_true(y >= before - 1e-15 && y >= 0.125 - 1e-15 && y <= 1 + 1e-15);
    before = y;
  }
}

static void test_beyond_its_points(void **state)
{
  (void)state;
  const double t[] = {0.4, 0.6, 0.8};
  hl_reflectance r = one_term(line, 3, t);
  assert_near(curve_at(&r, 0.9, 0), line(0.8), 1e-15);
  assert_near(curve_at(&r, 0.2, 0), 0.5 * line(0.4), 1e-15); /* to zero at t = 0 */
  const double below[] = {-0.5, 0.5};
  r = one_term(line, 2, below);
  r.term[0].fixed_axis = true;
  r.term[0].axis[0] = 1;
  const double n[3] = {-0.8, 0, 0.6}, v[3] = {0, 0, 1};
  double out[3];
  hl_reflectance_at(&r, n, v, v, out);
  assert_near(out[0], line(-0.5), 1e-15);
}

/* ---- axes and factors */

static double identity(double t)
{
  return t;
}

static void test_axes_follow_light_and_view(void **state)
{
  (void)state;
  const double t[] = {0, 1}, n[3] = {0.36, 0.48, 0.8}, s[3] = {0.8, 0, 0.6}, v[3] = {0, 0.28, 0.96};
  static const double aims[4][2] = {{1, 0}, {0, 1}, {1, 1}, {2, 0.5}};
  hl_reflectance r = one_term(identity, 2, t);
  for (int k = 0; k < 4; k++) {
    double a[3], out[3];
    r.term[0].cs = aims[k][0];
    r.term[0].cv = aims[k][1];
    for (int i = 0; i < 3; i++)
      a[i] = aims[k][0] * s[i] + aims[k][1] * v[i];
    hl_reflectance_at(&r, n, s, v, out);
    assert_near(out[0], hl_dot(n, a) / hl_norm(a), 1e-15);
  }
  r.term[0].fixed_axis = true;
  r.term[0].axis[1] = 1;
  double out[3];
  hl_reflectance_at(&r, n, s, v, out);
  assert_near(out[2], 3 * n[1], 1e-15);
}

/* Foreshortening, shadowing and masking are the light model's own: its rows at one pixel. */
static void test_factors_are_the_light_models(void **state)
{
  (void)state;
  const double t[] = {0, 1};
  test_random random = {4};
  for (int k = 0; k < 200; k++) {
    double n[3], s[3], v[3], out[3], footprint = 1e-9;
    for (int i = 0; i < 3; i++) {
      n[i] = random_normal(&random);
      s[i] = random_normal(&random);
      v[i] = random_normal(&random);
    }
    hl_unit(n, n);
    hl_unit(s, s);
    hl_unit(v, v);
    if (hl_dot(n, s) < 0.001 || hl_dot(n, v) < 0.05)
      continue;
    const hl_light_data data = {.n = 1,
                                .normal = {&n[0], &n[1], &n[2]},
                                .view = {&v[0], &v[1], &v[2]},
                                .footprint = &footprint};
    for (int lobe = HL_LOBE_PLAIN; lobe <= HL_LOBE_FORESHORTENED; lobe++)
      for (int masking = 0; masking < 2; masking++) {
        const hl_light_model model = {
            .lobe = (hl_lobe)lobe, .has_lobe = true, .masking = masking == 1};
        hl_rows rows;
        hl_rows_geometry(&model, &data, 0, 1, s, 1.7, NULL, &rows);
        hl_reflectance r = one_term(identity, 2, t);
        r.term[0].foreshortened = lobe == HL_LOBE_FORESHORTENED;
        r.term[0].masking_exponent = masking ? 1.7 : 0;
        hl_reflectance_at(&r, n, s, v, out);
        const double nh = 1 - rows.u[0] * rows.u[0] / 2;
        assert_near(out[0], fmax(nh, 0) * rows.g[0], 1e-10);
      }
  }
}

static void test_a_body_bends_with_the_view(void **state)
{
  (void)state;
  const double t[] = {0, 1}, n[3] = {0, 0, 1}, s[3] = {0.8, 0, 0.6}, v[3] = {0, 0.6, 0.8};
  hl_reflectance r = one_term(identity, 2, t);
  r.term[0].cv = 0;
  r.term[0].at_cos_view = 0.5;
  r.term[0].view_slope[1] = 0.25;
  double out[3];
  hl_reflectance_at(&r, n, s, v, out);
  assert_near(out[0], 0.6, 1e-15);
  assert_near(out[1], 2 * 0.6 + 0.25 * 0.6 * (0.8 - 0.5), 1e-15);
}

static void test_terms_add_up(void **state)
{
  (void)state;
  const double t[] = {0, 1}, n[3] = {0, 0, 1}, s[3] = {0.8, 0, 0.6}, v[3] = {0, 0.6, 0.8};
  hl_reflectance r = one_term(identity, 2, t);
  r.term[1] = r.term[0];
  r.term[0].cv = 0;
  r.term[1].foreshortened = true;
  r.n_terms = 2;
  double h[3], out[3];
  hl_add_scaled(s, 1, v, h);
  hl_unit(h, h);
  hl_reflectance_at(&r, n, s, v, out);
  assert_near(out[0], 0.6 + h[2] / 0.8, 1e-15);
  r.log_domain = true;
  hl_reflectance_at(&r, n, s, v, out);
  assert_near(out[0], exp(0.6 + h[2]) / 0.8, 1e-14);
  r.channels = 1;
  hl_reflectance_at(&r, n, s, v, out);
  assert_near(out[1], out[0], 0);
  assert_near(out[2], out[0], 0);
}

static void test_dark_where_unlit_or_unseen(void **state)
{
  (void)state;
  const double t[] = {0, 1}, n[3] = {0, 0, 1}, below[3] = {0.6, 0, -0.8}, edge[3] = {1, 0, 0};
  hl_reflectance r = one_term(line, 2, t);
  r.term[0].foreshortened = true;
  double out[3];
  for (int k = 0; k < 4; k++) {
    const double *away = k % 2 ? below : edge;
    r.log_domain = k > 1;
    hl_reflectance_at(&r, n, away, n, out);
    assert_near(out[0], 0, 0);
    hl_reflectance_at(&r, n, n, away, out);
    assert_near(out[2], 0, 0);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_a_line_comes_back),
      cmocka_unit_test(test_points_come_back),
      cmocka_unit_test(test_a_lobe_between_its_points),
      cmocka_unit_test(test_between_points_it_rises_as_they_do),
      cmocka_unit_test(test_beyond_its_points),
      cmocka_unit_test(test_axes_follow_light_and_view),
      cmocka_unit_test(test_factors_are_the_light_models),
      cmocka_unit_test(test_a_body_bends_with_the_view),
      cmocka_unit_test(test_terms_add_up),
      cmocka_unit_test(test_dark_where_unlit_or_unseen),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
