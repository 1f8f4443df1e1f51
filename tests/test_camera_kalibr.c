/* Cameras in Kalibr's camchain YAML. */
#include "camera_texts.h"

/* As Kalibr writes it: yaml.dump (here PyYAML 6.0) of the members of kalibr_common/ConfigReader.py. */
static const char camchain[] = "cam0:\n"
                               "  T_cam_imu:\n"
                               "  - - 0.0\n"
                               "    - 1.0\n"
                               "    - 0.0\n"
                               "    - 0.1\n"
                               "  - - 0.0\n"
                               "    - 0.0\n"
                               "    - 1.0\n"
                               "    - 0.2\n"
                               "  - - 1.0\n"
                               "    - 0.0\n"
                               "    - 0.0\n"
                               "    - 0.0\n"
                               "  - - 0.0\n"
                               "    - 0.0\n"
                               "    - 0.0\n"
                               "    - 1.0\n"
                               "  cam_overlaps: []\n"
                               "  camera_model: pinhole\n"
                               "  distortion_coeffs:\n"
                               "  - -0.2123\n"
                               "  - 0.0512\n"
                               "  - 1.0e-05\n"
                               "  - -0.00087\n"
                               "  distortion_model: radtan\n"
                               "  intrinsics:\n"
                               "  - 458.654\n"
                               "  - 457.296\n"
                               "  - 367.215\n"
                               "  - 248.375\n"
                               "  resolution:\n"
                               "  - 752\n"
                               "  - 480\n"
                               "  rostopic: /cam0/image_raw\n"
                               "  timeshift_cam_imu: 0.0\n";

static void test_reads_what_kalibr_writes(void **state)
{
  const hl_camera c = camera_of_text(state, camchain);
  assert_int_equal(c.model, HL_LENS_PINHOLE);
  assert_int_equal(c.width, 752);
  assert_int_equal(c.height, 480);
  assert_near(c.fx, 458.654, 0);
  assert_near(c.fy, 457.296, 0);
  assert_near(c.cx, 367.215, 0);
  assert_near(c.cy, 248.375, 0);
  assert_int_equal(c.n_distortion, 5);
  static const double k[5] = {-0.2123, 0.0512, 1e-5, -0.00087, 0};
  assert_memory_equal(c.distortion, k, sizeof k);
}

#define EQUI                                                                                       \
  "cam3:\n  camera_model: pinhole\n  intrinsics: [275, 278.5, 322.3, 236.8]\n"                     \
  "  distortion_model: equidistant\n  distortion_coeffs: [0.05, -0.02, 0.006, -0.001]\n"           \
  "  resolution: [640, 480]\n"

static void test_equidistant_is_a_fisheye(void **state)
{
  hl_camera c = camera_of_text(state, EQUI);
  assert_int_equal(c.model, HL_LENS_FISHEYE);
  assert_int_equal(c.n_distortion, 4);
  assert_near(c.distortion[2], 0.006, 0);
  c = camera_of_text(state, "cam0:\n  camera_model: pinhole\n  intrinsics: [275, 278.5, 322, 236]\n"
                            "  distortion_model: equi\n  distortion_coeffs: [0.05, 0, 0, 0]\n"
                            "  resolution: [640, 480]\n");
  assert_int_equal(c.model, HL_LENS_FISHEYE);
  c = camera_of_text(state, "cam0:\n  camera_model: pinhole\n  intrinsics: [275, 278.5, 322, 236]\n"
                            "  distortion_model: none\n  distortion_coeffs: []\n"
                            "  resolution: [640, 480]\n");
  assert_int_equal(c.model, HL_LENS_PINHOLE);
  assert_int_equal(c.n_distortion, 5);
  assert_near(c.distortion[0], 0, 0);
}

static void test_round_trips(void **state)
{
  camera_round_trip(state, &camera_samples[SAMPLE_PINHOLE_K3_0], HL_CAMERA_KALIBR);
  camera_round_trip(state, &camera_samples[SAMPLE_FISHEYE], HL_CAMERA_KALIBR);
}

