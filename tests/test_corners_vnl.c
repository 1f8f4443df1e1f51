/* mrcal's `.vnl`: there and back, what its rules mean, and what is refused. */
#include <locale.h>
#include <stdio.h>
#include <string.h>

#include "files.h"
#include "halflight/corners.h"

static const hl_target board = {HL_TARGET_CHESSBOARD, 3, 2, 0.01, 0};

#define SIX(name)                                                                                  \
  name " 1 2\n" name " 3 4 1\n" name " - -\n" name " 5 6 -\n" name " 7.5 8.25 0\n" name " 9 1e1\n"

static hl_status read_text(void **state, const char *text, hl_ctx *ctx, hl_corners *out)
{
  char path[TEST_PATH_MAX];
  path_in(state, "c.vnl", path);
  put_text(path, text);
  return hl_corners_read(ctx, path, &board, out);
}

static void test_read(void **state)
{
  hl_corners set;
  assert_int_equal(read_text(state,
                             "## mrgingham\n#! x\n# filename x y level\n\n" SIX("b.png")
                                 SIX("a/a.png") "c.png - - -\n",
                             NULL, &set),
                   HL_OK);
  assert_int_equal(set.n_views, 3);
  assert_int_equal(set.width, 0);
  assert_string_equal(set.view[0].name, "b.png");
  assert_string_equal(set.view[1].name, "a/a.png");
  for (int i = 0; i < 2; i++) {
    const hl_view *v = &set.view[i];
    assert_int_equal(v->seen, 4);
    assert_true(v->used);
    assert_near(v->corner[0].x, 1, 0);
    assert_near(v->corner[0].sigma, 1, 0);
    assert_near(v->corner[1].sigma, 2, 0); /* level 1 */
    assert_near(v->corner[2].sigma, 0, 0);
    assert_near(v->corner[3].sigma, 0, 0);
    assert_near(v->corner[4].x, 7.5, 0);
    assert_near(v->corner[4].y, 8.25, 0);
    assert_near(v->corner[5].y, 10, 0);
  }
  /* mrcal writes a file without a board as one row */
  assert_false(set.view[2].used);
  assert_int_equal(set.view[2].seen, 0);
  assert_string_equal(set.view[2].why, "0 corners seen; at least 4 are needed");
  hl_corners_free(&set);
}

/* As mrcal has it: what is negative was not seen. */
static void test_negative_is_unseen(void **state)
{
  hl_corners set;
  assert_int_equal(read_text(state,
                             "a -1 2\na 3 -0.5\na 5 6 -1\na 7 8\na 0 0 0.5\na 1 1\r\nb 1 2\nb 2 3\n"
                             "b 3 4\nb - -\nb - -\nb - - -",
                             NULL, &set),
                   HL_OK);
  const double sigma[6] = {0, 0, 0, 1, 1.41421356237309515, 1};
  for (int i = 0; i < 6; i++)
    assert_near(set.view[0].corner[i].sigma, sigma[i], 1e-15);
  assert_false(set.view[0].used); /* 3 of 6 */
  assert_int_equal(set.view[1].seen, 3);
  assert_false(set.view[1].used);
  hl_corners_free(&set);
}

static void refused_as(void **state, hl_status status, const char *text, const char *part)
{
  hl_ctx ctx = {0};
  hl_corners set = {.n_views = -7};
  assert_int_equal(read_text(state, text, &ctx, &set), status);
  assert_says(ctx.msg, "c.vnl: ");
  assert_says(ctx.msg, part);
  assert_int_equal(set.n_views, -7);
}

static void refused(void **state, const char *text, const char *part)
{
  refused_as(state, HL_ERR_FORMAT, text, part);
}

static void test_refusals(void **state)
{
  refused(state, "", "the file is empty");
  refused(state, "# filename x y\n", "no row; '# filename x y level'");
  refused(state, "a 1 2\na 1\n", "line 2: 2 words; a row is filename x y [level]");
  refused(state, "my board.png 1 2 0\n", "line 1: 5 words");
  refused(state, "\n\na 1 2 0 0\n", "line 3: 5 words");
  refused(state, "a 1 y 0\n", "line 1: y is 'y'; a number up to 1e+06, or -, is needed");
  refused(state, "a nan 2\n", "line 1: x is 'nan'");
  refused(state, "a 1 inf\n", "line 1: y is 'inf'");
  refused(state, "a 0x10 2\n", "line 1: x is '0x10'");
  refused(state, "a 1,5 2\n", "line 1: x is '1,5'");
  refused(state, "a 1e300 2\n", "line 1: x is '1e300'");
  refused(state, "a 1 2 31\n", "line 1: level is '31'; a number up to 30");
  refused(state, "a 1 \x01\n", "line 1: y is '?'");
  refused(state, "a\x1b[31m 1 2\n", "line 1: the file's name holds byte 0x1b");
  refused(state, "# filename x y weight\n" SIX("a"), "line 1: column 4 is 'weight'");
  refused(state, "# filename y x\n" SIX("a"), "line 1: column 2 is 'y'");
  refused(state, "# filename x\n" SIX("a"), "line 1: 2 columns");
  refused(state, "# filename x y level z\n" SIX("a"), "line 1: 5 columns");
}

