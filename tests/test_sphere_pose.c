/* The pose of a ball from rays that graze it. */
#include "../calib/sphere_pose.h"

#include <stdlib.h>
#include <string.h>

#include "ball_scene.h"
#include "near.h"

static const double radius_m = 0.025;

/* n rays that graze the ball about c, from azimuth `from` over `arc` rad, each off by noise. */
static void grazing(const double c[3], int n, double from, double arc, double noise_rad,
                    uint64_t seed, double *rays)
{
  double axis[3], e1[3], e2[3];
  hl_unit(c, axis);
  hl_tangent_basis(axis, e1, e2);
  const double half = asin(radius_m / hl_norm(c));
  test_random random = scene_random(seed);
  for (int i = 0; i < n; i++) {
    const double a = from + arc * i / n;
    const double t = half + (noise_rad > 0 ? noise_rad * random_normal(&random) : 0);
    for (int k = 0; k < 3; k++)
      rays[3 * i + k] = cos(t) * axis[k] + sin(t) * (cos(a) * e1[k] + sin(a) * e2[k]);
  }
}

static void test_exact_rays(void **state)
{
  (void)state;
  /* analytic: centres near and far, on and off the axis, and short arcs */
  static const double centers[][3] = {
      {0, 0, 0.4}, {0.1, -0.05, 0.5}, {-0.3, 0.2, 0.4}, {0.2, 0, 20}};
  static const double arcs[] = {6.283185307179586, 2.5};
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 2; j++) {
      double rays[3 * 40], rms;
      hl_sphere s;
      grazing(centers[i], 40, 0.3, arcs[j], 0, 0, rays);
      assert_int_equal(hl_sphere_from_rays(NULL, rays, 40, radius_m, 0, &s, &rms), HL_OK);
      const double d = hl_norm(centers[i]);
      for (int k = 0; k < 3; k++) /* rounding of a ray, 1e-16 rad, over the half-angle, squared */
        assert_near(s.center_m[k], centers[i][k], 1e-13 * d * (d / radius_m) * (d / radius_m));
      assert_near(s.radius_m, radius_m, 0);
      assert_near(rms, 0, 1e-12);
    }
}

static void test_three_rays_are_enough(void **state)
{
  (void)state;
  const double c[3] = {0.02, 0.01, 0.5};
  double rays[9];
  hl_sphere s;
  grazing(c, 3, 0, 6.283185307179586, 0, 0, rays);
  assert_int_equal(hl_sphere_from_rays(NULL, rays, 3, radius_m, 0, &s, NULL), HL_OK);
  for (int k = 0; k < 3; k++)
    assert_near(s.center_m[k], c[k], 1e-9);
  assert_false(s.has_covariance);
}

static void test_order_of_rays_does_not_matter(void **state)
{
  (void)state;
  const double c[3] = {0.02, 0.01, 0.5};
  double rays[3 * 30], turned[3 * 30];
  hl_sphere a, b;
  grazing(c, 30, 0, 6.283185307179586, 1e-4, 3, rays);
  for (int i = 0; i < 30; i++)
    memcpy(turned + 3 * i, rays + 3 * (29 - i), 3 * sizeof *rays);
  assert_int_equal(hl_sphere_from_rays(NULL, rays, 30, radius_m, 0, &a, NULL), HL_OK);
  assert_int_equal(hl_sphere_from_rays(NULL, turned, 30, radius_m, 0, &b, NULL), HL_OK);
  for (int k = 0; k < 3; k++)
    assert_near(a.center_m[k], b.center_m[k], 1e-9);
}

static void test_outliers_are_set_aside(void **state)
{
  (void)state;
  const double c[3] = {0.02, 0.01, 0.5};
  double rays[3 * 60], axis[3];
  hl_sphere s;
  grazing(c, 60, 0, 6.283185307179586, 1e-5, 5, rays);
  hl_unit(c, axis);
  for (int i = 0; i < 60; i += 5) { /* a fifth lies well inside the outline */
    hl_add_scaled(rays + 3 * i, 0.3, axis, rays + 3 * i);
    hl_unit(rays + 3 * i, rays + 3 * i);
  }
  assert_int_equal(hl_sphere_from_rays(NULL, rays, 60, radius_m, 0, &s, NULL), HL_OK);
  for (int k = 0; k < 2; k++)
    assert_near(s.center_m[k], c[k], 5e-6);
  assert_near(s.center_m[2], c[2], 2e-4);
}

