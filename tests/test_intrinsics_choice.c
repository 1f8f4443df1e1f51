/* The model: as asked, or the smallest that predicts views it has not seen. */
#include <string.h>

#include "corner_scene.h"

enum { VIEWS = 18 };

static hl_corners noisy_scene(hl_lens_model model)
{
  const hl_camera camera = board_camera(model);
  const hl_target target = board_target();
  const board_hold hold = board_held(&camera);
  hl_corners set = board_views(&camera, &target, VIEWS, 7, &hold, NULL);
  hl_corners noisy = board_noisy(&set, 0.1, 22);
  hl_corners_free(&set);
  return noisy;
}

static const char *why_of(const hl_notes *notes, const char *what)
{
  for (int i = 0; i < notes->n; i++)
    if (strcmp(notes->note[i].what, what) == 0)
      return notes->note[i].why;
  return NULL;
}

static void assert_says(const char *text, const char *part)
{
  if (!text || !strstr(text, part)) {
    print_error("'%s' does not say '%s'\n", text ? text : "(nothing)", part);
    fail();
  }
}

/* Each camera's own model is the one that auto keeps. */
static void test_auto(void **state)
{
  (void)state;
  static const char *const names[] = {"pinhole", "rational", "fisheye"};
  for (int model = 0; model < 3; model++) {
    hl_corners set = noisy_scene((hl_lens_model)model);
    hl_calibration c = board_calibrated(&set, HL_MODEL_AUTO);
    assert_int_equal(c.camera.model, model);
    assert_says(why_of(&c.used, names[model]), "held-out rms 0.1");
    for (int other = 0; other < 3; other++)
      if (other != model)
        assert_non_null(why_of(&c.left_out, names[other]));
    hl_calibration_free(&c);
    hl_corners_free(&set);
  }
}

static void test_reasons(void **state)
{
  (void)state;
  hl_corners set = noisy_scene(HL_LENS_PINHOLE);
  hl_calibration c = board_calibrated(&set, HL_MODEL_AUTO);
  assert_says(why_of(&c.left_out, "fisheye"), "tried from 90 deg");
  assert_says(why_of(&c.left_out, "rational"), "< 1 %");
  hl_calibration_free(&c);
  hl_corners_free(&set);
  set = noisy_scene(HL_LENS_RATIONAL);
  c = board_calibrated(&set, HL_MODEL_AUTO);
  assert_says(why_of(&c.left_out, "fisheye"), "held-out rms");
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

/* Auto's answer is that of its model asked for by name. */
static void test_same_as_asked(void **state)
{
  (void)state;
  hl_corners set = noisy_scene(HL_LENS_PINHOLE);
  hl_calibration a = board_calibrated(&set, HL_MODEL_AUTO);
  hl_calibration b = board_calibrated(&set, HL_MODEL_PINHOLE);
  assert_near(a.camera.fx, b.camera.fx, 1e-6);
  assert_near(a.camera.cy, b.camera.cy, 1e-6);
  assert_near(a.camera.covariance[0] / b.camera.covariance[0], 1, 1e-6);
  assert_says(why_of(&b.used, "pinhole"), "asked for");
  assert_says(why_of(&b.left_out, "rational"), "cross-validation");
  hl_calibration_free(&a);
  hl_calibration_free(&b);
  hl_corners_free(&set);
}

/* The least gain is a setting: at 99 % the fisheye with its error of decentring would do. */
static void test_gain(void **state)
{
  (void)state;
  hl_corners set = noisy_scene(HL_LENS_RATIONAL);
  hl_calibration_settings s = hl_calibration_defaults();
  hl_calibration c;
  s.model = HL_MODEL_AUTO;
  s.model_gain = 0.99;
  assert_int_equal(hl_calibrate(NULL, &set, &s, &c), HL_OK);
  assert_int_equal(c.camera.model, HL_LENS_FISHEYE);
  assert_says(why_of(&c.left_out, "rational"), "< 99 %");
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_auto),
      cmocka_unit_test(test_reasons),
      cmocka_unit_test(test_same_as_asked),
      cmocka_unit_test(test_gain),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