/* Kalibr asks for floats in intrinsics and coefficients and whole numbers in resolution. */
static void test_text(void **state)
{
  (void)state;
  const hl_camera c = {.model = HL_LENS_PINHOLE,
                       .width = 640,
                       .height = 480,
                       .fx = 800,
                       .fy = 801.5,
                       .cx = 320,
                       .cy = 239.5,
                       .n_distortion = 5,
                       .distortion = {-0.1, 0, 1e-5, 0, 0}};
  char *text = text_of_camera(&c, HL_CAMERA_KALIBR);
  assert_string_equal(text, "cam0:\n"
                            "  cam_overlaps: []\n"
                            "  camera_model: pinhole\n"
                            "  distortion_coeffs: [-0.1, 0.0, 1.0e-05, 0.0]\n"
                            "  distortion_model: radtan\n"
                            "  intrinsics: [800.0, 801.5, 320.0, 239.5]\n"
                            "  resolution: [640, 480]\n");
  free(text);
}

static void test_lenses_that_kalibr_has_not(void **state)
{
  (void)state;
  hl_camera c = camera_samples[SAMPLE_PINHOLE_K3_0];
  c.distortion[4] = 0.0025;
  camera_not_written(&c, HL_CAMERA_KALIBR,
                     "kalibr's radtan has no k3, which is 0.0025 here; a pinhole with k3 = 0 is "
                     "accepted");
  camera_not_written(&camera_samples[SAMPLE_RATIONAL], HL_CAMERA_KALIBR,
                     "kalibr has no rational lens");
}

static void test_refusals(void **state)
{
  changed_text_refused(state, camchain, "  timeshift_cam_imu", "cam1",
                       "several cameras, cam0 and cam1; a camchain of one is needed");
  camera_text_refused(state, "cam0: 5\n", "cam0 is no mapping");
  camera_text_refused(state, "cam0: {}\n", "cam0: camera_model is missing; a text is needed");
  changed_text_refused(state, EQUI, "pinhole", "omni",
                       "cam3: camera_model = 'omni' is not pinhole; pinhole with radtan or equid");
  changed_text_refused(state, EQUI, "equidistant", "fov",
                       "distortion_model = 'fov' is none of: radtan, equidistant, none");
  changed_text_refused(state, EQUI, "distortion_model", "distortion_mode",
                       "cam3: distortion_model is missing");
  changed_text_refused(state, EQUI, "275,", "275, 1,",
                       "cam3: intrinsics = [275,1,278.5,322.3,236.8]; an array of 4 numbers");
  changed_text_refused(state, EQUI, "275,", ".nan,",
                       "cam3: intrinsics[0] = \".nan\"; a finite number is needed");
  changed_text_refused(state, EQUI, "-0.001]", "]", "distortion_coeffs = [0.05,-0.02,0.006]");
  changed_text_refused(state, EQUI, "[640, 480]", "[640, 480.5]",
                       "cam3: resolution[1] = 480.5; a whole number in [2, 65536] is needed");
  changed_text_refused(state, EQUI, "[640, 480]", "[1, 480]", "resolution[0] = 1;");
  changed_text_refused(state, EQUI, "[640, 480]", "[1e30, 480]", "resolution[0] = 1e+30;");
  changed_text_refused(state, EQUI, "[640, 480]", "640", "resolution = 640; an array of 2");
  changed_text_refused(state, EQUI, "[640, 480]", "[960, 480]", "reaches 90 deg at");
  changed_text_refused(state, EQUI, "[640, 480]", "&a [640, 480]\n  b: *a", "*a is an alias");
}

static void test_cut_files(void **state)
{
  char *text = text_of_camera(&camera_samples[SAMPLE_FISHEYE], HL_CAMERA_KALIBR);
  cut_text_refused(state, text, strlen(text) - 1);
  free(text);
  cut_text_refused(state, camchain, (size_t)(strstr(camchain, "  - 480") - camchain));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_reads_what_kalibr_writes),
      cmocka_unit_test(test_equidistant_is_a_fisheye),
      cmocka_unit_test(test_round_trips),
      cmocka_unit_test(test_text),
      cmocka_unit_test(test_lenses_that_kalibr_has_not),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_cut_files),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
