/* Saddles on the linear plane: where they are, and what is not one. */
#include "../calib/saddle.h"

#include "board_scene.h"

enum { CORNERS = 35 };

static board_scene chessboard(double blur_px)
{
  board_scene s = board_scene_of("chessboard:7x5:0.03");
  s.blur_px = blur_px;
  s.noise = 0.002;
  board_place(&s, 0.6, 0.3, -0.4, 0.3);
  return s;
}

static hl_grey grey_of(const board_scene *s)
{
  hl_grey grey;
  hl_frame frame = board_frame(s);
  assert_int_equal(hl_grey_of(NULL, &frame, &grey), HL_OK);
  hl_frame_free(&frame);
  return grey;
}

/* The corner i with half a square to each side, moved by (dx, dy). */
static hl_cross cross_of(const board_scene *s, int i, double dx, double dy)
{
  double at[2];
  double right[2];
  double below[2];
  hl_cross c;
  board_truth(s, i, at);
  board_truth(s, i % 7 < 6 ? i + 1 : i - 1, right);
  board_truth(s, i / 7 < 4 ? i + 7 : i - 7, below);
  for (int k = 0; k < 2; k++) {
    c.across[k] = (i % 7 < 6 ? 0.5 : -0.5) * (right[k] - at[k]);
    c.down[k] = (i / 7 < 4 ? 0.5 : -0.5) * (below[k] - at[k]);
  }
  c.at[0] = at[0] + dx;
  c.at[1] = at[1] + dy;
  return c;
}

static void test_quarters(void **state)
{
  (void)state;
  const board_scene s = chessboard(0.7);
  hl_grey grey = grey_of(&s);
  for (int i = 0; i < CORNERS; i++) {
    const hl_cross c = cross_of(&s, i, 0, 0);
    double q[4];
    hl_cross_quarters(&grey, &c, q);
    for (int k = 0; k < 4; k++) { /* up left of the first corner is black */
      const bool black = (i % 7 + i / 7 + k) % 2 == 0;
      assert_near(q[k], black ? 0.03 : 0.8, 0.02);
    }
  }
  hl_grey_free(&grey);
}

static void test_window_fits_the_quarters(void **state)
{
  (void)state;
  const hl_cross square = {{0, 0}, {10, 0}, {0, 10}};
  const hl_cross narrow = {{0, 0}, {20, 0}, {0, 5}};
  const hl_cross slanted = {{0, 0}, {10, 0}, {10, 5}};
  const hl_cross large = {{0, 0}, {90, 0}, {0, 90}};
  const hl_cross none = {{0, 0}, {0, 0}, {0, 0}};
  assert_int_equal(hl_cross_half(&square), 6);
  assert_int_equal(hl_cross_half(&narrow), 3);
  assert_int_equal(hl_cross_half(&slanted), 3); /* 50 / 11.2 px to the nearer side */
  assert_int_equal(hl_cross_half(&large), HL_SADDLE_HALF_MAX);
  assert_int_equal(hl_cross_half(&none), 0);
}

#ifdef HL_HAVE_OPENCV

/* From up to a pixel away, at any blur that leaves the quarters' middles alone. */
static void test_corners_are_found(void **state)
{
  (void)state;
  test_random random = {3};
  for (int step = 0; step < 3; step++) {
    const double blur = 0.5 * pow(2, step);
    const board_scene s = chessboard(blur);
    hl_grey grey = grey_of(&s);
    hl_cross cross[CORNERS];
    bool moved[CORNERS];
    double sum = 0;
    for (int i = 0; i < CORNERS; i++)
      cross[i] = cross_of(&s, i, random_between(&random, -1, 1), random_between(&random, -1, 1));
    assert_int_equal(hl_saddles_refine(NULL, &grey, cross, moved, CORNERS), HL_OK);
    for (int i = 0; i < CORNERS; i++) {
      double truth[2];
      board_truth(&s, i, truth);
      assert_true(moved[i]);
      assert_near(cross[i].at[0], truth[0], 0.12);
      assert_near(cross[i].at[1], truth[1], 0.12);
      sum += pow(cross[i].at[0] - truth[0], 2) + pow(cross[i].at[1] - truth[1], 2);
    }
    assert_true(sqrt(sum / CORNERS) < 0.05);
    hl_grey_free(&grey);
  }
}

/* Too far off, without room for a window, at the frame's rim, on a flat: it stays, and says so. */
static void test_what_is_no_saddle_stays(void **state)
{
  (void)state;
  const board_scene s = chessboard(0.7);
  hl_grey grey = grey_of(&s);
  hl_cross cross[5] = {cross_of(&s, 10, 7, 0),
                       cross_of(&s, 10, 0.3, 0.3),
                       cross_of(&s, 10, 0, 0),
                       {{400, 2}, {30, 0}, {0, 30}},
                       {{700, 500}, {30, 0}, {0, 30}}};
  bool moved[5];
  for (int k = 0; k < 2; k++) {
    cross[1].across[k] *= 0.1;
    cross[1].down[k] *= 0.1;
  }
  for (int y = 0; y < 480; y++) /* corner 10 lies on a flat now */
    for (int x = 0; x < 640; x++)
      if (fabs(x - cross[2].at[0]) < 30 && fabs(y - cross[2].at[1]) < 30)
        grey.linear[y * 640 + x] = 0.3f;
  hl_cross before[5];
  memcpy(before, cross, sizeof cross);
  assert_int_equal(hl_saddles_refine(NULL, &grey, cross, moved, 5), HL_OK);
  for (int i = 0; i < 5; i++) {
    assert_false(moved[i]);
    assert_memory_equal(&cross[i], &before[i], sizeof before[i]);
  }
  hl_grey_free(&grey);
}

#else

static void test_unavailable(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  const board_scene s = chessboard(0.7);
  hl_grey grey = grey_of(&s);
  hl_cross cross = cross_of(&s, 10, 0, 0);
  bool moved;
  assert_int_equal(hl_saddles_refine(&ctx, &grey, &cross, &moved, 1), HL_ERR_UNAVAILABLE);
  assert_non_null(strstr(ctx.msg, "-DHL_WITH_OPENCV=ON"));
  assert_false(moved);
  hl_grey_free(&grey);
}

#endif

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_quarters),
      cmocka_unit_test(test_window_fits_the_quarters),
#ifdef HL_HAVE_OPENCV
      cmocka_unit_test(test_corners_are_found),
      cmocka_unit_test(test_what_is_no_saddle_stays),
#else
      cmocka_unit_test(test_unavailable),
#endif
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
