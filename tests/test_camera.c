/* Pixels to rays and back, and cameras that are refused. */
#include <string.h>

#include "files.h"
#include "halflight/camera.h"
#include "halflight/vec3.h"

static hl_camera camera_of(double f, const double distortion[5])
{
  hl_camera c = {.model = HL_LENS_PINHOLE,
                 .width = 640,
                 .height = 480,
                 .fx = f,
                 .fy = 1.01 * f,
                 .cx = 322.3,
                 .cy = 236.8,
                 .n_distortion = 5};
  memcpy(c.distortion, distortion, 5 * sizeof *distortion);
  return c;
}

static hl_camera plain(void)
{
  return camera_of(1400, (const double[5]){0});
}

static const double lenses[][5] = {
    {0, 0, 0, 0, 0},
    {-0.08, 0.02, 0, 0, 0},
    {-0.25, 0.08, 0.001, -0.0008, 0},
    {0.2, -0.05, 0.002, 0.001, 0.01},
};

/* A wide-angle camera of each model: 47, 51 and 80 deg to the corner. */
static const hl_camera wide[] = {
    {.model = HL_LENS_PINHOLE,
     .width = 640,
     .height = 480,
     .fx = 450,
     .fy = 455,
     .cx = 322.3,
     .cy = 236.8,
     .n_distortion = 5,
     .distortion = {-0.25, 0.08, 0.001, -0.0008, 0.002}},
    {.model = HL_LENS_RATIONAL,
     .width = 640,
     .height = 480,
     .fx = 450,
     .fy = 455,
     .cx = 322.3,
     .cy = 236.8,
     .n_distortion = 8,
     .distortion = {2.1, 0.9, -0.0005, 0.0008, 0.03, 2.4, 1.5, 0.2}},
    {.model = HL_LENS_FISHEYE,
     .width = 640,
     .height = 480,
     .fx = 275,
     .fy = 278,
     .cx = 322.3,
     .cy = 236.8,
     .n_distortion = 4,
     .distortion = {0.05, -0.02, 0.006, -0.001}},
};

enum { N_WIDE = sizeof wide / sizeof wide[0] };

/* Analytic: tan of the angle to the axis is (pixel - centre) / focal length. */
static void test_unproject_without_distortion(void **state)
{
  (void)state;
  const hl_camera c = plain();
  double ray[3];
  assert_int_equal(hl_camera_unproject(NULL, &c, 100.25, 470.5, ray), HL_OK);
  assert_near(ray[0] / ray[2], (100.25 - 322.3) / 1400, 1e-15);
  assert_near(ray[1] / ray[2], (470.5 - 236.8) / 1414, 1e-15);
  assert_near(hl_norm(ray), 1, 1e-15);
}

static void test_project_inverts_unproject(void **state)
{
  (void)state;
  const double focal[] = {450, 900, 1400, 20000};
  for (size_t l = 0; l < sizeof lenses / sizeof lenses[0]; l++)
    for (size_t f = 0; f < sizeof focal / sizeof focal[0]; f++) {
      const hl_camera c = camera_of(focal[f], lenses[l]);
      assert_int_equal(hl_camera_check(NULL, &c), HL_OK);
      for (int y = 0; y <= 480; y += 24)
        for (int x = 0; x <= 640; x += 32) {
          double ray[3], pixel[2];
          assert_int_equal(hl_camera_unproject(NULL, &c, x - 0.5, y - 0.5, ray), HL_OK);
          for (int i = 0; i < 3; i++)
            ray[i] *= 3.7;
          assert_int_equal(hl_camera_project(NULL, &c, ray, pixel), HL_OK);
          assert_near(pixel[0], x - 0.5, 1e-10);
          assert_near(pixel[1], y - 0.5, 1e-10);
        }
    }
}

static void test_wide_cameras_round_trip_to_the_corner(void **state)
{
  (void)state;
  for (int l = 0; l < N_WIDE; l++) {
    const hl_camera *c = &wide[l];
    hl_ctx ctx = {0};
    if (hl_camera_check(&ctx, c) != HL_OK)
      fail_msg("%s", ctx.msg);
    for (int y = 0; y <= 480; y += 24)
      for (int x = 0; x <= 640; x += 32) {
        double ray[3], pixel[2];
        assert_int_equal(hl_camera_unproject(NULL, c, x - 0.5, y - 0.5, ray), HL_OK);
        assert_near(hl_norm(ray), 1, 3e-16);
        assert_int_equal(hl_camera_project(NULL, c, ray, pixel), HL_OK);
        assert_near(pixel[0], x - 0.5, 1e-10);
        assert_near(pixel[1], y - 0.5, 1e-10);
      }
  }
}

