/* CAMERA.json as it should be, read and written, and every way it should not. */
#include "camera_texts.h"

#define HEAD "{\"format\":\"halflight-camera\",\"version\":1,\"model\":\"pinhole\","
#define SIZE "\"width\":640,\"height\":480,"
#define LENS "\"fx\":1400,\"fy\":1401.5,\"cx\":319.5,\"cy\":239.5,"
#define NONE "\"distortion\":[-0.1,0.02,0.001,-0.002,0]"

static hl_status read_text(void **state, const char *text, hl_ctx *ctx, hl_camera *out)
{
  char path[TEST_PATH_MAX];
  path_in(state, "camera.json", path);
  put_text(path, text);
  return hl_camera_read(ctx, path, out);
}

static void test_read_what_is_needed(void **state)
{
  hl_camera c;
  hl_ctx ctx = {0};
  assert_int_equal(read_text(state, HEAD SIZE LENS NONE "}", &ctx, &c), HL_OK);
  assert_int_equal(c.model, HL_LENS_PINHOLE);
  assert_int_equal(c.width, 640);
  assert_int_equal(c.height, 480);
  assert_near(c.fx, 1400, 0);
  assert_near(c.fy, 1401.5, 0);
  assert_near(c.cx, 319.5, 0);
  assert_near(c.cy, 239.5, 0);
  assert_int_equal(c.n_distortion, 5);
  assert_near(c.distortion[0], -0.1, 0);
  assert_near(c.distortion[3], -0.002, 0);
  assert_false(c.has_covariance);
  assert_near(c.rms_px, 0, 0);
  assert_int_equal(c.observations, 0);
}

/* 9 x 9, diagonal 1..9 with one correlated pair (0, 2). */
static void covariance_text(char *text, size_t room, double pair, double mirrored)
{
  size_t n = (size_t)snprintf(text, room, HEAD SIZE LENS NONE ",\"covariance\":[");
  for (int i = 0; i < 9; i++)
    for (int k = 0; k < 9; k++) {
      const double value = i == k             ? i + 1
                           : i == 0 && k == 2 ? pair
                           : i == 2 && k == 0 ? mirrored
                                              : 0;
      n += (size_t)snprintf(text + n, room - n, "%s%g%s", k == 0 ? (i == 0 ? "[" : ",[") : ",",
                            value, k == 8 ? "]" : "");
    }
  snprintf(text + n, room - n, "],\"rms_px\":0.25,\"observations\":1200,\"made_by\":\"a test\"}");
}

static void test_read_what_is_optional(void **state)
{
  char text[2048];
  covariance_text(text, sizeof text, 0.5, 0.5);
  hl_camera c;
  assert_int_equal(read_text(state, text, NULL, &c), HL_OK);
  assert_true(c.has_covariance);
  assert_near(c.covariance[0], 1, 0);
  assert_near(c.covariance[2], 0.5, 0);
  assert_near(c.covariance[18], 0.5, 0);
  assert_near(c.covariance[80], 9, 0);
  assert_near(c.rms_px, 0.25, 0);
  assert_int_equal(c.observations, 1200);
}

static void test_read_takes_null_for_absent(void **state)
{
  hl_camera c;
  assert_int_equal(read_text(state,
                             HEAD SIZE LENS NONE
                             ",\"covariance\":null,\"rms_px\":null,\"observations\":null}",
                             NULL, &c),
                   HL_OK);
  assert_false(c.has_covariance);
}

static void refused(void **state, const char *text, const char *part)
{
  hl_ctx ctx = {0};
  hl_camera c;
  hl_camera before;
  memset(&c, 0x5a, sizeof c);
  before = c;
  assert_int_equal(read_text(state, text, &ctx, &c), HL_ERR_FORMAT);
  assert_says(ctx.msg, part);
  assert_says(ctx.msg, "camera.json: ");
  assert_memory_equal(&c, &before, sizeof c);
}

static void test_read_refuses_what_is_no_covariance(void **state)
{
  char text[2048];
  covariance_text(text, sizeof text, 0.5, 0.4);
  refused(state, text, "covariance is no covariance; a symmetric 9 x 9 matrix");
  covariance_text(text, sizeof text, 1.8, 1.8); /* > sqrt(1 * 3) */
  refused(state, text, "covariance is no covariance");
  refused(state, HEAD SIZE LENS NONE ",\"covariance\":[1,2]}",
          "covariance = [1,2]; 9 rows of 9 numbers is needed");
}

