/* The profile across a short piece of a ball's rim. */
#include "../calib/sphere_rim.h"

#include <string.h>

#include "near.h"

static const double reach = 3.5;

/* A profile of the model's own form: dark shade outside, sqrt(depth) inside. */
static double profile(double t, double s)
{
  return t > 0 ? 0.3 + 0.02 * s + 0.2 * sqrt(t) - 0.01 * t : 0.1 + 0.01 * s + 0.02 * t / reach;
}

/* Pixels about a straight rim of the given slope, each the mean of 200 x 200 points. */
static void fill(double angle, double shift, hl_rim_pixels *px)
{
  const double gx = cos(angle), gy = sin(angle);
  enum { FINE = 200 };
  px->n = 0;
  for (int y = -4; y <= 4; y++)
    for (int x = -4; x <= 4; x++) {
      const double t = x * gx + y * gy, s = (y * gx - x * gy) / 4;
      if (!(fabs(t) <= reach) || !(fabs(s) <= 1))
        continue;
      double sum = 0;
      for (int k = 0; k < FINE * FINE; k++) {
        const double ox = (k % FINE + 0.5) / FINE - 0.5,
                     oy = ((double)(k / FINE) + 0.5) / FINE - 0.5;
        sum += profile(t + shift + ox * gx + oy * gy, s);
      }
      px->t[px->n] = t;
      px->s[px->n] = s;
      px->a[px->n] = fmax(fabs(gx), 0.05);
      px->b[px->n] = fmax(fabs(gy), 0.05);
      px->value[px->n++] = sum / (FINE * FINE);
    }
}

static void test_pixel_averages_match_fine_sampling(void **state)
{
  (void)state;
  static const double angles[] = {0.02, 0.4, 0.785, 1.3, 2.4};
  static hl_rim_pixels px;
  for (int i = 0; i < 5; i++) {
    hl_rim_fit f;
    fill(angles[i], 0.3, &px);
    hl_rim_solve(&px, 0.3, reach, &f);
    assert_true(px.n > 40);
    /* numerical: the mean of 40 000 points of a step is good to some 1e-3 of it in a few pixels */
    assert_near(f.ssr / px.n, 0, 1e-6);
    assert_near(f.c[0], 0.1, 5e-3);
    assert_near(f.c[3], 0.3, 1e-2);
    assert_near(f.c[5], 0.2, 2e-2);
  }
}

static void test_least_residual_is_at_the_rim(void **state)
{
  (void)state;
  static hl_rim_pixels px;
  hl_rim_fit f, off;
  fill(0.5, 0, &px);
  hl_rim_solve(&px, 0, reach, &f);
  for (int i = 1; i <= 5; i++) {
    hl_rim_solve(&px, 0.1 * i, reach, &off);
    assert_true(off.ssr > f.ssr);
    hl_rim_solve(&px, -0.1 * i, reach, &off);
    assert_true(off.ssr > f.ssr);
  }
}

static void test_slope_matches_finite_differences(void **state)
{
  (void)state;
  static hl_rim_pixels px;
  fill(0.5, 0, &px);
  static const double offsets[] = {-0.4, -0.1, 0.15, 0.3};
  for (int i = 0; i < 4; i++) {
    const double h = 1e-5;
    double information, pull;
    hl_rim_fit f, up, down;
    hl_rim_solve(&px, offsets[i], reach, &f);
    hl_rim_slope(&px, &f, reach, &information, &pull);
    hl_rim_solve(&px, offsets[i] + h, reach, &up);
    hl_rim_solve(&px, offsets[i] - h, reach, &down);
    /* d ssr / d offset = -2 pull: exact for variable projection */
    assert_near((up.ssr - down.ssr) / (2 * h), -2 * pull, 1e-4 * fabs(2 * pull) + 1e-9);
    assert_true(information > 0);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_pixel_averages_match_fine_sampling),
      cmocka_unit_test(test_least_residual_is_at_the_rim),
      cmocka_unit_test(test_slope_matches_finite_differences),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
