/* Capture: which frames are recorded, and what is said of the others. Every camera here is a recorded
 * session or a list of counts. */
#include "capture_scene.h"

static void test_records(void **state)
{
  const place p = make_place(state, "records", NULL, 0);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  size_t n = 0;
  plan.labels = scene_labels;
  plan.radius_m = 0.025;
  assert_int_equal(play(NULL, p.good, &plan, &r), HL_OK);
  assert_int_equal(r.recorded, SCENE_FRAMES);
  assert_int_equal(r.held, SCENE_FRAMES);
  assert_int_equal(r.lacks, 0);
  assert_string_equal(r.device, "test camera");
  assert_whole(p.out, scene_labels);
  assert_int_equal(folder_count(p.out), 2);
  /* once more: nothing is missing, nothing changes */
  char *before = get_file(p.json, &n);
  assert_int_equal(play(NULL, p.good, &plan, &r), HL_OK);
  assert_int_equal(r.recorded, 0);
  assert_int_equal(r.held, SCENE_FRAMES);
  char *after = get_file(p.json, &n);
  assert_string_equal(before, after);
  assert_non_null(strstr(after, "\"radius_m\": 0.025"));
  free(before);
  free(after);
}

/* Each fault costs its own frame and no other; a healthy camera then takes it, and the list is the
 * one of a session that had no fault, byte for byte. */
static void test_faults(void **state)
{
  static const struct {
    hl_session_fault_kind kind;
    const char *says;
  } cases[] = {
      {HL_FAULT_DROPPED, "it was dropped by the camera"},
      {HL_FAULT_EXPOSURE, "its metadata shows exposure 10000 us where 5000 us is locked"},
      {HL_FAULT_FAILED_READ, "it cannot be read: its buffer came back with an error"},
      {HL_FAULT_DIGITAL_GAIN, "its metadata shows digital gain 1.5 where only 1 is accepted"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    const hl_session_fault fault = {2, cases[i].kind};
    char name[16];
    char clean[SCENE_PATH_MAX];
    snprintf(name, sizeof name, "fault%zu", i);
    const place p = make_place(state, name, &fault, 1);
    hl_capture_plan plan = scene_plan(p.out);
    hl_capture_result r;
    hl_ctx ctx = {0};
    hl_session s;
    size_t n = 0;
    plan.labels = scene_labels;
    assert_int_equal(play(&ctx, p.bad, &plan, &r), HL_ERR_IO);
    assert_says(ctx.msg, "1 of 6 frames are missing; the first is 2, L2: ");
    assert_says(ctx.msg, cases[i].says);
    assert_int_equal(r.held, SCENE_FRAMES - 1);
    assert_int_equal(r.refused, 1);
    assert_int_equal(hl_session_read(NULL, p.out, &s), HL_OK);
    assert_int_equal(s.n, SCENE_FRAMES - 1);
    for (int k = 0; k < s.n; k++)
      assert_frame_is(&s, k, k < 2 ? k : k + 1);
    assert_string_equal(s.frame[2].label, "L3");
    hl_session_free(&s);
    assert_int_equal(play(&ctx, p.good, &plan, &r), HL_OK);
    assert_int_equal(r.recorded, 1);
    assert_whole(p.out, scene_labels);
    scene_join(clean, p.good, "clean");
    plan.folder = clean;
    assert_int_equal(play(&ctx, p.good, &plan, &r), HL_OK);
    scene_join(clean, p.good, "clean/session.json");
    char *resumed = get_file(p.json, &n);
    char *uninterrupted = get_file(clean, &n);
    assert_string_equal(resumed, uninterrupted);
    free(resumed);
    free(uninterrupted);
  }
}

/* The last frames dropped: they are missed too. */
static void test_dropped_at_the_end(void **state)
{
  const hl_session_fault faults[] = {{4, HL_FAULT_DROPPED}, {5, HL_FAULT_DROPPED}};
  const place p = make_place(state, "end", faults, 2);
  const hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  assert_int_equal(play(&ctx, p.bad, &plan, &r), HL_ERR_IO);
  assert_says(ctx.msg, "4 of 6 frames are in the session");
  assert_int_equal(r.held, 4);
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_OK);
  assert_whole(p.out, NULL);
}

static void test_vanishes(void **state)
{
  const hl_session_fault fault = {3, HL_FAULT_VANISH};
  const place p = make_place(state, "vanish", &fault, 1);
  const hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  for (int again = 0; again < 2; again++) {
    assert_int_equal(play(&ctx, p.bad, &plan, &r), HL_ERR_IO);
    assert_says(ctx.msg, "the camera vanished at frame 3; 3 of 6 frames are in the session");
    assert_int_equal(r.held, 3);
  }
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_OK);
  assert_int_equal(r.recorded, 3);
  assert_whole(p.out, NULL);
}

