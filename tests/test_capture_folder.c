/* The folder a capture writes to: what it takes up, what it refuses, and disks that fail. */
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/resource.h>

#include "capture_scene.h"

static hl_camera any_camera(int width)
{
  return (hl_camera){.width = width,
                     .height = SCENE_HEIGHT,
                     .fx = 20,
                     .fy = 20,
                     .cx = 5,
                     .cy = 4,
                     .n_distortion = 5};
}

static void test_resume_must_agree(void **state)
{
  const place p = make_place(state, "agree", NULL, 0);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  size_t n = 0;
  static const char *const others[] = {"L0", "L1", "other", "L3", "L4", "L5"};
  const hl_camera camera = any_camera(SCENE_WIDTH);
  hl_camera moved = camera;
  moved.fx = 21;
  plan.labels = scene_labels;
  plan.camera = &camera;
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_OK);
  char *before = get_file(p.json, &n);
  hl_capture_plan other[6];
  static const char *const says[] = {"has exposure_us 5000, 4000 is asked for",
                                     "has gain 2, 3 is asked for",
                                     "frame 2 has label 'L2', 'other' is asked for",
                                     "has radius_m 0, 0.02 is asked for",
                                     "is another calibrated camera",
                                     "has focus_dioptre -1, 0 is asked for"};
  for (int i = 0; i < 6; i++)
    other[i] = plan;
  other[0].locked.exposure_us = 4000;
  other[1].locked.gain = 3;
  other[2].labels = others;
  other[3].radius_m = 0.02;
  other[4].camera = &moved;
  other[5].locked.focus_dioptre = 0;
  for (int i = 0; i < 6; i++) {
    assert_int_equal(play(&ctx, p.good, &other[i], &r), HL_ERR_ARG);
    assert_says(ctx.msg, says[i]);
  }
  char *after = get_file(p.json, &n);
  assert_string_equal(before, after);
  free(before);
  free(after);
}

static void test_other_device_and_pixels(void **state)
{
  const place p = make_place(state, "device", NULL, 0);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  hl_session s;
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_OK);
  assert_int_equal(hl_session_read(NULL, p.bad, &s), HL_OK);
  s.device[0] = 'T';
  assert_int_equal(hl_session_write(NULL, &s), HL_OK);
  assert_int_equal(play(&ctx, p.bad, &plan, &r), HL_ERR_ARG);
  assert_says(ctx.msg, "the session is of camera 'test camera', not 'Test camera'");
  s.device[0] = 't';
  s.pixels = HL_PIXELS_RAW_DEMOSAICED;
  assert_int_equal(hl_session_write(NULL, &s), HL_OK);
  assert_int_equal(play(&ctx, p.bad, &plan, &r), HL_ERR_ARG);
  assert_says(ctx.msg, "its frames are 'raw-green', 'raw-demosaiced' is asked for");
  plan.pixels = HL_PIXELS_RAW_GREEN;
  assert_int_equal(play(&ctx, p.bad, &plan, &r), HL_ERR_ARG);
  assert_says(ctx.msg, "its frames are raw-demosaiced; raw-green cannot be had from it");
  plan.camera_id = "another";
  plan.pixels = HL_PIXELS_UNSTATED;
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_ERR_IO);
  assert_says(ctx.msg, "no camera 'another'");
  hl_session_free(&s);
}

static void test_camera_of_other_size(void **state)
{
  const place p = make_place(state, "size", NULL, 0);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  const hl_camera camera = any_camera(2 * SCENE_WIDTH);
  plan.camera = &camera;
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_ERR_ARG);
  assert_says(ctx.msg, "frames of 12 x 8 pixels, and a calibrated camera of 24 x 8");
  assert_int_equal(access(p.out, F_OK), -1);
}

/* A disk that takes the pictures but not the list any more. */
static void test_full_disk(void **state)
{
  const place p = make_place(state, "full", NULL, 0);
  const hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  hl_session s;
  struct rlimit limit;
  assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
  const struct rlimit little = {.rlim_cur = 1100, .rlim_max = limit.rlim_max};
  void (*old)(int) = signal(SIGXFSZ, SIG_IGN);
  assert_int_equal(setrlimit(RLIMIT_FSIZE, &little), 0);
  const hl_status st = play(&ctx, p.good, &plan, &r);
  assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
  signal(SIGXFSZ, old);
  assert_int_equal(st, HL_ERR_IO);
  assert_says(ctx.msg, "session.json: cannot write: File too large");
  assert_true(r.held > 0 && r.held < SCENE_FRAMES);
  assert_int_equal(hl_session_read(NULL, p.out, &s), HL_OK);
  assert_int_equal(s.n, r.held);
  for (int k = 0; k < s.n; k++)
    assert_frame_is(&s, k, k);
  hl_session_free(&s);
  char frames[SCENE_PATH_MAX];
  scene_join(frames, p.out, "frames");
  assert_int_equal(folder_count(frames), r.held); /* no left-overs */
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_OK);
  assert_whole(p.out, NULL);
}

