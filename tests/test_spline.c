/* B-splines as piecewise polynomials, against the recursion they come from. */
#include <string.h>

#include "../src/spline.h"
#include "near.h"

/* Uneven on purpose: many breaks in one of the table's bins, and a long last interval. */
static const double uneven[] = {0, 1e-5, 3e-5, 1e-4, 0.01, 0.011, 0.2, 0.5, 1.4};
enum { UNEVEN = sizeof uneven / sizeof *uneven };

/* Knot k of the clamped knot row: end breaks four times. */
static double knot(const double *breaks, int n, int k)
{
  const int i = k - 3;
  return breaks[i < 0 ? 0 : i > n - 1 ? n - 1 : i];
}

/* Cox and de Boor's recursion as books print it; half-open intervals, the last one closed. */
static double recursion(const double *breaks, int n, int i, int degree, double u)
{
  const double t0 = knot(breaks, n, i), t1 = knot(breaks, n, i + 1);
  if (degree == 0)
    return t0 < t1 && ((t0 <= u && u < t1) || (u >= t1 && t1 == breaks[n - 1]));
  const double rise = knot(breaks, n, i + degree) - t0;
  const double fall = knot(breaks, n, i + degree + 1) - t1;
  double sum = 0;
  if (rise > 0)
    sum += (u - t0) / rise * recursion(breaks, n, i, degree - 1, u);
  if (fall > 0)
    sum +=
        (knot(breaks, n, i + degree + 1) - u) / fall * recursion(breaks, n, i + 1, degree - 1, u);
  return sum;
}

static hl_spline spline_of(const double *breaks, int n)
{
  hl_spline s;
  memset(&s, 0xff, sizeof s);
  hl_spline_init(&s, breaks, n);
  return s;
}

static void test_shape_follows_the_breaks(void **state)
{
  (void)state;
  const hl_spline s = spline_of(uneven, UNEVEN);
  assert_int_equal(s.n, UNEVEN + 2);
  assert_int_equal(s.intervals, UNEVEN - 1);
  assert_near(s.low, 0, 0);
  assert_near(s.high, 1.4, 0);
}

static void values_match(const double *breaks, int n)
{
  const hl_spline s = spline_of(breaks, n);
  for (int i = 0; i + 1 < n; i++)
    for (int j = 0; j <= 8; j++) {
      const double u = breaks[i] + (breaks[i + 1] - breaks[i]) * j / 8.0;
      double value[4];
      const int at = hl_spline_values(&s, u, value);
      for (int f = 0; f < s.n; f++) {
        const double got = f >= at && f < at + 4 ? value[f - at] : 0;
        assert_near(got, recursion(breaks, n, f, 3, u), 1e-13);
      }
    }
}

static void test_values_match_the_recursion(void **state)
{
  (void)state;
  double even[HL_SPLINE_MAX - 2];
  const double one[2] = {-1, 2.5};
  for (int i = 0; i < HL_SPLINE_MAX - 2; i++)
    even[i] = 0.1 * i;
  values_match(uneven, UNEVEN);
  values_match(even, HL_SPLINE_MAX - 2);
  values_match(even, 3);
  values_match(one, 2);
}

static void test_interval_is_the_one_that_holds_the_point(void **state)
{
  (void)state;
  const hl_spline s = spline_of(uneven, UNEVEN);
  for (int i = 0; i + 1 < UNEVEN; i++) {
    assert_int_equal(hl_spline_interval(&s, uneven[i]), i);
    assert_int_equal(hl_spline_interval(&s, nextafter(uneven[i + 1], 0)), i);
  }
  assert_int_equal(hl_spline_interval(&s, 1.4), UNEVEN - 2);
}

/* Outside the domain the end intervals' polynomials go on; NaN must not reach past the table. */
static void test_outside_is_the_end_interval(void **state)
{
  (void)state;
  const hl_spline s = spline_of(uneven, UNEVEN);
  assert_int_equal(hl_spline_interval(&s, -3), 0);
  assert_int_equal(hl_spline_interval(&s, 1e9), UNEVEN - 2);
  assert_int_equal(hl_spline_interval(&s, HUGE_VAL), UNEVEN - 2);
  const int at = hl_spline_interval(&s, NAN);
  assert_true(at >= 0 && at < s.intervals);
}

