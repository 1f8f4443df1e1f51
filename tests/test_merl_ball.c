/* Balls of measured materials: which pixel shows which normal, and samples that say the same. */
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "halflight/merl_ball.h"
#include "merl_scene.h"

static const double toward[3] = {1, 1, 1};

static hl_merl_ball from_afar(const hl_merl *merl, int radius, const double light[3],
                              const hl_merl_ball_settings *settings)
{
  hl_ctx ctx = {0};
  hl_merl_ball out;
  if (hl_merl_ball_from_afar(&ctx, merl, radius, light, settings, &out) != HL_OK)
    fail_msg("%s", ctx.msg);
  return out;
}

/* x right, y up, z to the viewer; pixel centres half a pixel in. */
static void test_pixels_from_afar(void **state)
{
  (void)state;
  enum { R = 12 };
  hl_merl merl = table_of(brdf_lambert);
  hl_merl_ball ball = from_afar(&merl, R, toward, NULL);
  double s[3];
  int inside = 0;
  hl_unit(toward, s);
  assert_int_equal(ball.frame.width, 2 * R);
  assert_int_equal(ball.frame.height, 2 * R);
  assert_int_equal(ball.frame.channels, 3);
  for (int row = 0; row < 2 * R; row++)
    for (int column = 0; column < 2 * R; column++) {
      const float *at = ball.frame.radiance + 3 * (row * 2 * R + column);
      const double x = (-R + 0.5 + column) / R, y = -(-R + 0.5 + row) / R;
      const double z2 = 1 - x * x - y * y;
      const double cosine = z2 > 0 ? x * s[0] + y * s[1] + sqrt(z2) * s[2] : 0;
      inside += z2 > 0;
      assert_near((double)at[0], 0.3 * fmax(cosine, 0), 1e-7);
      assert_near((double)at[1], 0.2 * fmax(cosine, 0), 1e-7);
      assert_near((double)at[2], 0.1 * fmax(cosine, 0), 1e-7);
    }
  assert_int_equal(ball.n_pixels, inside);
  assert_int_equal(ball.n_unmeasured, 0);
  hl_merl_ball_free(&ball);
  hl_merl_free(&merl);
}

static void test_samples_from_afar(void **state)
{
  (void)state;
  hl_merl merl = table_of(brdf_ggx);
  hl_merl_ball_settings settings = hl_merl_ball_defaults();
  settings.min_cos_light = 0.3;
  settings.min_cos_view = 0.4;
  hl_merl_ball ball = from_afar(&merl, 20, toward, &settings);
  static const double v[3] = {0, 0, 1};
  const hl_samples *samples = &ball.samples;
  double s[3];
  hl_unit(toward, s);
  assert_int_equal(samples->channels, 3);
  assert_null(samples->view);
  assert_int_equal(hl_samples_check(NULL, samples), HL_OK);
  assert_in_range(samples->n, 300, ball.n_pixels);
  for (int i = 0; i < samples->n; i++) {
    const double *n = samples->normal + 3 * i;
    double want[3];
    assert_near(hl_norm(n), 1, 1e-15);
    assert_true(hl_dot(n, s) > 0.3 && n[2] > 0.4);
    brdf_ggx(n, s, v, want);
    for (int c = 0; c < 3; c++) /* the table's resolution, ours rounded up */
      assert_near(samples->value[c][i], want[c] * hl_dot(n, s), 3e-3 * want[c]);
  }
  hl_merl_ball_free(&ball);
  hl_merl_free(&merl);
}

static hl_camera camera(void)
{
  return (hl_camera){.width = 96,
                     .height = 80,
                     .fx = 300,
                     .fy = 310,
                     .cx = 50,
                     .cy = 38,
                     .n_distortion = 5,
                     .distortion = {-0.1, 0.02, 0.001, -0.001, 0}};
}

static hl_sphere sphere(void)
{
  return (hl_sphere){.center_m = {0.002, -0.001, 0.3}, .radius_m = 0.025};
}

