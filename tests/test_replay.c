/* Replay of sessions that are drawn here: truth of pose, lights and brightness; what is skipped and
 * what is refused; any number of jobs and any interruption, the same bytes. */
#include <sys/stat.h>

#include "ball_scene.h"
#include "files.h"
#include "halflight/export.h"
#include "halflight/replay.h"

enum { LIGHTS = 9 };

#define DEG 57.295779513082320877

static char top[TEST_PATH_MAX];

static void in(const char *name, char path[TEST_PATH_MAX])
{
  snprintf(path, TEST_PATH_MAX, "%.300s/%.100s", top, name);
}

static void light_of(int i, double out[3])
{
  /* the last is near the view, where body and lobe are nearly one curve */
  const double a = i % LIGHTS == LIGHTS - 1 ? 0.03 : 0.45 + 0.09 * (i % 5), t = 2.4 * i;
  out[0] = sin(a) * cos(t);
  out[1] = sin(a) * sin(t);
  out[2] = -cos(a);
}

static double brightness_of(int i)
{
  return i % 3 == 1 ? 0.8 : 1;
}

static ball_scene scene_at(int i)
{
  ball_scene s = scene_of(120, 98, 45);
  light_of(i, s.light);
  s.seed = (unsigned)(100 + i);
  s.noise = 0.0005;
  return s;
}

static void put_frame(const ball_scene *s, double brightness, const char *name)
{
  char path[TEST_PATH_MAX];
  hl_frame f = scene_frame(s);
  for (int i = 0; i < f.width * f.height; i++)
    f.radiance[i] = (float)(brightness * f.radiance[i]);
  in(name, path);
  assert_int_equal(hl_pfm_write(NULL, path, f.radiance, f.width, f.height, 1), HL_OK);
  scene_free(&f);
}

/* Frame 4 is of a ball nudged by half a pixel where `nudged`. */
static void draw(bool nudged)
{
  char path[TEST_PATH_MAX], text[2048];
  for (int i = 0; i < LIGHTS; i++) {
    char name[32];
    ball_scene s = scene_at(i);
    snprintf(name, sizeof name, "f%d.pfm", i);
    if (nudged && i == 4)
      s.ball.center_m[0] += 0.6 * s.ball.center_m[2] / s.camera.fx;
    put_frame(&s, brightness_of(i), name);
  }
  const ball_scene s = scene_at(0);
  in("camera.json", path);
  assert_int_equal(hl_camera_write(NULL, path, &s.camera), HL_OK);
  int at = snprintf(text, sizeof text,
                    "{\"format\":\"halflight-session\",\"version\":1,\"camera\":\"camera.json\","
                    "\"sphere\":null,\"radius_m\":0.025,\"frames\":[");
  for (int i = 0; i < LIGHTS; i++)
    at += snprintf(text + at, sizeof text - (size_t)at,
                   "%s{\"file\":\"f%d.pfm\",\"label\":\"L%d\",\"timestamp_ns\":%d}",
                   i > 0 ? "," : "", i, i, i);
  snprintf(text + at, sizeof text - (size_t)at, "]}");
  in("session.json", path);
  put_file(path, text, strlen(text));
}

static hl_session session(void)
{
  hl_session s;
  hl_ctx ctx = {0};
  if (hl_session_read(&ctx, top, &s) != HL_OK)
    fail_msg("%s", ctx.msg);
  return s;
}

static hl_lights replayed(const char *folder, int jobs, const hl_replay_watch *watch,
                          hl_replay_summary *summary)
{
  hl_session s = session();
  hl_replay_settings settings = hl_replay_defaults();
  hl_lights out;
  hl_ctx ctx = {0};
  settings.jobs = jobs;
  settings.light.lobe = HL_LOBE_PLAIN;
  if (hl_replay(&ctx, &s, folder, &settings, watch, summary, &out) != HL_OK)
    fail_msg("%s", ctx.msg);
  hl_session_free(&s);
  return out;
}

static double error_deg(const hl_rig_light *l)
{
  double truth[3];
  light_of(l->frame, truth);
  return DEG * hl_angle(truth, l->direction);
}

static void remove_tree(const char *folder)
{
  char command[TEST_PATH_MAX + 32];
  snprintf(command, sizeof command, "rm -rf '%s'", folder);
  assert_int_equal(system(command), 0);
}

static char *lights_text(const hl_lights *l)
{
  char *text = NULL;
  assert_int_equal(hl_lights_json(NULL, l, &text), HL_OK);
  return text;
}