static void test_read_refuses_members(void **state)
{
  refused(state, HEAD SIZE "\"fx\":0,\"fy\":1,\"cx\":1,\"cy\":1," NONE "}",
          "fx = 0; a number in [0.64, 1e+07] is needed");
  refused(state, HEAD SIZE "\"fx\":NaN,\"fy\":1,\"cx\":1,\"cy\":1," NONE "}", "NaN is not JSON");
  refused(state, HEAD SIZE "\"fx\":1400,\"fy\":1400,\"cx\":null,\"cy\":1," NONE "}",
          "cx = null; a number in [-640, 1280] is needed");
  refused(state, HEAD SIZE "\"fx\":1400,\"fy\":1400,\"cy\":1," NONE "}", "cx is missing");
  refused(state, HEAD "\"width\":\"640\",\"height\":480," LENS NONE "}",
          "width = \"640\"; a whole number in [2, 65536] is needed");
  refused(state, HEAD "\"width\":640.5,\"height\":480," LENS NONE "}", "width = 640.5");
  refused(state, HEAD "\"width\":1e99,\"height\":480," LENS NONE "}",
          "width = 1e99; a whole number");
  refused(state, HEAD SIZE LENS "\"distortion\":[1,2,3,4]}",
          "distortion = [1,2,3,4]; an array of 5 numbers is needed");
  refused(state, HEAD SIZE LENS "\"distortion\":[0,0,\"0\",0,0]}",
          "distortion[2] = \"0\"; a finite number is needed");
  refused(state, HEAD SIZE LENS "\"distortion\":[400,0,0,0,0]}", "distortion = [400, 0, ...]");
  refused(state, HEAD SIZE LENS NONE ",\"rms_px\":-1}", "rms_px = -1");
  refused(state, HEAD SIZE LENS NONE ",\"observations\":1.5}", "observations = 1.5");
  refused(state, "{\"format\":\"halflight-camera\",\"version\":1,\"model\":\"pinhol\"}",
          "model = 'pinhol' is none of: pinhole");
  refused(state, "{\"format\":\"halflight-camera\",\"version\":1,\"model\":3}",
          "model = 3; a text is needed");
}

/* Other programs' members, such as a calibration's views, are none of the camera's business. */
static void test_read_ignores_other_members(void **state)
{
  hl_camera c;
  assert_int_equal(read_text(state,
                             HEAD SIZE LENS NONE ",\"views\":[{\"name\":\"a\"}],\"target\":null}",
                             NULL, &c),
                   HL_OK);
  assert_near(c.fx, 1400, 0);
}

static void test_read_takes_each_model(void **state)
{
  hl_camera c;
  assert_int_equal(
      read_text(state,
                "{\"format\":\"halflight-camera\",\"version\":1,\"model\":\"fisheye\"," SIZE LENS
                "\"distortion\":[0.1,0.02,0.003,0.0004]}",
                NULL, &c),
      HL_OK);
  assert_int_equal(c.model, HL_LENS_FISHEYE);
  assert_int_equal(c.n_distortion, 4);
  assert_near(c.distortion[3], 0.0004, 0);
  assert_int_equal(
      read_text(state,
                "{\"format\":\"halflight-camera\",\"version\":1,\"model\":\"rational\"," SIZE LENS
                "\"distortion\":[0.4,-0.1,0.001,0.002,0.03,0.35,-0.06,0.02]}",
                NULL, &c),
      HL_OK);
  assert_int_equal(c.model, HL_LENS_RATIONAL);
  assert_int_equal(c.n_distortion, 8);
  assert_near(c.distortion[7], 0.02, 0);
  refused(state,
          "{\"format\":\"halflight-camera\",\"version\":1,\"model\":\"fisheye\"," SIZE LENS NONE
          "}",
          "distortion = [-0.1,0.02,0.001,-0.002,0]; an array of 4 numbers is needed");
}

/* ---- written */

/* A covariance whose every number has a long text. */
static hl_camera with_covariance(const hl_camera *sample)
{
  hl_camera c = *sample;
  const int n = hl_camera_intrinsics_count(&c);
  c.has_covariance = true;
  c.rms_px = 0.1 / 3;
  c.observations = 12345;
  for (int i = 0; i < n; i++)
    for (int k = 0; k < n; k++)
      c.covariance[i * n + k] = (i == k ? 1 : 0.5 / (1 + abs(i - k))) * pow(10, -i - k) / 3;
  return c;
}

