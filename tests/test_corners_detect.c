/* Targets in frames: how near to the truth their corners are, and which views are left out. */
#include <stdio.h>
#include <string.h>

#include "board_scene.h"
#include "files.h"
#include "halflight/corners.h"
#include "quiet.h"

#ifdef HL_HAVE_OPENCV
static const bool has_opencv = true;
#else
static const bool has_opencv = false;
#endif

static const char grid[] = "aprilgrid:6x6:0.03:0.3";
static const char chess[] = "chessboard:9x6:0.02";

/* A board of the spec, `share` of the frame wide or high. */
static board_scene scene(const char *spec, double share, double rx, double ry, double rz)
{
  board_scene s = board_scene_of(spec);
  s.blur_px = 0.7;
  s.noise = 0.004;
  s.slope = 0.6;
  board_place(&s, share, rx, ry, rz);
  if (s.target.kind == HL_TARGET_APRILGRID && !board_print(&s))
    skip();
  return s;
}

/* The only view of a set that looks for `target`. */
static hl_corners detect_as(const board_scene *s, const hl_target *target, hl_detection *detection)
{
  hl_ctx ctx = {0};
  hl_corners set = hl_corners_of(target);
  hl_frame frame = board_frame(s);
  const hl_status st = hl_corners_detect(&ctx, &set, &frame, "f.png", detection);
  if (st != HL_OK)
    print_error("%s\n", ctx.msg);
  assert_int_equal(st, HL_OK);
  assert_int_equal(set.n_views, 1);
  assert_int_equal(set.width, frame.width);
  assert_int_equal(set.height, frame.height);
  assert_string_equal(set.view[0].name, "f.png");
  hl_frame_free(&frame);
  return set;
}

static hl_corners detect(const board_scene *s, hl_detection *detection)
{
  return detect_as(s, &s->target, detection);
}

typedef struct statistics {
  int n, gross;
  double sum[2], squares, worst;
} statistics;

/* Those farther off than `gross` px are counted apart. */
static void compare(const board_scene *s, const hl_view *view, double gross, statistics *out)
{
  for (int i = 0; i < hl_target_corners(&s->target); i++) {
    const hl_corner *c = &view->corner[i];
    double truth[2];
    if (!(c->sigma > 0))
      continue;
    board_truth(s, i, truth);
    const double x = c->x - truth[0];
    const double y = c->y - truth[1];
    const double d = hypot(x, y);
    if (d > gross) {
      out->gross++;
      continue;
    }
    out->n++;
    out->sum[0] += x;
    out->sum[1] += y;
    out->squares += d * d / 2;
    out->worst = fmax(out->worst, d);
  }
}

static double bias(const statistics *t, int axis)
{
  return t->sum[axis] / t->n;
}

static double rms(const statistics *t)
{
  return sqrt(t->squares / t->n);
}

/* Six views all over the angles; returns what they are off. */
static statistics survey(board_scene *s, double share, double tilt, int *seen)
{
  statistics t = {0};
  test_random random = {21};
  *seen = 0;
  for (int i = 0; i < 6; i++) {
    hl_detection saw;
    const double rx = random_between(&random, -tilt, tilt);
    const double ry = random_between(&random, -tilt, tilt);
    board_place(s, share, rx, ry, random_between(&random, -3, 3));
    s->seed = (unsigned)i;
    hl_corners set = detect(s, &saw);
    assert_string_equal(set.view[0].why, "");
    assert_true(set.view[0].used);
    *seen += set.view[0].seen;
    compare(s, &set.view[0], 1.5, &t);
    hl_corners_free(&set);
  }
  return t;
}

/* ---------------------------------------------------------------- how near to the truth */

/* A wrong origin of AprilTag's pixels would show as a bias of half a pixel, edges instead of saddles
 * as 0.5 px of scatter. */
static void test_kalibrs_boards(void **state)
{
  (void)state;
  for (int bits = 1; bits <= 2; bits++) {
    int seen;
    board_scene s = scene(grid, 0.6, 0, 0, 0);
    s.border_bits = bits;
    const statistics t = survey(&s, 0.6, 0.6, &seen);
    assert_true(seen >= 6 * 140);
    if (!has_opencv)
      continue;
    assert_near(bias(&t, 0), 0, 0.01);
    assert_near(bias(&t, 1), 0, 0.01);
    assert_near(rms(&t), 0, 0.04);
    assert_int_equal(t.gross, 0);
  }
}