static void test_truth_and_names(void **state)
{
  (void)state;
  draw(false);
  hl_lights l = replayed(NULL, 2, NULL, NULL);
  const ball_scene s = scene_at(0);
  double center, radius;
  scene_error(&s, &l.ball[0], &center, &radius);
  assert_true(center < 0.02 && radius < 0.02);
  assert_int_equal(l.n, LIGHTS);
  for (int i = 0; i < LIGHTS; i++) {
    char label[16];
    snprintf(label, sizeof label, "L%d", i);
    assert_string_equal(l.light[i].label, label);
    assert_int_equal(l.light[i].frame, i);
    assert_true(l.light[i].found);
    assert_true(error_deg(&l.light[i]) < 0.1);
    const double median = 1; /* six of nine are at full brightness */
    assert_near(l.light[i].intensity[0], brightness_of(i) / median, 0.02);
  }
  hl_lights_free(&l);
}

static void test_moved_frame_is_named(void **state)
{
  (void)state;
  draw(true);
  hl_lights l = replayed(NULL, 2, NULL, NULL);
  assert_false(l.trusted);
  for (int i = 0; i < LIGHTS; i++) {
    bool moved = false;
    for (int k = 0; k < l.light[i].reasons.n; k++)
      moved = moved || strcmp(l.light[i].reasons.note[k].what, "moved") == 0;
    assert_int_equal(moved, i == 4);
    assert_true(error_deg(&l.light[i]) < 0.1); /* by its own pose */
  }
  assert_string_equal(l.reasons.note[0].what, "moved");
  assert_says(l.reasons.note[0].why, "1 of 9 frames show the ball or the camera elsewhere: f4.pfm");
  hl_lights_free(&l);
}

static void test_bad_frames_are_skipped(void **state)
{
  (void)state;
  char path[TEST_PATH_MAX];
  draw(false);
  in("f2.pfm", path);
  put_file(path, "Pf\n240 2", 8);
  in("f5.pfm", path);
  assert_int_equal(unlink(path), 0);
  in("f7.pfm", path);
  const float small[4] = {0};
  assert_int_equal(hl_pfm_write(NULL, path, small, 2, 2, 1), HL_OK);
  hl_replay_summary summary;
  hl_lights l = replayed(NULL, 1, NULL, &summary);
  assert_int_equal(summary.n_failed, 3);
  for (int i = 0; i < LIGHTS; i++)
    assert_int_equal(l.light[i].found, i != 2 && i != 5 && i != 7);
  assert_says(l.light[5].reasons.note[0].why, "f5.pfm");
  assert_says(l.light[7].reasons.note[0].why, "the frame has 2 x 2 px, the camera 240 x 200");
  assert_says(l.reasons.note[0].why, "3 of 9 frames gave no light: f2.pfm, f5.pfm, f7.pfm");
  hl_lights_free(&l);
}

/* Two balls in one frame: the right half of each frame is another scene's. What each ball has to itself
 * is found where it is, and the light, which both saw, is of the surer one. */
static void draw_two(ball_scene two[2])
{
  char path[TEST_PATH_MAX], text[2048];
  two[0] = scene_of(62, 98, 40);
  two[1] = scene_of(178, 104, 44);
  for (int i = 0; i < LIGHTS; i++) {
    char name[32];
    hl_frame f[2];
    for (int b = 0; b < 2; b++) {
      light_of(i, two[b].light);
      two[b].seed = (unsigned)(300 + 2 * i + b);
      two[b].noise = 0.0005;
      f[b] = scene_frame(&two[b]);
    }
    for (int at = 0; at < f[0].width * f[0].height; at++)
      if (at % f[0].width >= f[0].width / 2)
        f[0].radiance[at] = f[1].radiance[at];
    snprintf(name, sizeof name, "f%d.pfm", i);
    in(name, path);
    assert_int_equal(hl_pfm_write(NULL, path, f[0].radiance, f[0].width, f[0].height, 1), HL_OK);
    scene_free(&f[0]);
    scene_free(&f[1]);
  }
  in("camera.json", path);
  assert_int_equal(hl_camera_write(NULL, path, &two[0].camera), HL_OK);
  int at = snprintf(text, sizeof text,
                    "{\"format\":\"halflight-session\",\"version\":1,\"camera\":\"camera.json\","
                    "\"radius_m\":0.025,\"circle_px\":[62,98,40],"
                    "\"balls\":[{\"radius_m\":0.025,\"circle_px\":[178,104,44]}],\"frames\":[");
  for (int i = 0; i < LIGHTS; i++)
    at += snprintf(text + at, sizeof text - (size_t)at, "%s{\"file\":\"f%d.pfm\"}",
                   i > 0 ? "," : "", i);
  snprintf(text + at, sizeof text - (size_t)at, "]}");
  in("session.json", path);
  put_file(path, text, strlen(text));
}