static hl_merl_ball through(const hl_merl *merl, const hl_merl_ball_settings *settings)
{
  static const double light[3] = {0.5, -0.4, -1};
  const hl_camera c = camera();
  const hl_sphere b = sphere();
  hl_ctx ctx = {0};
  hl_merl_ball out;
  if (hl_merl_ball_through_camera(&ctx, merl, &c, &b, light, settings, &out) != HL_OK)
    fail_msg("%s", ctx.msg);
  return out;
}

/* The frame against the surface that the rest of the library sees there. */
static void test_pixels_through_a_camera(void **state)
{
  (void)state;
  hl_merl merl = table_of(brdf_lambert);
  hl_merl_ball_settings settings = hl_merl_ball_defaults();
  settings.background = 0.5;
  settings.oversample = 8;
  hl_merl_ball ball = through(&merl, &settings);
  const hl_camera c = camera();
  const hl_sphere b = sphere();
  hl_surface surface;
  double s[3] = {0.5, -0.4, -1};
  hl_unit(s, s);
  assert_int_equal(hl_surface_of_sphere(NULL, &c, &b, 0.3, &surface), HL_OK);
  assert_int_equal(ball.frame.width, 96);
  assert_int_equal(ball.frame.height, 80);
  assert_true(ball.n_pixels > surface.n);
  for (int i = 0; i < surface.n; i++) {
    const double cosine = hl_dot(surface.normal + 3 * i, s);
    /* the mean over a pixel of Lambert's shading, away from the shadow's edge: its value at the
     * centre to a part in a thousand */
    if (cosine > 0.1)
      assert_near((double)ball.frame.radiance[3 * surface.pixel[i]], 0.3 * cosine, 1e-3);
    if (cosine < -0.1)
      assert_near((double)ball.frame.radiance[3 * surface.pixel[i]], 0, 0);
  }
  assert_near((double)ball.frame.radiance[0], 0.5, 0);
  hl_surface_free(&surface);
  hl_merl_ball_free(&ball);
  hl_merl_free(&merl);
}

/* The outline's pixels are covered by what of them lies on the ball: with a black material before
 * white, the missing light is the ball's area, the ellipse of a sphere's image. */
static void test_the_rim_is_smooth(void **state)
{
  (void)state;
  hl_merl merl = table_of(brdf_lambert);
  for (size_t i = 0; i < 3 * (size_t)HL_MERL_CELLS; i++)
    merl.value[i] = 0;
  hl_merl_ball_settings settings = hl_merl_ball_defaults();
  settings.background = 1;
  hl_camera c = camera();
  memset(c.distortion, 0, sizeof c.distortion);
  const hl_sphere b = sphere();
  static const double light[3] = {0, 0, -1};
  hl_merl_ball ball;
  assert_int_equal(hl_merl_ball_through_camera(NULL, &merl, &c, &b, light, &settings, &ball),
                   HL_OK);
  double missing = 0;
  for (int i = 0; i < 96 * 80; i++)
    missing += 1 - (double)ball.frame.radiance[3 * i];
  /* analytic: a cone of half-angle a about an axis at angle t to z, cut by the image plane */
  const double d = hl_norm(b.center_m), sin_a = b.radius_m / d, cos_t = b.center_m[2] / d;
  const double cos2 = cos_t * cos_t - sin_a * sin_a;
  const double cos_a = sqrt(1 - sin_a * sin_a);
  const double area =
      3.14159265358979323846 * sin_a * sin_a * cos_a * cos_t / (cos2 * sqrt(cos2)) * c.fx * c.fy;
  assert_near(missing, area, 2e-3 * area);
  hl_merl_ball_free(&ball);
  hl_merl_free(&merl);
}