static void test_kalibrs_boards_through_a_lens(void **state)
{
  (void)state;
  int seen;
  board_scene s = scene(grid, 0.6, 0, 0, 0);
  s.camera.distortion[0] = -0.3;
  s.camera.distortion[1] = 0.1;
  s.camera.fx = s.camera.fy = 500;
  const statistics t = survey(&s, 0.6, 0.5, &seen);
  assert_true(seen >= 6 * 140);
  if (!has_opencv)
    return;
  assert_near(bias(&t, 0), 0, 0.01);
  assert_near(bias(&t, 1), 0, 0.01);
  assert_near(rms(&t), 0, 0.04);
}

/* Tags that stand alone have AprilTag's edges, without OpenCV too. */
static void test_tags_that_stand_alone(void **state)
{
  (void)state;
  int seen;
  board_scene s = scene(grid, 0.7, 0, 0, 0);
  s.isolated = true;
  s.border_bits = 1;
  const statistics t = survey(&s, 0.7, 0.5, &seen);
  assert_true(seen >= 6 * 136);
  assert_near(bias(&t, 0), 0, 0.02);
  assert_near(bias(&t, 1), 0, 0.02);
  assert_near(rms(&t), 0, 0.06);
}

static void test_chessboards(void **state)
{
  (void)state;
  int seen;
  if (!has_opencv)
    skip();
  board_scene s = scene(chess, 0.5, 0, 0, 0);
  const statistics t = survey(&s, 0.5, 0.5, &seen);
  assert_int_equal(seen, 6 * 54);
  assert_near(bias(&t, 0), 0, 0.01);
  assert_near(bias(&t, 1), 0, 0.01);
  assert_near(rms(&t), 0, 0.03);
  assert_int_equal(t.gross, 0);
}

/* Ids from the top left, tags printed turned: the corners stay where they are on the board. */
static void test_other_numberings(void **state)
{
  (void)state;
  for (int i = 1; i < 4; i++) {
    statistics t = {0};
    hl_detection saw;
    board_scene s = scene(grid, 0.7, 0.3, -0.3, 2);
    s.top_left_ids = i != 2;
    s.turned = i == 3 ? 1 : i == 2 ? 2 : 0;
    assert_true(board_print(&s));
    hl_corners set = detect(&s, &saw);
    assert_int_equal(saw.top_left_ids, s.top_left_ids);
    assert_true(set.view[0].used);
    compare(&s, &set.view[0], 1.5, &t);
    assert_true(t.n >= 140);
    assert_int_equal(t.gross, 0);
    hl_corners_free(&set);
  }
}

/* What leaves the frame is not seen; what is left stays in its place on the board. */
static void test_boards_in_part(void **state)
{
  (void)state;
  statistics t = {0};
  hl_detection saw;
  board_scene s = scene(grid, 1.4, 0.2, 0.2, 0.5);
  hl_corners set = detect(&s, &saw);
  assert_true(set.view[0].used);
  assert_true(saw.tags > 8 && saw.tags < 32);
  assert_true(set.view[0].seen > 3 * saw.tags && set.view[0].seen <= 4 * saw.tags);
  compare(&s, &set.view[0], 1.5, &t);
  assert_int_equal(t.gross, 0);
  for (int i = 0; i < hl_target_corners(&s.target); i++) {
    const hl_corner *c = &set.view[0].corner[i];
    assert_true(c->sigma > 0 ? c->x >= 0 && c->y >= 0 && c->x <= 639 && c->y <= 479
                             : c->x == 0 && c->y == 0);
  }
  hl_corners_free(&set);
}

/* ---------------------------------------------------------------- views that are left out */

static void left_out_as(const board_scene *s, const hl_target *target, const char *part)
{
  hl_detection saw;
  hl_corners set = detect_as(s, target, &saw);
  assert_false(set.view[0].used);
  assert_says(set.view[0].why, part);
  hl_corners_free(&set);
}

static void left_out(const board_scene *s, const char *part)
{
  left_out_as(s, &s->target, part);
}

static void test_mirrored(void **state)
{
  (void)state;
  board_scene s = scene(grid, 0.7, 0.3, -0.3, 0.2);
  s.mirrored = true;
  left_out(&s, "the board is seen mirrored: photograph it directly, not through a mirror, or flip "
               "the frames");
}

static void test_blurred(void **state)
{
  (void)state;
  board_scene s = scene(grid, 0.8, 0.1, 0.1, 0.2);
  s.blur_px = 5;
  left_out(&s, "no tag of family tag36h11 was found; the target has 36; the frame is blurred by at "
               "least ");
  if (!has_opencv)
    return;
  s = scene(chess, 0.4, 0.1, 0.1, 0.2);
  s.blur_px = 5;
  left_out(&s, "the board is blurred by ");
}

