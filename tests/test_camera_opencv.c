/* Cameras in OpenCV's YAML. */
#include "camera_texts.h"

/* Written by cv2.FileStorage of OpenCV 4.6.0 (Debian python3-opencv), members as its calibration
 * sample has them. */
static const char opencv_460[] =
    "%YAML:1.0\n"
    "---\n"
    "calibration_time: \"Fri Jan  1 12:00:00 2021\"\n"
    "nr_of_frames: 12\n"
    "image_width: 640\n"
    "image_height: 480\n"
    "# flags: 0\n"
    "camera_matrix: !!opencv-matrix\n"
    "   rows: 3\n"
    "   cols: 3\n"
    "   dt: d\n"
    "   data: [ 4.5012500000000000e+02, 0., 3.2230000000000001e+02, 0.,\n"
    "       4.5510000000000002e+02, 2.3680000000000001e+02, 0., 0., 1. ]\n"
    "distortion_coefficients: !!opencv-matrix\n"
    "   rows: 5\n"
    "   cols: 1\n"
    "   dt: d\n"
    "   data: [ -2.0000000000000001e-01, 5.0000000000000003e-02,\n"
    "       1.0000000000000000e-03, -2.0000000000000000e-03,\n"
    "       1.0000000000000000e-02 ]\n"
    "avg_reprojection_error: 2.0999999999999999e-01\n"
    "per_view_reprojection_errors: !!opencv-matrix\n"
    "   rows: 2\n"
    "   cols: 1\n"
    "   dt: f\n"
    "   data: [ 1.00000001e-01, 2.00000003e-01 ]\n";

static void test_reads_what_opencv_writes(void **state)
{
  const hl_camera c = camera_of_text(state, opencv_460);
  assert_int_equal(c.model, HL_LENS_PINHOLE);
  assert_int_equal(c.width, 640);
  assert_int_equal(c.height, 480);
  assert_near(c.fx, 450.125, 0);
  assert_near(c.fy, 455.1, 0);
  assert_near(c.cx, 322.3, 0);
  assert_near(c.cy, 236.8, 0);
  assert_int_equal(c.n_distortion, 5);
  static const double k[5] = {-0.2, 0.05, 0.001, -0.002, 0.01};
  assert_memory_equal(c.distortion, k, sizeof k);
  assert_near(c.rms_px, 0.21, 0);
  assert_false(c.has_covariance);
}

#define HEAD "image_width: 640\nimage_height: 480\n"
#define MATRIX                                                                                     \
  "camera_matrix: {rows: 3, cols: 3, dt: d, data: [450., 0, 320, 0, 455, 240, 0, 0, 1]}\n"
#define COEFFICIENTS(rows, cols, data)                                                             \
  "distortion_coefficients: {rows: " #rows ", cols: " #cols ", dt: d, data: [" data "]}\n"
#define FOUR COEFFICIENTS(1, 4, "-0.02, 0.01, 0.001, -0.002")
#define FIVE COEFFICIENTS(1, 5, "-0.02, 0.01, 0.001, -0.002, 0.003")
#define EIGHT COEFFICIENTS(8, 1, "0.4, -0.1, 0.001, 0.002, 0.03, 0.35, -0.06, 0.02")

