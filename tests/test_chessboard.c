/* Which corner of a chessboard is the first, and what is no view of the target. */
#include "../calib/chessboard.h"

#include "board_scene.h"
#include "files.h"

enum { CORNERS_MAX = 81 };

static board_scene board(const char *spec, double turn)
{
  board_scene s = board_scene_of(spec);
  s.blur_px = 0.7;
  s.noise = 0.004;
  s.slope = 0.5;
  board_place(&s, 0.6, 0.3, -0.3, turn);
  return s;
}

/* Looks for `spec` where the scene shows its own target. */
static hl_status look(const board_scene *s, const char *spec, hl_ctx *ctx,
                      hl_corner corner[CORNERS_MAX], char why[HL_REASON_MAX])
{
  hl_grey grey;
  hl_target target;
  hl_detection detection;
  hl_frame frame = board_frame(s);
  memset(corner, 0, CORNERS_MAX * sizeof *corner);
  assert_int_equal(hl_target_parse(NULL, spec, &target), HL_OK);
  assert_int_equal(hl_grey_of(NULL, &frame, &grey), HL_OK);
  hl_frame_free(&frame);
  const hl_status st = hl_chessboard_find(ctx, &target, &grey, corner, &detection, why);
  hl_grey_free(&grey);
  return st;
}

#ifdef HL_HAVE_OPENCV

static void found(const board_scene *s, const char *spec, hl_corner corner[CORNERS_MAX])
{
  char why[HL_REASON_MAX];
  assert_int_equal(look(s, spec, NULL, corner, why), HL_OK);
  assert_string_equal(why, "");
}

static void refused(const board_scene *s, const char *spec, const char *part)
{
  hl_corner corner[CORNERS_MAX];
  char why[HL_REASON_MAX];
  assert_int_equal(look(s, spec, NULL, corner, why), HL_OK);
  assert_says(why, part);
  for (int i = 0; i < CORNERS_MAX; i++)
    assert_near(corner[i].sigma, 0, 0);
}

/* Corner i is the truth's corner order(i). */
static void assert_order(const board_scene *s, const hl_corner *corner, bool reversed)
{
  const int n = hl_target_corners(&s->target);
  for (int i = 0; i < n; i++) {
    double truth[2];
    board_truth(s, reversed ? n - 1 - i : i, truth);
    assert_near(corner[i].x, truth[0], 0.2);
    assert_near(corner[i].y, truth[1], 0.2);
    assert_near(corner[i].sigma, 1, 0);
  }
}

/* Columns plus rows odd: whichever way the board is held, its own first corner is the first. */
static void test_one_way_round(void **state)
{
  (void)state;
  static const char *const specs[] = {"chessboard:6x5:0.02", "chessboard:5x6:0.02"};
  hl_corner corner[CORNERS_MAX];
  for (int k = 0; k < 2; k++)
    for (int step = 0; step < 4; step++) {
      const double turn = -3 + 1.5 * step;
      const board_scene s = board(specs[k], turn);
      found(&s, specs[k], corner);
      assert_order(&s, corner, false);
    }
}

/* Both even, or both odd: two ways look alike, and x points to the right. */
static void test_two_ways_round(void **state)
{
  (void)state;
  static const char *const specs[] = {"chessboard:6x4:0.02", "chessboard:7x5:0.02"};
  hl_corner corner[CORNERS_MAX];
  for (int k = 0; k < 2; k++)
    for (int step = 0; step < 5; step++) {
      const double turn = -2.8 + 1.4 * step;
      const board_scene s = board(specs[k], turn);
      found(&s, specs[k], corner);
      assert_order(&s, corner, fabs(turn) > 1.5);
    }
}

/* A square board looks alike in two or four ways; the first square is black, and x points to the
 * right as far as that lets it. */
static void test_square_boards(void **state)
{
  (void)state;
  static const char *const specs[] = {"chessboard:5x5:0.02", "chessboard:6x6:0.02"};
  hl_corner corner[CORNERS_MAX];
  for (int k = 0; k < 2; k++)
    for (int step = 0; step < 9; step++) {
      const double turn = -2.9 + 0.7 * step;
      const board_scene s = board(specs[k], turn);
      const int side = s.target.columns;
      found(&s, specs[k], corner);
      const double x[2] = {corner[side - 1].x - corner[0].x, corner[side - 1].y - corner[0].y};
      const double y[2] = {corner[side * (side - 1)].x - corner[0].x,
                           corner[side * (side - 1)].y - corner[0].y};
      assert_true(x[0] * y[1] - x[1] * y[0] > 0);
      assert_true(x[0] > 0);
      if (side % 2 == 0)
        assert_true(x[0] / hypot(x[0], x[1]) > fabs(y[0]) / hypot(y[0], y[1]) - 0.1);
      else { /* half a turn at most from the print: the other two ways begin with white */
        double first[2];
        double last[2];
        board_truth(&s, 0, first);
        board_truth(&s, side - 1, last);
        assert_order(&s, corner, last[0] < first[0]);
      }
    }
}