static void test_written_is_read_again(void **state)
{
  for (int i = 0; i < N_CAMERA_SAMPLES; i++) {
    camera_round_trip(state, &camera_samples[i], HL_CAMERA_JSON);
    const hl_camera c = with_covariance(&camera_samples[i]);
    const size_t n = (size_t)hl_camera_intrinsics_count(&c);
    camera_round_trip(state, &c, HL_CAMERA_JSON);
    char *text = text_of_camera(&c, HL_CAMERA_JSON);
    const hl_camera back = camera_of_text(state, text);
    assert_true(back.has_covariance);
    assert_memory_equal(back.covariance, c.covariance, n * n * sizeof(double));
    assert_near(back.rms_px, c.rms_px, 0);
    assert_int_equal(back.observations, 12345);
    free(text);
  }
}

static void test_written_to_a_file(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "written.json", path);
  const hl_camera c = with_covariance(&camera_samples[SAMPLE_FISHEYE]);
  hl_camera back;
  assert_int_equal(hl_camera_write(NULL, path, &c), HL_OK);
  assert_int_equal(hl_camera_read(NULL, path, &back), HL_OK);
  same_intrinsics(&c, &back);
  hl_ctx ctx = {0};
  path_in(state, "nowhere/written.json", path);
  assert_int_equal(hl_camera_write(&ctx, path, &c), HL_ERR_IO);
  assert_says(ctx.msg, "nowhere/written.json: cannot create: ");
}

static void test_what_is_not_stated_is_not_written(void **state)
{
  (void)state;
  const hl_camera c = {.width = 640,
                       .height = 480,
                       .fx = 800,
                       .fy = 801.5,
                       .cx = 320,
                       .cy = 239.5,
                       .n_distortion = 5,
                       .distortion = {-0.5, 0.25}};
  char *text = text_of_camera(&c, HL_CAMERA_JSON);
  assert_string_equal(text, "{\n \"format\": \"halflight-camera\",\n \"version\": 1,\n"
                            " \"model\": \"pinhole\",\n \"width\": 640,\n \"height\": 480,\n"
                            " \"fx\": 800.0,\n \"fy\": 801.5,\n \"cx\": 320.0,\n \"cy\": 239.5,\n"
                            " \"distortion\": [-0.5, 0.25, 0.0, 0.0, 0.0]\n}\n");
  free(text);
}

static void test_what_could_not_be_read_is_not_written(void **state)
{
  (void)state;
  hl_camera c = with_covariance(&camera_samples[SAMPLE_PINHOLE]);
  c.covariance[1] *= 3;
  camera_not_written(&c, HL_CAMERA_JSON, "covariance is no covariance; a symmetric 9 x 9 matrix");
  c = with_covariance(&camera_samples[SAMPLE_PINHOLE]);
  c.covariance[0] = NAN;
  camera_not_written(&c, HL_CAMERA_JSON, "covariance is no covariance");
  c = with_covariance(&camera_samples[SAMPLE_PINHOLE]);
  c.rms_px = NAN;
  camera_not_written(&c, HL_CAMERA_JSON, "rms_px = nan is outside");
  c.rms_px = -1;
  camera_not_written(&c, HL_CAMERA_JSON, "rms_px = -1 is outside");
  c.rms_px = 1;
  c.observations = -3;
  camera_not_written(&c, HL_CAMERA_JSON, "observations = -3 is outside");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_read_what_is_needed),
      cmocka_unit_test(test_read_what_is_optional),
      cmocka_unit_test(test_read_takes_null_for_absent),
      cmocka_unit_test(test_read_refuses_what_is_no_covariance),
      cmocka_unit_test(test_read_refuses_members),
      cmocka_unit_test(test_read_ignores_other_members),
      cmocka_unit_test(test_read_takes_each_model),
      cmocka_unit_test(test_written_is_read_again),
      cmocka_unit_test(test_written_to_a_file),
      cmocka_unit_test(test_what_is_not_stated_is_not_written),
      cmocka_unit_test(test_what_could_not_be_read_is_not_written),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
