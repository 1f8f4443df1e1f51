/* What is refused, with which words, and what is answered but not to be trusted. */
#include <string.h>

#include "corner_scene.h"

enum { VIEWS = 10 };

static hl_corners scene_held(const board_hold *hold, int views, double noise)
{
  const hl_camera camera = board_camera(HL_LENS_PINHOLE);
  const hl_target target = board_target();
  hl_corners set = board_views(&camera, &target, views, 31, hold, NULL);
  hl_corners noisy = board_noisy(&set, noise, 32);
  hl_corners_free(&set);
  return noisy;
}

static hl_corners scene(int views)
{
  const hl_camera camera = board_camera(HL_LENS_PINHOLE);
  const board_hold hold = board_held(&camera);
  return scene_held(&hold, views, 0.1);
}

/* Refused with this status and these words, nothing written; the set is freed. */
static void refused(hl_corners set, const hl_calibration_settings *settings, hl_status status,
                    const char *part)
{
  hl_ctx ctx = {0};
  hl_calibration out = {.noise_px = -7};
  const hl_status st = hl_calibrate(&ctx, &set, settings, &out);
  if (st != status || !strstr(ctx.msg, part))
    print_error("status %d: '%s' does not say '%s'\n", st, ctx.msg, part);
  assert_int_equal(st, status);
  assert_non_null(strstr(ctx.msg, part));
  assert_near(out.noise_px, -7, 0);
  assert_null(out.view);
  hl_corners_free(&set);
}