/* The blur that is told is the one that was there, with the pixel's own. */
static void test_blur_is_told(void **state)
{
  (void)state;
  for (int step = 0; step < 3; step++) {
    const double blur = 0.6 * pow(1.6, step);
    hl_detection saw;
    board_scene s = scene(grid, 0.8, 0.1, 0.1, 0.2);
    s.blur_px = blur;
    hl_corners set = detect(&s, &saw);
    assert_true(set.view[0].used);
    const double want = sqrt(blur * blur + 1.0 / 12);
    assert_near(saw.blur_px, want, has_opencv ? 0.07 * want : 0.3 * want);
    hl_corners_free(&set);
  }
}

static void test_another_grid(void **state)
{
  (void)state;
  hl_target target;
  hl_detection saw;
  const board_scene s = scene("aprilgrid:6x4:0.03:0.3", 0.7, 0.3, -0.3, 0.2);
  assert_int_equal(hl_target_parse(NULL, "aprilgrid:5x5:0.03:0.3", &target), HL_OK);
  left_out_as(&s, &target,
              "saw 24 tags of this family, ids 0 .. 23; the target has 25 in 5 "
              "columns, but these lie as in 6");
  assert_int_equal(hl_target_parse(NULL, "aprilgrid:6x4:0.03:0.2", &target), HL_OK);
  left_out_as(&s, &target, "the tags are 0.30 of a tag apart; the target's spacing ratio is 0.2");
  /* a target that ends earlier has the tags that it has */
  assert_int_equal(hl_target_parse(NULL, "aprilgrid:6x3:0.03:0.3", &target), HL_OK);
  hl_corners set = detect_as(&s, &target, &saw);
  assert_true(set.view[0].used);
  assert_int_equal(saw.tags, 24);
  assert_int_equal(saw.foreign, 6);
  assert_true(set.view[0].seen <= 72);
  hl_corners_free(&set);
}

static void test_too_little(void **state)
{
  (void)state;
  const board_scene one = scene("aprilgrid:1x1:0.03:0.3", 0.3, 0.3, -0.3, 0.2);
  left_out(&one, "saw 1 tag of this family, ids 0 .. 0; the target has 1");
  board_scene none = scene(grid, 0.7, 0, 0, 0);
  none.black = none.white = none.around;
  left_out(&none, "no tag of family tag36h11 was found; the target has 36");
}

/* A tag that is there twice is not taken; two are enough where they can be compared. */
static void test_twice(void **state)
{
  (void)state;
  hl_detection saw;
  board_scene s = scene("aprilgrid:3x2:0.03:0.3", 0.6, 0.3, -0.3, 0.2);
  memcpy(s.cells[0], s.cells[4], sizeof s.cells[0]); /* top left: 3, now like bottom middle, 1 */
  hl_corners set = detect(&s, &saw);
  assert_int_equal(saw.tags, 6);
  assert_true(set.view[0].used);
  assert_int_equal(set.view[0].seen, 16);
  static const int gone[8] = {0, 1, 6, 7, 14, 15, 20, 21};
  for (int i = 0; i < 8; i++)
    assert_near(set.view[0].corner[gone[i]].sigma, 0, 0);
  hl_corners_free(&set);
  for (int i = 1; i < 6; i++)
    memcpy(s.cells[i], s.cells[0], sizeof s.cells[0]);
  left_out(&s, "saw 6 tags of this family, ids 1 .. 1; the target has 6, each once");
}

/* A tag that belongs elsewhere, though its id is one of the target's and there once. */
static void test_a_tag_in_a_wrong_place(void **state)
{
  (void)state;
  statistics t = {0};
  hl_detection saw;
  board_scene s = scene(grid, 0.7, 0.3, -0.3, 0.2);
  board_scene other = scene(grid, 0.7, 0, 0, 0);
  memcpy(s.cells[8], other.cells[27], sizeof s.cells[8]);
  memcpy(s.cells[27], other.cells[8], sizeof s.cells[27]);
  hl_corners set = detect(&s, &saw);
  assert_int_equal(saw.tags, 36);
  assert_true(set.view[0].used);
  compare(&s, &set.view[0], 1.5, &t);
  assert_int_equal(t.gross, 0);
  assert_int_equal(t.n, 4 * 34);
  hl_corners_free(&set);
}

/* ---------------------------------------------------------------- the call */