static void test_samples_through_a_camera(void **state)
{
  (void)state;
  hl_merl merl = table_of(brdf_ggx);
  hl_merl_ball ball = through(&merl, NULL);
  const hl_camera c = camera();
  const hl_sphere b = sphere();
  const hl_samples *samples = &ball.samples;
  double s[3] = {0.5, -0.4, -1};
  hl_unit(s, s);
  assert_non_null(samples->view);
  assert_int_equal(hl_samples_check(NULL, samples), HL_OK);
  assert_in_range(samples->n, 500, ball.n_pixels);
  for (int i = 0; i < samples->n; i++) {
    const double *n = samples->normal + 3 * i, *v = samples->view + 3 * i;
    double point[3], pixel[2], want[3];
    assert_true(hl_dot(n, s) > 0.02 && hl_dot(n, v) > 0.05);
    /* seen from the camera, at the centre of a pixel */
    hl_add_scaled(b.center_m, b.radius_m, n, point);
    assert_near(hl_angle(point, v), 3.14159265358979323846, 1e-9);
    assert_int_equal(hl_camera_project(NULL, &c, point, pixel), HL_OK);
    assert_near(pixel[0], round(pixel[0]), 1e-6);
    assert_near(pixel[1], round(pixel[1]), 1e-6);
    brdf_ggx(n, s, v, want);
    for (int k = 0; k < 3; k++)
      if (hl_dot(n, s) > 0.1 && hl_dot(n, v) > 0.1) /* the table's resolution, ours rounded up */
        assert_near(samples->value[k][i], want[k] * hl_dot(n, s), 0.01 * want[k] * hl_dot(n, s));
  }
  hl_merl_ball_free(&ball);
  hl_merl_free(&merl);
}

/* The frame marks what was not measured; the samples leave it out. */
static void test_unmeasured(void **state)
{
  (void)state;
  hl_merl merl = table_of(brdf_lambert);
  for (int i = 0; i < 30; i++)
    for (int j = 0; j < 90; j++)
      for (int k = 0; k < 180; k++)
        merl.value[hl_merl_cell(i, j, k)] = -1; /* within 10 degrees of the highlight */
  hl_merl_ball ball = from_afar(&merl, 20, toward, NULL);
  const double v[3] = {0, 0, 1};
  double h[3];
  hl_unit(toward, h);
  hl_add_scaled(h, 1, v, h);
  hl_unit(h, h);
  int marked = 0;
  for (int i = 0; i < 40 * 40; i++) {
    if (ball.frame.state[3 * i] != HL_SAMPLE_UNUSABLE)
      continue;
    marked++;
    for (int c = 0; c < 3; c++) {
      assert_int_equal(ball.frame.state[3 * i + c], HL_SAMPLE_UNUSABLE);
      assert_near((double)ball.frame.radiance[3 * i + c], 0, 0);
    }
  }
  assert_true(marked > 10);
  assert_int_equal(marked, ball.n_unmeasured);
  assert_int_equal(3 * marked, ball.frame.n_unusable);
  for (int i = 0; i < ball.samples.n; i++)
    assert_true(hl_angle(ball.samples.normal + 3 * i, h) > 9.5 * 3.14159 / 180);
  hl_merl_ball_free(&ball);
  ball = through(&merl, NULL);
  assert_true(ball.n_unmeasured > 10);
  hl_merl_ball_free(&ball);
  hl_merl_free(&merl);
}

static void refused(hl_status got, hl_status want, const hl_ctx *ctx, const char *part)
{
  assert_int_equal(got, want);
  assert_says(ctx->msg, part);
}