/* Answered, but for this reason not to be trusted; the set is freed. */
static void distrusted(hl_corners set, const char *what, const char *part)
{
  hl_calibration c = board_calibrated(&set, HL_MODEL_PINHOLE);
  bool said = false;
  assert_false(c.trusted);
  for (int i = 0; i < c.reasons.n; i++)
    said =
        said || (strcmp(c.reasons.note[i].what, what) == 0 && strstr(c.reasons.note[i].why, part));
  for (int i = 0; i < c.reasons.n && !said; i++)
    print_error("%s: %s\n", c.reasons.note[i].what, c.reasons.note[i].why);
  assert_true(said);
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

static void test_too_few_views(void **state)
{
  (void)state;
  refused(scene(3), NULL, HL_ERR_DEGENERATE, "3 views; at least 4 are needed");
  hl_corners set = scene(VIEWS);
  for (int v = 2; v < VIEWS; v++) {
    set.view[v].used = false;
    snprintf(set.view[v].why, sizeof set.view[v].why, "blurred");
  }
  refused(set, NULL, HL_ERR_DEGENERATE,
          "2 of 10 views can be used; at least 4 are needed; "
          "view02.png: blurred");
  set = scene(VIEWS);
  set.n_views = 0;
  hl_calibration out;
  assert_int_equal(hl_calibrate(NULL, &set, NULL, &out), HL_ERR_DEGENERATE);
  set.n_views = VIEWS;
  hl_corners_free(&set);
}

/* Views keep `count` corners, from the first row on. */
static hl_corners shortened(int count)
{
  hl_corners set = scene(VIEWS);
  for (int v = 0; v < VIEWS; v++) {
    set.view[v].seen = 0;
    for (int i = 0; i < hl_target_corners(&set.target); i++) {
      hl_corner *c = &set.view[v].corner[i];
      if (set.view[v].seen >= count)
        c->sigma = 0;
      set.view[v].seen += c->sigma > 0;
    }
  }
  return set;
}

static void test_few_corners(void **state)
{
  (void)state;
  refused(shortened(0), NULL, HL_ERR_DEGENERATE, "view00.png: no corner is seen");
  refused(shortened(7), NULL, HL_ERR_DEGENERATE, "only 7 corners; at least 8 are needed");
}

static void test_corners_in_a_row(void **state)
{
  (void)state;
  hl_corners set = scene(VIEWS);
  const int columns = hl_target_corner_columns(&set.target);
  for (int v = 0; v < VIEWS; v++) {
    int best = 0, most = 0;
    for (int row = 0; row < columns; row++) {
      int seen = 0;
      for (int i = 0; i < columns; i++)
        seen += set.view[v].corner[row * columns + i].sigma > 0;
      best = seen > most ? row : best;
      most = seen > most ? seen : most;
    }
    for (int i = 0; i < hl_target_corners(&set.target); i++)
      if (i / columns != best)
        set.view[v].corner[i].sigma = 0;
    set.view[v].seen = most;
    assert_true(most >= 8);
  }
  refused(set, NULL, HL_ERR_DEGENERATE, "lie in a row");
}

static void test_arguments(void **state)
{
  (void)state;
  hl_corners set = scene(VIEWS);
  set.width = 0;
  refused(set, NULL, HL_ERR_ARG, "the frames' size is 0 x 480 px");
  hl_calibration_settings s = hl_calibration_defaults();
  assert_int_equal(hl_fields_check(NULL, hl_calibration_fields(), &s), HL_OK);
  s.min_views = 2;
  refused(scene(VIEWS), &s, HL_ERR_ARG, "min_views = 2 is outside [3, 1000]");
  s = hl_calibration_defaults();
  s.outlier_sigmas = NAN;
  refused(scene(VIEWS), &s, HL_ERR_ARG, "outlier_sigmas");
  s = hl_calibration_defaults();
  s.view_ratio = -1;
  refused(scene(VIEWS), &s, HL_ERR_ARG, "view_ratio");
  s = hl_calibration_defaults();
  s.model_gain = 1.5;
  refused(scene(VIEWS), &s, HL_ERR_ARG, "model_gain");
  set = scene(VIEWS);
  set.target.size_m = 0;
  refused(set, NULL, HL_ERR_ARG, "target");
}

static void test_other_frames(void **state)
{
  (void)state;
  hl_corners set = scene(VIEWS);
  set.width = 320;
  set.height = 240;
  refused(set, NULL, HL_ERR_FORMAT, "is outside the frame of 320 x 240 px");
}

/* The corners of each row counted backwards. */
static void mirror(hl_view *view, const hl_target *target)
{
  const int columns = hl_target_corner_columns(target);
  for (int i = 0; i < hl_target_corners(target); i += columns)
    for (int k = 0; k < columns / 2; k++) {
      const hl_corner swap = view->corner[i + k];
      view->corner[i + k] = view->corner[i + columns - 1 - k];
      view->corner[i + columns - 1 - k] = swap;
    }
}

static void test_mirrored(void **state)
{
  (void)state;
  hl_corners set = scene(VIEWS);
  mirror(&set.view[3], &set.target);
  hl_calibration c = board_calibrated(&set, HL_MODEL_PINHOLE);
  assert_false(c.view[3].used);
  assert_non_null(strstr(c.view[3].why, "mirrored"));
  assert_true(c.trusted);
  hl_calibration_free(&c);
  for (int v = 0; v < VIEWS; v++)
    if (v != 3)
      mirror(&set.view[v], &set.target);
  refused(set, NULL, HL_ERR_DEGENERATE, "the board is seen mirrored");
}

static void test_parallel_boards(void **state)
{
  (void)state;
  board_hold hold = {0, 0.3, 0.55, 0.16, 0.6};
  hl_corners set = scene_held(&hold, VIEWS, 0.1);
  hl_calibration c;
  hl_ctx ctx = {0};
  const hl_status st = hl_calibrate(&ctx, &set, NULL, &c);
  if (st == HL_OK) { /* the noise tilts them */
    assert_false(c.trusted);
    assert_string_equal(c.reasons.note[0].what, "parallel boards");
    hl_calibration_free(&c);
  } else {
    assert_int_equal(st, HL_ERR_DEGENERATE);
    assert_non_null(strstr(ctx.msg, "parallel"));
  }
  hl_corners_free(&set);
  hold.tilt_rad = 0.03;
  distrusted(scene_held(&hold, VIEWS, 0.1), "parallel boards",
             "does not determine the focal length");
  distrusted(scene_held(&hold, VIEWS, 0.1), "focal length", "tilt the boards more");
}

/* As many corners, but of another board. */
static void test_another_board(void **state)
{
  (void)state;
  hl_corners set = scene(VIEWS);
  set.target = (hl_target){HL_TARGET_CHESSBOARD, 12, 12, 0.03, 0};
  refused(set, NULL, HL_ERR_DEGENERATE, "taken as 12 x 12 corners of chessboard:12x12:0.03");
  set = scene(VIEWS);
  set.target.columns = 4;
  set.target.rows = 9;
  refused(set, NULL, HL_ERR_DEGENERATE, "is that the board that was seen?");
  set = scene(VIEWS);
  test_random r = {8};
  for (int v = 0; v < VIEWS; v++)
    for (int i = 0; i < hl_target_corners(&set.target); i++) {
      set.view[v].corner[i].x = random_between(&r, 0, 639);
      set.view[v].corner[i].y = random_between(&r, 0, 479);
    }
  hl_calibration c;
  assert_int_equal(hl_calibrate(NULL, &set, NULL, &c), HL_ERR_DEGENERATE);
  hl_corners_free(&set);
}

/* The board's own numbers, a little wrong: fitted to a pixel, told all the same. */
static void test_board_shape(void **state)
{
  (void)state;
  hl_corners set = scene(VIEWS);
  set.target.spacing_ratio = 0.28;
  distrusted(set, "target spec", "instead of 0.28 would explain");
  /* a board that was printed 2 % longer along its rows: seen so, described without */
  const hl_camera camera = board_camera(HL_LENS_PINHOLE);
  const board_hold hold = board_held(&camera);
  hl_pose poses[VIEWS];
  const hl_target target = {HL_TARGET_CHESSBOARD, 10, 10, 0.023, 0};
  hl_corners plain = board_views(&camera, &target, VIEWS, 33, &hold, poses);
  for (int v = 0; v < VIEWS; v++)
    for (int i = 0; i < hl_target_corners(&target); i++) {
      double b[3], at[3], q[2];
      hl_target_corner(&target, i, b);
      b[0] *= 1.02;
      hl_pose_apply(&poses[v], b, at, NULL, NULL);
      assert_int_equal(hl_camera_project(NULL, &camera, at, q), HL_OK);
      plain.view[v].corner[i].x = q[0];
      plain.view[v].corner[i].y = q[1];
    }
  hl_corners noisy = board_noisy(&plain, 0.1, 34);
  hl_corners_free(&plain);
  distrusted(noisy, "target spec", "longer along its rows");
}

static void test_coverage(void **state)
{
  (void)state;
  const board_hold hold = {0.55, 0.9, 1.1, 0.02, 1};
  hl_corners set = scene_held(&hold, VIEWS, 0.02);
  hl_calibration c;
  hl_ctx ctx = {0};
  const hl_status st = hl_calibrate(&ctx, &set, NULL, &c);
  if (st == HL_OK) {
    assert_false(c.trusted);
    assert_true(c.coverage < 0.3);
    hl_calibration_free(&c);
  } else { /* distortion extrapolated until it folds */
    assert_int_equal(st, HL_ERR_DEGENERATE);
    assert_non_null(strstr(ctx.msg, "of the frame's cells"));
  }
  hl_corners_free(&set);
}

static void test_large_residuals(void **state)
{
  (void)state;
  const hl_camera camera = board_camera(HL_LENS_PINHOLE);
  const board_hold hold = board_held(&camera);
  distrusted(scene_held(&hold, 16, 2), "residuals", "more than a lens or a print is off by");
}

/* What the rational model is told beside the corners is said. */
static void test_held_denominator(void **state)
{
  (void)state;
  hl_corners set = scene(VIEWS);
  hl_calibration c = board_calibrated(&set, HL_MODEL_RATIONAL);
  bool said = false;
  for (int i = 0; i < c.used.n; i++)
    said = said || strcmp(c.used.note[i].what, "held denominator") == 0;
  assert_true(said);
  hl_calibration_free(&c);
  hl_corners_free(&set);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_too_few_views),    cmocka_unit_test(test_few_corners),
      cmocka_unit_test(test_corners_in_a_row), cmocka_unit_test(test_arguments),
      cmocka_unit_test(test_other_frames),     cmocka_unit_test(test_mirrored),
      cmocka_unit_test(test_parallel_boards),  cmocka_unit_test(test_another_board),
      cmocka_unit_test(test_board_shape),      cmocka_unit_test(test_coverage),
      cmocka_unit_test(test_large_residuals),  cmocka_unit_test(test_held_denominator),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
