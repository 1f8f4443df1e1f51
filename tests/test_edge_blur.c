/* How sharp edges and frames are, on boards blurred by known amounts. */
#include "../calib/edge_blur.h"

#include "../calib/frame_blur.h"
#include "board_scene.h"

static hl_grey grey_of(const board_scene *s)
{
  hl_grey grey;
  hl_frame frame = board_frame(s);
  assert_int_equal(hl_grey_of(NULL, &frame, &grey), HL_OK);
  hl_frame_free(&frame);
  return grey;
}

static board_scene chessboard(double blur_px)
{
  board_scene s = board_scene_of("chessboard:7x5:0.03");
  s.blur_px = blur_px;
  s.noise = 0.005;
  board_place(&s, 0.7, 0.2, -0.3, 0.3);
  return s;
}

/* The blur and the pixel's own width together. Squares have 60 px. */
static void test_an_edge(void **state)
{
  (void)state;
  for (int step = 0; step < 4; step++) {
    const double blur = 0.5 * pow(2, step);
    const board_scene s = chessboard(blur);
    hl_grey grey = grey_of(&s);
    for (int i = 8; i < 12; i++) {
      double a[2];
      double b[2];
      board_truth(&s, i, a);
      board_truth(&s, i + 1, b);
      const double want = sqrt(blur * blur + 1.0 / 12);
      assert_near(hl_edge_blur(&grey, a, b, 25), want, 0.05 * want + 0.05);
      assert_near(hl_edge_blur(&grey, b, a, 25), want, 0.05 * want + 0.05);
    }
    hl_grey_free(&grey);
  }
}

/* Along a square's middle there is no step. */
static void test_no_edge(void **state)
{
  (void)state;
  const board_scene s = chessboard(0.7);
  hl_grey grey = grey_of(&s);
  double p[3][2];
  board_truth(&s, 8, p[0]);
  board_truth(&s, 16, p[1]);
  const double along[2] = {0.2 * (p[1][0] - p[0][0]), 0.2 * (p[1][1] - p[0][1])};
  const double middle[2] = {(p[0][0] + p[1][0]) / 2, (p[0][1] + p[1][1]) / 2};
  const double a[2] = {middle[0] - along[0], middle[1] - along[1]};
  const double b[2] = {middle[0] + along[0], middle[1] + along[1]};
  assert_true(isnan(hl_edge_blur(&grey, a, b, 6)));
  assert_true(isnan(hl_edge_blur(&grey, a, a, 6)));
  assert_true(isnan(hl_edge_blur(&grey, a, b, 0.5)));
  assert_true(isnan(hl_edge_blur(&grey, a, b, NAN)));
  hl_grey_free(&grey);
}

/* As its head says: right up to 2 px, at least so much beyond. */
static void test_a_frame(void **state)
{
  (void)state;
  for (int step = 1; step <= 7; step++) {
    const double blur = 0.7 * step;
    const board_scene s = chessboard(blur);
    hl_grey grey = grey_of(&s);
    const double got = hl_frame_blur(&grey);
    const double want = sqrt(blur * blur + 1.0 / 12);
    assert_true(got < want + 0.15);
    assert_true(got > fmin(want, 2.2) - 0.15);
    hl_grey_free(&grey);
  }
}

static void test_what_a_frame_says(void **state)
{
  (void)state;
  char why[HL_REASON_MAX] = "no board";
  board_scene s = chessboard(0.7);
  hl_grey grey = grey_of(&s);
  hl_frame_blur_say(&grey, why);
  assert_string_equal(why, "no board");
  hl_grey_free(&grey);
  s = chessboard(3);
  grey = grey_of(&s);
  assert_true(hl_frame_blur_say(&grey, why) > 2);
  assert_non_null(strstr(why, "no board; the frame is blurred by at least 2."));
  memset(why, 'a', sizeof why);
  why[HL_REASON_MAX - 1] = '\0';
  hl_frame_blur_say(&grey, why); /* no room: it stays */
  assert_int_equal(strlen(why), HL_REASON_MAX - 1);
  hl_grey_free(&grey);
}

static void test_flat_and_small_frames_have_none(void **state)
{
  (void)state;
  static float flat[200 * 100];
  for (int i = 0; i < 200 * 100; i++)
    flat[i] = 0.5f;
  const int sizes[2][2] = {{200, 100}, {20, 20}};
  for (int i = 0; i < 2; i++) {
    hl_frame frame;
    hl_grey grey;
    assert_int_equal(hl_frame_from_codes(NULL, flat, sizes[i][0], sizes[i][1], 1, 32, NULL, &frame),
                     HL_OK);
    assert_int_equal(hl_grey_of(NULL, &frame, &grey), HL_OK);
    assert_near(hl_frame_blur(&grey), 0, 0);
    hl_grey_free(&grey);
    hl_frame_free(&frame);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_an_edge),
      cmocka_unit_test(test_no_edge),
      cmocka_unit_test(test_a_frame),
      cmocka_unit_test(test_what_a_frame_says),
      cmocka_unit_test(test_flat_and_small_frames_have_none),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
