/* Which format a camera file is in, and what is common to all. */
#include "../src/camera_file.h"
#include "camera_texts.h"

static void test_names(void **state)
{
  (void)state;
  assert_string_equal(hl_camera_format_name(HL_CAMERA_JSON), "json");
  assert_string_equal(hl_camera_format_name(HL_CAMERA_OPENCV), "opencv");
  assert_string_equal(hl_camera_format_name(HL_CAMERA_KALIBR), "kalibr");
  assert_string_equal(hl_camera_format_name(HL_CAMERA_MRCAL), "mrcal");
  assert_null(hl_camera_format_name(4));
  assert_null(hl_camera_format_name(-1));
}

#define JSON                                                                                       \
  "\"format\":\"halflight-camera\",\"version\":1,\"model\":\"pinhole\",\"width\":640,"             \
  "\"height\":480,\"fx\":1400,\"fy\":1401,\"cx\":320,\"cy\":240,\"distortion\":[0,0,0,0,0]"
#define MRCAL                                                                                      \
  "'lensmodel':'LENSMODEL_PINHOLE','intrinsics':[1400,1401,320,240],'imagersize':[640,480]"
#define OPENCV                                                                                     \
  "image_width: 640, image_height: 480, "                                                          \
  "camera_matrix: {rows: 3, cols: 3, data: [1400, 0, 320, 0, 1401, 240, 0, 0, 1]}, "               \
  "distortion_coefficients: {rows: 1, cols: 4, data: [0, 0, 0, 0]}"
#define KALIBR                                                                                     \
  "cam0: {camera_model: pinhole, intrinsics: [1400, 1401, 320, 240], distortion_model: none, "     \
  "resolution: [640, 480]}"

static void test_told_apart_by_content(void **state)
{
  static const char *const texts[] = {
      "{" JSON "}",
      " \n\t{ \n" JSON "}\n",
      "{" MRCAL "}",
      "\n# a note\n # and more\n{\n" MRCAL "}",
      "{# inside\n" MRCAL "}",
      "{\"lensmodel\":\"LENSMODEL_PINHOLE\",\"intrinsics\":[1400,1401,320,240],\"imagersize\":[640,"
      "480]}",
      "# a note\n{\"lensmodel\":\"LENSMODEL_PINHOLE\",'intrinsics':[1400,1401,320,240],"
      "'imagersize':[640,480]}",
      "---\n{" OPENCV "}\n",
      "%YAML 1.2\n---\n{" OPENCV "}\n",
      "--- {" KALIBR "}\n",
      "# a note\n" KALIBR "\n",
      KALIBR,
  };
  for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
    const hl_camera c = camera_of_text(state, texts[i]);
    assert_near(c.fx, 1400, 0);
    assert_near(c.cy, 240, 0);
    assert_int_equal(c.height, 480);
    assert_int_equal(c.n_distortion, 5);
  }
}

static void test_what_is_none_of_them(void **state)
{
  camera_text_refused(state, "fx = 400", "no camera is known in it: not JSON, no camera_matrix");
  camera_text_refused(state, "fx: 400\nfy: 400\n", "no camera is known in it");
  camera_text_refused(state, "camera: {}\ncamx: 3\ncam: 1\n", "no camera is known in it");
  camera_text_refused(state, "\x89PNG\r\n\x1a\n", "neither JSON nor YAML");
  camera_text_refused(state, "[1, 2]", "not a JSON object; one of format 'halflight-camera'");
  camera_text_refused(state, "{\"a\": 1}", "format is missing");
  camera_text_refused(state, "{\"a\": 1,", "line 1: not JSON");
  camera_text_refused(state, "{", "line 1: not JSON");
  camera_text_refused(state, "{'a': 1}", "lensmodel is missing");
  camera_text_refused(state, "#", "nothing is in it");
  camera_text_refused(state, "\xef\xbb\xbf{" JSON "}", "no camera is known in it: not JSON");
}

/* Every format says the same of a lens that is none. */
static void test_check_follows_whatever_the_format(void **state)
{
  camera_text_refused(state,
                      "{'lensmodel':'LENSMODEL_OPENCV4','intrinsics':[1400,1400,320,240,400,0,0,"
                      "0],'imagersize':[640,480]}",
                      "distortion = [400, 0, ...] stretches the image");
  camera_text_refused(state,
                      "cam0: {camera_model: pinhole, intrinsics: [1400, 1401, 320, 240], "
                      "distortion_model: radtan, distortion_coeffs: [400, 0, 0, 0], "
                      "resolution: [640, 480]}",
                      "cam0: distortion = [400, 0, ...] stretches the image");
}