static void test_long_name_is_refused(void **state)
{
  char text[400];
  memset(text, 'n', sizeof text);
  memcpy(text + 300, " 1 2\n", sizeof " 1 2\n");
  refused(state, text, "line 1: the file's name has 300 bytes; up to 255 are accepted");
}

/* Says how many rows there are, how many are needed, and what would fit. */
static void test_another_board_is_refused(void **state)
{
  refused(state, SIX("a") "b 1 2\nb 1 2\n",
          "line 7: 'b' has 2 rows from here; chessboard:3x2:0.01 needs 6");
  refused(state, SIX("a") "a 1 2\n", "line 1: 'a' has 7 rows from here");
  refused(state, SIX("a") SIX("a"),
          "line 1: 'a' has 12 rows from here; chessboard:3x2:0.01 needs "
          "6; 4x3 corners would fit");
  refused(state, "a 1 2\n", "line 1: 'a' has 1 row from here");
  refused(state, SIX("a") SIX("b") SIX("a"),
          "line 13: 'a' was there from line 1; a file's rows must stand together");
  /* interleaved rows */
  refused(state, "a 1 2\na 1 2\nb 1 2\n" SIX("a"), "line 1: 'a' has 2 rows from here");

  hl_ctx ctx = {0};
  hl_corners set;
  char path[TEST_PATH_MAX];
  path_in(state, "c.vnl", path);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  for (int i = 0; i < 4 * 24; i++)
    fprintf(file, "v %d %d\n", i, i);
  fclose(file);
  const hl_target grid = {HL_TARGET_APRILGRID, 6, 6, 0.088, 0.3};
  assert_int_equal(hl_corners_read(&ctx, path, &grid, &set), HL_ERR_FORMAT);
  assert_says(ctx.msg, "line 1: 'v' has 96 rows from here; aprilgrid:6x6:0.088:0.3 needs 144; 6x4 "
                       "tags would fit");
}

static void test_missing_file(void **state)
{
  hl_ctx ctx = {0};
  hl_corners set;
  char path[TEST_PATH_MAX];
  path_in(state, "none.vnl", path);
  assert_int_equal(hl_corners_read(&ctx, path, &board, &set), HL_ERR_IO);
  assert_says(ctx.msg, "none.vnl: cannot open");
}

static hl_view *add(hl_corners *set, const char *name)
{
  hl_view *view = NULL;
  assert_int_equal(hl_corners_add(NULL, set, name, &view), HL_OK);
  return view;
}

/* Decimals of up to 15 digits come back exactly. */
static void test_write_then_read(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "out.vnl", path);
  test_random random = {1};
  hl_corners set = hl_corners_of(&board);
  hl_corners back;
  for (int v = 0; v < 5; v++) {
    char name[16];
    snprintf(name, sizeof name, "f/%d.png", v);
    hl_view *view = add(&set, name);
    for (int i = 0; i < 6; i++)
      if ((v + i) % 5 != 0) {
        view->corner[i] = (hl_corner){rint(random_between(&random, 0, 4e9)) / 1e6,
                                      rint(random_between(&random, 0, 4e9)) / 1e6, 1 << (i % 3)};
        view->seen++;
      }
  }
  hl_view *out = add(&set, "mirrored.png");
  out->corner[0] = (hl_corner){1, 1, 1};
  out->seen = 1;
  out->used = false;
  snprintf(out->why, sizeof out->why, "the board is seen mirrored");
  assert_int_equal(hl_corners_write(NULL, path, &set), HL_OK);
  assert_int_equal(hl_corners_read(NULL, path, &board, &back), HL_OK);
  assert_int_equal(back.n_views, 6);
  for (int v = 0; v < 5; v++) {
    assert_string_equal(back.view[v].name, set.view[v].name);
    assert_int_equal(back.view[v].seen, set.view[v].seen);
    assert_true(back.view[v].used);
    for (int i = 0; i < 6; i++) {
      assert_near(back.view[v].corner[i].x, set.view[v].corner[i].x, 0);
      assert_near(back.view[v].corner[i].y, set.view[v].corner[i].y, 0);
      assert_near(back.view[v].corner[i].sigma, set.view[v].corner[i].sigma, 0);
    }
  }
  /* what we left out, others shall not use */
  assert_false(back.view[5].used);
  assert_int_equal(back.view[5].seen, 0);
  hl_corners_free(&back);
  hl_corners_free(&set);
}

