/* What the public call refuses: one line that says why, and nothing touched. */
#include "files.h"
#include "light_scene.h"

static void settings_refused(const hl_light_settings *settings, const char *part)
{
  lit_scene s = lit_glossy();
  lit_shot one = lit_shot_of(&s, 33);
  hl_ctx ctx = {0};
  hl_light out, before;
  memset(&out, 0x5a, sizeof out);
  memset(&before, 0x5a, sizeof before);
  assert_int_equal(lit_status(&one.frame, &one.surface, settings, &ctx, &out), HL_ERR_ARG);
  assert_int_equal(ctx.status, HL_ERR_ARG);
  assert_says(ctx.msg, part);
  assert_memory_equal(&out, &before, sizeof out);
  lit_shot_free(&one);
}

static void test_settings_out_of_bounds(void **state)
{
  (void)state;
  hl_light_settings s = hl_light_defaults();
  assert_int_equal(hl_fields_check(NULL, hl_light_fields(), &s), HL_OK);
  s.model_error = NAN;
  settings_refused(&s, "model_error = nan");
  s = hl_light_defaults();
  s.outlier_sigmas = NAN;
  settings_refused(&s, "outlier_sigmas = nan");
  s = hl_light_defaults();
  s.widest_deg = NAN;
  settings_refused(&s, "widest_deg = nan");
  s = hl_light_defaults();
  s.widest_deg = 181;
  settings_refused(&s, "widest_deg = 181");
  s = hl_light_defaults();
  s.model_error = -0.01;
  settings_refused(&s, "model_error = -0.01");
  s = hl_light_defaults();
  s.outlier_sigmas = HUGE_VAL;
  settings_refused(&s, "outlier_sigmas = inf");
  s = hl_light_defaults();
  s.threads = -1;
  settings_refused(&s, "threads = -1");
  s = hl_light_defaults();
  s.lobe = (hl_lobe)3;
  settings_refused(&s, "lobe");
}

static void test_sizes_that_do_not_belong_together(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  lit_shot one = lit_shot_of(&s, 34);
  hl_light_work *work = NULL;
  hl_light out, before;
  memset(&out, 0x5a, sizeof out);
  memset(&before, 0x5a, sizeof before);
  hl_ctx ctx = {0};
  assert_int_equal(hl_light_work_new(NULL, one.surface.n - 1, 1, &work), HL_OK);
  assert_int_equal(hl_light_estimate(&ctx, work, &one.frame, &one.surface, NULL, &out), HL_ERR_ARG);
  assert_says(ctx.msg, "surface has");
  hl_light_work_free(work);
  assert_int_equal(hl_light_work_new(NULL, one.surface.n, 3, &work), HL_OK);
  assert_int_equal(hl_light_estimate(&ctx, work, &one.frame, &one.surface, NULL, &out), HL_ERR_ARG);
  assert_says(ctx.msg, "channel");
  hl_light_work_free(work);
  assert_int_equal(hl_light_work_new(NULL, one.surface.n, 1, &work), HL_OK);
  one.frame.height--;
  assert_int_equal(hl_light_estimate(&ctx, work, &one.frame, &one.surface, NULL, &out), HL_ERR_ARG);
  assert_says(ctx.msg, "144 x 143");
  assert_memory_equal(&out, &before, sizeof out);
  hl_light_work_free(work);
  lit_shot_free(&one);
}

static void test_workspaces_that_make_no_sense(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  hl_light_work *work = (hl_light_work *)&ctx;
  assert_int_equal(hl_light_work_new(&ctx, 0, 1, &work), HL_ERR_ARG);
  assert_says(ctx.msg, "max_pixels = 0");
  assert_int_equal(hl_light_work_new(&ctx, INT32_MAX, 1, &work), HL_ERR_ARG);
  assert_says(ctx.msg, "max_pixels = 2147483647");
  assert_int_equal(hl_light_work_new(&ctx, 100, 2, &work), HL_ERR_ARG);
  assert_says(ctx.msg, "channels = 2");
  assert_int_equal(hl_light_work_new(NULL, 100, -1, &work), HL_ERR_ARG);
  assert_ptr_equal(work, &ctx);
  hl_light_work_free(NULL);
}

/* A frame that tells no direction: found = false, and one reason that says what and what to do. */
static void hopeless(lit_shot *s, const char *what, const char *part)
{
  hl_ctx ctx = {0};
  hl_light out;
  memset(&out, 0x5a, sizeof out);
  assert_int_equal(lit_status(&s->frame, &s->surface, NULL, &ctx, &out), HL_ERR_DEGENERATE);
  assert_false(out.found);
  assert_false(out.trusted);
  assert_true(out.reasons.n >= 1);
  assert_string_equal(out.reasons.note[0].what, what);
  assert_says(out.reasons.note[0].why, part);
  assert_says(ctx.msg, part);
  assert_int_equal(lit_status(&s->frame, &s->surface, NULL, NULL, &out), HL_ERR_DEGENERATE);
  assert_false(out.found);
}

static void fill(lit_shot *s, double value, hl_sample_state of)
{
  for (int i = 0; i < s->surface.n; i++) {
    s->frame.radiance[s->surface.pixel[i]] = (float)value;
    s->frame.state[s->surface.pixel[i]] = (uint8_t)of;
  }
}

static void test_frames_without_a_light(void **state)
{
  (void)state;
  lit_scene scene = lit_glossy();
  lit_shot s = lit_shot_of(&scene, 35);
  fill(&s, 0, HL_SAMPLE_OK);
  hopeless(&s, "black", "expose more");
  fill(&s, -0.01, HL_SAMPLE_OK);
  hopeless(&s, "black", "expose more");
  fill(&s, 0.5, HL_SAMPLE_OK);
  hopeless(&s, "constant", "varies by");
  fill(&s, 1, HL_SAMPLE_CLIPPED);
  hopeless(&s, "clipped", "expose less");
  fill(&s, 0, HL_SAMPLE_UNUSABLE);
  hopeless(&s, "pixels", "only 0 usable pixels");
  lit_shot_free(&s);
  scene = lit_ball(4);
  lit_shot tiny = lit_shot_of(&scene, 36);
  assert_true(tiny.surface.n < 60);
  hopeless(&tiny, "pixels", "at least");
  lit_shot_free(&tiny);
}

/* Just above the least: an answer or a reason, and no read beyond the few pixels there are. */
static void test_small_balls(void **state)
{
  (void)state;
  static const double radii[] = {6, 7, 9, 13};
  for (int i = 0; i < 4; i++) {
    lit_scene scene = lit_ball(radii[i]);
    scene.width = 0.3;
    scene.channels = i % 2 ? 3 : 1;
    scene.noise = 0.002;
    lit_shot s = lit_shot_of(&scene, 37);
    const hl_light light = lit_light_of(&s, NULL);
    assert_true(light.found);
    assert_true(!light.trusted || lit_error_deg(&scene, &light) < 3);
    lit_shot_free(&s);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_settings_out_of_bounds),
      cmocka_unit_test(test_sizes_that_do_not_belong_together),
      cmocka_unit_test(test_workspaces_that_make_no_sense),
      cmocka_unit_test(test_frames_without_a_light),
      cmocka_unit_test(test_small_balls),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
