/* How normals and views turn with the ball and the camera, against central differences. */
#include <stdlib.h>
#include <string.h>

#include "halflight/surface.h"
#include "halflight/vec3.h"
#include "near.h"

/* One lens of each model, strong enough that its coefficients matter. */
static hl_camera camera_of(hl_lens_model model)
{
  static const double lens[3][HL_DISTORTION_MAX] = {
      {-0.25, 0.08, 0.001, -0.0008, 0.01},
      {0.1, -0.05, 0.001, -0.0008, 0.02, 0.3, -0.02, 0.01},
      {-0.03, 0.01, -0.004, 0.001},
  };
  static const int coefficients[3] = {5, 8, 4};
  hl_camera c = {.model = model,
                 .width = 120,
                 .height = 100,
                 .fx = 130,
                 .fy = 140,
                 .cx = 58,
                 .cy = 51,
                 .n_distortion = coefficients[model]};
  memcpy(c.distortion, lens[model], sizeof c.distortion);
  return c;
}

static hl_sphere ball_off_the_axis(void)
{
  return (hl_sphere){.center_m = {0.03, -0.02, 0.12}, .radius_m = 0.025};
}

static hl_surface surface_of(const hl_camera *c, const hl_sphere *s)
{
  hl_surface out = {0};
  assert_int_equal(hl_surface_of_sphere(NULL, c, s, 0.2, &out), HL_OK);
  return out;
}

/* Place of a pixel in a surface; -1 where it is not. */
static int place_of(const hl_surface *f, int pixel)
{
  for (int i = 0; i < f->n; i++)
    if (f->pixel[i] == pixel)
      return i;
  return -1;
}

/* Central difference of a component triple between two surfaces at one pixel, against column j. */
static int column_is(const double *low, const double *high, double step, const double *column,
                     int stride, double tolerance)
{
  int wrong = 0;
  for (int k = 0; k < 3; k++)
    wrong += !is_near((high[k] - low[k]) / (2 * step), column[k * stride], tolerance);
  return wrong;
}

static void test_by_center(void **state)
{
  (void)state;
  const double h = 1e-7;
  for (int model = 0; model < 3; model++) {
    const hl_camera c = camera_of((hl_lens_model)model);
    const hl_sphere ball = ball_off_the_axis();
    hl_surface f = surface_of(&c, &ball);
    assert_true(f.is_ball && f.n > 300);
    for (int j = 0; j < 3; j++) {
      hl_sphere low = ball, high = ball;
      low.center_m[j] -= h;
      high.center_m[j] += h;
      hl_surface a = surface_of(&c, &low), b = surface_of(&c, &high);
      int seen = 0;
      for (int i = 0; i < f.n; i += 7) {
        const int ia = place_of(&a, f.pixel[i]), ib = place_of(&b, f.pixel[i]);
        double by[3][3];
        if (ia < 0 || ib < 0)
          continue;
        hl_surface_by_center(&f, i, by);
        /* rates reach 1 / (0.2 * 0.025 m) */
        assert_int_equal(
            column_is(a.normal + 3 * ia, b.normal + 3 * ib, h, by[0] + j, 3, 2e-5 * 200), 0);
        seen++;
      }
      assert_true(seen > 40);
      hl_surface_free(&a);
      hl_surface_free(&b);
    }
    hl_surface_free(&f);
  }
}

