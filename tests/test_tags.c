/* Tags through AprilTag: their corners to a fifth of a pixel, which edges without blur allow, in our convention of pixel (0,0). */
#include "../calib/tags.h"

#include <stdio.h>
#include <string.h>

#include "files.h"
#include "halflight/target.h"
#include "quiet.h"

#ifdef HL_HAVE_APRILTAG

enum { WIDTH = 240, HEIGHT = 200, CELL = 5 };

typedef struct canvas {
  int width, height;
  float pixel[WIDTH * HEIGHT];
} canvas;

static void clear(canvas *c, int width, int height)
{
  c->width = width;
  c->height = height;
  for (int i = 0; i < width * height; i++)
    c->pixel[i] = 1;
}

/* Its black square begins with pixel (x, y). */
static void draw(canvas *c, int id, int border_bits, int x, int y)
{
  bool white[HL_TARGET_TAG_CELLS][HL_TARGET_TAG_CELLS];
  assert_int_equal(hl_target_tag_cells(NULL, id, white), HL_OK);
  const int side = HL_TARGET_TAG_CELLS + 2 * border_bits;
  for (int v = 0; v < side * CELL; v++)
    for (int u = 0; u < side * CELL; u++) {
      const int column = u / CELL - border_bits;
      const int row = v / CELL - border_bits;
      const bool inside =
          column >= 0 && row >= 0 && column < HL_TARGET_TAG_CELLS && row < HL_TARGET_TAG_CELLS;
      c->pixel[(y + v) * c->width + x + u] = inside && white[row][column] ? 1 : 0.02f;
    }
}

static void turn_quarter(canvas *c)
{
  static canvas turned;
  turned.width = c->height;
  turned.height = c->width;
  for (int y = 0; y < c->height; y++)
    for (int x = 0; x < c->width; x++)
      turned.pixel[x * turned.width + c->height - 1 - y] = c->pixel[y * c->width + x];
  *c = turned;
}

static hl_grey grey_of(const canvas *c)
{
  hl_frame frame;
  hl_grey grey;
  assert_int_equal(hl_frame_from_codes(NULL, c->pixel, c->width, c->height, 1, 32, NULL, &frame),
                   HL_OK);
  assert_int_equal(hl_grey_of(NULL, &frame, &grey), HL_OK);
  hl_frame_free(&frame);
  hl_grey_code_curved(&grey);
  return grey;
}

/* group fixture: one finder for all */
static hl_tag_finder *finder;

static int finder_begin(void **state)
{
  (void)state;
  return hl_tag_finder_new(NULL, &finder) == HL_OK ? 0 : -1;
}

static int finder_end(void **state)
{
  (void)state;
  hl_tag_finder_free(finder);
  return 0;
}

static hl_tags find_by(const canvas *c, hl_tag_edges edges)
{
  hl_tags tags;
  hl_grey grey = grey_of(c);
  assert_int_equal(hl_tags_find(NULL, finder, &grey, edges, &tags), HL_OK);
  hl_grey_free(&grey);
  return tags;
}

static hl_tags find(const canvas *c)
{
  return find_by(c, HL_TAG_EDGES_REFINED);
}

/* The first pixel's centre is (0,0), so the square begins half a pixel before its first pixel. */
static void test_origin_and_order(void **state)
{
  (void)state;
  static canvas c;
  for (int i = 0; i < 4; i++) {
    const int bits = 1 + i % 2;
    clear(&c, WIDTH, HEIGHT);
    draw(&c, 17, bits, 83, 61);
    hl_tags tags = find_by(&c, i < 2 ? HL_TAG_EDGES_REFINED : HL_TAG_EDGES_FOUND);
    const double side = CELL * (HL_TARGET_TAG_CELLS + 2 * bits);
    const double want[4][2] = {
        {82.5, 60.5}, {82.5 + side, 60.5}, {82.5 + side, 60.5 + side}, {82.5, 60.5 + side}};
    assert_int_equal(tags.n, 1);
    assert_int_equal(tags.border_bits, bits);
    assert_int_equal(tags.tag[0].id, 17);
    for (int k = 0; k < 4; k++)
      for (int axis = 0; axis < 2; axis++)
        assert_near(tags.tag[0].corner[k][axis], want[k][axis], 0.2);
    hl_tags_free(&tags);
  }
}

/* The first corner is the printed top left, wherever it is. */
static void test_order_follows_the_print(void **state)
{
  (void)state;
  static canvas c;
  clear(&c, WIDTH, HEIGHT);
  draw(&c, 100, 1, 83, 61);
  double at[2] = {82.5, 60.5};
  for (int quarter = 0; quarter < 4; quarter++) {
    hl_tags tags = find(&c);
    assert_int_equal(tags.n, 1);
    assert_near(tags.tag[0].corner[0][0], at[0], 0.2);
    assert_near(tags.tag[0].corner[0][1], at[1], 0.2);
    double middle[2];
    hl_tag_center(&tags.tag[0], middle);
    assert_near(hypot(middle[0] - at[0], middle[1] - at[1]), 20 * sqrt(2), 0.2);
    assert_near(hl_tag_side(&tags.tag[0]), 40, 0.2);
    hl_tags_free(&tags);
    const double x = at[0];
    at[0] = c.height - 1 - at[1];
    at[1] = x;
    turn_quarter(&c);
  }
}