static void test_slow_lock(void **state)
{
  const hl_session_fault slow = {5, HL_FAULT_SLOW_LOCK};
  const place p = make_place(state, "slow", &slow, 1);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  plan.settle_frames = 5; /* not one more may pass */
  assert_int_equal(play(&ctx, p.bad, &plan, &r), HL_ERR_IO);
  assert_says(ctx.msg, "after 5 frames the camera is not as it was locked");
  assert_says(ctx.msg, "exposure 2500 us where 5000 us is locked");
  assert_int_equal(access(p.out, F_OK), -1); /* nothing was begun */
  plan.settle_frames = 6;
  assert_int_equal(play(&ctx, p.bad, &plan, &r), HL_OK);
  assert_int_equal(r.refused, 0);
  assert_whole(p.out, NULL);
}

static void test_never_as_locked(void **state)
{
  const place p = make_place(state, "never", NULL, 0);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  plan.locked.exposure_us = 4000;
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_ERR_IO);
  assert_says(ctx.msg, "6 of 6 frames are missing");
  assert_says(ctx.msg, "exposure 5000 us where 4000 us is locked");
  assert_int_equal(access(p.out, F_OK), -1);
}

/* A picture that is not what the session's hash says, and one of another size. */
static void test_bad_pictures(void **state)
{
  const place p = make_place(state, "pictures", NULL, 0);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  hl_session s;
  char *path = NULL;
  uint16_t codes[2 * SCENE_WIDTH * SCENE_HEIGHT];
  scene_codes(1, 2 * SCENE_WIDTH, codes);
  const hl_capture_frame wide = {
      .codes = codes, .width = 2 * SCENE_WIDTH, .height = SCENE_HEIGHT, .channels = 1, .bits = 16};
  assert_int_equal(hl_session_read(NULL, p.bad, &s), HL_OK);
  assert_int_equal(hl_session_path(NULL, &s, s.frame[4].file, &path), HL_OK);
  assert_int_equal(hl_capture_picture_write(NULL, path, &wide), HL_OK);
  assert_int_equal(play(&ctx, p.bad, &plan, &r), HL_ERR_IO);
  assert_says(ctx.msg, "the first is 4: it cannot be read");
  assert_says(ctx.msg, "SHA-256");
  assert_int_equal(r.held, 5);
  s.frame[4].sha256[0] = '\0';
  assert_int_equal(hl_session_write(NULL, &s), HL_OK);
  assert_int_equal(play(&ctx, p.bad, &plan, &r), HL_ERR_IO);
  assert_says(ctx.msg, "it has 24 x 8 pixels where the first frame has 12 x 8");
  put_text(path, "P");
  assert_int_equal(play(&ctx, p.bad, &plan, &r), HL_ERR_IO);
  assert_says(ctx.msg, "the first is 4: it cannot be read");
  assert_int_equal(unlink(path), 0);
  assert_int_equal(play(&ctx, p.bad, &plan, &r), HL_ERR_IO);
  assert_says(ctx.msg, "the first is 4: it cannot be read");
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_OK);
  assert_whole(p.out, NULL);
  free(path);
  hl_session_free(&s);
}

static void test_too_short(void **state)
{
  const place p = make_place(state, "short", NULL, 0);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  plan.n_frames = 8;
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_ERR_IO);
  assert_says(ctx.msg, "ends after its 6 frames; 6 of 8 frames are in the session");
  assert_whole(p.out, NULL);
}

static void test_stops(void **state)
{
  const place p = make_place(state, "stops", NULL, 0);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  plan.go_on = until_two;
  assert_int_equal(play(NULL, p.good, &plan, &r), HL_OK);
  assert_true(r.stopped);
  assert_int_equal(r.held, 2);
  plan.go_on = NULL;
  assert_int_equal(play(NULL, p.good, &plan, &r), HL_OK);
  assert_int_equal(r.recorded, 4);
  assert_whole(p.out, NULL);
}

/* A control that the driver lacks: frames come, each marked. */
static void test_lacks(void **state)
{
  const place p = make_place(state, "lacks", NULL, 0);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_session s;
  plan.locked.white_balance[0] = plan.locked.white_balance[1] = 1.5;
  plan.locked.focus_dioptre = 0;
  assert_int_equal(play(NULL, p.good, &plan, &r), HL_OK);
  assert_int_equal(r.lacks, HL_LACKS_WHITE_BALANCE | HL_LACKS_FOCUS);
  assert_int_equal(hl_session_read(NULL, p.out, &s), HL_OK);
  for (int k = 0; k < s.n; k++)
    assert_string_equal(s.frame[k].untrusted, "the driver has no control of white balance, focus");
  hl_session_free(&s);
}