static void test_read_only(void **state)
{
  const place p = make_place(state, "readonly", NULL, 0);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  const bool root = geteuid() == 0;
  assert_int_equal(chmod(*state, 0755), 0);
  assert_int_equal(mkdir(p.out, 0555), 0);
  if (root && seteuid(65534) != 0)
    skip();
  const hl_status inside = play(&ctx, p.good, &plan, &r);
  hl_ctx other = {0};
  char below[SCENE_PATH_MAX];
  scene_join(below, p.out, "new");
  plan.folder = below;
  const hl_status made = play(&other, p.good, &plan, &r);
  if (root)
    assert_int_equal(seteuid(0), 0);
  assert_int_equal(inside, HL_ERR_IO);
  assert_says(ctx.msg, "session.json: cannot create: Permission denied");
  assert_int_equal(made, HL_ERR_IO);
  assert_says(other.msg, "cannot make the folder: Permission denied");
  assert_int_equal(folder_count(p.out), 0);
}

static void test_two_at_once(void **state)
{
  const place p = make_place(state, "two", NULL, 0);
  const hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  assert_int_equal(mkdir(p.out, 0777), 0);
  const int other = open(p.out, O_RDONLY | O_DIRECTORY);
  assert_int_equal(flock(other, LOCK_EX), 0);
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_ERR_IO);
  assert_says(ctx.msg, "another capture is at work in this folder");
  close(other);
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_OK);
}

static void picture_of(char path[SCENE_PATH_MAX], const char *out, int k, const char *more)
{
  char name[64];
  snprintf(name, sizeof name, "frames/%04d.%s%s", k, hl_capture_picture_ending(16), more);
  scene_join(path, out, name);
}

/* What a killed capture leaves: a picture that is on no list, and beginnings of files. */
static void test_left_over(void **state)
{
  const place p = make_place(state, "left", NULL, 0);
  hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  char path[SCENE_PATH_MAX];
  plan.go_on = until_two;
  assert_int_equal(play(NULL, p.good, &plan, &r), HL_OK);
  plan.go_on = NULL;
  picture_of(path, p.out, 2, "");
  put_text(path, "half a picture");
  picture_of(path, p.out, 3, ".99-0.tmp");
  put_text(path, "x");
  scene_join(path, p.out, "session.json.99-0.tmp");
  put_text(path, "x");
  assert_int_equal(play(NULL, p.good, &plan, &r), HL_OK);
  assert_whole(p.out, NULL);
  assert_int_equal(folder_count(p.out), 2);
  scene_join(path, p.out, "frames");
  assert_int_equal(folder_count(path), SCENE_FRAMES);
  /* a frame on the list that is gone is no small matter */
  hl_ctx ctx = {0};
  picture_of(path, p.out, 1, "");
  assert_int_equal(unlink(path), 0);
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_ERR_IO);
  assert_says(ctx.msg, "is on the list but not in the folder");
}

/* A folder of frames that is a link out of the session is not written to. */
static void test_link_out(void **state)
{
  const place p = make_place(state, "link", NULL, 0);
  const hl_capture_plan plan = scene_plan(p.out);
  hl_capture_result r;
  hl_ctx ctx = {0};
  char link[SCENE_PATH_MAX];
  scene_join(link, p.out, "frames");
  assert_int_equal(mkdir(p.out, 0777), 0);
  assert_int_equal(symlink("../good", link), 0);
  const int before = folder_count(p.good);
  assert_int_equal(play(&ctx, p.good, &plan, &r), HL_ERR_FORMAT);
  assert_says(ctx.msg, "leads out of the session's folder");
  assert_int_equal(folder_count(p.good), before);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_resume_must_agree),
      cmocka_unit_test(test_other_device_and_pixels),
      cmocka_unit_test(test_camera_of_other_size),
      cmocka_unit_test(test_full_disk),
      cmocka_unit_test(test_read_only),
      cmocka_unit_test(test_two_at_once),
      cmocka_unit_test(test_left_over),
      cmocka_unit_test(test_link_out),
  };
  return cmocka_run_group_tests(tests, folder_new, tree_free);
}