static void test_text(void **state)
{
  char path[TEST_PATH_MAX];
  size_t n;
  path_in(state, "text.vnl", path);
  hl_corners set = hl_corners_of(&board);
  hl_view *view = add(&set, "a.png");
  for (int i = 0; i < 5; i++)
    view->corner[i] = (hl_corner){i + 0.1, 2, i + 1};
  hl_view *out = add(&set, "b.png");
  out->used = false;
  snprintf(out->why, sizeof out->why, "no tag");
  assert_int_equal(hl_corners_write(NULL, path, &set), HL_OK);
  char *text = get_file(path, &n);
  assert_string_equal(text, "## chessboard:3x2:0.01\n# filename x y level\n"
                            "a.png 0.1 2 0\na.png 1.1 2 1\na.png 2.1 2 1.5849625\na.png 3.1 2 2\n"
                            "a.png 4.1 2 2.32192809\na.png - - -\n"
                            "## left out: no tag\nb.png - - -\n");
  free(text);
  hl_corners_free(&set);
}

static void test_write_refusals(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "never.vnl", path);
  static const char *const names[] = {"my board.png", "#1.png", "a\tb", "a\nb"};
  for (int i = 0; i < 4; i++) {
    hl_ctx ctx = {0};
    hl_corners set = hl_corners_of(&board);
    add(&set, "good.png");
    add(&set, names[i]);
    assert_int_equal(hl_corners_write(&ctx, path, &set), HL_ERR_ARG);
    assert_non_null(strstr(ctx.msg, "a .vnl cannot hold the name"));
    hl_corners_free(&set);
  }
  static const hl_corner wrong[] = {{-0.1, 5, 1}, {5, -0.1, 1},     {NAN, 5, 1},
                                    {5, 5, 0.5},  {5, INFINITY, 1}, {5, 5, INFINITY}};
  for (int i = 0; i < 6; i++) {
    hl_ctx ctx = {0};
    hl_corners set = hl_corners_of(&board);
    add(&set, "a.png")->corner[3] = wrong[i];
    assert_int_equal(hl_corners_write(&ctx, path, &set), HL_ERR_ARG);
    assert_says(ctx.msg, "corner 3 of 'a.png' is at (");
    hl_corners_free(&set);
  }
  assert_int_not_equal(access(path, F_OK), 0);
}

/* Whatever the bytes: a set that keeps its promises, or one line that says why not. */
static void test_any_bytes(void **state)
{
  static const char good[] = "# filename x y level\n" SIX("a") SIX("b.png") "c - - -\n";
  static const char spice[] = " \n\t\r-+.0123456789eE#ab\0\xff";
  char path[TEST_PATH_MAX];
  path_in(state, "fuzz.vnl", path);
  test_random random = {7};
  int accepted = 0;
  for (int round = 0; round < 3000; round++) {
    char text[sizeof good];
    memcpy(text, good, sizeof good);
    const int changes = 1 + (int)random_between(&random, 0, 4);
    for (int i = 0; i < changes; i++)
      text[(size_t)random_between(&random, 0, sizeof good - 1)] =
          spice[(size_t)random_between(&random, 0, sizeof spice - 1)];
    const size_t n =
        round % 3 == 0 ? (size_t)random_between(&random, 1, sizeof good - 1) : sizeof good - 1;
    put_file(path, text, n);
    hl_ctx ctx = {0};
    hl_corners set;
    const hl_status st = hl_corners_read(&ctx, path, &board, &set);
    if (st != HL_OK) {
      assert_int_equal(st, HL_ERR_FORMAT);
      assert_says(ctx.msg, "fuzz.vnl: ");
      continue;
    }
    accepted++;
    assert_true(set.n_views > 0);
    for (int v = 0; v < set.n_views; v++)
      for (int i = 0; i < 6; i++) {
        const hl_corner c = set.view[v].corner[i];
        assert_true(c.sigma >= 0 && c.x >= 0 && c.x <= 1e6 && c.y >= 0 && c.y <= 1e6);
      }
    hl_corners_free(&set);
  }
  assert_true(accepted > 100 && accepted < 2900);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_read),
      cmocka_unit_test(test_negative_is_unseen),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_long_name_is_refused),
      cmocka_unit_test(test_another_board_is_refused),
      cmocka_unit_test(test_missing_file),
      cmocka_unit_test(test_write_then_read),
      cmocka_unit_test(test_text),
      cmocka_unit_test(test_write_refusals),
      cmocka_unit_test(test_any_bytes),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
