/* session.json: there and back, and what is refused. */
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "files.h"
#include "halflight/session.h"

#define HEAD "{\"format\":\"halflight-session\",\"version\":1,"
#define SUM "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"

static hl_status read_text(void **state, const char *text, hl_ctx *ctx, hl_session *out)
{
  char path[TEST_PATH_MAX];
  path_in(state, "session.json", path);
  put_text(path, text);
  return hl_session_read(ctx, *state, out);
}

static void test_read_least(void **state)
{
  hl_session s;
  assert_int_equal(read_text(state, HEAD "\"frames\":[]}", NULL, &s), HL_OK);
  assert_int_equal(s.n, 0);
  assert_string_equal(s.camera, "");
  assert_string_equal(s.folder, *state);
  assert_int_equal(s.n_balls, 1);
  assert_null(s.ball[0].sphere);
  assert_int_equal(s.frame_settings.transfer, HL_TRANSFER_AUTO);
  assert_int_equal(s.pixels, HL_PIXELS_UNSTATED);
  assert_true(s.locked.focus_dioptre < 0);
  hl_session_free(&s);
}

static const char everything[] = HEAD
    "\"camera\":\"camera.json\",\"sphere\":null,\"radius_m\":0.025,\"circle_px\":[10,20,5],"
    "\"balls\":[{\"sphere\":\"b/sphere.json\"},{\"radius_m\":0.01}],\"transfer\":\"gamma\","
    "\"gamma\":1.8,\"black\":0.0625,\"saturation\":0.9,\"device\":\"/base/soc/i2c0mux/imx477@1a\","
    "\"pixels\":\"raw-green\",\"size_px\":[640,480],\"locked\":{\"exposure_us\":5000,\"gain\":1.5,"
    "\"white_balance\":[1.25,2.5],\"frame_duration_us\":33333,\"focus_dioptre\":0},"
    "\"frames\":[{\"file\":\"frames/0000.png\",\"label\":\"L00\",\"timestamp_ns\":9007199254740993,"
    "\"exposure_us\":5000.5,\"gain\":1.5,\"digital_gain\":1,\"white_balance\":[1.25,2.5],"
    "\"sha256\":\"" SUM "\"},{\"file\":\"frames/0001.png\",\"untrusted\":\"no white balance\"}],"
    "\"faults\":[{\"frame\":1,\"kind\":\"failed-read\"},{\"frame\":3,\"kind\":\"slow-lock\"}]}";

static void check_everything(const hl_session *s)
{
  assert_string_equal(s->camera, "camera.json");
  assert_int_equal(s->n_balls, 3);
  assert_null(s->ball[0].sphere);
  assert_near(s->ball[0].radius_m, 0.025, 0);
  assert_near(s->ball[0].circle_px[1], 20, 0);
  assert_string_equal(s->ball[1].sphere, "b/sphere.json");
  assert_near(s->ball[2].radius_m, 0.01, 0);
  assert_int_equal(s->frame_settings.transfer, HL_TRANSFER_GAMMA);
  assert_near(s->frame_settings.gamma, 1.8, 0);
  assert_near(s->frame_settings.black, 0.0625, 0);
  assert_near(s->frame_settings.saturation, 0.9, 0);
  assert_string_equal(s->device, "/base/soc/i2c0mux/imx477@1a");
  assert_int_equal(s->pixels, HL_PIXELS_RAW_GREEN);
  assert_int_equal(s->size_px[0], 640);
  assert_int_equal(s->size_px[1], 480);
  assert_near(s->locked.exposure_us, 5000, 0);
  assert_near(s->locked.white_balance[1], 2.5, 0);
  assert_near(s->locked.frame_duration_us, 33333, 0);
  assert_near(s->locked.focus_dioptre, 0, 0);
  assert_int_equal(s->n, 2);
  assert_string_equal(s->frame[0].label, "L00");
  assert_true(s->frame[0].timestamp_ns == INT64_C(9007199254740993)); /* 2^53 + 1 */
  assert_near(s->frame[0].exposure_us, 5000.5, 0);
  assert_near(s->frame[0].digital_gain, 1, 0);
  assert_near(s->frame[0].white_balance[0], 1.25, 0);
  assert_string_equal(s->frame[0].sha256, SUM);
  assert_string_equal(s->frame[1].label, "");
  assert_string_equal(s->frame[1].sha256, "");
  assert_string_equal(s->frame[1].untrusted, "no white balance");
  assert_int_equal(s->n_faults, 2);
  assert_int_equal(s->fault[0].frame, 1);
  assert_int_equal(s->fault[0].kind, HL_FAULT_FAILED_READ);
  assert_int_equal(s->fault[1].kind, HL_FAULT_SLOW_LOCK);
}

static void test_there_and_back(void **state)
{
  hl_session s;
  hl_session back;
  char *first = NULL;
  char *second = NULL;
  assert_int_equal(read_text(state, everything, NULL, &s), HL_OK);
  check_everything(&s);
  assert_int_equal(hl_session_json(NULL, &s, &first), HL_OK);
  assert_int_equal(hl_session_write(NULL, &s), HL_OK);
  assert_int_equal(hl_session_read(NULL, *state, &back), HL_OK);
  check_everything(&back);
  assert_int_equal(hl_session_json(NULL, &back, &second), HL_OK);
  assert_string_equal(first, second);
  free(first);
  free(second);
  hl_session_free(&s);
  hl_session_free(&back);
}

