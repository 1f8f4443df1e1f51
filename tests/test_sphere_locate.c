/* Finding a ball in a frame. */
#include <stdio.h>
#include <string.h>

#include "ball_scene.h"
#include "near.h"

/* Locates and checks the errors in pixels. */
static void found_within(const ball_scene *s, const hl_frame *f, const hl_sphere_settings *settings,
                         double center_limit, double radius_limit)
{
  hl_ctx ctx = {0};
  hl_sphere found;
  hl_sphere_fit fit;
  double center, radius;
  if (hl_sphere_locate(&ctx, f, &s->camera, s->ball.radius_m, settings, &found, &fit) != HL_OK)
    fail_msg("%s", ctx.msg);
  scene_error(s, &found, &center, &radius);
  assert_near(center, 0, center_limit);
  assert_near(radius, 0, radius_limit);
  assert_true(found.has_covariance);
  assert_near(found.radius_m, s->ball.radius_m, 0);
  assert_true(fit.n_points >= 7 && fit.arc > 0 && fit.arc <= 1 && fit.rms_px < 0.4);
}

static void render_and_find(const ball_scene *s, double center_limit, double radius_limit)
{
  hl_frame f = scene_frame(s);
  found_within(s, &f, NULL, center_limit, radius_limit);
  scene_free(&f);
}

static void test_backgrounds(void **state)
{
  (void)state;
  static const double levels[] = {0, 0.05, 0.2, 1.5}; /* the ball's own radiance is about 0.4 */
  for (int i = 0; i < 4; i++) {
    ball_scene s = scene_of(110.4 + 0.3 * i, 95.2, 50 + 7 * i);
    s.background = levels[i];
    render_and_find(&s, 0.04, 0.04);
  }
  ball_scene s = scene_of(130.2, 99.7, 60);
  s.background = 0.4;
  s.slope = 0.7;
  render_and_find(&s, 0.04, 0.04);
}

/* Cameras whose lens bends the same ball's outline in its own way; the last sees 85 deg from the axis
 * in its corners. */