static void test_project_refuses_what_is_behind(void **state)
{
  (void)state;
  const hl_camera c = plain();
  const double behind[][3] = {{0, 0, -1}, {0.1, 0, 0}, {0, 0, NAN}, {INFINITY, 0, 1}};
  for (size_t i = 0; i < sizeof behind / sizeof behind[0]; i++) {
    hl_ctx ctx = {0};
    double pixel[2] = {-7, -7};
    assert_int_equal(hl_camera_project(&ctx, &c, behind[i], pixel), HL_ERR_DEGENERATE);
    assert_says(ctx.msg, "z > 0 is needed");
    assert_near(pixel[0], -7, 0);
  }
}

static void test_unproject_refuses_beyond_the_fold(void **state)
{
  (void)state;
  const hl_camera c = camera_of(450, (const double[5]){-0.5, 0, 0, 0, 0});
  hl_ctx ctx = {0};
  double ray[3] = {-7, -7, -7};
  assert_int_equal(hl_camera_unproject(&ctx, &c, 900, 240, ray), HL_ERR_NOT_CONVERGED);
  assert_says(ctx.msg, "pixel (900, 240)");
  assert_near(ray[0], -7, 0);
}

/* ---- derivatives */

static void test_intrinsics_are_a_vector_and_back(void **state)
{
  (void)state;
  for (int l = 0; l < N_WIDE; l++) {
    hl_camera c = wide[l];
    double theta[HL_INTRINSICS_MAX] = {0}, again[HL_INTRINSICS_MAX] = {0};
    const int n = hl_camera_intrinsics_count(&c);
    assert_int_equal(n, 4 + c.n_distortion);
    hl_camera_intrinsics(&c, theta);
    assert_near(theta[0], c.fx, 0);
    assert_near(theta[1], c.fy, 0);
    assert_near(theta[2], c.cx, 0);
    assert_near(theta[3], c.cy, 0);
    assert_near(theta[n - 1], c.distortion[c.n_distortion - 1], 0);
    for (int k = 0; k < n; k++)
      theta[k] += k + 1;
    hl_camera_set_intrinsics(&c, theta);
    hl_camera_intrinsics(&c, again);
    for (int k = 0; k < HL_INTRINSICS_MAX; k++)
      assert_near(again[k], theta[k], 0);
    assert_near(c.fy, wide[l].fy + 2, 0);
    assert_near(c.distortion[0], wide[l].distortion[0] + 5, 0);
  }
}

/* A step of one intrinsic : rounding and third derivatives weigh alike. */
static double step_of(int k)
{
  return k < 4 ? 1e-2 : 1e-6;
}

static hl_camera with_step(const hl_camera *c, int k, double step)
{
  hl_camera out = *c;
  double theta[HL_INTRINSICS_MAX];
  hl_camera_intrinsics(c, theta);
  theta[k] += step;
  hl_camera_set_intrinsics(&out, theta);
  return out;
}

/* Central differences over points that land in the frame; relative to the derivative's size. */
static void test_project_derivatives_against_differences(void **state)
{
  (void)state;
  test_random r = {5};
  for (int l = 0; l < N_WIDE; l++)
    for (int i = 0; i < 60; i++) {
      const hl_camera *c = &wide[l];
      double p[3], pixel[2], plain[2], by_point[2][3], by[2][HL_INTRINSICS_MAX], a[2], b[2];
      assert_int_equal(hl_camera_unproject(NULL, c, random_between(&r, -0.5, 639.5),
                                           random_between(&r, -0.5, 479.5), p),
                       HL_OK);
      const double far = random_between(&r, 0.1, 5);
      for (int k = 0; k < 3; k++)
        p[k] *= far;
      assert_int_equal(hl_camera_project_derivatives(NULL, c, p, pixel, by_point, by), HL_OK);
      assert_int_equal(hl_camera_project(NULL, c, p, plain), HL_OK);
      assert_near(pixel[0], plain[0], 0);
      assert_near(pixel[1], plain[1], 0);
      for (int k = 0; k < 3; k++) {
        double low[3] = {p[0], p[1], p[2]}, high[3] = {p[0], p[1], p[2]};
        const double step = 1e-5 * p[2];
        low[k] -= step;
        high[k] += step;
        assert_int_equal(hl_camera_project(NULL, c, low, a), HL_OK);
        assert_int_equal(hl_camera_project(NULL, c, high, b), HL_OK);
        for (int m = 0; m < 2; m++)
          assert_near(by_point[m][k] * p[2], (b[m] - a[m]) / 2e-5, 1e-5); /* of 300 px */
      }
      for (int k = 0; k < hl_camera_intrinsics_count(c); k++) {
        const hl_camera low = with_step(c, k, -step_of(k)), high = with_step(c, k, step_of(k));
        assert_int_equal(hl_camera_project(NULL, &low, p, a), HL_OK);
        assert_int_equal(hl_camera_project(NULL, &high, p, b), HL_OK);
        for (int m = 0; m < 2; m++)
          assert_near(by[m][k], (b[m] - a[m]) / (2 * step_of(k)), k < 4 ? 1e-10 : 1e-5);
      }
    }
}

