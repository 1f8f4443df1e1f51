/* Normals, views and footprints of a ball and of a normal map. */
#include <stdlib.h>
#include <string.h>

#include "halflight/surface.h"
#include "halflight/vec3.h"
#include "near.h"

static const double wide[5] = {-0.25, 0.08, 0.001, -0.0008, 0};

static hl_camera camera_of(double f, const double *distortion)
{
  hl_camera c = {
      .width = 320, .height = 240, .fx = f, .fy = f, .cx = 159.5, .cy = 119.5, .n_distortion = 5};
  if (distortion)
    memcpy(c.distortion, distortion, 5 * sizeof *distortion);
  return c;
}

/* The ball whose centre is seen at a pixel, with an image of about that radius. */
static hl_sphere ball_at(const hl_camera *c, double x, double y, double radius_px)
{
  double ray[3];
  assert_int_equal(hl_camera_unproject(NULL, c, x, y, ray), HL_OK);
  hl_sphere s = {.radius_m = 0.025};
  const double distance = 0.025 / sin(atan(radius_px / c->fx));
  for (int i = 0; i < 3; i++)
    s.center_m[i] = distance * ray[i];
  return s;
}

static hl_surface surface_of(const hl_camera *c, const hl_sphere *s, double min_cos_view)
{
  hl_surface out = {0};
  assert_int_equal(hl_surface_of_sphere(NULL, c, s, min_cos_view, &out), HL_OK);
  return out;
}

/* Analytic: the point lies on the ball (|p - C| = R) and on the ray, and the normal is outward. The
 * point is rebuilt from the normal alone. */
static void points_lie_on(const hl_camera *c, const hl_sphere *s, const hl_surface *f)
{
  for (int i = 0; i < f->n; i++) {
    const double *n = f->normal + 3 * i, *v = f->view + 3 * i;
    double p[3], ray[3];
    hl_add_scaled(s->center_m, s->radius_m, n, p);
    assert_int_equal(
        hl_camera_unproject(NULL, c, f->pixel[i] % c->width, (double)(f->pixel[i] / c->width), ray),
        HL_OK);
    assert_near(hl_norm(n), 1, 1e-14);
    assert_near(hl_angle(p, ray), 0, 1e-13);
    for (int k = 0; k < 3; k++)
      assert_near(v[k], -ray[k], 1e-15);
    assert_true(hl_dot(n, v) > 0);
  }
}

static void test_normals_lie_on_the_ball(void **state)
{
  (void)state;
  const double at[][3] = {{160, 120, 50}, {250, 60, 30}, {-10, 100, 60}, {40, 250, 40}};
  for (int lens = 0; lens < 2; lens++)
    for (int i = 0; i < 4; i++) {
      const hl_camera c = camera_of(400, lens ? wide : NULL);
      const hl_sphere s = ball_at(&c, at[i][0], at[i][1], at[i][2]);
      hl_surface f = surface_of(&c, &s, 1e-9);
      assert_true(f.n > 100);
      points_lie_on(&c, &s, &f);
      for (int k = 1; k < f.n; k++)
        assert_true(f.pixel[k] > f.pixel[k - 1]);
      hl_surface_free(&f);
      assert_null(f.pixel);
    }
}

static bool sees(const hl_camera *c, const hl_sphere *s, double x, double y)
{
  double ray[3];
  return hl_camera_unproject(NULL, c, x, y, ray) == HL_OK &&
         hl_angle(ray, s->center_m) < asin(s->radius_m / hl_norm(s->center_m));
}

/* Every pixel of the frame, asked one by one for its corners, without any box. */
static void test_pixels_are_those_that_lie_on_it_as_a_whole(void **state)
{
  (void)state;
  const double at[][3] = {{160, 120, 50}, {313.2, 5.7, 12}, {-10, 100, 60}, {33, 200, 3.2}};
  for (int i = 0; i < 4; i++) {
    const hl_camera c = camera_of(400, wide);
    const hl_sphere s = ball_at(&c, at[i][0], at[i][1], at[i][2]);
    hl_surface f = surface_of(&c, &s, 1e-9);
    int next = 0;
    for (int p = 0; p < c.width * c.height; p++) {
      const double x = p % c.width, y = (double)(p / c.width);
      const bool whole = sees(&c, &s, x - 0.5, y - 0.5) && sees(&c, &s, x + 0.5, y - 0.5) &&
                         sees(&c, &s, x - 0.5, y + 0.5) && sees(&c, &s, x + 0.5, y + 0.5);
      const bool listed = next < f.n && f.pixel[next] == p;
      assert_int_equal(whole, listed);
      next += listed;
    }
    assert_int_equal(next, f.n);
    hl_surface_free(&f);
  }
}

