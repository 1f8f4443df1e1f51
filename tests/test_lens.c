/* Lens models: closed forms, derivatives, the inverse, and where there is none. */
#include "../calib/lens.h"
#include "halflight/lens_names.h"
#include "near.h"

/* A mild, a wide, a pincushion and a decentred lens. */
static const double lenses[][5] = {
    {0, 0, 0, 0, 0},
    {-0.25, 0.08, 0.001, -0.0008, 0},
    {0.12, -0.03, 0, 0, 0.01},
    {-0.1, 0.02, 0.02, 0.015, -0.002},
};

enum { N_LENSES = sizeof lenses / sizeof lenses[0] };

static const hl_lens *pinhole(void)
{
  return hl_lens_of(HL_LENS_PINHOLE);
}

static void test_table_knows_its_models(void **state)
{
  (void)state;
  assert_non_null(pinhole());
  assert_string_equal(hl_lens_name(HL_LENS_PINHOLE), "pinhole");
  assert_int_equal(hl_lens_coefficients(HL_LENS_PINHOLE), 5);
  assert_null(hl_lens_of((hl_lens_model)77));
  assert_null(hl_lens_name(77));
  assert_null(hl_lens_name(-1));
  assert_int_equal(hl_lens_coefficients(77), 0);
}

/* Analytic: on the x axis u = x (1 + k1 x^2 + k2 x^4 + k3 x^6) + 3 p2 x^2, v = p1 x^2. */
static void test_distort_on_an_axis(void **state)
{
  (void)state;
  const double k[5] = {0.1, 0.2, 0.03, 0.04, 0.5};
  const double at[2] = {0.5, 0};
  double out[2], j[2][2];
  pinhole()->distort(k, at, out, j);
  assert_near(out[0], 0.5 * (1 + 0.1 * 0.25 + 0.2 * 0.0625 + 0.5 * 0.015625) + 3 * 0.04 * 0.25,
              1e-15);
  assert_near(out[1], 0.03 * 0.25, 1e-15);
}

static void test_distort_without_distortion_is_the_identity(void **state)
{
  (void)state;
  const double at[2] = {0.3, -0.7};
  double out[2], j[2][2];
  pinhole()->distort(lenses[0], at, out, j);
  assert_near(out[0], 0.3, 0);
  assert_near(out[1], -0.7, 0);
  assert_near(j[0][0], 1, 0);
  assert_near(j[0][1], 0, 0);
  assert_near(j[1][0], 0, 0);
  assert_near(j[1][1], 1, 0);
}

/* Central differences: error of second order in the step. */
static void test_jacobian_against_differences(void **state)
{
  (void)state;
  const double step = 1e-5;
  test_random r = {7};
  for (int l = 0; l < N_LENSES; l++)
    for (int i = 0; i < 50; i++) {
      const double at[2] = {random_between(&r, -0.8, 0.8), random_between(&r, -0.8, 0.8)};
      double out[2], j[2][2], ignored[2][2];
      pinhole()->distort(lenses[l], at, out, j);
      for (int k = 0; k < 2; k++) {
        double low[2] = {at[0], at[1]}, high[2] = {at[0], at[1]}, a[2], b[2];
        low[k] -= step;
        high[k] += step;
        pinhole()->distort(lenses[l], low, a, ignored);
        pinhole()->distort(lenses[l], high, b, ignored);
        assert_near(j[0][k], (b[0] - a[0]) / (2 * step), 1e-8);
        assert_near(j[1][k], (b[1] - a[1]) / (2 * step), 1e-8);
      }
    }
}

/* All these lenses are one to one within |(x, y)| <= 0.7. */
static void test_undistort_inverts_distort(void **state)
{
  (void)state;
  test_random r = {11};
  for (int l = 0; l < N_LENSES; l++)
    for (int i = 0; i < 200; i++) {
      const double at[2] = {random_between(&r, -0.49, 0.49), random_between(&r, -0.49, 0.49)};
      double image[2], back[2], j[2][2];
      pinhole()->distort(lenses[l], at, image, j);
      assert_true(hl_lens_undistort(pinhole(), lenses[l], image, back));
      assert_near(back[0], at[0], 2e-14);
      assert_near(back[1], at[1], 2e-14);
    }
}

/* A radial lens has no preferred azimuth. */
static void test_undistort_turns_with_the_image(void **state)
{
  (void)state;
  const double k[5] = {-0.2, 0.05, 0, 0, 0.01};
  double along_x[2], turned[2];
  const double c = cos(0.7), s = sin(0.7);
  assert_true(hl_lens_undistort(pinhole(), k, (const double[2]){0.4, 0}, along_x));
  assert_true(hl_lens_undistort(pinhole(), k, (const double[2]){0.4 * c, 0.4 * s}, turned));
  assert_near(turned[0], c * along_x[0], 1e-14);
  assert_near(turned[1], s * along_x[0], 1e-14);
}

/* x - x^3/3 has its maximum 2/3 at x = 1: nothing is seen beyond, and what is seen before is the
 * root on the near side (x^3 - 3x + 3u = 0; for u = 0.6 near 0.7401). */
static void test_undistort_stays_before_the_fold(void **state)
{
  (void)state;
  const double k[5] = {-1.0 / 3, 0, 0, 0, 0};
  double out[2] = {-7, -7};
  assert_true(hl_lens_undistort(pinhole(), k, (const double[2]){0.6, 0}, out));
  assert_near(out[0] - out[0] * out[0] * out[0] / 3, 0.6, 1e-15);
  assert_true(out[0] < 1);
  out[0] = -7;
  assert_false(hl_lens_undistort(pinhole(), k, (const double[2]){0.67, 0}, out));
  assert_false(hl_lens_undistort(pinhole(), k, (const double[2]){50, 0}, out));
  assert_near(out[0], -7, 0);
}

static void test_undistort_refuses_what_is_no_number(void **state)
{
  (void)state;
  double out[2] = {-7, -7};
  assert_false(hl_lens_undistort(pinhole(), lenses[1], (const double[2]){NAN, 0}, out));
  assert_false(hl_lens_undistort(pinhole(), lenses[1], (const double[2]){INFINITY, 0}, out));
  const double k[5] = {NAN, 0, 0, 0, 0};
  assert_false(hl_lens_undistort(pinhole(), k, (const double[2]){0.1, 0}, out));
  assert_near(out[0], -7, 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_table_knows_its_models),
      cmocka_unit_test(test_distort_on_an_axis),
      cmocka_unit_test(test_distort_without_distortion_is_the_identity),
      cmocka_unit_test(test_jacobian_against_differences),
      cmocka_unit_test(test_undistort_inverts_distort),
      cmocka_unit_test(test_undistort_turns_with_the_image),
      cmocka_unit_test(test_undistort_stays_before_the_fold),
      cmocka_unit_test(test_undistort_refuses_what_is_no_number),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
