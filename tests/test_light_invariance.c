/* What must not change the answer: threads, frames before, axes, exposure, order, dust. */
#include "light_scene.h"

static lit_scene scene_of(lit_lobe lobe, double width, double angle_deg)
{
  lit_scene s = lit_glossy();
  s.lobe = lobe;
  s.width = width;
  lit_direction(angle_deg, -60, s.light);
  return s;
}

static void assert_same_bits(const hl_light *a, const hl_light *b)
{
  assert_memory_equal(a->direction, b->direction, sizeof a->direction);
  assert_memory_equal(a->tangent_basis, b->tangent_basis, sizeof a->tangent_basis);
  assert_memory_equal(a->covariance_rad2, b->covariance_rad2, sizeof a->covariance_rad2);
  assert_memory_equal(a->ellipse_95_rad, b->ellipse_95_rad, sizeof a->ellipse_95_rad);
  assert_memory_equal(&a->rms, &b->rms, sizeof a->rms);
  assert_memory_equal(&a->evidence_highlight, &b->evidence_highlight, sizeof a->rms);
  assert_int_equal(a->n_curves, b->n_curves);
  for (int k = 0; k < a->n_curves; k++)
    assert_memory_equal(a->curves[k].value, b->curves[k].value,
                        sizeof(double) * (size_t)a->curves[k].n);
  assert_int_equal(a->n_outliers, b->n_outliers);
  assert_int_equal(a->iterations, b->iterations);
  assert_int_equal(a->used.n, b->used.n);
  assert_int_equal(a->left_out.n, b->left_out.n);
  for (int i = 0; i < a->used.n; i++)
    assert_string_equal(a->used.note[i].why, b->used.note[i].why);
  for (int i = 0; i < a->left_out.n; i++)
    assert_string_equal(a->left_out.note[i].why, b->left_out.note[i].why);
}

static void test_threads_change_no_bit(void **state)
{
  (void)state;
  static const int threads[] = {2, 3, 8, 0};
  lit_scene s = lit_usual();
  s.channels = 3;
  lit_shot one = lit_shot_of(&s, 1);
  hl_light_settings settings = hl_light_defaults();
  settings.threads = 1;
  const hl_light want = lit_light_of(&one, &settings);
  for (int i = 0; i < 4; i++) {
    settings.threads = threads[i];
    const hl_light got = lit_light_of(&one, &settings);
    assert_same_bits(&got, &want);
  }
  lit_shot_free(&one);
}

static void test_a_used_workspace_is_as_good_as_new(void **state)
{
  (void)state;
  const lit_scene s = lit_usual();
  lit_scene other = scene_of(LIT_FORESHORTENED, 0.4, 100);
  other.saturation = 0.3;
  lit_shot one = lit_shot_of(&s, 2), two = lit_shot_of(&other, 3);
  const hl_light want = lit_light_of(&one, NULL);
  hl_light_work *work = NULL;
  assert_int_equal(hl_light_work_new(NULL, one.surface.n + 500, 1, &work), HL_OK);
  hl_light got;
  memset(&got, 0xff, sizeof got);
  assert_int_equal(hl_light_estimate(NULL, work, &two.frame, &two.surface, NULL, &got), HL_OK);
  for (int round = 0; round < 2; round++) {
    assert_int_equal(hl_light_estimate(NULL, work, &one.frame, &one.surface, NULL, &got), HL_OK);
    assert_same_bits(&got, &want);
  }
  /* also after a frame that was refused */
  memset(two.frame.radiance, 0, sizeof(float) * LIT_SIDE * LIT_SIDE);
  memset(two.frame.state, 0, LIT_SIDE * LIT_SIDE);
  assert_int_equal(hl_light_estimate(NULL, work, &two.frame, &two.surface, NULL, &got),
                   HL_ERR_DEGENERATE);
  assert_int_equal(hl_light_estimate(NULL, work, &one.frame, &one.surface, NULL, &got), HL_OK);
  assert_same_bits(&got, &want);
  hl_light_work_free(work);
  lit_shot_free(&one);
  lit_shot_free(&two);
}

/* A rotation by `angle` about an axis (Rodrigues). */
static void rotate(const double axis[3], double angle, double x[3])
{
  double cross[3], out[3];
  const double along = hl_dot(axis, x) * (1 - cos(angle));
  hl_cross(axis, x, cross);
  for (int i = 0; i < 3; i++)
    out[i] = cos(angle) * x[i] + sin(angle) * cross[i] + along * axis[i];
  memcpy(x, out, sizeof out);
}