static void test_unproject_derivatives_against_differences(void **state)
{
  (void)state;
  test_random r = {6};
  for (int l = 0; l < N_WIDE; l++)
    for (int i = 0; i < 60; i++) {
      const hl_camera *c = &wide[l];
      const double x = random_between(&r, -0.5, 639.5), y = random_between(&r, -0.5, 479.5);
      double ray[3], plain[3], by_pixel[3][2], by[3][HL_INTRINSICS_MAX], a[3], b[3];
      assert_int_equal(hl_camera_unproject_derivatives(NULL, c, x, y, ray, by_pixel, by), HL_OK);
      assert_int_equal(hl_camera_unproject(NULL, c, x, y, plain), HL_OK);
      for (int m = 0; m < 3; m++)
        assert_near(ray[m], plain[m], 0);
      for (int k = 0; k < 2; k++) {
        const double dx = k == 0 ? 0.02 : 0, dy = k == 1 ? 0.02 : 0;
        assert_int_equal(hl_camera_unproject(NULL, c, x - dx, y - dy, a), HL_OK);
        assert_int_equal(hl_camera_unproject(NULL, c, x + dx, y + dy, b), HL_OK);
        for (int m = 0; m < 3; m++)
          assert_near(by_pixel[m][k], (b[m] - a[m]) / 0.04, 2e-10); /* of 1/450 .. 1/200 */
      }
      for (int k = 0; k < hl_camera_intrinsics_count(c); k++) {
        const hl_camera low = with_step(c, k, -step_of(k)), high = with_step(c, k, step_of(k));
        assert_int_equal(hl_camera_unproject(NULL, &low, x, y, a), HL_OK);
        assert_int_equal(hl_camera_unproject(NULL, &high, x, y, b), HL_OK);
        for (int m = 0; m < 3; m++)
          assert_near(by[m][k], (b[m] - a[m]) / (2 * step_of(k)), k < 4 ? 2e-10 : 3e-8);
      }
    }
}

/* A ray of fixed length turns within its tangent plane. */
static void test_unproject_derivatives_leave_the_length(void **state)
{
  (void)state;
  for (int l = 0; l < N_WIDE; l++) {
    double ray[3], by_pixel[3][2], by[3][HL_INTRINSICS_MAX];
    assert_int_equal(hl_camera_unproject_derivatives(NULL, &wide[l], 610, 20, ray, by_pixel, by),
                     HL_OK);
    for (int k = 0; k < hl_camera_intrinsics_count(&wide[l]); k++)
      assert_near(ray[0] * by[0][k] + ray[1] * by[1][k] + ray[2] * by[2][k], 0, 5e-15);
    for (int k = 0; k < 2; k++)
      assert_near(ray[0] * by_pixel[0][k] + ray[1] * by_pixel[1][k] + ray[2] * by_pixel[2][k], 0,
                  1e-17);
  }
}