/* AprilTag itself would write past an array here. */
static void test_small_frames(void **state)
{
  (void)state;
  static canvas c;
  clear(&c, 56, 60);
  draw(&c, 3, 1, 8, 9);
  hl_tags tags = find(&c);
  assert_int_equal(tags.n, 1);
  assert_near(tags.tag[0].corner[2][0], 47.5, 0.2);
  hl_tags_free(&tags);
  clear(&c, 2, 2);
  tags = find(&c);
  assert_int_equal(tags.n, 0);
  assert_int_equal(tags.border_bits, 0);
  hl_tags_free(&tags);
}

static void test_mirrored_tags_are_none(void **state)
{
  (void)state;
  static canvas c;
  clear(&c, WIDTH, HEIGHT);
  draw(&c, 17, 1, 83, 61);
  hl_grey grey = grey_of(&c);
  hl_tags tags;
  hl_grey_mirror(&grey);
  assert_int_equal(hl_tags_find(NULL, finder, &grey, HL_TAG_EDGES_FOUND, &tags), HL_OK);
  assert_int_equal(tags.n, 0);
  hl_tags_free(&tags);
  hl_grey_free(&grey);
}

/* By id, then by place; one that is there twice is there twice, however often it is looked for. */
static void test_several(void **state)
{
  (void)state;
  static canvas c;
  clear(&c, WIDTH, HEIGHT);
  draw(&c, 9, 2, 10, 10);
  draw(&c, 4, 2, 90, 20);
  draw(&c, 9, 2, 170, 100);
  hl_tags tags = find(&c);
  const int ids[3] = {4, 9, 9};
  assert_int_equal(tags.n, 3);
  for (int i = 0; i < 3; i++)
    assert_int_equal(tags.tag[i].id, ids[i]);
  hl_tags_free(&tags);
  hl_grey grey = grey_of(&c);
  assert_int_equal(hl_tags_search(NULL, finder, &grey, 10, &tags), HL_OK); /* 10 are never found */
  assert_int_equal(tags.n, 3);
  assert_int_equal(tags.border_bits, 2);
  hl_tags_free(&tags);
  hl_grey_free(&grey);
}

static void test_too_large(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  hl_tags tags = {.n = -7};
  const hl_grey grey = {.width = 40000, .height = 10, .stride = 40000, .rows = HL_GREY_SIDE_MIN};
  assert_int_equal(hl_tags_find(&ctx, finder, &grey, HL_TAG_EDGES_FOUND, &tags), HL_ERR_FORMAT);
  assert_says(ctx.msg, "frame of 40000 x 10 pixels; AprilTag takes up to 32767 a side");
  assert_int_equal(tags.n, -7);
}

/* AprilTag prints of singular matrices and the like; nobody hears it. */
static void test_silent(void **state)
{
  (void)state;
  static canvas c;
  test_random random = {11};
  long printed = 0;
  for (int round = 0; round < 20; round++) {
    const double coarse = random_between(&random, 1, 12);
    clear(&c, WIDTH, HEIGHT);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
      const double x = floor((i % WIDTH) / coarse);
      const double y = floor((double)(i / WIDTH) / coarse);
      test_random cell = {(uint64_t)(x * 7919 + y * 104729 + round + 1) * 0x9E3779B97F4A7C15u};
      random_uniform(&cell);
      c.pixel[i] = random_uniform(&cell) < 0.5 ? 0 : 1;
    }
    quiet q = quiet_begin();
    hl_tags tags = find(&c);
    printed += quiet_end(&q);
    hl_tags_free(&tags);
  }
  assert_int_equal(printed, 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_origin_and_order), cmocka_unit_test(test_order_follows_the_print),
      cmocka_unit_test(test_small_frames),     cmocka_unit_test(test_mirrored_tags_are_none),
      cmocka_unit_test(test_several),          cmocka_unit_test(test_too_large),
      cmocka_unit_test(test_silent),
  };
  return cmocka_run_group_tests(tests, finder_begin, finder_end);
}

#else

static void test_unavailable(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  hl_tag_finder *finder = NULL;
  assert_int_equal(hl_tag_finder_new(&ctx, &finder), HL_ERR_UNAVAILABLE);
  assert_says(ctx.msg, "-DHL_WITH_APRILTAG=ON");
  assert_null(finder);
  hl_tag_finder_free(finder);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_unavailable),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

#endif