static void test_refused(void **state)
{
  static const struct {
    const char *text, *says;
  } cases[] = {
      {"{\"format\":\"halflight-session\",\"version\":2,\"frames\":[]}",
       "session.json: version = 2 is newer than this program"},
      {"{\"format\":\"halflight-sphere\",\"version\":1,\"frames\":[]}", "'halflight-session'"},
      {HEAD "\"frames\":", "not JSON"},
      {HEAD "\"radius_m\":1}", "frames is no list"},
      {HEAD "\"frames\":[7]}", "frames[0]: file is missing"},
      {HEAD "\"frames\":[{\"file\":\"a\"},{\"file\":\"../a\"}]}",
       "frames[1]: file = \"../a\" is no"},
      {HEAD "\"frames\":[{\"file\":\"/etc/passwd\"}]}", "frames[0]: file = \"/etc/passwd\" is no"},
      {HEAD "\"frames\":[{\"file\":\"etc/passwd\"}]}", "file = \"etc/passwd\" leads out"},
      {HEAD "\"camera\":\"etc/c.json\",\"frames\":[]}", "camera = \"etc/c.json\" leads out"},
      {HEAD "\"sphere\":\"../s\",\"frames\":[]}", "sphere = \"../s\" is no plain path"},
      {HEAD "\"balls\":[{\"sphere\":\"/s\"}],\"frames\":[]}", "balls[0]: sphere = \"/s\""},
      {HEAD "\"frames\":[{\"file\":\"a\"},{\"file\":\"b\"},{\"file\":\"a\"}]}",
       "frames 0 and 2 are the same file, \"a\""},
      {HEAD "\"frames\":[{\"file\":\"a\",\"sha256\":\"12\"}]}", "frames[0]: sha256 = \"12\""},
      {HEAD "\"frames\":[{\"file\":\"a\",\"timestamp_ns\":1.5}]}", "timestamp_ns is no whole"},
      {HEAD "\"frames\":[{\"file\":\"a\",\"gain\":-1}]}", "frames[0]: gain = -1"},
      {HEAD "\"frames\":[{\"file\":\"a\",\"white_balance\":[1]}]}", "white_balance"},
      {HEAD "\"radius_m\":0,\"frames\":[]}", "radius_m = 0"},
      {HEAD "\"pixels\":\"rgb\",\"frames\":[]}", "pixels = \"rgb\"; one of raw-green"},
      {HEAD "\"transfer\":\"log\",\"frames\":[]}", "one of auto, linear, srgb, gamma"},
      {HEAD "\"size_px\":[640,0],\"frames\":[]}", "size_px[1] = 0"},
      {HEAD "\"circle_px\":[1,2,-3],\"frames\":[]}", "circle_px[2] = -3"},
      {HEAD "\"frames\":[],\"faults\":[{\"frame\":0,\"kind\":\"fire\"}]}",
       "faults[0]: kind = \"fire\"; one of dropped"},
      {HEAD "\"balls\":[{},{},{},{},{},{},{},{}],\"frames\":[]}", "up to 7 balls"},
  };
  char link[TEST_PATH_MAX];
  path_in(state, "etc", link);
  assert_int_equal(symlink("/etc", link), 0);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    hl_session s;
    hl_ctx ctx = {0};
    const hl_status st = read_text(state, cases[i].text, &ctx, &s);
    if (st != HL_ERR_FORMAT)
      print_error("%s\n", cases[i].text);
    assert_int_equal(st, HL_ERR_FORMAT);
    assert_says(ctx.msg, cases[i].says);
  }
  unlink(link);
}

static void test_no_folder(void **state)
{
  (void)state;
  hl_session s;
  hl_ctx ctx = {0};
  assert_int_equal(hl_session_read(&ctx, "/nowhere/at/all/", &s), HL_ERR_IO);
  assert_says(ctx.msg, "/nowhere/at/all/session.json: cannot open");
}

/* A disk that takes no more leaves what was there. */
static void test_full_disk(void **state)
{
  char path[TEST_PATH_MAX];
  hl_session s;
  hl_ctx ctx = {0};
  size_t before = 0;
  size_t after = 0;
  path_in(state, "session.json", path);
  assert_int_equal(read_text(state, everything, NULL, &s), HL_OK);
  char *was = get_file(path, &before);
  struct rlimit limit;
  assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
  const struct rlimit none = {.rlim_cur = 100, .rlim_max = limit.rlim_max};
  void (*old)(int) = signal(SIGXFSZ, SIG_IGN);
  assert_int_equal(setrlimit(RLIMIT_FSIZE, &none), 0);
  const hl_status st = hl_session_write(&ctx, &s);
  assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
  signal(SIGXFSZ, old);
  assert_int_equal(st, HL_ERR_IO);
  assert_says(ctx.msg, "session.json: cannot write");
  char *is = get_file(path, &after);
  assert_string_equal(is, was);
  assert_int_equal(folder_count(*state), 1);
  free(was);
  free(is);
  hl_session_free(&s);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_read_least), cmocka_unit_test(test_there_and_back),
      cmocka_unit_test(test_refused),    cmocka_unit_test(test_no_folder),
      cmocka_unit_test(test_full_disk),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
