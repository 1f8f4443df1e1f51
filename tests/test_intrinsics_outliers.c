/* Corners and views that stand out leave with a count and a reason; nothing else does. */
#include <string.h>

#include "corner_scene.h"

enum { VIEWS = 10 };

static hl_corners noisy_scene(void)
{
  const hl_camera camera = board_camera(HL_LENS_PINHOLE);
  const hl_target target = board_target();
  const board_hold hold = board_held(&camera);
  hl_corners set = board_views(&camera, &target, VIEWS, 11, &hold, NULL);
  hl_corners noisy = board_noisy(&set, 0.1, 12);
  hl_corners_free(&set);
  return noisy;
}

/* Every intrinsic within four of its stated deviations of the truth. */
static void near_truth(const hl_calibration *c)
{
  const hl_camera truth = board_camera(HL_LENS_PINHOLE);
  const int n = hl_camera_intrinsics_count(&truth);
  double got[HL_INTRINSICS_MAX], want[HL_INTRINSICS_MAX];
  hl_camera_intrinsics(&c->camera, got);
  hl_camera_intrinsics(&truth, want);
  for (int k = 0; k < n; k++)
    assert_near((got[k] - want[k]) / sqrt(c->camera.covariance[k * n + k]), 0, 4);
}

static const char *why_of(const hl_notes *notes, const char *what)
{
  for (int i = 0; i < notes->n; i++)
    if (strcmp(notes->note[i].what, what) == 0)
      return notes->note[i].why;
  return "";
}

/* The first seen corners of a view, in board order. */
static hl_corner *seen_corner(hl_corners *set, int view, int k)
{
  hl_corner *corner = set->view[view].corner;
  for (int i = 0;; i++)
    if (corner[i].sigma > 0 && k-- == 0)
      return &corner[i];
}

static void test_clean(void **state)
{
  (void)state;
  hl_corners set = noisy_scene();
  hl_calibration c = board_calibrated(&set, HL_MODEL_PINHOLE);
  assert_int_equal(c.corners_left_out, 0);
  for (int v = 0; v < VIEWS; v++)
    assert_true(c.view[v].used);
  assert_string_equal(why_of(&c.left_out, "outlier rejection"), "no corner or view stands out");
  near_truth(&c);
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

static void test_single_corners(void **state)
{
  (void)state;
  hl_corners set = noisy_scene();
  for (int k = 0; k < 4; k++)
    seen_corner(&set, 3, 10 + k)->x += 40;
  seen_corner(&set, 6, 30)->y -= 2;
  hl_calibration c = board_calibrated(&set, HL_MODEL_PINHOLE);
  assert_int_equal(c.corners_left_out, 5);
  assert_int_equal(c.view[3].seen - c.view[3].corners, 4);
  assert_int_equal(c.view[6].seen - c.view[6].corners, 1);
  assert_true(c.trusted);
  assert_string_equal(why_of(&c.used, "outlier rejection"), "5 corners and 0 views left out");
  near_truth(&c);
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

/* A view off by 2 px everywhere: left out as a whole, its corners not counted one by one. */
static void test_view(void **state)
{
  (void)state;
  hl_corners set = noisy_scene();
  test_random r = {5};
  for (int i = 0; i < hl_target_corners(&set.target); i++) {
    set.view[4].corner[i].x += 2 * random_normal(&r);
    set.view[4].corner[i].y += 2 * random_normal(&r);
  }
  hl_calibration c = board_calibrated(&set, HL_MODEL_PINHOLE);
  assert_false(c.view[4].used);
  assert_int_equal(c.corners_left_out, 0);
  assert_non_null(strstr(c.view[4].why, "times the median"));
  assert_near(c.view[4].rms_px, 2 * sqrt(2), 0.4); /* its pose fitted again, for the record */
  assert_true(c.trusted);
  near_truth(&c);
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

/* Corners counted from another place: no camera's view, and the others do not suffer. */
static void test_rolled_view(void **state)
{
  (void)state;
  hl_corners set = noisy_scene();
  const int n = hl_target_corners(&set.target);
  const hl_corner first = set.view[2].corner[0];
  memmove(set.view[2].corner, set.view[2].corner + 1, (size_t)(n - 1) * sizeof first);
  set.view[2].corner[n - 1] = first;
  hl_calibration c = board_calibrated(&set, HL_MODEL_PINHOLE);
  assert_false(c.view[2].used);
  near_truth(&c);
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

static void test_switched_off(void **state)
{
  (void)state;
  hl_corners set = noisy_scene();
  hl_calibration_settings s = hl_calibration_defaults();
  hl_calibration c;
  seen_corner(&set, 6, 30)->y -= 2;
  s.outlier_sigmas = 0;
  s.view_ratio = 0;
  assert_int_equal(hl_calibrate(NULL, &set, &s, &c), HL_OK);
  assert_int_equal(c.corners_left_out, 0);
  assert_int_equal(c.view[6].corners, c.view[6].seen);
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

/* As many views stay as are needed, the better ones. */
static void test_never_too_few(void **state)
{
  (void)state;
  hl_corners set = noisy_scene();
  hl_calibration_settings s = hl_calibration_defaults();
  hl_calibration c;
  test_random r = {6};
  for (int v = 0; v < 3; v++)
    for (int i = 0; i < hl_target_corners(&set.target); i++)
      set.view[v].corner[i].x += (v + 1) * random_normal(&r);
  s.min_views = VIEWS - 1;
  assert_int_equal(hl_calibrate(NULL, &set, &s, &c), HL_OK);
  int used = 0;
  for (int v = 0; v < VIEWS; v++)
    used += c.view[v].used;
  assert_int_equal(used, VIEWS - 1);
  assert_false(c.view[2].used); /* the worst of the three */
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_clean),        cmocka_unit_test(test_single_corners),
      cmocka_unit_test(test_view),         cmocka_unit_test(test_rolled_view),
      cmocka_unit_test(test_switched_off), cmocka_unit_test(test_never_too_few),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