static void test_functions_sum_to_one_and_are_not_negative(void **state)
{
  (void)state;
  const hl_spline s = spline_of(uneven, UNEVEN);
  for (int i = 0; i <= 5000; i++) {
    double value[4], slope[4];
    const double u = 1.4 * i / 5000;
    const int at = hl_spline_values(&s, u, value);
    hl_spline_slopes(&s, at, u, slope);
    for (int k = 0; k < 4; k++)
      assert_true(value[k] >= -1e-15);
    assert_near(value[0] + value[1] + value[2] + value[3], 1, 1e-13);
    assert_near((slope[0] + slope[1] + slope[2] + slope[3]) * 1e-5, 0, 1e-13);
  }
}

/* Marsden: coefficients (t1 t2 t3 of the inner knots) give u, and their products u^3. */
static void test_polynomials_are_reproduced(void **state)
{
  (void)state;
  const hl_spline s = spline_of(uneven, UNEVEN);
  for (int i = 0; i <= 300; i++) {
    const double u = 1.4 * i / 300;
    double value[4], slope[4], line = 0, cube = 0, line_slope = 0, cube_slope = 0;
    const int at = hl_spline_values(&s, u, value);
    hl_spline_slopes(&s, at, u, slope);
    for (int k = 0; k < 4; k++) {
      const double a = knot(uneven, UNEVEN, at + k + 1), b = knot(uneven, UNEVEN, at + k + 2),
                   c = knot(uneven, UNEVEN, at + k + 3);
      line += value[k] * (a + b + c) / 3;
      cube += value[k] * a * b * c;
      line_slope += slope[k] * (a + b + c) / 3;
      cube_slope += slope[k] * a * b * c;
    }
    assert_near(line, u, 1e-13);
    assert_near(cube, u * u * u, 1e-13);
    assert_near(line_slope, 1, 1e-10);
    assert_near(cube_slope, 3 * u * u, 1e-10);
  }
}

static void test_slopes_match_differences(void **state)
{
  (void)state;
  double even[20];
  for (int i = 0; i < 20; i++)
    even[i] = 0.07 * i;
  const hl_spline s = spline_of(even, 20);
  const double step = 1e-5;
  for (int i = 0; i < 19; i++)
    for (int j = 1; j < 8; j++) {
      const double u = even[i] + 0.07 * j / 8;
      double slope[4], low[4], high[4];
      const int at = hl_spline_values(&s, u - step, low);
      assert_int_equal(hl_spline_values(&s, u + step, high), at);
      hl_spline_slopes(&s, at, u, slope);
      for (int k = 0; k < 4; k++)
        assert_near(slope[k], (high[k] - low[k]) / (2 * step), 1e-5);
    }
}

/* Value, slope and bend agree from both sides of a break. */
static void test_smooth_across_breaks(void **state)
{
  (void)state;
  double even[12];
  for (int i = 0; i < 12; i++)
    even[i] = 0.1 * i * (1 + 0.05 * i);
  const hl_spline s = spline_of(even, 12);
  for (int i = 1; i < 11; i++) {
    const double x = even[i] - even[i - 1];
    for (int f = i - 1; f < i + 4; f++) {
      double left[3] = {0}, right[3] = {0};
      if (f < i + 3) {
        const double(*p)[4] = s.poly[i - 1];
        const int k = f - i + 1;
        left[0] = p[0][k] + x * (p[1][k] + x * (p[2][k] + x * p[3][k]));
        left[1] = p[1][k] + x * (2 * p[2][k] + 3 * x * p[3][k]);
        left[2] = 2 * p[2][k] + 6 * x * p[3][k];
      }
      if (f >= i)
        for (int d = 0; d < 3; d++)
          right[d] = (d == 2 ? 2 : 1) * s.poly[i][d][f - i];
      for (int d = 0; d < 3; d++)
        assert_near(left[d], right[d], 1e-9);
    }
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_shape_follows_the_breaks),
      cmocka_unit_test(test_values_match_the_recursion),
      cmocka_unit_test(test_interval_is_the_one_that_holds_the_point),
      cmocka_unit_test(test_outside_is_the_end_interval),
      cmocka_unit_test(test_functions_sum_to_one_and_are_not_negative),
      cmocka_unit_test(test_polynomials_are_reproduced),
      cmocka_unit_test(test_slopes_match_differences),
      cmocka_unit_test(test_smooth_across_breaks),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