/* Each lens bends the picture in its own way; the ball, its normals and the share of the sky that it
 * fills stay. The fisheye sees one ball 60 deg off its axis. */
static const hl_camera lenses[] = {
    {.model = HL_LENS_PINHOLE,
     .width = 320,
     .height = 240,
     .fx = 300,
     .fy = 303,
     .cx = 158.2,
     .cy = 121.3,
     .n_distortion = 5,
     .distortion = {-0.25, 0.08, 0.001, -0.0008, 0.002}},
    {.model = HL_LENS_RATIONAL,
     .width = 320,
     .height = 240,
     .fx = 300,
     .fy = 303,
     .cx = 158.2,
     .cy = 121.3,
     .n_distortion = 8,
     .distortion = {2.1, 0.9, -0.0005, 0.0008, 0.03, 2.4, 1.5, 0.2}},
    {.model = HL_LENS_FISHEYE,
     .width = 320,
     .height = 240,
     .fx = 300,
     .fy = 303,
     .cx = 158.2,
     .cy = 121.3,
     .n_distortion = 4,
     .distortion = {0.05, -0.02, 0.006, -0.001}},
    {.model = HL_LENS_FISHEYE,
     .width = 400,
     .height = 300,
     .fx = 165,
     .fy = 165,
     .cx = 201.2,
     .cy = 148.4,
     .n_distortion = 4,
     .distortion = {0.02, -0.01, 0.002, -0.0005}},
};

enum { N_LENSES = sizeof lenses / sizeof lenses[0] };