static const hl_camera lenses[] = {
    {.model = HL_LENS_PINHOLE,
     .width = 240,
     .height = 200,
     .fx = 240,
     .fy = 236,
     .cx = 118.2,
     .cy = 101.3,
     .n_distortion = 5,
     .distortion = {-0.25, 0.08, 0.001, -0.0008, 0.002}},
    {.model = HL_LENS_RATIONAL,
     .width = 240,
     .height = 200,
     .fx = 240,
     .fy = 236,
     .cx = 118.2,
     .cy = 101.3,
     .n_distortion = 8,
     .distortion = {2.1, 0.9, -0.0005, 0.0008, 0.03, 2.4, 1.5, 0.2}},
    {.model = HL_LENS_FISHEYE,
     .width = 240,
     .height = 200,
     .fx = 240,
     .fy = 236,
     .cx = 118.2,
     .cy = 101.3,
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

/* The ball stays where it is; 0.04 px are about 40 um there. */
static void test_every_lens_finds_the_same_ball(void **state)
{
  (void)state;
  static const double centers[][3] = {{0.004, -0.006, 0.13}, {0.045, 0.03, 0.16}};
  for (int i = 0; i < 2; i++)
    for (int l = 0; l < N_LENSES; l++) {
      ball_scene s = scene_of(120, 100, 50);
      s.camera = lenses[l];
      memcpy(s.ball.center_m, centers[i], sizeof centers[i]);
      render_and_find(&s, 0.04, 0.04);
    }
}

/* Out to 70 deg from the axis, where the outline is no ellipse. */
static void test_fisheye_finds_a_ball_far_off_its_axis(void **state)
{
  (void)state;
  static const double angles_deg[] = {15, 40, 55, 70}, azimuths[] = {0.55, 2.5};
  for (int i = 0; i < 4; i++)
    for (int side = 0; side < 2; side++) {
      ball_scene s = scene_of(120, 100, 50);
      s.camera = lenses[N_LENSES - 1];
      s.background = 0.05;
      const double t = angles_deg[i] * 3.14159265358979323846 / 180;
      s.ball.center_m[0] = 0.14 * sin(t) * cos(azimuths[side]);
      s.ball.center_m[1] = 0.14 * sin(t) * sin(azimuths[side]);
      s.ball.center_m[2] = 0.14 * cos(t);
      render_and_find(&s, 0.06, 0.06);
    }
}

static void test_part_of_the_rim_unlit_on_black(void **state)
{
  (void)state;
  static const double lights[][3] = {{0.15, -0.2, -0.97}, {0.9, 0.1, -0.3}, {0.8, -0.3, 0.3}};
  for (int i = 0; i < 3; i++) {
    ball_scene s = scene_of(118.7, 101.3, 60);
    s.background = 0;
    s.noise = 0.0005;
    hl_unit(lights[i], s.light);
    render_and_find(&s, 0.06, 0.06);
  }
}

static void test_cut_by_the_frame(void **state)
{
  (void)state;
  static const double at[][2] = {{5, 100}, {120, 190}, {235, 60}};
  for (int i = 0; i < 3; i++) {
    ball_scene s = scene_of(at[i][0], at[i][1], 60);
    render_and_find(&s, 0.08, 0.08);
  }
}

static void test_three_channels_and_scale(void **state)
{
  (void)state;
  ball_scene s = scene_of(121.3, 98.8, 55);
  s.channels = 3;
  hl_frame f = scene_frame(&s);
  found_within(&s, &f, NULL, 0.03, 0.03);
  for (int i = 0; i < f.width * f.height * 3; i++)
    f.radiance[i] *= 3e4f;
  found_within(&s, &f, NULL, 0.03, 0.03);
  scene_free(&f);
}

static void test_unusable_and_clipped_samples(void **state)
{
  (void)state;
  ball_scene s = scene_of(121.3, 98.8, 55);
  hl_frame f = scene_frame(&s);
  test_random random = scene_random(8);
  for (int i = 0; i < f.width * f.height; i++) {
    if (random_uniform(&random) < 0.01) {
      f.state[i] = HL_SAMPLE_UNUSABLE;
      f.radiance[i] = 0;
    } else if (f.radiance[i] > 0.5f) {
      f.state[i] = HL_SAMPLE_CLIPPED;
      f.radiance[i] = 0.5f;
    }
  }
  found_within(&s, &f, NULL, 0.05, 0.05);
  scene_free(&f);
}

/* A second ball in the right half, its shape scaled down by `flatten` across the rows. */
static void add_disc(hl_frame *f, double x0, double y0, double radius, double flatten, float value)
{
  for (int y = 0; y < f->height; y++)
    for (int x = 0; x < f->width; x++) {
      int in = 0;
      for (int k = 0; k < 16; k++)
        in += hypot(x + (k % 4 - 1.5) / 4 - x0, (y + (k / 4 - 1.5) / 4 - y0) / flatten) < radius;
      float *v = &f->radiance[y * f->width + x];
      *v = *v * (float)(16 - in) / 16 + value * (float)in / 16;
    }
}

static void refused(const hl_frame *f, const ball_scene *s, double radius_m,
                    const hl_sphere_settings *settings, hl_status want, const char *part)
{
  hl_ctx ctx = {0};
  hl_sphere found, before;
  hl_sphere_fit fit, fit_before;
  memset(&found, 0x5a, sizeof found);
  memset(&fit, 0x5a, sizeof fit);
  before = found;
  fit_before = fit;
  assert_int_equal(hl_sphere_locate(&ctx, f, &s->camera, radius_m, settings, &found, &fit), want);
  if (!strstr(ctx.msg, part))
    fail_msg("'%s' lacks '%s'", ctx.msg, part);
  assert_null(strchr(ctx.msg, '\n'));
  assert_memory_equal(&found, &before, sizeof found);
  assert_memory_equal(&fit, &fit_before, sizeof fit);
}

static void test_two_balls_need_a_hint(void **state)
{
  (void)state;
  ball_scene s = scene_of(65.4, 98.8, 45);
  s.camera.distortion[0] = s.camera.distortion[1] = 0;
  s.camera.distortion[2] = s.camera.distortion[3] = 0;
  hl_frame f = scene_frame(&s);
  add_disc(&f, 175, 100, 44, 1, 0.4f);
  refused(&f, &s, 0.025, NULL, HL_ERR_DEGENERATE, "two balls look equally good");
  hl_sphere_settings near = hl_sphere_defaults();
  near.hint_x_px = 68;
  near.hint_y_px = 96;
  near.hint_radius_px = 47;
  found_within(&s, &f, &near, 0.05, 0.05);
  near.hint_x_px = 20;
  near.hint_y_px = 20;
  near.hint_radius_px = 10;
  refused(&f, &s, 0.025, &near, HL_ERR_DEGENERATE, "near");
  scene_free(&f);
}

static void test_no_ball(void **state)
{
  (void)state;
  ball_scene s = scene_of(120, 100, 50);
  hl_frame f = scene_frame(&s);
  const int n = f.width * f.height;
  for (int i = 0; i < n; i++)
    f.radiance[i] = 0;
  refused(&f, &s, 0.025, NULL, HL_ERR_DEGENERATE, "no ball: 0 edge points");
  for (int i = 0; i < n; i++)
    f.radiance[i] = 0.3f;
  refused(&f, &s, 0.025, NULL, HL_ERR_DEGENERATE, "no ball: 0 edge points");
  test_random random = scene_random(3);
  for (int i = 0; i < n; i++)
    f.radiance[i] = (float)fmax(0.3 + 0.1 * random_normal(&random), 0);
  refused(&f, &s, 0.025, NULL, HL_ERR_DEGENERATE, "no ");
  scene_free(&f);
}

static void test_shapes_that_are_no_ball(void **state)
{
  (void)state;
  ball_scene s = scene_of(120, 100, 50);
  memset(s.camera.distortion, 0, sizeof s.camera.distortion);
  static const double flatten[] = {0.95, 0.85, 0.6};
  for (int i = 0; i < 3; i++) {
    hl_frame f = scene_frame(&s);
    for (int k = 0; k < f.width * f.height; k++)
      f.radiance[k] = 0.1f;
    add_disc(&f, 120, 100, 80, flatten[i], 0.5f);
    hl_sphere found;
    const hl_status st = hl_sphere_locate(NULL, &f, &s.camera, 0.025, NULL, &found, NULL);
    assert_true(st == HL_ERR_RESIDUAL || st == HL_ERR_DEGENERATE);
    for (int y = 0; y < f.height; y++)
      for (int x = 0; x < f.width; x++)
        f.radiance[y * f.width + x] = abs(x - 120) < 60 + 10 * i && abs(y - 100) < 60 ? 0.5f : 0.1f;
    const hl_status box = hl_sphere_locate(NULL, &f, &s.camera, 0.025, NULL, &found, NULL);
    assert_true(box == HL_ERR_RESIDUAL || box == HL_ERR_DEGENERATE);
    scene_free(&f);
  }
}

static void test_short_arc_and_tight_limit(void **state)
{
  (void)state;
  ball_scene s = scene_of(-5, -2, 60);
  hl_frame f = scene_frame(&s);
  refused(&f, &s, 0.025, NULL, HL_ERR_DEGENERATE, "of its outline, at least 30 % is needed");
  scene_free(&f);
  ball_scene noisy = scene_of(120, 100, 50);
  noisy.noise = 0.03;
  hl_frame g = scene_frame(&noisy);
  hl_sphere_settings tight = hl_sphere_defaults();
  tight.max_rms_px = 0.01;
  refused(&g, &noisy, 0.025, &tight, HL_ERR_RESIDUAL, "at most 0.01 px");
  scene_free(&g);
}

static void test_arguments(void **state)
{
  (void)state;
  ball_scene s = scene_of(120, 100, 50);
  hl_frame f = scene_frame(&s);
  refused(&f, &s, 0, NULL, HL_ERR_ARG, "radius_m = 0");
  refused(&f, &s, NAN, NULL, HL_ERR_ARG, "radius_m = nan");
  ball_scene other = s;
  other.camera.width = 320;
  refused(&f, &other, 0.025, NULL, HL_ERR_ARG, "the frame is 240 x 200, the camera 320 x 200");
  hl_sphere_settings bad = hl_sphere_defaults();
  bad.min_arc = NAN;
  refused(&f, &s, 0.025, &bad, HL_ERR_ARG, "min_arc");
  bad = hl_sphere_defaults();
  bad.min_radius_px = 200;
  bad.max_radius_px = 100;
  refused(&f, &s, 0.025, &bad, HL_ERR_ARG,
          "max_radius_px = 100 px; 0 or above min_radius_px = 200 is needed");
  bad.max_radius_px = 200;
  refused(&f, &s, 0.025, &bad, HL_ERR_ARG, "max_radius_px = 200 px");
  bad = hl_sphere_defaults();
  ball_scene no_camera = s;
  no_camera.camera.fx = NAN;
  refused(&f, &no_camera, 0.025, NULL, HL_ERR_FORMAT, "fx");
  scene_free(&f);
}

/* The outline gives the distance in radii only: 12 of 100 km are farther than a ball may be. */
static void test_impossible_ball(void **state)
{
  (void)state;
  ball_scene s = scene_of(120, 100, 50);
  hl_frame f = scene_frame(&s);
  refused(&f, &s, 1e5, NULL, HL_ERR_DEGENERATE, "impossible ball's: center_m[2] = 1.2");
  scene_free(&f);
}

/* A power of two changes no rounding: the same ball up to the largest floats, here a background that
 * fills most of the frame. */
static void test_largest_floats(void **state)
{
  (void)state;
  ball_scene s = scene_of(121.3, 98.8, 30);
  s.background = 1.5;
  s.channels = 3;
  hl_frame f = scene_frame(&s);
  float top = 0;
  const int n = f.width * f.height * 3;
  for (int i = 0; i < n; i++)
    top = fmaxf(top, f.radiance[i]);
  int exponent;
  (void)frexpf(top, &exponent);
  hl_sphere plain, large;
  memset(&plain, 0, sizeof plain);
  memset(&large, 0, sizeof large);
  assert_int_equal(hl_sphere_locate(NULL, &f, &s.camera, 0.025, NULL, &plain, NULL), HL_OK);
  for (int i = 0; i < n; i++)
    f.radiance[i] = ldexpf(f.radiance[i], 128 - exponent);
  assert_int_equal(hl_sphere_locate(NULL, &f, &s.camera, 0.025, NULL, &large, NULL), HL_OK);
  for (int k = 0; k < 3; k++)
    assert_near(large.center_m[k], plain.center_m[k], 1e-9);
  scene_free(&f);
}

static void test_settings(void **state)
{
  (void)state;
  const hl_field_table *table = hl_sphere_fields();
  hl_sphere_settings s = hl_sphere_defaults();
  assert_int_equal(hl_fields_check(NULL, table, &s), HL_OK);
  assert_int_equal((size_t)table->n * sizeof(double), sizeof s); /* every member has an entry */
  for (int i = 0; i < table->n; i++) {
    hl_ctx ctx = {0};
    const hl_field *field = &table->fields[i];
    const double bad[2] = {nextafter(field->min, -INFINITY), nextafter(field->max, INFINITY)};
    for (int k = 0; k < 2; k++) {
      s = hl_sphere_defaults();
      memcpy((char *)&s + field->offset, &bad[k], sizeof bad[k]);
      assert_int_equal(hl_fields_check(&ctx, table, &s), HL_ERR_ARG);
      assert_non_null(strstr(ctx.msg, field->name));
    }
  }
}

static void test_same_frame_same_bits(void **state)
{
  (void)state;
  ball_scene s = scene_of(121.3, 98.8, 55);
  s.noise = 0.01;
  hl_frame f = scene_frame(&s);
  hl_sphere a, b;
  memset(&a, 0, sizeof a);
  memset(&b, 0, sizeof b);
  assert_int_equal(hl_sphere_locate(NULL, &f, &s.camera, 0.025, NULL, &a, NULL), HL_OK);
  assert_int_equal(hl_sphere_locate(NULL, &f, &s.camera, 0.025, NULL, &b, NULL), HL_OK);
  assert_memory_equal(&a, &b, sizeof a);
  scene_free(&f);
}

/* Root mean square of the errors, and of the errors over what is stated, at one level of noise. */
static void sample_errors(double noise, double *rms_px, double *normalised)
{
  enum { RUNS = 16 };
  double sum = 0, squares = 0;
  for (int run = 0; run < RUNS; run++) {
    test_random random = scene_random(900 + (uint64_t)run);
    ball_scene s = scene_of(110 + 10 * random_uniform(&random), 95 + 10 * random_uniform(&random),
                            45 + 10 * random_uniform(&random));
    s.noise = noise;
    s.seed = 50 + (unsigned)run;
    hl_frame f = scene_frame(&s);
    hl_sphere found;
    assert_int_equal(hl_sphere_locate(NULL, &f, &s.camera, 0.025, NULL, &found, NULL), HL_OK);
    for (int k = 0; k < 3; k++) {
      const double e = found.center_m[k] - s.ball.center_m[k];
      const double px = s.camera.fx / s.ball.center_m[2];
      sum += e * e / found.covariance_m2[k][k];
      squares += k < 2 ? e * e * px * px : 0;
    }
    scene_free(&f);
  }
  *normalised = sqrt(sum / (3 * RUNS));
  *rms_px = sqrt(squares / (2 * RUNS));
}

static void test_errors_follow_the_noise_and_are_stated(void **state)
{
  (void)state;
  double low, high, stated_low, stated_high;
  sample_errors(0.004, &low, &stated_low);
  sample_errors(0.016, &high, &stated_high);
  print_message("centre error %.4f, %.4f px; over stated %.2f, %.2f\n", low, high, stated_low,
                stated_high);
  assert_near(high / low, 4, 1.6);
  assert_near(stated_low, 1.05, 0.4);
  assert_near(stated_high, 1.05, 0.4);
}

/* With the blur given, the same answer near the ball and a full reading where it moved. */
static void test_relocate_with_the_blur_known(void **state)
{
  (void)state;
  static const double shift_px[] = {0, 0.2, 2.0};
  for (int i = 0; i < 3; i++) {
    const ball_scene s = scene_of(118.7, 101.3, 50);
    hl_frame frame = scene_frame(&s);
    hl_sphere near = s.ball, found, quick;
    hl_sphere_fit fit;
    hl_sphere_settings settings = hl_sphere_defaults();
    double center, radius;
    near.center_m[0] += shift_px[i] * near.center_m[2] / s.camera.fx;
    assert_int_equal(hl_sphere_relocate(NULL, &frame, &s.camera, &near, NULL, &found, &fit), HL_OK);
    settings.blur_px = fit.blur_px > 0.02 ? fit.blur_px : 0.02;
    assert_int_equal(hl_sphere_relocate(NULL, &frame, &s.camera, &near, &settings, &quick, &fit),
                     HL_OK);
    scene_error(&s, &quick, &center, &radius);
    assert_true(center < 0.04 && radius < 0.04);
    assert_true(hl_angle(found.center_m, quick.center_m) * s.camera.fx < 0.02);
    hl_frame_free(&frame);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_backgrounds),
      cmocka_unit_test(test_every_lens_finds_the_same_ball),
      cmocka_unit_test(test_fisheye_finds_a_ball_far_off_its_axis),
      cmocka_unit_test(test_part_of_the_rim_unlit_on_black),
      cmocka_unit_test(test_cut_by_the_frame),
      cmocka_unit_test(test_three_channels_and_scale),
      cmocka_unit_test(test_unusable_and_clipped_samples),
      cmocka_unit_test(test_two_balls_need_a_hint),
      cmocka_unit_test(test_no_ball),
      cmocka_unit_test(test_shapes_that_are_no_ball),
      cmocka_unit_test(test_short_arc_and_tight_limit),
      cmocka_unit_test(test_arguments),
      cmocka_unit_test(test_impossible_ball),
      cmocka_unit_test(test_largest_floats),
      cmocka_unit_test(test_settings),
      cmocka_unit_test(test_relocate_with_the_blur_known),
      cmocka_unit_test(test_same_frame_same_bits),
      cmocka_unit_test(test_errors_follow_the_noise_and_are_stated),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
