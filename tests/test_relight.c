/* Relit images: axes, normals of balls, radiance against closed forms, comparison. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/relight.h"
#include "halflight/vec3.h"
#include "near.h"

/* Lambert alone: radiance = 0.5 n.s, 0.25 n.s, 0.125 n.s. */
static hl_reflectance lambert(void)
{
  hl_reflectance r = {.channels = 3, .n_terms = 1};
  hl_lobe_term *t = &r.term[0];
  snprintf(t->name, sizeof t->name, "%s", "diffuse");
  t->cs = 1;
  t->n = 2;
  t->t[1] = 1;
  t->value[0][1] = 0.5;
  t->value[1][1] = 0.25;
  t->value[2][1] = 0.125;
  return r;
}

/* Straight from the front the image's right is x in both frames, its down -y or y. */
static void test_axes_from_the_front(void **state)
{
  (void)state;
  hl_viewing v;
  assert_int_equal(hl_viewing_along(NULL, NULL, false, &v), HL_OK);
  const double samples[3][3] = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}};
  const double camera[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
  for (int i = 0; i < 3; i++) {
    assert_near(v.right[i], samples[0][i], 0);
    assert_near(v.down[i], samples[1][i], 0);
    assert_near(v.view[i], samples[2][i], 0);
  }
  assert_int_equal(hl_viewing_along(NULL, NULL, true, &v), HL_OK);
  for (int i = 0; i < 3; i++) {
    assert_near(v.right[i], camera[0][i], 0);
    assert_near(v.down[i], camera[1][i], 0);
    assert_near(v.view[i], camera[2][i], 0);
  }
}

static void test_axes_are_orthonormal_everywhere(void **state)
{
  (void)state;
  test_random random = {.state = 3};
  for (int i = 0; i < 200; i++) {
    double view[3] = {random_normal(&random), random_normal(&random), random_normal(&random)};
    if (i < 2) { /* straight from above and below */
      view[0] = view[2] = 0;
      view[1] = i == 0 ? 2 : -3;
    }
    hl_viewing v;
    double into[3], handed[3];
    assert_int_equal(hl_viewing_along(NULL, view, i % 2 == 0, &v), HL_OK);
    assert_near(hl_norm(v.right), 1, 1e-12);
    assert_near(hl_norm(v.down), 1, 1e-12);
    assert_near(hl_dot(v.right, v.down), 0, 1e-12);
    assert_near(hl_angle(v.view, view), 0, 1e-9);
    hl_cross(v.right, v.down, into); /* x right, y down, z into the picture: right-handed */
    hl_add_scaled(into, 1, v.view, handed);
    assert_near(hl_norm(handed), 0, 1e-12);
  }
}

/* Pixel centres at -R + 0.5 ...; the frame is x right, y up. Analytic. */
static void test_normals_of_a_ball(void **state)
{
  (void)state;
  enum { R = 10 };
  hl_viewing v;
  hl_frame f = {0};
  hl_viewing_along(NULL, NULL, false, &v);
  assert_int_equal(hl_normals_of_ball(NULL, R, &v, &f), HL_OK);
  assert_int_equal(f.width, 2 * R);
  assert_int_equal(f.height, 2 * R);
  int inside = 0;
  for (int row = 0; row < f.height; row++)
    for (int column = 0; column < f.width; column++) {
      const double x = (column - R + 0.5) / R, y = (R - 0.5 - row) / R;
      const float *n = f.radiance + 3 * (row * f.width + column);
      if (x * x + y * y < 1) {
        inside++;
        assert_near(n[0], x, 1e-6);
        assert_near(n[1], y, 1e-6);
        assert_near(n[2], sqrt(1 - x * x - y * y), 1e-6);
      } else {
        assert_near(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 0, 0);
      }
    }
  assert_true(inside > 300);
  hl_frame_free(&f);
}

static void lit_ball(const hl_reflectance *r, const double light[3], hl_surface *surface,
                     hl_frame *out)
{
  hl_viewing v;
  hl_frame normals = {0};
  hl_viewing_along(NULL, NULL, false, &v);
  assert_int_equal(hl_normals_of_ball(NULL, 20, &v, &normals), HL_OK);
  assert_int_equal(hl_surface_of_parallel_view(NULL, &normals, v.view, 1e-3, surface), HL_OK);
  assert_int_equal(hl_relight(NULL, r, surface, light, out), HL_OK);
  hl_frame_free(&normals);
}