/* Frames as recorded: in colour, 8 bits, clipped, with pixels that are none. */
static void test_frames_of_all_kinds(void **state)
{
  (void)state;
  statistics t = {0};
  hl_detection saw;
  const board_scene s = scene(grid, 0.7, 0.3, -0.3, 0.2);
  hl_frame float_frame = board_frame(&s);
  const size_t n = 640 * 480;
  uint8_t *codes = malloc(3 * n);
  assert_non_null(codes);
  for (size_t i = 0; i < n; i++) {
    const double linear = fmin(fmax((double)float_frame.radiance[i], 0), 1);
    const double code = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    for (int c = 0; c < 3; c++)
      codes[3 * i + (size_t)c] = (uint8_t)lrint(255 * code);
  }
  hl_frame frame;
  assert_int_equal(hl_frame_from_codes(NULL, codes, 640, 480, 3, 8, NULL, &frame), HL_OK);
  for (size_t i = 0; i < 3 * n; i += 1009) { /* dead samples; 1009 is prime */
    frame.radiance[i] = 0;
    frame.state[i] = HL_SAMPLE_UNUSABLE;
  }
  hl_corners set = hl_corners_of(&s.target);
  assert_int_equal(hl_corners_detect(NULL, &set, &frame, "f.png", &saw), HL_OK);
  assert_true(set.view[0].used);
  compare(&s, &set.view[0], 1.5, &t);
  assert_true(t.n >= 140);
  if (has_opencv)
    assert_near(rms(&t), 0, 0.04);
  hl_corners_free(&set);
  hl_frame_free(&frame);
  hl_frame_free(&float_frame);
  free(codes);
}

/* Dim frames in any unit. */
static void test_scale_does_not_matter(void **state)
{
  (void)state;
  const board_scene s = scene(grid, 0.7, 0.3, -0.3, 0.2);
  hl_corners one = detect(&s, NULL);
  hl_frame frame = board_frame(&s);
  for (size_t i = 0; i < 640 * 480; i++)
    frame.radiance[i] *= 0x1p-13f; /* a power of two changes no digit */
  hl_corners other = hl_corners_of(&s.target);
  assert_int_equal(hl_corners_detect(NULL, &other, &frame, "f.png", NULL), HL_OK);
  assert_memory_equal(one.view[0].corner, other.view[0].corner, 144 * sizeof(hl_corner));
  hl_corners_free(&one);
  hl_corners_free(&other);
  hl_frame_free(&frame);
}

/* Bit for bit, and as a .vnl holds it. */
static void test_repeats_and_survives_a_file(void **state)
{
  (void)state;
  const char *const specs[2] = {grid, chess};
  for (int k = 0; k < (has_opencv ? 2 : 1); k++) {
    char path[TEST_PATH_MAX];
    path_in(state, "kept.vnl", path);
    const board_scene s = scene(specs[k], 0.6, 0.3, -0.3, 0.2);
    const size_t n = (size_t)hl_target_corners(&s.target);
    hl_corners one = detect(&s, NULL);
    hl_corners two = detect(&s, NULL);
    hl_corners kept;
    assert_true(one.view[0].used);
    assert_memory_equal(one.view[0].corner, two.view[0].corner, n * sizeof(hl_corner));
    assert_int_equal(hl_corners_write(NULL, path, &one), HL_OK);
    assert_int_equal(hl_corners_read(NULL, path, &s.target, &kept), HL_OK);
    assert_memory_equal(one.view[0].corner, kept.view[0].corner, n * sizeof(hl_corner));
    hl_corners_free(&one);
    hl_corners_free(&two);
    hl_corners_free(&kept);
  }
}

static void test_silent(void **state)
{
  (void)state;
  const char *const specs[2] = {grid, chess};
  for (int k = 0; k < (has_opencv ? 2 : 1); k++) {
    const board_scene s = scene(specs[k], 0.6, 0.3, -0.3, 0.2);
    hl_frame frame = board_frame(&s);
    hl_corners set = hl_corners_of(&s.target);
    quiet q = quiet_begin();
    const hl_status st = hl_corners_detect(NULL, &set, &frame, "f.png", NULL);
    assert_int_equal(quiet_end(&q), 0);
    assert_int_equal(st, HL_OK);
    hl_corners_free(&set);
    hl_frame_free(&frame);
  }
}