/* Normals and views turned, radiance kept: the light turns along. */
static void test_rotation_turns_the_light(void **state)
{
  (void)state;
  static const double axes[3][3] = {{0, 0, 1}, {0.6, 0, 0.8}, {-0.48, 0.8, 0.36}};
  static const double angles[3] = {1.5707963267948966, 0.7, 2.9};
  for (int lobe = LIT_PLAIN; lobe <= LIT_FORESHORTENED; lobe++)
    for (int k = 0; k < 3; k++) {
      lit_scene s = lit_usual();
      s.lobe = (lit_lobe)lobe;
      lit_shot one = lit_shot_of(&s, 4);
      hl_light before = lit_light_of(&one, NULL);
      for (int i = 0; i < one.surface.n; i++) {
        rotate(axes[k], angles[k], one.surface.normal + 3 * i);
        rotate(axes[k], angles[k], one.surface.view + 3 * i);
      }
      const hl_light after = lit_light_of(&one, NULL);
      rotate(axes[k], angles[k], before.direction);
      assert_near(hl_angle(before.direction, after.direction), 0, 1e-7);
      for (int i = 0; i < 2; i++)
        assert_near(after.ellipse_95_rad[i] / before.ellipse_95_rad[i], 1, 1e-3);
      lit_shot_free(&one);
    }
}

/* A mirrored scene has a mirrored light. */
static void test_mirroring_mirrors_the_light(void **state)
{
  (void)state;
  const lit_scene s = lit_usual();
  lit_shot one = lit_shot_of(&s, 5);
  const hl_light before = lit_light_of(&one, NULL);
  for (int i = 0; i < one.surface.n; i++) {
    one.surface.normal[3 * i] *= -1;
    one.surface.view[3 * i] *= -1;
  }
  const hl_light after = lit_light_of(&one, NULL);
  assert_near(after.direction[0], -before.direction[0], 1e-7);
  assert_near(after.direction[1], before.direction[1], 1e-7);
  assert_near(after.direction[2], before.direction[2], 1e-7);
  lit_shot_free(&one);
}

/* Exposure, to the ends of what a float holds; powers of two change no bit. */
static void test_exposure_does_not_matter(void **state)
{
  (void)state;
  static const double scales[] = {1e-12, 1e12, 1e30, 1e-30};
  static const double powers[] = {0x1p-60, 0x1p90};
  lit_scene s = lit_usual();
  lit_shot one = lit_shot_of(&s, 6);
  const hl_light want = lit_light_of(&one, NULL);
  for (int i = 0; i < 4; i++) {
    s.scale = scales[i];
    lit_shot other = lit_shot_of(&s, 6);
    const hl_light got = lit_light_of(&other, NULL);
    assert_near(hl_angle(got.direction, want.direction), 0, 2e-7); /* a float's rounding */
    assert_near(got.diffuse_strength[0] / scales[i], want.diffuse_strength[0], 1e-4);
    assert_near(got.rms / scales[i], want.rms, 1e-6);
    lit_shot_free(&other);
  }
  for (int i = 0; i < 2; i++) {
    s.scale = powers[i];
    lit_shot other = lit_shot_of(&s, 6);
    hl_light got = lit_light_of(&other, NULL);
    got.rms /= powers[i];
    for (int k = 0; k < got.n_curves; k++)
      for (int p = 0; p < got.curves[k].n; p++)
        got.curves[k].value[p] /= powers[i];
    assert_same_bits(&got, &want);
    lit_shot_free(&other);
  }
  lit_shot_free(&one);
}

/* The surface's list dealt out anew: each pixel keeps its place in the frame, its normal and view. */
static void test_order_of_pixels_does_not_matter(void **state)
{
  (void)state;
  const lit_scene s = lit_usual();
  test_random random = {8};
  lit_shot one = lit_shot_of(&s, 7);
  const hl_light before = lit_light_of(&one, NULL);
  for (int i = one.surface.n - 1; i > 0; i--) {
    const int j = (int)(random_uniform(&random) * (i + 1));
    const int a = one.surface.pixel[i], b = one.surface.pixel[j];
    for (int k = 0; k < 3; k++) {
      double swap = one.surface.normal[3 * i + k];
      one.surface.normal[3 * i + k] = one.surface.normal[3 * j + k];
      one.surface.normal[3 * j + k] = swap;
      swap = one.surface.view[3 * i + k];
      one.surface.view[3 * i + k] = one.surface.view[3 * j + k];
      one.surface.view[3 * j + k] = swap;
    }
    const double footprint = one.surface.footprint[i];
    one.surface.footprint[i] = one.surface.footprint[j];
    one.surface.footprint[j] = footprint;
    one.surface.pixel[i] = b;
    one.surface.pixel[j] = a;
  }
  const hl_light after = lit_light_of(&one, NULL);
  assert_near(hl_angle(before.direction, after.direction), 0, 1e-7);
  assert_near(after.rms, before.rms, 1e-6 * before.rms);
  lit_shot_free(&one);
}