/* Solid angle of a pixel: its corners' rays span two triangles. */
static double pixel_sr(const hl_camera *c, int pixel)
{
  static const double corner[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  double ray[4][3], cross[3];
  for (int k = 0; k < 4; k++)
    assert_int_equal(hl_camera_unproject(NULL, c, pixel % c->width + corner[k][0],
                                         pixel / c->width + corner[k][1], ray[k]),
                     HL_OK);
  double sum = 0;
  for (int k = 1; k < 3; k++) {
    hl_cross(ray[k], ray[k + 1], cross);
    sum += fabs(hl_dot(ray[0], cross)) / 2;
  }
  return sum;
}

static void test_every_lens_gives_the_same_normals(void **state)
{
  (void)state;
  static const hl_sphere balls[] = {{.center_m = {0.01, -0.012, 0.2}, .radius_m = 0.025},
                                    {.center_m = {0.11, 0.05, 0.07}, .radius_m = 0.025}};
  for (int i = 0; i < 2; i++)
    for (int l = i == 0 ? 0 : N_LENSES - 1; l < N_LENSES; l++) {
      const hl_camera *c = &lenses[l];
      hl_surface f = surface_of(c, &balls[i], 1e-9);
      points_lie_on(c, &balls[i], &f);
      double sr = 0;
      for (int k = 0; k < f.n; k++)
        sr += pixel_sr(c, f.pixel[k]);
      /* a cone of half-angle a fills 2 pi (1 - cos a); pixels that lie on it in part are left out,
       * 0.65 px all around: 1.3 / r of the area of r px radius */
      const double half = asin(balls[i].radius_m / hl_norm(balls[i].center_m));
      const double cone = 2 * 3.14159265358979 * (1 - cos(half));
      const double rim = 1 / (half * c->fx);
      assert_near(sr / cone, 1 - 1.3 * rim, 0.4 * rim);
      hl_surface_free(&f);
    }
}

/* Seen from far, the image is a disc: pi r^2 pixels less a rim of about half a pixel's diagonal
 * around, and the footprint is 1 / (r n.v) across the slope. */
static void test_far_ball_is_a_disc(void **state)
{
  (void)state;
  const hl_camera c = camera_of(1e5, NULL);
  const hl_sphere s = ball_at(&c, 159.5, 119.5, 100);
  hl_surface f = surface_of(&c, &s, 0.3);
  for (int i = 0; i < f.n; i++) {
    const double x = f.pixel[i] % c.width - 159.5, y = f.pixel[i] / c.width - 119.5;
    const double *n = f.normal + 3 * i;
    assert_near(n[0], x / 100, 1e-3);
    assert_near(n[1], y / 100, 1e-3);
    const double cosine = hl_dot(n, f.view + 3 * i);
    assert_true(cosine >= 0.3);
    assert_near(f.footprint[i] * 100 * cosine, 1, 0.02);
  }
  hl_surface_free(&f);
  f = surface_of(&c, &s, 1e-9);
  assert_near(f.n, 3.14159265 * 100 * 100, 2 * 3.14159265 * 100);
  assert_true(f.n < 3.14159265 * 100 * 100);
  hl_surface_free(&f);
}

/* Turning camera content by a quarter about the axis (square pixels, centred) turns normals. */
static void test_a_quarter_turn_turns_the_normals(void **state)
{
  (void)state;
  hl_camera c = camera_of(300, (const double[5]){-0.2, 0.05, 0, 0, 0});
  c.width = c.height = 201;
  c.cx = c.cy = 100;
  const hl_sphere s = {.center_m = {0.03, -0.02, 0.3}, .radius_m = 0.025};
  const hl_sphere turned = {.center_m = {0.02, 0.03, 0.3}, .radius_m = 0.025}; /* (-y, x) */
  hl_surface a = surface_of(&c, &s, 0.1), b = surface_of(&c, &turned, 0.1);
  assert_int_equal(a.n, b.n);
  int found = 0;
  for (int i = 0; i < a.n; i++) {
    const int x = a.pixel[i] % 201, y = a.pixel[i] / 201;
    const int wanted = x * 201 + (200 - y);
    for (int k = 0; k < b.n; k++)
      if (b.pixel[k] == wanted) {
        found++;
        assert_near(b.normal[3 * k], -a.normal[3 * i + 1], 1e-12);
        assert_near(b.normal[3 * k + 1], a.normal[3 * i], 1e-12);
        assert_near(b.normal[3 * k + 2], a.normal[3 * i + 2], 1e-12);
        assert_near(b.footprint[k], a.footprint[i], 1e-12);
      }
  }
  assert_int_equal(found, a.n);
  hl_surface_free(&a);
  hl_surface_free(&b);
}

/* Only the ratio of radius and distance can be seen. */
static void test_scale_does_not_matter(void **state)
{
  (void)state;
  const hl_camera c = camera_of(400, wide);
  const hl_sphere s = {.center_m = {0.02, 0.01, 0.2}, .radius_m = 0.02};
  const hl_sphere big = {.center_m = {20, 10, 200}, .radius_m = 20};
  hl_surface a = surface_of(&c, &s, 1e-9), b = surface_of(&c, &big, 1e-9);
  assert_int_equal(a.n, b.n);
  for (int i = 0; i < 3 * a.n; i++)
    assert_near(b.normal[i], a.normal[i], 1e-11);
  hl_surface_free(&a);
  hl_surface_free(&b);
}

static void sphere_refused(hl_sphere s, double min_cos_view, hl_status want, const char *part)
{
  const hl_camera c = camera_of(400, NULL);
  hl_ctx ctx = {0};
  hl_surface f = {.n = -7};
  assert_int_equal(hl_surface_of_sphere(&ctx, &c, &s, min_cos_view, &f), want);
  if (!strstr(ctx.msg, part))
    fail_msg("'%s' does not say '%s'", ctx.msg, part);
  assert_int_equal(f.n, -7);
}

static void test_sphere_refusals(void **state)
{
  (void)state;
  const hl_sphere good = {.center_m = {0, 0, 0.3}, .radius_m = 0.025};
  hl_sphere s = good;
  s.center_m[0] = 1;
  sphere_refused(s, 0.1, HL_ERR_DEGENERATE, "no pixel of the 320 x 240 frame lies on the ball");
  s = good;
  s.center_m[2] = 10;
  sphere_refused(s, 0.1, HL_ERR_DEGENERATE, "1 px in radius; at least 3 px are needed");
  s = good;
  s.center_m[2] = -0.3;
  sphere_refused(s, 0.1, HL_ERR_ARG, "not wholly in front of the camera");
  s = good;
  s.radius_m = NAN;
  sphere_refused(s, 0.1, HL_ERR_ARG, "radius_m = nan");
  sphere_refused(good, NAN, HL_ERR_ARG, "min_cos_view = nan is outside (0, 1)");
  sphere_refused(good, 0, HL_ERR_ARG, "min_cos_view = 0 is outside (0, 1)");
  sphere_refused(good, 1, HL_ERR_ARG, "min_cos_view = 1");
}

/* ---- normal maps */

static hl_frame map_of(const hl_camera *c, const hl_surface *f)
{
  const size_t pixels = (size_t)c->width * (size_t)c->height;
  float *codes = calloc(3 * pixels, sizeof *codes);
  assert_non_null(codes);
  for (int i = 0; i < f->n; i++)
    for (int k = 0; k < 3; k++)
      codes[3 * f->pixel[i] + k] = (float)f->normal[3 * i + k];
  hl_frame map = {0};
  assert_int_equal(hl_frame_from_codes(NULL, codes, c->width, c->height, 3, 32, NULL, &map), HL_OK);
  free(codes);
  return map;
}

/* A ball given as a map is the ball, to single precision. */
static void test_map_of_a_ball_is_the_ball(void **state)
{
  (void)state;
  const hl_camera c = camera_of(400, wide);
  const hl_sphere s = ball_at(&c, 130, 90, 60);
  hl_surface a = surface_of(&c, &s, 0.05), b = {0};
  hl_frame map = map_of(&c, &a);
  map.state[3 * a.pixel[5] + 1] = HL_SAMPLE_UNUSABLE;
  assert_int_equal(hl_surface_of_normals(NULL, &c, &map, 0.04, &b), HL_OK);
  assert_int_equal(b.n, a.n - 1);
  for (int i = 6; i < a.n; i++) {
    assert_int_equal(b.pixel[i - 1], a.pixel[i]);
    for (int k = 0; k < 3; k++) {
      assert_near(b.normal[3 * i - 3 + k], a.normal[3 * i + k], 1e-7);
      assert_near(b.view[3 * i - 3 + k], a.view[3 * i + k], 0);
    }
    if (hl_dot(a.normal + 3 * i, a.view + 3 * i) > 0.5)
      assert_near(b.footprint[i - 1] / a.footprint[i], 1, 0.02);
  }
  hl_surface_free(&a);
  hl_surface_free(&b);
  hl_frame_free(&map);
}

/* A plane's normal does not change, but edges inside a pixel need a width. */
static void test_flat_map_has_a_least_footprint(void **state)
{
  (void)state;
  hl_camera c = camera_of(400, NULL);
  c.width = c.height = 4;
  float codes[48];
  for (int i = 0; i < 48; i++)
    codes[i] = i % 3 == 2 ? -1.0f : 0.0f;
  hl_frame map = {0};
  hl_surface f = {0};
  assert_int_equal(hl_frame_from_codes(NULL, codes, 4, 4, 3, 32, NULL, &map), HL_OK);
  assert_int_equal(hl_surface_of_normals(NULL, &c, &map, 0.1, &f), HL_OK);
  assert_int_equal(f.n, 16);
  for (int i = 0; i < f.n; i++)
    assert_near(f.footprint[i], 1e-6, 0);
  hl_surface_free(&f);
  assert_int_equal(hl_surface_of_normals(NULL, &c, &map, 0, &f), HL_ERR_ARG);
  hl_frame_free(&map);
}

static void map_refused(const float *codes, int width, int height, int channels, const char *part)
{
  hl_camera c = camera_of(400, NULL);
  c.width = 2;
  c.height = 2;
  hl_frame map = {0};
  assert_int_equal(hl_frame_from_codes(NULL, codes, width, height, channels, 32, NULL, &map),
                   HL_OK);
  hl_ctx ctx = {0};
  hl_surface f = {.n = -7};
  assert_int_equal(hl_surface_of_normals(&ctx, &c, &map, 0.1, &f), HL_ERR_FORMAT);
  if (!strstr(ctx.msg, part))
    fail_msg("'%s' does not say '%s'", ctx.msg, part);
  assert_int_equal(f.n, -7);
  hl_frame_free(&map);
}

static void test_map_refusals(void **state)
{
  (void)state;
  const float away[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, NAN, 0, 0};
  const float none[12] = {0};
  const float is_long[12] = {0, 0, -1, 0, 0, -1.02f};
  map_refused(away, 2, 2, 3, "no normal of the map faces the camera");
  map_refused(none, 2, 2, 3, "no normal of the map faces the camera");
  map_refused(is_long, 2, 2, 3, "normal at pixel (1, 0) has length 1.02");
  map_refused(none, 2, 1, 3, "normal map is 2 x 1 px; the camera's 2 x 2 is needed");
  map_refused(none, 2, 2, 1, "normal map has 1 channel; 3 are needed");
}

static void test_free_takes_nothing(void **state)
{
  (void)state;
  hl_surface f = {0};
  hl_surface_free(NULL);
  hl_surface_free(&f);
  assert_null(f.normal);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_normals_lie_on_the_ball),
      cmocka_unit_test(test_pixels_are_those_that_lie_on_it_as_a_whole),
      cmocka_unit_test(test_every_lens_gives_the_same_normals),
      cmocka_unit_test(test_far_ball_is_a_disc),
      cmocka_unit_test(test_a_quarter_turn_turns_the_normals),
      cmocka_unit_test(test_scale_does_not_matter),
      cmocka_unit_test(test_sphere_refusals),
      cmocka_unit_test(test_map_of_a_ball_is_the_ball),
      cmocka_unit_test(test_flat_map_has_a_least_footprint),
      cmocka_unit_test(test_map_refusals),
      cmocka_unit_test(test_free_takes_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