/* Analytic: k max(0, n.s) a channel. */
static void test_a_lambert_ball(void **state)
{
  (void)state;
  const hl_reflectance r = lambert();
  const double light[3] = {2, 1, 2};
  double s[3];
  hl_surface surface = {0};
  hl_frame f = {0};
  hl_unit(light, s);
  lit_ball(&r, light, &surface, &f);
  int dark = 0;
  for (int i = 0; i < surface.n; i++) {
    const double ns = hl_dot(surface.normal + 3 * i, s);
    const float *p = f.radiance + 3 * surface.pixel[i];
    dark += ns <= 0;
    for (int c = 0; c < 3; c++)
      assert_near(p[c], ns > 0 ? r.term[0].value[c][1] * ns : 0, 1e-6);
  }
  assert_true(dark > 50);
  hl_surface_free(&surface);
  hl_frame_free(&f);
}

static void test_comparison_sees_what_differs(void **state)
{
  (void)state;
  const hl_reflectance r = lambert();
  const double light[3] = {0, 0.6, 0.8};
  hl_surface surface = {0};
  hl_frame relit = {0}, photo = {0}, difference = {0};
  hl_relit_error e;
  lit_ball(&r, light, &surface, &relit);
  hl_surface_free(&surface);
  lit_ball(&r, light, &surface, &photo);
  const size_t samples = (size_t)photo.width * (size_t)photo.height * 3;
  for (size_t i = 0; i < samples; i++)
    photo.radiance[i] *= 2; /* another exposure */
  assert_int_equal(hl_relit_compare(NULL, &relit, &surface, light, &photo, false, &e, NULL), HL_OK);
  assert_near(e.relative_error, 0.5, 1e-6);
  assert_near(e.scale, 1, 0);
  assert_int_equal(hl_relit_compare(NULL, &relit, &surface, light, &photo, true, &e, NULL), HL_OK);
  assert_near(e.relative_error, 0, 1e-6);
  assert_near(e.scale, 0.5, 1e-6);
  /* a clipped pixel, and one that is no number, say nothing */
  const int at = surface.pixel[surface.n / 2];
  const int compared = e.n_pixels;
  for (int c = 0; c < 3; c++) {
    photo.radiance[3 * at + c] = 1000;
    photo.state[3 * at + c] = HL_SAMPLE_CLIPPED;
  }
  assert_int_equal(hl_relit_compare(NULL, &relit, &surface, light, &photo, true, &e, &difference),
                   HL_OK);
  assert_near(e.relative_error, 0, 1e-6);
  assert_int_equal(e.n_pixels, compared - 1);
  assert_near(difference.radiance[3 * at], 0, 0);
  hl_frame_free(&difference);
  hl_frame_free(&relit);
  hl_frame_free(&photo);
  hl_surface_free(&surface);
}

static void test_refusals(void **state)
{
  (void)state;
  const hl_reflectance r = lambert();
  const double nothing[3] = {0, 0, 0}, light[3] = {0, 0, 1}, behind[3] = {0, 0, -1};
  hl_ctx ctx = {0};
  hl_viewing v;
  hl_surface surface = {0};
  hl_frame f = {0}, other = {0}, untouched = {0};
  hl_relit_error e;
  assert_int_equal(hl_viewing_along(&ctx, nothing, false, &v), HL_ERR_ARG);
  hl_viewing_along(NULL, NULL, false, &v);
  assert_int_equal(hl_normals_of_ball(&ctx, 0, &v, &untouched), HL_ERR_ARG);
  assert_int_equal(hl_normals_of_ball(&ctx, 9000, &v, &untouched), HL_ERR_ARG);
  lit_ball(&r, light, &surface, &f);
  assert_int_equal(hl_relight(&ctx, &r, &surface, nothing, &untouched), HL_ERR_ARG);
  assert_int_equal(hl_normals_of_ball(&ctx, 3, &v, &other), HL_OK);
  assert_int_equal(hl_relit_compare(&ctx, &f, &surface, light, &other, false, &e, NULL),
                   HL_ERR_FORMAT);
  assert_non_null(strstr(ctx.msg, "6 x 6"));
  /* from behind nothing is lit, so nothing can be compared */
  assert_int_equal(hl_relit_compare(&ctx, &f, &surface, behind, &f, false, &e, NULL),
                   HL_ERR_FORMAT);
  assert_non_null(strstr(ctx.msg, "no pixel to compare"));
  assert_int_equal(hl_surface_of_parallel_view(&ctx, &other, nothing, 1e-3, &surface), HL_ERR_ARG);
  assert_int_equal(hl_surface_of_parallel_view(&ctx, &other, behind, 1e-3, &surface),
                   HL_ERR_FORMAT);
  assert_null(untouched.radiance);
  hl_frame_free(&f);
  hl_frame_free(&other);
  hl_surface_free(&surface);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_axes_from_the_front),
      cmocka_unit_test(test_axes_are_orthonormal_everywhere),
      cmocka_unit_test(test_normals_of_a_ball),
      cmocka_unit_test(test_a_lambert_ball),
      cmocka_unit_test(test_comparison_sees_what_differs),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