static void test_derivatives_need_not_be_wanted_and_are_refused_alike(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  double pixel[2] = {-7, -7}, ray[3] = {-7, -7, -7}, by_point[2][3] = {{-7}};
  double by[3][HL_INTRINSICS_MAX] = {{-7}}, by_pixel[3][2] = {{-7}};
  const double ahead[3] = {0.1, 0.2, 1}, behind[3] = {0, 0, -1};
  const hl_camera *c = &wide[2];
  assert_int_equal(hl_camera_project_derivatives(&ctx, c, behind, pixel, by_point, by),
                   HL_ERR_DEGENERATE);
  assert_says(ctx.msg, "z > 0 is needed");
  assert_int_equal(hl_camera_unproject_derivatives(&ctx, c, 900, 240, ray, by_pixel, by),
                   HL_ERR_NOT_CONVERGED);
  assert_says(ctx.msg, "pixel (900, 240)");
  assert_near(pixel[0], -7, 0);
  assert_near(ray[0], -7, 0);
  assert_near(by_point[0][0], -7, 0);
  assert_near(by_pixel[0][0], -7, 0);
  assert_near(by[0][0], -7, 0);
  assert_int_equal(hl_camera_project_derivatives(NULL, c, ahead, pixel, NULL, NULL), HL_OK);
  assert_int_equal(hl_camera_unproject_derivatives(NULL, c, pixel[0], pixel[1], ray, NULL, NULL),
                   HL_OK);
  assert_near(hl_angle(ray, ahead), 0, 1e-15);
}

/* ---- refusals */

static void refused(const hl_camera *c, const char *part)
{
  hl_ctx ctx = {0};
  assert_int_equal(hl_camera_check(&ctx, c), HL_ERR_FORMAT);
  assert_says(ctx.msg, part);
  assert_int_equal(hl_camera_check(NULL, c), HL_ERR_FORMAT);
}

#define REFUSED_WITH(member, value, part)                                                          \
  do {                                                                                             \
    hl_camera changed = plain();                                                                   \
    changed.member = value;                                                                        \
    refused(&changed, part);                                                                       \
  } while (0)

static void test_check_refuses_each_number(void **state)
{
  (void)state;
  REFUSED_WITH(width, 1, "width = 1 px is outside [2, 65536] px");
  REFUSED_WITH(height, 65537, "height = 65537 px");
  REFUSED_WITH(fx, 0, "fx = 0 px is outside [0.64, 1e+07] px");
  REFUSED_WITH(fx, NAN, "fx = nan px");
  REFUSED_WITH(fy, -1400, "fy = -1400 px");
  REFUSED_WITH(fy, INFINITY, "fy = inf px");
  REFUSED_WITH(cx, 1281, "cx = 1281 px is outside [-640, 1280] px");
  REFUSED_WITH(cy, NAN, "cy = nan px");
  REFUSED_WITH(model, (hl_lens_model)9, "model = 9");
  REFUSED_WITH(n_distortion, 4, "distortion has 4 coefficients; model pinhole needs 5");
  REFUSED_WITH(distortion[2], NAN, "distortion[2] = nan");
}

/* The frame's corner is at 0.286 focal lengths: 400 r^3 stretches it many times; -12 folds
 * (1 - 36 r^2 = 0 at r = 0.167); -40, 600 folds and comes back (1 - 120 r^2 + 3000 r^4 is negative
 * for r between 0.109 and 0.168). */
static void test_check_refuses_lenses_that_are_none(void **state)
{
  (void)state;
  hl_camera c = camera_of(1400, (const double[5]){400, 0, 0, 0, 0});
  refused(&c, "distortion = [400, 0, ...] stretches the image");
  c = camera_of(1400, (const double[5]){-12, 0, 0, 0, 0});
  refused(&c, "distortion = [-12, 0, ...] folds");
  c = camera_of(1400, (const double[5]){-40, 600, 0, 0, 0});
  refused(&c, "folds between the axis and pixel");
  c = camera_of(1400, (const double[5]){0, 0, 3, 0, 0});
  refused(&c, "distortion = [0, 0, ...]");
  c = camera_of(1400, (const double[5]){1e300, 0, 0, 0, 0});
  refused(&c, "distortion");
}

/* Fold radii are analytic: 1 + 3 k1 r^2 = 0. A frame just inside is accepted, one that reaches it
 * is not. */
static void test_check_accepts_up_to_the_fold(void **state)
{
  (void)state;
  hl_camera c = {.width = 200,
                 .height = 2,
                 .fx = 100,
                 .fy = 100,
                 .cx = 99.5,
                 .cy = 0.5,
                 .n_distortion = 5,
                 .distortion = {-1.0 / 3 / 2.3}};
  /* image radius of the fold: (2/3) sqrt(2.3) = 1.0110 focal lengths; the frame's corner is at
   * 1.00005 */
  assert_int_equal(hl_camera_check(NULL, &c), HL_OK);
  c.distortion[0] = -1.0 / 3 / 2.2; /* 0.9888 */
  refused(&c, "folds");
}

static hl_camera fisheye(double f, double k1, double k2)
{
  return (hl_camera){.model = HL_LENS_FISHEYE,
                     .width = 640,
                     .height = 480,
                     .fx = f,
                     .fy = f,
                     .cx = 319.5,
                     .cy = 239.5,
                     .n_distortion = 4,
                     .distortion = {k1, k2, 0, 0}};
}