static void test_three_equal_channels_are_one(void **state)
{
  (void)state;
  const lit_scene s = lit_usual();
  lit_shot grey = lit_shot_of(&s, 9), rgb = lit_shot_of(&s, 9);
  const size_t n = LIT_SIDE * LIT_SIDE;
  rgb.frame.channels = 3;
  rgb.frame.radiance = realloc(rgb.frame.radiance, 3 * n * sizeof(float));
  rgb.frame.state = realloc(rgb.frame.state, 3 * n);
  assert_true(rgb.frame.radiance && rgb.frame.state);
  for (size_t i = 0; i < 3 * n; i++) {
    rgb.frame.radiance[i] = grey.frame.radiance[i / 3];
    rgb.frame.state[i] = grey.frame.state[i / 3];
  }
  const hl_light one = lit_light_of(&grey, NULL), three = lit_light_of(&rgb, NULL);
  assert_near(hl_angle(one.direction, three.direction), 0, 1e-7);
  assert_int_equal(three.channels, 3);
  assert_int_equal(three.n_pixels, one.n_pixels);
  assert_int_equal(three.n_clipped, one.n_clipped);
  for (int c = 0; c < 3; c++) {
    assert_near(three.diffuse_strength[c], one.diffuse_strength[0], 1e-5);
    assert_near(three.color[c], 1, 1e-9);
  }
  /* three copies of one noise are no more information */
  for (int i = 0; i < 2; i++)
    assert_near(three.ellipse_95_rad[i] / one.ellipse_95_rad[i], 1, 1e-3);
  lit_shot_free(&grey);
  lit_shot_free(&rgb);
}

/* ---- dust */

/* Three pixels in a hundred are anything at all. Squared errors without and with go to `sum`. */
static void add_dust(lit_lobe lobe, uint64_t seed, double sum[2])
{
  lit_scene s = scene_of(lobe, 0.15, 50);
  s.noise = 0.004;
  lit_shot clean = lit_shot_of(&s, seed), dusty = lit_shot_of(&s, seed);
  test_random random = {seed + 100};
  int wild = 0;
  for (int i = 0; i < dusty.surface.n; i++)
    if (random_uniform(&random) < 0.03) {
      float *r = &dusty.frame.radiance[dusty.surface.pixel[i]];
      const double was = *r;
      *r = (float)(1.5 * random_uniform(&random));
      wild += fabs(*r - was) > 0.2 + 0.5 * was; /* far enough to be told */
    }
  const hl_light a = lit_light_of(&clean, NULL), b = lit_light_of(&dusty, NULL);
  sum[0] += pow(lit_error_deg(&s, &a), 2);
  sum[1] += pow(lit_error_deg(&s, &b), 2);
  assert_true(wild > 30);
  if (b.n_outliers < 9 * wild / 10 || !b.trusted)
    print_error("lobe %d, seed %d: %d wild, %d outliers, error %.3f deg\n", lobe, (int)seed, wild,
                b.n_outliers, lit_error_deg(&s, &b));
  assert_true(b.n_outliers >= 9 * wild / 10);
  assert_true(b.n_outliers <= dusty.surface.n / 20);
  assert_true(a.n_outliers <= clean.surface.n / 1000);
  assert_true(b.trusted);
  lit_shot_free(&clean);
  lit_shot_free(&dusty);
}

static void dust_is_left_out(lit_lobe lobe)
{
  enum { SEEDS = 4 };
  double sum[2] = {0};
  for (uint64_t seed = 1; seed <= SEEDS; seed++)
    add_dust(lobe, seed, sum);
  assert_near(sqrt(sum[1] / SEEDS), 0, 2 * sqrt(sum[0] / SEEDS) + 0.02);
}

static void test_dust_on_a_matte_ball(void **state)
{
  (void)state;
  dust_is_left_out(LIT_MATTE);
}

static void test_dust_on_a_glossy_ball(void **state)
{
  (void)state;
  dust_is_left_out(LIT_PLAIN);
}

static void test_dust_on_a_metal_ball(void **state)
{
  (void)state;
  dust_is_left_out(LIT_FORESHORTENED);
}

static void test_no_outliers_when_told_so(void **state)
{
  (void)state;
  lit_scene s = lit_usual();
  lit_shot one = lit_shot_of(&s, 30);
  hl_light_settings settings = hl_light_defaults();
  settings.outlier_sigmas = 0;
  for (int i = 0; i < one.surface.n; i += 100)
    one.frame.radiance[one.surface.pixel[i]] = 3;
  const hl_light light = lit_light_of(&one, &settings);
  assert_int_equal(light.n_outliers, 0);
  lit_shot_free(&one);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_threads_change_no_bit),
      cmocka_unit_test(test_a_used_workspace_is_as_good_as_new),
      cmocka_unit_test(test_rotation_turns_the_light),
      cmocka_unit_test(test_mirroring_mirrors_the_light),
      cmocka_unit_test(test_exposure_does_not_matter),
      cmocka_unit_test(test_order_of_pixels_does_not_matter),
      cmocka_unit_test(test_three_equal_channels_are_one),
      cmocka_unit_test(test_dust_on_a_matte_ball),
      cmocka_unit_test(test_dust_on_a_glossy_ball),
      cmocka_unit_test(test_dust_on_a_metal_ball),
      cmocka_unit_test(test_no_outliers_when_told_so),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