static void test_refusals_append_nothing(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  hl_detection saw = {.tags = -7};
  char name[300];
  const board_scene s = scene(grid, 0.7, 0.3, -0.3, 0.2);
  hl_frame frame = board_frame(&s);
  hl_corners set = hl_corners_of(&s.target);
  memset(name, 'n', sizeof name);
  name[sizeof name - 1] = '\0';
  assert_int_equal(hl_corners_detect(&ctx, &set, &frame, name, &saw), HL_ERR_ARG);
  assert_says(ctx.msg, "name of view 0 has 299 bytes");
  assert_int_equal(set.n_views, 0);
  assert_int_equal(set.width, 0);
  assert_int_equal(saw.tags, -7);
  assert_int_equal(hl_corners_detect(&ctx, &set, &frame, "a.png", &saw), HL_OK);
  frame.width = 320;
  frame.height = 960;
  assert_int_equal(hl_corners_detect(&ctx, &set, &frame, "b.png", NULL), HL_ERR_FORMAT);
  assert_says(ctx.msg, "b.png: 320 x 960 pixels; the frames before have 640 x 480, and one camera "
                       "has one size");
  frame.width = 640 * 480;
  frame.height = 1;
  assert_int_equal(hl_corners_detect(&ctx, &set, &frame, "b.png", NULL), HL_ERR_FORMAT);
  assert_says(ctx.msg, "b.png: 307200 x 1 pixels; at least 2 x 2 are needed");
  assert_int_equal(set.n_views, 1);
  frame.width = 640;
  frame.height = 480;
  hl_frame_free(&frame);
  hl_corners_free(&set);
}

/* Frames too small for any board. */
static void test_tiny_frames(void **state)
{
  (void)state;
  static const float pixel[64] = {0.5f};
  static const int sizes[3][2] = {{2, 2}, {2, 32}, {8, 8}};
  const char *const specs[2] = {grid, chess};
  for (int k = 0; k < 6; k++) {
    hl_frame frame;
    hl_corners set;
    hl_target target;
    const int *size = sizes[k % 3];
#ifndef HL_HAVE_APRILTAG
    if (k < 3)
      continue;
#endif
    if (k >= 3 && !has_opencv)
      continue;
    assert_int_equal(hl_target_parse(NULL, specs[k / 3], &target), HL_OK);
    assert_int_equal(hl_frame_from_codes(NULL, pixel, size[0], size[1], 1, 32, NULL, &frame),
                     HL_OK);
    set = hl_corners_of(&target);
    assert_int_equal(hl_corners_detect(NULL, &set, &frame, "tiny.png", NULL), HL_OK);
    assert_int_equal(set.n_views, 1);
    assert_false(set.view[0].used);
    assert_true(set.view[0].why[0] != '\0');
    hl_corners_free(&set);
    hl_frame_free(&frame);
  }
}

/* What this build cannot look for. */
static void test_unavailable(void **state)
{
  (void)state;
  hl_frame frame = {.width = 200, .height = 200, .channels = 1, .bits = 32};
  frame.radiance = calloc(200 * 200, sizeof *frame.radiance);
  frame.state = calloc(200 * 200, 1);
  assert_true(frame.radiance && frame.state);
  const char *const specs[2] = {grid, chess};
  static const char *const options[2] = {"-DHL_WITH_APRILTAG=ON", "-DHL_WITH_OPENCV=ON"};
  bool there[2] = {false, has_opencv};
#ifdef HL_HAVE_APRILTAG
  there[0] = true;
#endif
  for (int k = 0; k < 2; k++) {
    hl_ctx ctx = {0};
    hl_target target;
    assert_int_equal(hl_target_parse(NULL, specs[k], &target), HL_OK);
    hl_corners set = hl_corners_of(&target);
    const hl_status st = hl_corners_detect(&ctx, &set, &frame, "f.png", NULL);
    assert_int_equal(st, there[k] ? HL_OK : HL_ERR_UNAVAILABLE);
    assert_int_equal(set.n_views, there[k]);
    if (!there[k])
      assert_says(ctx.msg, options[k]);
    hl_corners_free(&set);
  }
  hl_frame_free(&frame);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_kalibrs_boards),
      cmocka_unit_test(test_kalibrs_boards_through_a_lens),
      cmocka_unit_test(test_tags_that_stand_alone),
      cmocka_unit_test(test_chessboards),
      cmocka_unit_test(test_other_numberings),
      cmocka_unit_test(test_boards_in_part),
      cmocka_unit_test(test_mirrored),
      cmocka_unit_test(test_blurred),
      cmocka_unit_test(test_blur_is_told),
      cmocka_unit_test(test_another_grid),
      cmocka_unit_test(test_too_little),
      cmocka_unit_test(test_twice),
      cmocka_unit_test(test_a_tag_in_a_wrong_place),
      cmocka_unit_test(test_frames_of_all_kinds),
      cmocka_unit_test(test_scale_does_not_matter),
      cmocka_unit_test(test_repeats_and_survives_a_file),
      cmocka_unit_test(test_silent),
      cmocka_unit_test(test_refusals_append_nothing),
      cmocka_unit_test(test_tiny_frames),
      cmocka_unit_test(test_unavailable),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