/* An equidistant fisheye's 90 deg are at pi/2 f; the frame's corner at 400 px, so f > 254.65 px is
 * needed. With k1 = -1/6 the picture folds at 81.03 deg, 0.9428 f. */
static void test_check_says_where_a_fisheye_ends(void **state)
{
  (void)state;
  hl_camera c = fisheye(254.7, 0, 0);
  assert_int_equal(hl_camera_check(NULL, &c), HL_OK);
  c = fisheye(254.6, 0, 0);
  refused(&c,
          "pixel (-0.5, -0.5) is 400.0 px from the centre, but this fisheye lens reaches 90 deg at "
          "399.9 px");
  c = fisheye(240, 0, 0);
  refused(
      &c,
      "reaches 90 deg at 377.0 px and sees nothing beyond; a frame cropped to less is accepted");
  c = fisheye(425, -1.0 / 6, 0); /* 400.7 px */
  assert_int_equal(hl_camera_check(NULL, &c), HL_OK);
  c = fisheye(400, -1.0 / 6, 0); /* 377 px */
  refused(
      &c,
      "folds at 81.1 deg, 377.1 px from the centre: pixel (-0.5, -0.5), 400.0 px from it, sees no "
      "direction; a frame that ends before the fold is accepted");
  c = fisheye(300, NAN, 0);
  refused(&c, "distortion[0] = nan");
  c = fisheye(300, 0, 0);
  c.n_distortion = 5;
  refused(&c, "distortion has 5 coefficients; model fisheye needs 4");
}

/* Compared with the equidistant lens: t + 0.9 t^3 stretches 1 + 2.7 t^2 = 3 times at t = 0.861, seen
 * at 1.435 f = 400 px for f = 279; a pinhole's yardstick would not notice. */
static void test_check_measures_a_fisheye_by_a_fisheye(void **state)
{
  (void)state;
  hl_camera c = fisheye(285, 0.9, 0);
  assert_int_equal(hl_camera_check(NULL, &c), HL_OK);
  c = fisheye(270, 0.9, 0);
  refused(&c, "distortion = [0.9, 0, ...] stretches the image 3.07 times");
}

/* A rational lens's pole is no fold to look beyond: 1 - x^2/4 over a frame that needs x < 2 only far
 * out stretches; and a denominator of zero within the frame is refused. */
static void test_check_refuses_rational_poles(void **state)
{
  (void)state;
  hl_camera c = wide[1];
  const double pole[HL_DISTORTION_MAX] = {0, 0, 0, 0, 0, -0.25};
  memcpy(c.distortion, pole, sizeof pole);
  assert_int_equal(hl_camera_check(NULL, &c), HL_OK); /* image 0.91 f is seen at x = 0.77 */
  c.fx = c.fy = 100;                                  /* 4 f: x = 1.56, stretched 1.6/0.15 times */
  refused(&c, "distortion = [0, 0, ...] stretches the image");
  const double near_pole[HL_DISTORTION_MAX] = {-3, 0, 0, 0, 0, -1, 0, 0};
  memcpy(c.distortion, near_pole, sizeof near_pole);
  refused(&c, "distortion = [-3, 0, ...] folds at");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_unproject_without_distortion),
      cmocka_unit_test(test_project_inverts_unproject),
      cmocka_unit_test(test_wide_cameras_round_trip_to_the_corner),
      cmocka_unit_test(test_project_refuses_what_is_behind),
      cmocka_unit_test(test_unproject_refuses_beyond_the_fold),
      cmocka_unit_test(test_intrinsics_are_a_vector_and_back),
      cmocka_unit_test(test_project_derivatives_against_differences),
      cmocka_unit_test(test_unproject_derivatives_against_differences),
      cmocka_unit_test(test_unproject_derivatives_leave_the_length),
      cmocka_unit_test(test_derivatives_need_not_be_wanted_and_are_refused_alike),
      cmocka_unit_test(test_check_refuses_each_number),
      cmocka_unit_test(test_check_refuses_lenses_that_are_none),
      cmocka_unit_test(test_check_accepts_up_to_the_fold),
      cmocka_unit_test(test_check_says_where_a_fisheye_ends),
      cmocka_unit_test(test_check_measures_a_fisheye_by_a_fisheye),
      cmocka_unit_test(test_check_refuses_rational_poles),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