static void test_by_intrinsics(void **state)
{
  (void)state;
  for (int model = 0; model < 3; model++) {
    const hl_camera c = camera_of((hl_lens_model)model);
    const hl_sphere ball = ball_off_the_axis();
    hl_surface f = surface_of(&c, &ball);
    double theta[HL_INTRINSICS_MAX];
    hl_camera_intrinsics(&c, theta);
    for (int j = 0; j < hl_camera_intrinsics_count(&c); j++) {
      const double h = j < 4 ? 1e-4 : 1e-6, at = theta[j];
      hl_camera low = c, high = c;
      theta[j] = at - h;
      hl_camera_set_intrinsics(&low, theta);
      theta[j] = at + h;
      hl_camera_set_intrinsics(&high, theta);
      theta[j] = at;
      hl_surface a = surface_of(&low, &ball), b = surface_of(&high, &ball);
      int seen = 0;
      for (int i = 0; i < f.n; i += 7) {
        const int ia = place_of(&a, f.pixel[i]), ib = place_of(&b, f.pixel[i]);
        double normal[3][HL_INTRINSICS_MAX], view[3][HL_INTRINSICS_MAX];
        if (ia < 0 || ib < 0)
          continue;
        assert_int_equal(hl_surface_by_intrinsics(NULL, &f, i, normal, view), HL_OK);
        assert_int_equal(column_is(a.normal + 3 * ia, b.normal + 3 * ib, h, normal[0] + j,
                                   HL_INTRINSICS_MAX, 1e-4),
                         0);
        assert_int_equal(
            column_is(a.view + 3 * ia, b.view + 3 * ib, h, view[0] + j, HL_INTRINSICS_MAX, 1e-6),
            0);
        seen++;
      }
      assert_true(seen > 40);
      hl_surface_free(&a);
      hl_surface_free(&b);
    }
    hl_surface_free(&f);
  }
}

/* Analytic: a normal turns within its tangent plane. */
static void test_turns_are_tangent(void **state)
{
  (void)state;
  const hl_camera c = camera_of(HL_LENS_PINHOLE);
  const hl_sphere ball = ball_off_the_axis();
  hl_surface f = surface_of(&c, &ball);
  for (int i = 0; i < f.n; i++) {
    const double *n = f.normal + 3 * i;
    double center[3][3], normal[3][HL_INTRINSICS_MAX], view[3][HL_INTRINSICS_MAX];
    hl_surface_by_center(&f, i, center);
    assert_int_equal(hl_surface_by_intrinsics(NULL, &f, i, normal, view), HL_OK);
    for (int j = 0; j < 3; j++)
      assert_near(n[0] * center[0][j] + n[1] * center[1][j] + n[2] * center[2][j], 0, 1e-11);
    for (int j = 0; j < 9; j++)
      assert_near(n[0] * normal[0][j] + n[1] * normal[1][j] + n[2] * normal[2][j], 0, 1e-11);
  }
  hl_surface_free(&f);
}

/* The normals of a map move with nothing. */
static void test_map(void **state)
{
  (void)state;
  const hl_camera c = camera_of(HL_LENS_PINHOLE);
  const hl_sphere ball = ball_off_the_axis();
  hl_surface f = surface_of(&c, &ball);
  double center[3][3], normal[3][HL_INTRINSICS_MAX], view[3][HL_INTRINSICS_MAX];
  f.is_ball = false;
  hl_surface_by_center(&f, 5, center);
  assert_int_equal(hl_surface_by_intrinsics(NULL, &f, 5, normal, view), HL_OK);
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < 9; j++) {
      assert_near(normal[k][j], 0, 0);
      assert_near(center[k][j % 3], 0, 0);
    }
  assert_true(fabs(view[0][2]) > 1e-3); /* 1 / fx */
  hl_surface_free(&f);
}

static void test_a_surface_without_a_camera(void **state)
{
  (void)state;
  const hl_camera c = camera_of(HL_LENS_PINHOLE);
  const hl_sphere ball = ball_off_the_axis();
  hl_surface f = surface_of(&c, &ball);
  hl_ctx ctx = {0};
  double normal[3][HL_INTRINSICS_MAX] = {{-7}}, view[3][HL_INTRINSICS_MAX];
  memset(&f.camera, 0, sizeof f.camera);
  assert_int_equal(hl_surface_by_intrinsics(&ctx, &f, 0, normal, view), HL_ERR_ARG);
  assert_non_null(strstr(ctx.msg, "of a frame of 120 x 100, its camera of 0 x 0"));
  assert_near(normal[0][0], -7, 0);
  hl_surface_free(&f);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_by_center),
      cmocka_unit_test(test_by_intrinsics),
      cmocka_unit_test(test_turns_are_tangent),
      cmocka_unit_test(test_map),
      cmocka_unit_test(test_a_surface_without_a_camera),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