static void test_plan_refused(void **state)
{
  hl_capture_plan plan = scene_plan(*state);
  hl_capture_result r;
  hl_ctx ctx = {0};
  const hl_capture_source none = {0};
  plan.n_frames = 0;
  assert_int_equal(hl_capture_run(&ctx, &none, &plan, &r), HL_ERR_ARG);
  assert_says(ctx.msg, "0 frames");
  plan = scene_plan(*state);
  plan.locked.gain = 0;
  assert_int_equal(hl_capture_run(&ctx, &none, &plan, &r), HL_ERR_ARG);
  assert_says(ctx.msg, "gain = 0");
  plan = scene_plan(*state);
  plan.pixels = HL_PIXELS_PROCESSED;
  assert_int_equal(hl_capture_run(&ctx, &none, &plan, &r), HL_ERR_ARG);
  assert_says(ctx.msg, "white balance = 0, 0");
}

/* A live camera: frames have counts and no places. */
typedef struct live {
  int at;
  uint16_t codes[SCENE_WIDTH * SCENE_HEIGHT];
} live;

static hl_status live_open(hl_ctx *ctx, void *state, const char *id, hl_session_pixels *pixels,
                           hl_capture_camera *opened)
{
  (void)ctx;
  (void)state;
  (void)id;
  *pixels = HL_PIXELS_RAW_GREEN;
  *opened = (hl_capture_camera){"live", ""};
  return HL_OK;
}

static hl_status live_lock(hl_ctx *ctx, void *state, const hl_session_locked *locked,
                           unsigned *lacks)
{
  (void)ctx;
  (void)state;
  (void)locked;
  *lacks = 0;
  return HL_OK;
}

static hl_status live_start(hl_ctx *ctx, void *state, int first)
{
  (void)ctx;
  (void)first;
  ((live *)state)->at = 0;
  return HL_OK;
}

/* Counts 40, 41, 42 show other settings; 45 is dropped. Frame k of the scene is count 43 + k. */
static hl_status live_next(hl_ctx *ctx, void *state, hl_capture_frame *f)
{
  static const int counts[] = {40, 41, 42, 43, 44, 46, 47, 48, 49, 50};
  live *l = state;
  if (l->at >= (int)(sizeof counts / sizeof *counts))
    return hl_fail(ctx, HL_ERR_IO, "read beyond the end");
  const int count = counts[l->at++];
  scene_codes(count - 43, SCENE_WIDTH, l->codes);
  *f = (hl_capture_frame){.readable = true,
                          .place = -1,
                          .count = count,
                          .codes = l->codes,
                          .width = SCENE_WIDTH,
                          .height = SCENE_HEIGHT,
                          .channels = 1,
                          .bits = 16,
                          .codes_mean = hl_frame_defaults(),
                          .shown = {.exposure_us = count < 43 ? 10 : SCENE_EXPOSURE * 1.01,
                                    .gain = SCENE_GAIN,
                                    .focus_dioptre = -1}};
  return HL_OK;
}

static void live_stop(void *state)
{
  (void)state;
}

static void test_live(void **state)
{
  const place p = make_place(state, "live", NULL, 0);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  hl_session s;
  live camera = {0};
  const hl_capture_source source = {"live",     &camera,   NULL,      live_open, live_lock,
                                    live_start, live_next, live_stop, NULL};
  plan.labels = scene_labels;
  assert_int_equal(hl_capture_run(&ctx, &source, &plan, &r), HL_ERR_IO);
  assert_says(ctx.msg, "1 of 6 frames are missing; the first is 2, L2: it was dropped");
  assert_int_equal(hl_session_read(NULL, p.out, &s), HL_OK);
  assert_int_equal(s.n, 5);
  assert_frame_is(&s, 1, 1);
  assert_frame_is(&s, 2, 3); /* the light of the dropped frame is not given to the next */
  assert_string_equal(s.frame[2].label, "L3");
  assert_near(s.frame[0].exposure_us, SCENE_EXPOSURE * 1.01, 1e-9); /* as the sensor says */
  hl_session_free(&s);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_records),
      cmocka_unit_test(test_faults),
      cmocka_unit_test(test_dropped_at_the_end),
      cmocka_unit_test(test_vanishes),
      cmocka_unit_test(test_slow_lock),
      cmocka_unit_test(test_never_as_locked),
      cmocka_unit_test(test_bad_pictures),
      cmocka_unit_test(test_too_short),
      cmocka_unit_test(test_stops),
      cmocka_unit_test(test_lacks),
      cmocka_unit_test(test_plan_refused),
      cmocka_unit_test(test_live),
  };
  return cmocka_run_group_tests(tests, folder_new, tree_free);
}