static void test_two_balls(void **state)
{
  (void)state;
  char one[TEST_PATH_MAX];
  ball_scene two[2];
  draw_two(two);
  in("out4", one);
  hl_replay_summary summary;
  hl_lights l = replayed(one, 2, NULL, &summary);
  assert_int_equal(l.n_balls, 2);
  for (int b = 0; b < 2; b++) {
    double center, radius;
    scene_error(&two[b], &l.ball[b], &center, &radius);
    assert_true(center < 0.03 && radius < 0.03);
  }
  for (int i = 0; i < LIGHTS; i++) {
    assert_true(l.light[i].found);
    assert_in_range(l.light[i].ball, 0, 1);
    assert_true(error_deg(&l.light[i]) < 0.1);
  }
  hl_lights again = replayed(one, 1, NULL, &summary); /* as they were kept */
  assert_int_equal(summary.n_reused, LIGHTS);
  char *a = lights_text(&l), *b = lights_text(&again);
  assert_string_equal(a, b);
  free(a);
  free(b);
  hl_lights_free(&l);
  hl_lights_free(&again);
  remove_tree(one);
}

static bool stop_after_three(void *user)
{
  int *calls = user;
  return ++*calls > LIGHTS + 4; /* the outlines first */
}

static void test_same_for_jobs_and_resume(void **state)
{
  (void)state;
  char one[TEST_PATH_MAX], two[TEST_PATH_MAX], command[2 * TEST_PATH_MAX + 32];
  draw(false);
  in("out1", one);
  in("out2", two);
  hl_replay_summary summary;
  hl_lights whole = replayed(one, 1, NULL, &summary);
  assert_int_equal(summary.n_reused, 0);
  int calls = 0;
  const hl_replay_watch watch = {NULL, stop_after_three, &calls};
  hl_lights none = replayed(two, 2, &watch, &summary);
  assert_true(summary.stopped);
  assert_int_equal(none.n, 0);
  hl_lights rest = replayed(two, 2, NULL, &summary);
  assert_in_range(summary.n_reused, 1, LIGHTS - 1);
  char *a = lights_text(&whole), *b = lights_text(&rest);
  assert_string_equal(a, b);
  snprintf(command, sizeof command, "diff -r '%s' '%s'", one, two);
  assert_int_equal(system(command), 0);
  free(a);
  free(b);
  hl_lights_free(&whole);
  hl_lights_free(&rest);
  remove_tree(one);
  remove_tree(two);
}

static void test_changed_frame_is_done_anew(void **state)
{
  (void)state;
  char out[TEST_PATH_MAX], path[TEST_PATH_MAX];
  draw(false);
  in("out3", out);
  hl_replay_summary summary;
  hl_replay_settings settings = hl_replay_defaults();
  settings.light.lobe = HL_LOBE_PLAIN;
  hl_lights l = replayed(out, 2, NULL, &summary);
  hl_lights_free(&l);
  snprintf(path, sizeof path, "%.400s/frames/00003.json", out);
  put_file(path, "{\"format\":", 10);
  l = replayed(out, 2, NULL, &summary);
  assert_int_equal(summary.n_reused, LIGHTS - 1);
  hl_lights_free(&l);
  settings.light.outlier_sigmas = 9;
  hl_session s = session();
  assert_int_equal(hl_replay(NULL, &s, out, &settings, NULL, &summary, &l), HL_OK);
  assert_int_equal(summary.n_reused, 0);
  hl_lights_free(&l);
  hl_session_free(&s);
  remove_tree(out);
}

static char *text_in(const char *folder, const char *name)
{
  char path[TEST_PATH_MAX];
  size_t n;
  snprintf(path, sizeof path, "%.300s/%.100s", folder, name);
  return get_file(path, &n);
}