static void test_lens_follows_from_count_and_key(void **state)
{
  hl_camera c = camera_of_text(state, HEAD MATRIX FOUR);
  assert_int_equal(c.model, HL_LENS_PINHOLE);
  assert_int_equal(c.n_distortion, 5);
  assert_near(c.distortion[3], -0.002, 0);
  assert_near(c.distortion[4], 0, 0);
  c = camera_of_text(state, HEAD MATRIX EIGHT);
  assert_int_equal(c.model, HL_LENS_RATIONAL);
  assert_int_equal(c.n_distortion, 8);
  assert_near(c.distortion[7], 0.02, 0);
  static const char *const fisheyes[] = {"fisheye_model: 1\n", "fisheye_model: true\n",
                                         "distortion_model: equidistant\n",
                                         "fisheye_model: 1\ndistortion_model: fisheye\n"};
  char text[1024];
  for (int i = 0; i < 4; i++) {
    snprintf(text, sizeof text, HEAD MATRIX FOUR "%s", fisheyes[i]);
    c = camera_of_text(state, text);
    assert_int_equal(c.model, HL_LENS_FISHEYE);
    assert_int_equal(c.n_distortion, 4);
    assert_near(c.distortion[3], -0.002, 0);
  }
  static const char *const others[] = {"fisheye_model: 0\n", "fisheye_model: false\n",
                                       "distortion_model: plumb_bob\n",
                                       "distortion_model: rational_polynomial\n"};
  for (int i = 0; i < 4; i++) {
    snprintf(text, sizeof text, HEAD MATRIX FIVE "%s", others[i]);
    assert_int_equal(camera_of_text(state, text).model, HL_LENS_PINHOLE);
  }
}

/* OpenCV pads with zeros what its larger models do not use. */
static void test_larger_models_without_their_terms(void **state)
{
  hl_camera c = camera_of_text(
      state,
      HEAD MATRIX COEFFICIENTS(1, 14, "0.4,-0.1,0.001,0.002,0.03,0.35,-0.06,0.02,0,0,0,0.,-0,0"));
  assert_int_equal(c.model, HL_LENS_RATIONAL);
  assert_near(c.distortion[5], 0.35, 0);
  camera_text_refused(state,
                      HEAD MATRIX COEFFICIENTS(1, 12,
                                               "0.4,-0.1,0.001,0.002,0.03,0.35,-0.06,0.02,0,"
                                               "1e-3,0,0"),
                      "distortion_coefficients: data[9] = 0.001 is of a thin prism");
}

static void test_round_trips(void **state)
{
  for (int i = 0; i < N_CAMERA_SAMPLES; i++)
    camera_round_trip(state, &camera_samples[i], HL_CAMERA_OPENCV);
  hl_camera c = camera_samples[SAMPLE_FISHEYE];
  c.rms_px = 0.1 / 3;
  char *text = text_of_camera(&c, HL_CAMERA_OPENCV);
  assert_near(camera_of_text(state, text).rms_px, c.rms_px, 0);
  free(text);
}

/* The text, as cv2.FileStorage of OpenCV 4.6.0 and yaml.safe_load of PyYAML 6.0 were seen to read it,
 * to the same numbers. */
static void test_text_as_both_read_it(void **state)
{
  (void)state;
  hl_camera c = {.model = HL_LENS_FISHEYE,
                 .width = 640,
                 .height = 480,
                 .fx = 275.1,
                 .fy = 278,
                 .cx = 322.3,
                 .cy = 236.8,
                 .n_distortion = 4,
                 .distortion = {0.05, -0.02, 0.006, -1e-5},
                 .rms_px = 0.25};
  char *text = text_of_camera(&c, HL_CAMERA_OPENCV);
  assert_string_equal(text, "%YAML 1.1\n---\n"
                            "image_width: 640\nimage_height: 480\n"
                            "fisheye_model: 1\n"
                            "camera_matrix:\n   rows: 3\n   cols: 3\n   dt: d\n"
                            "   data: [ 275.1, 0.0, 322.3,\n      0.0, 278.0, 236.8,\n"
                            "      0.0, 0.0, 1.0 ]\n"
                            "distortion_coefficients:\n   rows: 1\n   cols: 4\n   dt: d\n"
                            "   data: [ 0.05, -0.02, 0.006,\n      -1.0e-05 ]\n"
                            "avg_reprojection_error: 0.25\n");
  free(text);
}

