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

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_unproject_without_distortion),
      cmocka_unit_test(test_project_inverts_unproject),
      cmocka_unit_test(test_project_refuses_what_is_behind),
      cmocka_unit_test(test_unproject_refuses_beyond_the_fold),
      cmocka_unit_test(test_check_refuses_each_number),
      cmocka_unit_test(test_check_refuses_lenses_that_are_none),
      cmocka_unit_test(test_check_accepts_up_to_the_fold),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