/* Twice the lights in two files each: a session long enough for its kind of lobe to be told from a sample. */
static void test_the_kind_of_a_sample(void **state)
{
  (void)state;
  char path[TEST_PATH_MAX], link_path[TEST_PATH_MAX], one[TEST_PATH_MAX], two[TEST_PATH_MAX];
  char text[2048];
  draw(false);
  int at = snprintf(text, sizeof text,
                    "{\"format\":\"halflight-session\",\"version\":1,\"camera\":\"camera.json\","
                    "\"sphere\":null,\"radius_m\":0.025,\"frames\":[");
  for (int i = 0; i < 2 * LIGHTS; i++) {
    char name[32];
    snprintf(name, sizeof name, "f%d.pfm", i % LIGHTS);
    in(name, path);
    snprintf(name, sizeof name, "g%d.pfm", i);
    in(name, link_path);
    assert_int_equal(link(path, link_path), 0);
    at += snprintf(text + at, sizeof text - (size_t)at, "%s{\"file\":\"%s\"}", i > 0 ? "," : "",
                   name);
  }
  snprintf(text + at, sizeof text - (size_t)at, "]}");
  in("session.json", path);
  put_file(path, text, strlen(text));
  in("kind1", one);
  in("kind2", two);
  hl_session s = session();
  hl_replay_settings settings = hl_replay_defaults();
  hl_lights a, b;
  settings.jobs = 1;
  assert_int_equal(hl_replay(NULL, &s, one, &settings, NULL, NULL, &a), HL_OK);
  settings.jobs = 2;
  assert_int_equal(hl_replay(NULL, &s, two, &settings, NULL, NULL, &b), HL_OK);
  for (int i = 0; i < 2 * LIGHTS; i++) {
    a.light[i].frame %= LIGHTS;
    assert_true(error_deg(&a.light[i]) < 0.1);
    assert_near(a.light[i].intensity[0], brightness_of(i % LIGHTS), 0.02);
    a.light[i].frame = i;
  }
  char *first = text_in(one, "frames/00003.json"), *second = text_in(two, "frames/00003.json");
  assert_non_null(strstr(first, "not tried: a sample of the session's frames does without"));
  assert_string_equal(first, second);
  free(first);
  free(second);
  first = lights_text(&a);
  second = lights_text(&b);
  assert_string_equal(first, second);
  free(first);
  free(second);
  hl_lights_free(&a);
  hl_lights_free(&b);
  hl_session_free(&s);
  remove_tree(one);
  remove_tree(two);
  for (int i = 0; i < 2 * LIGHTS; i++) {
    snprintf(text, sizeof text, "g%d.pfm", i);
    in(text, path);
    unlink(path);
  }
}

static void refused(const char *text, const char *folder, hl_status status, const char *part)
{
  char path[TEST_PATH_MAX];
  in("session.json", path);
  put_file(path, text, strlen(text));
  hl_session s = session();
  hl_lights l;
  hl_ctx ctx = {0};
  assert_int_equal(hl_replay(&ctx, &s, folder, NULL, NULL, NULL, &l), status);
  assert_says(ctx.msg, part);
  assert_null(l.light);
  hl_session_free(&s);
}

#define HEAD "{\"format\":\"halflight-session\",\"version\":1,\"camera\":\"camera.json\","

static void test_refusals(void **state)
{
  (void)state;
  char path[TEST_PATH_MAX];
  draw(false);
  refused(HEAD "\"radius_m\":0.025,\"frames\":[]}", NULL, HL_ERR_FORMAT,
          "the session has no frames; at least 1 is needed");
  refused(HEAD "\"radius_m\":0.025,\"frames\":[{\"file\":\"none.pfm\"}]}", NULL, HL_ERR_DEGENERATE,
          "no frame shows ball 0; the first:");
  refused(HEAD "\"frames\":[{\"file\":\"f1.pfm\"}]}", NULL, HL_ERR_FORMAT,
          "ball 0 has neither sphere nor radius_m");
  refused(HEAD "\"radius_m\":0.025,\"frames\":[{\"file\":\"f1.pfm\"}]}", "/proc/none", HL_ERR_IO,
          "/proc/none: cannot make the folder");
  in("camera.json", path);
  assert_int_equal(unlink(path), 0);
  refused(HEAD "\"radius_m\":0.025,\"frames\":[{\"file\":\"f1.pfm\"}]}", NULL, HL_ERR_IO,
          "camera.json");
}

static int begin(void **state)
{
  (void)state;
  snprintf(top, sizeof top, "/tmp/halflight-replay-XXXXXX");
  return mkdtemp(top) ? 0 : -1;
}

static int end(void **state)
{
  (void)state;
  remove_tree(top);
  return 0;
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_truth_and_names),
      cmocka_unit_test(test_moved_frame_is_named),
      cmocka_unit_test(test_bad_frames_are_skipped),
      cmocka_unit_test(test_two_balls),
      cmocka_unit_test(test_same_for_jobs_and_resume),
      cmocka_unit_test(test_changed_frame_is_done_anew),
      cmocka_unit_test(test_the_kind_of_a_sample),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, begin, end);
}