/* Errors over a seeded sample, each divided by its stated standard deviation. */
static double normalised_error(int n, double noise_rad, double stated_rad, double *rms_m)
{
  const double c[3] = {0.02, 0.01, 0.5};
  enum { RUNS = 200 };
  double sum = 0, squares = 0, *rays = malloc(3 * (size_t)n * sizeof *rays);
  assert_non_null(rays);
  for (int run = 0; run < RUNS; run++) {
    hl_sphere s;
    grazing(c, n, 0, 6.283185307179586, noise_rad, 100 + (uint64_t)run, rays);
    assert_int_equal(hl_sphere_from_rays(NULL, rays, n, radius_m, stated_rad, &s, NULL), HL_OK);
    assert_true(s.has_covariance);
    for (int k = 0; k < 3; k++) {
      const double e = s.center_m[k] - c[k];
      sum += e * e / s.covariance_m2[k][k];
      squares += e * e;
    }
  }
  free(rays);
  *rms_m = sqrt(squares / (3 * RUNS));
  return sqrt(sum / (3 * RUNS));
}

static void test_covariance_is_honest(void **state)
{
  (void)state;
  double rms, rms4, rms_double;
  assert_near(normalised_error(40, 1e-4, 0, &rms), 1.05, 0.2);
  assert_near(normalised_error(40, 1e-4, 1e-4, &rms), 1, 0.2);
  /* four times the rays halve the error, twice the noise doubles it */
  assert_near(normalised_error(160, 1e-4, 0, &rms4), 1.05, 0.2);
  normalised_error(40, 2e-4, 0, &rms_double);
  assert_near(rms4 / rms, 0.5, 0.08);
  assert_near(rms_double / rms, 2, 0.1);
}

static void test_step_matches_finite_differences(void **state)
{
  (void)state;
  const double c[3] = {0.05, -0.02, 0.4};
  double ray[3], h = 1e-6;
  hl_cone cone;
  hl_unit(c, cone.axis);
  hl_tangent_basis(cone.axis, cone.e1, cone.e2);
  cone.half_angle_rad = 0.06;
  const double a = 0.7;
  for (int k = 0; k < 3; k++)
    ray[k] = cos(0.06) * cone.axis[k] + sin(0.06) * (cos(a) * cone.e1[k] + sin(a) * cone.e2[k]);
  /* the reading of one ray changes by -(cos a, sin a, 1) a step */
  const double expected[3] = {-cos(a), -sin(a), -1};
  for (int j = 0; j < 3; j++) {
    const double up[3] = {j == 0 ? h : 0, j == 1 ? h : 0, j == 2 ? h : 0};
    const double down[3] = {-up[0], -up[1], -up[2]};
    const hl_cone p = hl_cone_step(&cone, up), m = hl_cone_step(&cone, down);
    const double slope =
        ((hl_angle(ray, p.axis) - p.half_angle_rad) - (hl_angle(ray, m.axis) - m.half_angle_rad)) /
        (2 * h);
    assert_near(slope, expected[j], 1e-8);
  }
}

static void refused(const double *rays, int n, double radius, double sigma, hl_status want,
                    const char *part)
{
  hl_ctx ctx = {0};
  hl_sphere s, before;
  memset(&s, 0x5a, sizeof s);
  before = s;
  assert_int_equal(hl_sphere_from_rays(&ctx, rays, n, radius, sigma, &s, NULL), want);
  assert_non_null(strstr(ctx.msg, part));
  assert_memory_equal(&s, &before, sizeof s);
}

static void test_refusals(void **state)
{
  (void)state;
  const double c[3] = {0.02, 0.01, 0.5};
  double rays[3 * 12], same[3 * 12], line[3 * 12];
  grazing(c, 12, 0, 6.283185307179586, 0, 0, rays);
  refused(rays, 2, radius_m, 0, HL_ERR_ARG, "n = 2, at least 3");
  refused(rays, 12, 0, 0, HL_ERR_ARG, "radius_m = 0");
  refused(rays, 12, NAN, 0, HL_ERR_ARG, "radius_m = nan");
  refused(rays, 12, radius_m, -1, HL_ERR_ARG, "sigma_rad = -1");
  for (int i = 0; i < 12; i++) {
    const double x[3] = {0.01 * i, 0, 1};
    memcpy(same + 3 * i, rays, 3 * sizeof *rays);
    hl_unit(x, line + 3 * i);
  }
  refused(same, 12, radius_m, 0, HL_ERR_DEGENERATE, "do not span a cone");
  refused(line, 12, radius_m, 0, HL_ERR_DEGENERATE, "do not span a cone");
  rays[4] = NAN;
  refused(rays, 12, radius_m, 0, HL_ERR_ARG, "ray 1 has length");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_exact_rays),
      cmocka_unit_test(test_three_rays_are_enough),
      cmocka_unit_test(test_order_of_rays_does_not_matter),
      cmocka_unit_test(test_outliers_are_set_aside),
      cmocka_unit_test(test_covariance_is_honest),
      cmocka_unit_test(test_step_matches_finite_differences),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
