/* Corners against their neighbours: what stands out, what is left out, and the gap they show. */
#include "../calib/board_fit.h"

#include "board_scene.h"

enum { CORNERS = 144 };

/* All corners of a tilted board as the camera sees them, exactly. */
static board_scene exact(const char *spec, double k1, hl_corner corner[CORNERS])
{
  board_scene s = board_scene_of(spec);
  s.camera.distortion[0] = k1;
  board_place(&s, 0.8, 0.3, -0.4, 0.2);
  for (int i = 0; i < hl_target_corners(&s.target); i++) {
    double pixel[2];
    board_truth(&s, i, pixel);
    corner[i] = (hl_corner){pixel[0], pixel[1], 1};
  }
  return s;
}

static const char grid[] = "aprilgrid:6x6:0.03:0.3";

static void test_exact_corners_fit(void **state)
{
  (void)state;
  hl_corner corner[CORNERS];
  const board_scene s = exact(grid, 0, corner);
  const hl_board_fit fit = hl_board_fit_of(&s.target, corner);
  assert_int_equal(fit.seen, CORNERS);
  assert_near(fit.rms_px, 0, 1e-6);
}

/* Barrel distortion of 30 px at the corners of the frame, and a fisheye lens that sees 110 degrees. */
static void test_lens_distortion_hardly_shows(void **state)
{
  (void)state;
  hl_corner corner[CORNERS];
  board_scene s = exact(grid, -0.25, corner);
  assert_near(hl_board_fit_of(&s.target, corner).rms_px, 0, 0.02);
  s.camera.model = HL_LENS_FISHEYE;
  s.camera.n_distortion = 4;
  s.camera.distortion[0] = 0.02;
  s.camera.fx = s.camera.fy = 220;
  board_place(&s, 0.75, 0.3, -0.4, 0.2);
  for (int i = 0; i < CORNERS; i++) {
    double pixel[2];
    board_truth(&s, i, pixel);
    corner[i] = (hl_corner){pixel[0], pixel[1], 1};
  }
  assert_near(hl_board_fit_of(&s.target, corner).rms_px, 0, 0.3);
}

static void test_a_wrong_corner_stands_out(void **state)
{
  (void)state;
  hl_corner corner[CORNERS];
  const board_scene s = exact(grid, -0.25, corner);
  corner[77].x += 3;
  corner[5].sigma = 0;
  const hl_board_fit fit = hl_board_fit_of(&s.target, corner);
  assert_int_equal(fit.seen, CORNERS - 1);
  assert_int_equal(fit.worst, 77);
  assert_true(fit.worst_px > 1.5 && fit.worst_px < 3);
}

static void test_too_few_say_nothing(void **state)
{
  (void)state;
  hl_corner corner[CORNERS];
  const board_scene s = exact(grid, 0, corner);
  for (int i = 0; i < CORNERS; i++)
    if (i > 1 && i != 12 && i != 13)
      corner[i].sigma = 0;
  const hl_board_fit fit = hl_board_fit_of(&s.target, corner);
  assert_int_equal(fit.seen, 4);
  assert_int_equal(fit.worst, -1);
  assert_near(fit.rms_px, 0, 0);
}

/* Tag (2, 3), corners 76, 77, 88, 89, moved as a whole; its neighbours stay. */
static void test_a_wrong_tag_goes_alone(void **state)
{
  (void)state;
  static const int tag[4] = {76, 77, 88, 89};
  hl_corner corner[CORNERS];
  const board_scene s = exact(grid, -0.25, corner);
  for (int i = 0; i < 4; i++)
    corner[tag[i]].y += 6;
  hl_corner kept[CORNERS];
  memcpy(kept, corner, sizeof kept);
  assert_int_equal(hl_board_prune(&s.target, kept, 1.5, 0.03, 0), 0);
  assert_int_equal(hl_board_prune(&s.target, corner, 1.5, 0.03, 10), 1);
  int gone = 0;
  for (int i = 0; i < CORNERS; i++)
    gone += corner[i].sigma == 0;
  assert_int_equal(gone, 4);
  for (int i = 0; i < 4; i++)
    assert_near(corner[tag[i]].sigma, 0, 0);
  assert_int_equal(hl_board_prune(&s.target, corner, 1.5, 0.03, 10), 0);
}

/* No perspective changes a cross ratio. */
static void test_spacing_ratio(void **state)
{
  (void)state;
  hl_corner corner[CORNERS];
  board_scene s = exact(grid, 0, corner);
  assert_near(hl_board_spacing_ratio(&s.target, corner), 0.3, 1e-9);
  s.target.spacing_ratio = 0.5; /* what the target says does not matter */
  assert_near(hl_board_spacing_ratio(&s.target, corner), 0.3, 1e-9);
  s = exact("aprilgrid:6x6:0.03:0.12", -0.2, corner);
  assert_near(hl_board_spacing_ratio(&s.target, corner), 0.12, 0.002);
  for (int i = 2; i < CORNERS; i++)
    if (i % 4 > 1)
      corner[i].sigma = 0;
  for (int i = 0; i < CORNERS; i++)
    if (i / 12 > 1)
      corner[i].sigma = 0;
  assert_near(hl_board_spacing_ratio(&s.target, corner), 0, 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_exact_corners_fit),
      cmocka_unit_test(test_lens_distortion_hardly_shows),
      cmocka_unit_test(test_a_wrong_corner_stands_out),
      cmocka_unit_test(test_too_few_say_nothing),
      cmocka_unit_test(test_a_wrong_tag_goes_alone),
      cmocka_unit_test(test_spacing_ratio),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
