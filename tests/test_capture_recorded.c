/* A recorded session as a camera: its frames, its times, what it says of itself. */
#include "capture_scene.h"

#include <time.h>

static hl_capture_source opened(const char *folder, bool full_speed)
{
  hl_capture_source source;
  hl_capture_camera camera;
  hl_session_pixels pixels = HL_PIXELS_UNSTATED;
  assert_int_equal(hl_capture_recorded(NULL, folder, full_speed, &source), HL_OK);
  assert_int_equal(source.open(NULL, source.state, "", &pixels, &camera), HL_OK);
  assert_string_equal(camera.id, "test camera");
  assert_int_equal(pixels, HL_PIXELS_RAW_GREEN);
  return source;
}

/* Sixteen bits come through as they were. */
static void test_codes(void **state)
{
  const place p = make_place(state, "codes", NULL, 0);
  hl_capture_source source = opened(p.good, true);
  hl_capture_frame f;
  assert_int_equal(source.start(NULL, source.state, 2), HL_OK);
  for (int k = 2; k < SCENE_FRAMES; k++) {
    assert_int_equal(source.next(NULL, source.state, &f), HL_OK);
    assert_true(f.readable);
    assert_int_equal(f.place, k);
    assert_true(f.timestamp_ns == INT64_C(1000000) * (k + 1));
    assert_int_equal(f.codes_mean.transfer, HL_TRANSFER_LINEAR);
    for (int i = 0; i < SCENE_WIDTH * SCENE_HEIGHT; i++) {
      if (f.bits == 16)
        assert_int_equal(((const uint16_t *)f.codes)[i], scene_code(k, i));
      else
        assert_near((double)((const float *)f.codes)[i] * 65535, scene_code(k, i), 0.01);
    }
  }
  hl_ctx ctx = {0};
  assert_int_equal(source.next(&ctx, source.state, &f), HL_ERR_IO);
  assert_says(ctx.msg, "ends after its 6 frames");
  source.stop(source.state);
  source.close(source.state);
}

static void test_counts_and_places(void **state)
{
  const hl_session_fault faults[] = {{1, HL_FAULT_DROPPED}, {2, HL_FAULT_SLOW_LOCK}};
  const place p = make_place(state, "counts", faults, 2);
  hl_capture_source source = opened(p.bad, true);
  static const int places[] = {-1, -1, 0, 2, 3, 4, 5};
  hl_capture_frame f;
  int64_t before = -1;
  assert_int_equal(source.start(NULL, source.state, 0), HL_OK);
  for (int i = 0; i < 7; i++) {
    assert_int_equal(source.next(NULL, source.state, &f), HL_OK);
    assert_int_equal(f.place, places[i]);
    assert_true(f.count == before + (i == 3 ? 2 : 1)); /* the gap of the dropped one */
    before = f.count;
    assert_near(f.shown.exposure_us, i < 2 ? SCENE_EXPOSURE / 2 : SCENE_EXPOSURE, 0);
  }
  source.close(source.state);
}

/* Frames keep the distance in time that their stamps state: never less. */
static void test_times(void **state)
{
  const place p = make_place(state, "times", NULL, 0);
  hl_session s;
  struct timespec a;
  struct timespec b;
  hl_capture_frame f;
  assert_int_equal(hl_session_read(NULL, p.good, &s), HL_OK);
  for (int k = 0; k < s.n; k++)
    s.frame[k].timestamp_ns = INT64_C(40000000) * k;
  assert_int_equal(hl_session_write(NULL, &s), HL_OK);
  hl_capture_source source = opened(p.good, false);
  assert_int_equal(source.start(NULL, source.state, 0), HL_OK);
  assert_int_equal(source.next(NULL, source.state, &f), HL_OK);
  clock_gettime(CLOCK_MONOTONIC, &a);
  for (int k = 1; k < 4; k++)
    assert_int_equal(source.next(NULL, source.state, &f), HL_OK);
  clock_gettime(CLOCK_MONOTONIC, &b);
  const double passed = (double)(b.tv_sec - a.tv_sec) + 1e-9 * (double)(b.tv_nsec - a.tv_nsec);
  assert_true(passed > 0.1); /* 120 ms, less what reading the first took */
  source.close(source.state);
  hl_session_free(&s);
}

static void test_says_what_it_lacks(void **state)
{
  const place p = make_place(state, "lacking", NULL, 0);
  hl_capture_source source = opened(p.good, true);
  const hl_session_locked locked = {.focus_dioptre = -1};
  unsigned lacks = 0;
  assert_int_equal(source.lock(NULL, source.state, &locked, &lacks), HL_OK);
  assert_int_equal(lacks, HL_LACKS_WHITE_BALANCE | HL_LACKS_FRAME_DURATION | HL_LACKS_FOCUS);
  source.close(source.state);
}

static void test_no_session(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  hl_capture_source source;
  assert_int_equal(hl_capture_recorded(&ctx, "/nowhere/at/all", true, &source), HL_ERR_IO);
  assert_says(ctx.msg, "/nowhere/at/all/session.json: cannot open");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_codes),      cmocka_unit_test(test_counts_and_places),
      cmocka_unit_test(test_times),      cmocka_unit_test(test_says_what_it_lacks),
      cmocka_unit_test(test_no_session),
  };
  return cmocka_run_group_tests(tests, folder_new, tree_free);
}