static void test_refusals(void **state)
{
  (void)state;
  static const double none[3] = {0, 0, 0}, behind[3] = {0, 0, -1}, front[3] = {0, 0, -1};
  hl_merl merl = table_of(brdf_lambert);
  hl_merl_ball_settings settings = hl_merl_ball_defaults();
  hl_merl_ball ball = {.n_pixels = -7};
  hl_ctx ctx = {0};
  refused(hl_merl_ball_from_afar(&ctx, &merl, 0, toward, NULL, &ball), HL_ERR_ARG, &ctx,
          "radius 0 px is outside [1, 1024]");
  refused(hl_merl_ball_from_afar(&ctx, &merl, 1025, toward, NULL, &ball), HL_ERR_ARG, &ctx,
          "radius 1025 px");
  refused(hl_merl_ball_from_afar(&ctx, &merl, 9, none, NULL, &ball), HL_ERR_ARG, &ctx,
          "light (0, 0, 0); a direction is needed");
  refused(hl_merl_ball_from_afar(&ctx, &merl, 9, behind, NULL, &ball), HL_ERR_DEGENERATE, &ctx,
          "light (0, 0, -1) lights no measured part of the ball that is seen");
  settings.oversample = 17;
  refused(hl_merl_ball_from_afar(&ctx, &merl, 9, toward, &settings, &ball), HL_ERR_ARG, &ctx,
          "oversample = 17");
  settings = hl_merl_ball_defaults();
  settings.background = NAN;
  refused(hl_merl_ball_from_afar(&ctx, &merl, 9, toward, &settings, &ball), HL_ERR_ARG, &ctx,
          "background = nan");
  hl_camera c = camera();
  hl_sphere b = sphere();
  b.center_m[0] = 1;
  refused(hl_merl_ball_through_camera(&ctx, &merl, &c, &b, front, NULL, &ball), HL_ERR_DEGENERATE,
          &ctx, "no pixel of the 96 x 80 frame shows the ball");
  b.center_m[2] = -1;
  refused(hl_merl_ball_through_camera(&ctx, &merl, &c, &b, front, NULL, &ball), HL_ERR_ARG, &ctx,
          "sphere: ");
  c.fx = 0;
  refused(hl_merl_ball_through_camera(&ctx, &merl, &c, &b, front, NULL, &ball), HL_ERR_ARG, &ctx,
          "camera: ");
  assert_int_equal(ball.n_pixels, -7);
  hl_merl_ball_free(NULL);
  hl_merl_free(&merl);
}

/* What is written is what is read. */
static void test_samples_there_and_back(void **state)
{
  char path[TEST_PATH_MAX];
  hl_merl merl = table_of(brdf_ggx);
  hl_merl_ball ball = through(&merl, NULL);
  hl_samples back;
  path_in(state, "t.csv", path);
  for (int views = 0; views < 2; views++) {
    hl_samples samples = ball.samples;
    samples.view = views ? samples.view : NULL;
    assert_int_equal(hl_samples_write(NULL, path, &samples), HL_OK);
    assert_int_equal(hl_samples_read(NULL, path, &back), HL_OK);
    assert_int_equal(back.n, samples.n);
    assert_int_equal(back.channels, 3);
    assert_int_equal(back.view != NULL, views);
    for (int i = 0; i < 3 * back.n; i++) {
      assert_near(back.normal[i], samples.normal[i], 1e-8);
      if (views)
        assert_near(back.view[i], samples.view[i], 1e-8);
    }
    for (int i = 0; i < back.n; i++)
      for (int k = 0; k < 3; k++)
        assert_near(back.value[k][i], samples.value[k][i], 1e-8 * samples.value[k][i]);
    hl_samples_free(&back);
  }
  hl_samples grey = ball.samples;
  grey.channels = 1;
  assert_int_equal(hl_samples_write(NULL, path, &grey), HL_OK);
  assert_int_equal(hl_samples_read(NULL, path, &back), HL_OK);
  assert_int_equal(back.channels, 1);
  hl_samples_free(&back);
  unlink(path);
  assert_int_equal(hl_samples_write(NULL, "/nowhere/t.csv", &grey), HL_ERR_IO);
  hl_merl_ball_free(&ball);
  hl_merl_free(&merl);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_pixels_from_afar),
      cmocka_unit_test(test_samples_from_afar),
      cmocka_unit_test(test_pixels_through_a_camera),
      cmocka_unit_test(test_the_rim_is_smooth),
      cmocka_unit_test(test_samples_through_a_camera),
      cmocka_unit_test(test_unmeasured),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_samples_there_and_back),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