static void test_refusals(void **state)
{
  camera_text_refused(state, MATRIX FIVE, "image_width is missing; a whole number in [2, 65536]");
  camera_text_refused(state, HEAD FIVE,
                      "camera_matrix is missing; a matrix of rows, cols and data");
  camera_text_refused(state, HEAD MATRIX, "distortion_coefficients is missing; a matrix");
  camera_text_refused(state, HEAD FIVE "camera_matrix: [1, 2, 3]\n", "camera_matrix is no mapping");
  camera_text_refused(state, HEAD MATRIX COEFFICIENTS(1, 3, "0, 0, 0"),
                      "distortion_coefficients is 1 x 3; 4, 5, 8, 12 or 14 in one row or column");
  camera_text_refused(state, HEAD MATRIX COEFFICIENTS(2, 2, "0, 0, 0, 0"),
                      "distortion_coefficients is 2 x 2");
  camera_text_refused(state, HEAD MATRIX FIVE "fisheye_model: 1\n",
                      "distortion_coefficients is 1 x 5; a fisheye's 4 in one row or column");
  camera_text_refused(state, HEAD MATRIX FOUR "fisheye_model: 2\n", "fisheye_model = 2; a whole");
  camera_text_refused(state, HEAD MATRIX FOUR "distortion_model: omni\n",
                      "distortion_model = 'omni' is none of: plumb_bob, rational_polynomial");
  const char *good = HEAD MATRIX FIVE;
  assert_int_equal(camera_of_text(state, good).width, 640);
  changed_text_refused(state, good, "640", "1", "image_width = 1;");
  changed_text_refused(state, good, "480", "480.5", "image_height = 480.5;");
  changed_text_refused(state, good, "480", "big", "image_height = \"big\";");
  changed_text_refused(state, good, "450.", ".Nan",
                       "camera_matrix: data[0] = \".Nan\"; a finite number is needed");
  changed_text_refused(state, good, "450.", "1e999", "camera_matrix: data[0] = \"1e999\"");
  changed_text_refused(state, good, "0.003", ".Inf", "distortion_coefficients: data[4] = \".Inf\"");
  changed_text_refused(state, good, "[450., 0,", "[450., 0.5,",
                       "camera_matrix: data[1] = 0.5; 0 is needed: [fx 0 cx; 0 fy cy; 0 0 1]");
  changed_text_refused(state, good, "0, 0, 1]", "0, 0, 2]",
                       "camera_matrix: data[8] = 2; 1 is needed");
  changed_text_refused(state, good, "0, 0, 1]", "0, 0]",
                       "camera_matrix: data = [450.0,0,320,0,455,240,0,0]; an array of 9 numbers");
  changed_text_refused(state, good, "rows: 3, cols: 3", "rows: 9, cols: 1",
                       "camera_matrix is 9 x 1; 3 x 3 is needed");
  changed_text_refused(state, good, "rows: 3, cols: 3", "rows: 4, cols: 4",
                       "camera_matrix: 4 x 4 values; at most 9 are needed");
  changed_text_refused(state, good, "rows: 3", "rows: x", "camera_matrix: rows = \"x\"");
  changed_text_refused(state, good, "450.", "-450.", "fx = -450 px is outside");
  changed_text_refused(state, good, "-0.02,", "-9,", "distortion = [-9, 0.01, ...] folds");
  changed_text_refused(state, good, "rows: 3, cols: 3", "rows: &r 3, cols: *r", "*r is an alias");
}

static void test_cut_files(void **state)
{
  char *text = text_of_camera(&camera_samples[SAMPLE_RATIONAL], HL_CAMERA_OPENCV);
  cut_text_refused(state, text, strlen(text) - 2);
  free(text);
  cut_text_refused(state, opencv_460, (size_t)(strstr(opencv_460, "avg_repro") - opencv_460) - 1);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_reads_what_opencv_writes),
      cmocka_unit_test(test_lens_follows_from_count_and_key),
      cmocka_unit_test(test_larger_models_without_their_terms),
      cmocka_unit_test(test_round_trips),
      cmocka_unit_test(test_text_as_both_read_it),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_cut_files),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