/* What a mirror shows is the same chessboard where a side is even, and x turns to y as it must. */
static void test_even_boards_do_not_tell_mirrors(void **state)
{
  (void)state;
  hl_corner corner[CORNERS_MAX];
  board_scene s = board("chessboard:6x5:0.02", 0.2);
  s.mirrored = true;
  found(&s, "chessboard:6x5:0.02", corner);
  assert_true((corner[5].x - corner[0].x) * (corner[24].y - corner[0].y) -
                  (corner[5].y - corner[0].y) * (corner[24].x - corner[0].x) >
              0);
}

static void test_odd_boards_tell_mirrors(void **state)
{
  (void)state;
  static const char part[] = "the board is seen mirrored, or its first square is white: photograph "
                             "it directly or flip the frames, or give it as 5x7";
  hl_corner corner[CORNERS_MAX];
  board_scene s = board("chessboard:7x5:0.02", 0.2);
  s.mirrored = true;
  refused(&s, "chessboard:7x5:0.02", part);
  s.mirrored = false;
  s.white_first = true;
  refused(&s, "chessboard:7x5:0.02", part);
  found(&s, "chessboard:5x7:0.02", corner); /* as the reason says */
}

static void test_other_boards(void **state)
{
  (void)state;
  const board_scene s = board("chessboard:7x5:0.02", 0.2);
  refused(&s, "chessboard:8x5:0.02",
          "no whole chessboard of 8 x 5 inner corners; one of about 7 x 5 is seen");
  refused(&s, "chessboard:6x4:0.02", "6 x 4");
}

/* The detector may find a part of a larger board; the pattern then goes on. */
static void test_a_part_of_a_board(void **state)
{
  (void)state;
  hl_corner corner[CORNERS_MAX];
  char why[HL_REASON_MAX];
  int gone_on = 0;
  for (int columns = 3; columns < 7; columns++)
    for (int rows = 3; rows < 6; rows++) {
      char spec[HL_TARGET_SPEC_MAX];
      const board_scene s = board("chessboard:7x5:0.02", 0.2);
      snprintf(spec, sizeof spec, "chessboard:%dx%d:0.02", columns, rows);
      assert_int_equal(look(&s, spec, NULL, corner, why), HL_OK);
      assert_true(strlen(why) > 0);
      gone_on += strstr(why, "the pattern goes on: at least") != NULL;
    }
  print_message("%d of 12 parts were found as boards\n", gone_on);
  assert_true(gone_on > 0);
}

static void test_no_board(void **state)
{
  (void)state;
  board_scene s = board("chessboard:7x5:0.02", 0.2);
  s.black = s.white = s.around;
  refused(&s, "chessboard:7x5:0.02",
          "no chessboard was found; the target has 7 x 5 inner corners, all must be seen");
  s = board("chessboard:7x5:0.02", 0.2);
  s.blur_px = 14;
  refused(&s, "chessboard:7x5:0.02", "the frame is blurred by at least ");
}

#else

static void test_unavailable(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  hl_corner corner[CORNERS_MAX];
  char why[HL_REASON_MAX];
  const board_scene s = board("chessboard:7x5:0.02", 0.2);
  assert_int_equal(look(&s, "chessboard:7x5:0.02", &ctx, corner, why), HL_ERR_UNAVAILABLE);
  assert_says(ctx.msg, "-DHL_WITH_OPENCV=ON");
}

#endif

int main(void)
{
  const struct CMUnitTest tests[] = {
#ifdef HL_HAVE_OPENCV
      cmocka_unit_test(test_one_way_round),
      cmocka_unit_test(test_two_ways_round),
      cmocka_unit_test(test_square_boards),
      cmocka_unit_test(test_even_boards_do_not_tell_mirrors),
      cmocka_unit_test(test_odd_boards_tell_mirrors),
      cmocka_unit_test(test_other_boards),
      cmocka_unit_test(test_a_part_of_a_board),
      cmocka_unit_test(test_no_board),
#else
      cmocka_unit_test(test_unavailable),
#endif
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
