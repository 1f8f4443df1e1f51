/* Cameras as mrcal's .cameramodel. */
#include "camera_texts.h"

/* Written by mrcal.cameramodel(...).write(...) of mrcal 2.2 (Debian python3-mrcal 2.2-4), with the last
 * two members, as a calibration adds them, shortened. */
static const char mrcal_22[] =
    "# a note\n"
    "# of two lines, isn't it {\n"
    "{\n"
    "    'lensmodel':  'LENSMODEL_OPENCV8',\n"
    "\n"
    "    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n"
    "    'intrinsics': [ 450.123456, 455.1, 322.3, 236.8, 2.1, 0.9, -0.0005, 0.0008, 0.03, 2.4, "
    "1.5, 0.2,],\n"
    "\n"
    "    'valid_intrinsics_region': [\n"
    "    [ 0, 0 ],\n"
    "    [ 0, 400 ],\n"
    "    [ 600, 400 ],\n"
    "    [ 600, 0 ],\n"
    "    [ 0, 0 ],\n"
    "],\n"
    "\n"
    "    # extrinsics are rt_fromref\n"
    "    'extrinsics': [ 0.1, 0.2, 0.3, 1, 2, 3,],\n"
    "\n"
    "    'imagersize': [ 640, 480,],\n"
    "\n"
    "    'icam_intrinsics': 0,\n"
    "\n"
    "    # The optimization inputs contain all the data used to compute this model.\n"
    "    'optimization_inputs': b'P)h>@6aWAK2mk;8Aplhd000000000O003@j#{}~_`^&<=+-*',\n"
    "\n"
    "}\n";

static void test_reads_what_mrcal_writes(void **state)
{
  const hl_camera c = camera_of_text(state, mrcal_22);
  assert_int_equal(c.model, HL_LENS_RATIONAL);
  assert_int_equal(c.width, 640);
  assert_int_equal(c.height, 480);
  assert_near(c.fx, 450.123456, 0);
  assert_near(c.fy, 455.1, 0);
  assert_near(c.cx, 322.3, 0);
  assert_near(c.cy, 236.8, 0);
  assert_int_equal(c.n_distortion, 8);
  static const double k[8] = {2.1, 0.9, -0.0005, 0.0008, 0.03, 2.4, 1.5, 0.2};
  assert_memory_equal(c.distortion, k, sizeof k);
}

static void test_lensmodels(void **state)
{
  static const struct {
    const char *name, *more;
    hl_lens_model model;
  } known[] = {{"LENSMODEL_PINHOLE", "", HL_LENS_PINHOLE},
               {"LENSMODEL_OPENCV4", ",-.2,.05,.001,-.002", HL_LENS_PINHOLE},
               {"LENSMODEL_OPENCV5", ",-.2,.05,.001,-.002,.01", HL_LENS_PINHOLE},
               {"LENSMODEL_OPENCV8", ",.4,-.1,.001,.002,.03,.35,-.06,.02", HL_LENS_RATIONAL}};
  char text[512];
  for (int i = 0; i < 4; i++) {
    snprintf(text, sizeof text,
             "{'lensmodel':'%s','intrinsics':(450,455,320,240%s),'imagersize':(640,480)}",
             known[i].name, known[i].more);
    const hl_camera c = camera_of_text(state, text);
    assert_int_equal(c.model, known[i].model);
    assert_int_equal(c.n_distortion, i < 3 ? 5 : 8);
    assert_near(c.distortion[0], i == 0 ? 0 : i < 3 ? -0.2 : 0.4, 0);
    assert_near(c.distortion[4], i < 2 ? 0 : i == 2 ? 0.01 : 0.03, 0);
  }
}

static void test_round_trips(void **state)
{
  for (int i = 0; i < N_CAMERA_SAMPLES; i++)
    if (i != SAMPLE_FISHEYE)
      camera_round_trip(state, &camera_samples[i], HL_CAMERA_MRCAL);
}

/* As mrcal 2.2 was seen to read it. */
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
  char *text = text_of_camera(&c, HL_CAMERA_MRCAL);
  assert_string_equal(
      text, "{\n"
            "    'lensmodel':  'LENSMODEL_OPENCV5',\n"
            "\n"
            "    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n"
            "    'intrinsics': [ 800.0, 801.5, 320.0, 239.5, -0.1, 0.0, 1.0e-05, 0.0, 0.0 ],\n"
            "\n"
            "    # extrinsics are rt_fromref\n"
            "    'extrinsics': [ 0, 0, 0, 0, 0, 0 ],\n"
            "\n"
            "    'imagersize': [ 640, 480 ],\n"
            "}\n");
  free(text);
}

static void test_refusals(void **state)
{
  static const char *const others[] = {"LENSMODEL_CAHVOR", "LENSMODEL_CAHVORE_linearity=0.37",
                                       "LENSMODEL_OPENCV12", "LENSMODEL_STEREOGRAPHIC",
                                       "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=30_Ny=18_fov"};
  char part[200];
  for (int i = 0; i < 5; i++) {
    snprintf(part, sizeof part, "lensmodel = '%s' is none of: LENSMODEL_PINHOLE, LENSMODEL_OPENCV4",
             others[i]);
    changed_text_refused(state, mrcal_22, "LENSMODEL_OPENCV8", others[i], part);
  }
  changed_text_refused(state, mrcal_22, "'lensmodel'", "'lens'", "lensmodel is missing");
  changed_text_refused(state, mrcal_22, "'intrinsics'", "'x'",
                       "intrinsics is missing; an array of 12");
  changed_text_refused(state, mrcal_22, "'imagersize'", "'x'",
                       "imagersize is missing; an array of 2");
  changed_text_refused(state, mrcal_22, "LENSMODEL_OPENCV8", "LENSMODEL_OPENCV5",
                       "; an array of 9 numbers is needed");
  changed_text_refused(state, mrcal_22, "455.1", "nan",
                       "line 7: no Python dictionary: a number, a text, a list or a dictionary is "
                       "needed, 'nan,' found");
  changed_text_refused(state, mrcal_22, "455.1", "None", "intrinsics[1] = null; a finite number");
  changed_text_refused(state, mrcal_22, "455.1", "1e999", "'1e999,' found");
  changed_text_refused(state, mrcal_22, "480", "480.5", "imagersize[1] = 480.5; a whole number");
  changed_text_refused(state, mrcal_22, "450.123456", "-450", "fx = -450 px is outside");
  changed_text_refused(state, mrcal_22, "'extrinsics'", "'lensmodel'",
                       "line 18: lensmodel is given twice");
  camera_not_written(
      &camera_samples[SAMPLE_FISHEYE], HL_CAMERA_MRCAL,
      "mrcal has no Kannala-Brandt fisheye; pinhole and rational lenses are accepted");
}

static void test_cut_files(void **state)
{
  char *text = text_of_camera(&camera_samples[SAMPLE_RATIONAL], HL_CAMERA_MRCAL);
  cut_text_refused(state, text, strlen(text) - 1);
  free(text);
  cut_text_refused(state, mrcal_22, strlen(mrcal_22) - 1);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_reads_what_mrcal_writes),
      cmocka_unit_test(test_lensmodels),
      cmocka_unit_test(test_round_trips),
      cmocka_unit_test(test_text),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_cut_files),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