static void test_large_files(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "camera", path);
  enum { LARGE = (16 << 20) + 100 };
  char *bytes = malloc(LARGE);
  assert_non_null(bytes);
  memset(bytes, ' ', LARGE);
  bytes[0] = 'a';
  bytes[1] = ':';
  put_file(path, bytes, LARGE);
  free(bytes);
  hl_ctx ctx = {0};
  hl_camera c;
  assert_int_equal(hl_camera_read(&ctx, path, &c), HL_ERR_FORMAT);
  assert_says(ctx.msg, "over 16777216 bytes, the largest YAML accepted");
  assert_int_equal(truncate(path, (64 << 20) + 1), 0);
  assert_int_equal(hl_camera_read(&ctx, path, &c), HL_ERR_FORMAT);
  assert_says(ctx.msg, "over 67108864 bytes, the largest accepted");
}

static void test_missing_file(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "nowhere.yml", path);
  hl_ctx ctx = {0};
  hl_camera c;
  assert_int_equal(hl_camera_read(&ctx, path, &c), HL_ERR_IO);
  assert_says(ctx.msg, "nowhere.yml: cannot open: ");
}

/* Those who read more of a CAMERA.json get its document, of others none. */
static void test_document(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "camera", path);
  hl_camera c;
  json_t *document = NULL;
  put_text(path, "{" JSON ",\"views\":[1,2,3]}");
  assert_int_equal(hl_camera_file_read(NULL, path, &c, &document), HL_OK);
  assert_int_equal(json_array_size(json_object_get(document, "views")), 3);
  json_decref(document);
  document = (json_t *)path;
  put_text(path, KALIBR);
  assert_int_equal(hl_camera_file_read(NULL, path, &c, &document), HL_OK);
  assert_null(document);
  document = (json_t *)path;
  put_text(path, "{" JSON);
  assert_int_equal(hl_camera_file_read(NULL, path, &c, &document), HL_ERR_FORMAT);
  assert_ptr_equal(document, path);
}

static void test_lost_parts(void **state)
{
  (void)state;
  hl_camera c = camera_samples[SAMPLE_PINHOLE];
  for (int f = 0; hl_camera_format_name(f); f++)
    assert_int_equal(hl_camera_lost(&c, (hl_camera_format)f), 0);
  c.has_covariance = true;
  c.rms_px = 0.2;
  c.observations = 1000;
  assert_int_equal(hl_camera_lost(&c, HL_CAMERA_JSON), 0);
  assert_int_equal(hl_camera_lost(&c, HL_CAMERA_OPENCV),
                   HL_CAMERA_COVARIANCE | HL_CAMERA_OBSERVATIONS);
  assert_int_equal(hl_camera_lost(&c, HL_CAMERA_KALIBR),
                   HL_CAMERA_COVARIANCE | HL_CAMERA_RMS | HL_CAMERA_OBSERVATIONS);
  assert_int_equal(hl_camera_lost(&c, HL_CAMERA_MRCAL),
                   HL_CAMERA_COVARIANCE | HL_CAMERA_RMS | HL_CAMERA_OBSERVATIONS);
}

static void test_text_is_refused(void **state)
{
  (void)state;
  hl_camera c = camera_samples[SAMPLE_PINHOLE];
  char *text = NULL;
  hl_ctx ctx = {0};
  assert_int_equal(hl_camera_text(&ctx, &c, (hl_camera_format)4, &text), HL_ERR_ARG);
  assert_says(ctx.msg, "format = 4");
  for (int f = 0; hl_camera_format_name(f); f++) {
    c.fx = NAN;
    camera_not_written(&c, (hl_camera_format)f, "fx = nan px is outside");
    c = camera_samples[SAMPLE_PINHOLE];
    c.distortion[1] = -70;
    camera_not_written(&c, (hl_camera_format)f, "folds");
  }
  assert_null(text);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_names),
      cmocka_unit_test(test_told_apart_by_content),
      cmocka_unit_test(test_what_is_none_of_them),
      cmocka_unit_test(test_check_follows_whatever_the_format),
      cmocka_unit_test(test_large_files),
      cmocka_unit_test(test_missing_file),
      cmocka_unit_test(test_document),
      cmocka_unit_test(test_lost_parts),
      cmocka_unit_test(test_text_is_refused),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
