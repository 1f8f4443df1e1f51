/* Targets: specs read and written, every refusal, and where the corners are. */
#include <locale.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/target.h"
#include "near.h"

static hl_target parsed(const char *spec)
{
  hl_ctx ctx = {0};
  hl_target t;
  if (hl_target_parse(&ctx, spec, &t) != HL_OK)
    fail_msg("%s: %s", spec, ctx.msg);
  return t;
}

static void test_parse(void **state)
{
  (void)state;
  const hl_target grid = parsed("aprilgrid:6x5:0.03:0.3");
  assert_int_equal(grid.kind, HL_TARGET_APRILGRID);
  assert_int_equal(grid.columns, 6);
  assert_int_equal(grid.rows, 5);
  assert_near(grid.size_m, 0.03, 0);
  assert_near(grid.spacing_ratio, 0.3, 0);
  const hl_target board = parsed("chessboard:9x6:0.025");
  assert_int_equal(board.kind, HL_TARGET_CHESSBOARD);
  assert_int_equal(board.columns, 9);
  assert_int_equal(board.rows, 6);
  assert_near(board.size_m, 0.025, 0);
  assert_near(board.spacing_ratio, 0, 0);
}

/* the bounds themselves are inside */
static void test_parse_extremes(void **state)
{
  (void)state;
  assert_int_equal(parsed("aprilgrid:1x1:1e-5:0.01").columns, 1);
  assert_int_equal(parsed("aprilgrid:64x9:100:10").columns, 64);
  assert_int_equal(parsed("aprilgrid:9x64:100:10").rows, 64);
  assert_int_equal(parsed("chessboard:3x3:0.01").rows, 3);
  assert_int_equal(parsed("chessboard:64x64:0.01").columns, 64);
}

/* analytic: what the compiler makes of the same digits */
static void test_numbers(void **state)
{
  static const struct {
    const char *text;
    double value;
  } numbers[] = {
      {"0.03", 0.03},     {".03", .03},        {"3e-2", 3e-2},
      {"30E-3", 30e-3},   {"0.3e-1", 0.3e-1},  {"1", 1},
      {"1.", 1.},         {"0.0300000", 0.03}, {"1e+1", 1e1},
      {"00.5", 0.5},      {"0.0381", 0.0381},  {"0.123456789012345", 0.123456789012345},
      {"0.0254", 0.0254}, {"0.07", 0.07},      {"99.9999999999999", 99.9999999999999},
  };
  (void)state;
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
    char spec[64];
    snprintf(spec, sizeof spec, "chessboard:9x6:%s", numbers[i].text);
    assert_near(parsed(spec).size_m, numbers[i].value, 0);
  }
  /* more digits than a double holds: to one unit in the last place */
  assert_near(parsed("chessboard:9x6:0.029999999999999999").size_m, 0.03, 4e-18);
  assert_near(parsed("chessboard:9x6:12.345678901234567").size_m, 12.345678901234567, 2e-15);
  assert_near(parsed("chessboard:9x6:12.34567890123456789012345").size_m, 12.345678901234567,
              2e-15);
}

/* every decimal of up to 15 digits is read as the C library reads it in the C locale */
static void test_numbers_as_strtod(void **state)
{
  test_random random = {20240511};
  (void)state;
  for (int i = 0; i < 20000; i++) {
    char spec[64];
    const int digits = 1 + (int)(random_uniform(&random) * 15);
    const double value = pow(10, random_between(&random, -4.9, 1.9));
    snprintf(spec, sizeof spec, "chessboard:9x6:%.*g", digits, value);
    assert_near(parsed(spec).size_m, strtod(spec + strlen("chessboard:9x6:"), NULL), 0);
  }
}

static void check_text(const char *spec, const char *want)
{
  char text[HL_TARGET_SPEC_MAX];
  const hl_target t = parsed(spec);
  assert_ptr_equal(hl_target_spec(&t, text), text);
  assert_string_equal(text, want);
  const hl_target again = parsed(text);
  assert_near(again.size_m, t.size_m, 0);
  assert_near(again.spacing_ratio, t.spacing_ratio, 0);
}

static void test_spec(void **state)
{
  (void)state;
  check_text("aprilgrid:6x6:0.03:0.3", "aprilgrid:6x6:0.03:0.3");
  check_text("aprilgrid:6x6:3e-2:.30", "aprilgrid:6x6:0.03:0.3");
  check_text("chessboard:9x6:0.025", "chessboard:9x6:0.025");
  check_text("chessboard:9x6:2e-05", "chessboard:9x6:2e-05");
  check_text("aprilgrid:64x9:0.123456789012345:0.987654321098765",
             "aprilgrid:64x9:0.123456789012345:0.987654321098765");
  check_text("chessboard:9x6:0.012345678901234567", "chessboard:9x6:0.012345678901234568");
}

static void refuses(const char *spec, const char *message)
{
  hl_ctx ctx = {0};
  hl_target t;
  memset(&t, 0x5a, sizeof t);
  const hl_target before = t;
  assert_int_equal(hl_target_parse(&ctx, spec, &t), HL_ERR_ARG);
  assert_string_equal(ctx.msg, message);
  assert_memory_equal(&t, &before, sizeof t);
  assert_int_equal(hl_target_parse(NULL, spec, &t), HL_ERR_ARG);
}

#define GRID "aprilgrid:COLSxROWS:TAG_M:SPACING_RATIO"
#define BOARD "chessboard:COLSxROWS:SQUARE_M"

static void test_refuses_kinds(void **state)
{
  (void)state;
  refuses("", "target '': '' is no kind of target; " GRID " or " BOARD " is needed");
  refuses("circles:4x11:0.02", "target 'circles:4x11:0.02': 'circles' is no kind of target; " GRID
                               " or " BOARD " is needed");
  refuses("Aprilgrid:6x6:0.03:0.3", "target 'Aprilgrid:6x6:0.03:0.3': 'Aprilgrid' is no kind of "
                                    "target; " GRID " or " BOARD " is needed");
  refuses("aprilgrid2:6x6:0.03:0.3", "target 'aprilgrid2:6x6:0.03:0.3': 'aprilgrid2' is no kind of "
                                     "target; " GRID " or " BOARD " is needed");
}

static void test_refuses_parts(void **state)
{
  (void)state;
  refuses("aprilgrid", "target 'aprilgrid': 1 parts between colons; " GRID " is needed");
  refuses("aprilgrid:6x6:0.03",
          "target 'aprilgrid:6x6:0.03': 3 parts between colons; " GRID " is needed");
  refuses("chessboard:9x6:0.025:0.3",
          "target 'chessboard:9x6:0.025:0.3': 4 parts between colons; " BOARD " is needed");
  refuses("chessboard:9x6:0.025:",
          "target 'chessboard:9x6:0.025:': 4 parts between colons; " BOARD " is needed");
  refuses("aprilgrid:6x6:0.03:0.3:1:2",
          "target 'aprilgrid:6x6:0.03:0.3:1:2' is too long; " GRID " is needed");
  refuses("chessboard:9x6:0.0250000000000000000000000000000000",
          "target 'chessboard:9x6:0.0250000000000000000000000000000000' is too long; " BOARD
          " is needed");
}

static void test_refuses_counts(void **state)
{
  static const char *const wrong[] = {"9",    "9x",   "x6",   "9X6",   "9x6x2",
                                      "-9x6", "+9x6", " 9x6", "9.5x6", ""};
  (void)state;
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
    char spec[64];
    char message[HL_MESSAGE_MAX];
    snprintf(spec, sizeof spec, "chessboard:%s:0.025", wrong[i]);
    snprintf(message, sizeof message, "target '%s': COLSxROWS is '%s'; " BOARD " is needed", spec,
             wrong[i]);
    refuses(spec, message);
  }
  refuses("aprilgrid:0x6:0.03:0.3", "target: columns = 0 tags is outside [1, 64]");
  refuses("aprilgrid:6x0:0.03:0.3", "target: rows = 0 tags is outside [1, 64]");
  refuses("aprilgrid:65x6:0.03:0.3", "target: columns = 65 tags is outside [1, 64]");
  refuses("aprilgrid:6x65:0.03:0.3", "target: rows = 65 tags is outside [1, 64]");
  refuses("chessboard:2x6:0.03", "target: columns = 2 inner corners is outside [3, 64]");
  refuses("chessboard:9x2:0.03", "target: rows = 2 inner corners is outside [3, 64]");
  refuses("chessboard:9x65:0.03", "target: rows = 65 inner corners is outside [3, 64]");
  refuses("chessboard:99999999999999999999x6:0.03",
          "target: columns = 999999 inner corners is outside [3, 64]");
  refuses("aprilgrid:28x21:0.03:0.3", "target: 28 x 21 = 588 tags are more than the 587 of family "
                                      "tag36h11; fewer columns or rows are needed");
}

static void test_refuses_numbers(void **state)
{
  static const char *const wrong[] = {"",      ".",      "0,03", "-0.03", "+0.03", " 0.03",
                                      "0.03 ", "0.03m",  "1e",   "1e+",   "1e-x",  "1e999",
                                      "1e-99", "0x1p-4", "nan",  "inf",   "0..3",  "0.0.3"};
  (void)state;
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
    char spec[64];
    char message[HL_MESSAGE_MAX];
    snprintf(spec, sizeof spec, "chessboard:9x6:%s", wrong[i]);
    snprintf(message, sizeof message, "target '%s': SQUARE_M is '%s'; " BOARD " is needed", spec,
             wrong[i]);
    refuses(spec, message);
    snprintf(spec, sizeof spec, "aprilgrid:6x6:%s:0.3", wrong[i]);
    snprintf(message, sizeof message, "target '%s': TAG_M is '%s'; " GRID " is needed", spec,
             wrong[i]);
    refuses(spec, message);
    snprintf(spec, sizeof spec, "aprilgrid:6x6:0.03:%s", wrong[i]);
    snprintf(message, sizeof message, "target '%s': SPACING_RATIO is '%s'; " GRID " is needed",
             spec, wrong[i]);
    refuses(spec, message);
  }
  refuses("chessboard:9x6:0", "target: square = 0 m is outside [1e-05, 100]");
  refuses("chessboard:9x6:9.99e-6", "target: square = 9.99e-06 m is outside [1e-05, 100]");
  refuses("chessboard:9x6:100.5", "target: square = 100.5 m is outside [1e-05, 100]");
  refuses("aprilgrid:6x6:101:0.3", "target: tag = 101 m is outside [1e-05, 100]");
  refuses("aprilgrid:6x6:0.03:0", "target: spacing ratio = 0 is outside [0.01, 10]");
  refuses("aprilgrid:6x6:0.03:0.0099", "target: spacing ratio = 0.0099 is outside [0.01, 10]");
  refuses("aprilgrid:6x6:0.03:30", "target: spacing ratio = 30 is outside [0.01, 10]");
}

static void check_refuses(hl_target t, const char *message)
{
  hl_ctx ctx = {0};
  assert_int_equal(hl_target_check(&ctx, &t), HL_ERR_ARG);
  assert_string_equal(ctx.msg, message);
}

/* targets that no spec makes */
static void test_check(void **state)
{
  const hl_target grid = {HL_TARGET_APRILGRID, 6, 6, 0.03, 0.3};
  const hl_target board = {HL_TARGET_CHESSBOARD, 9, 6, 0.03, 0};
  hl_target t;
  (void)state;
  assert_int_equal(hl_target_check(NULL, &grid), HL_OK);
  assert_int_equal(hl_target_check(NULL, &board), HL_OK);
  t = grid;
  t.kind = (hl_target_kind)7;
  check_refuses(t, "target: kind = 7 is neither aprilgrid nor chessboard");
  t = grid;
  t.rows = -1;
  check_refuses(t, "target: rows = -1 tags is outside [1, 64]");
  t = grid;
  t.size_m = NAN;
  check_refuses(t, "target: tag = nan m is outside [1e-05, 100]");
  t = grid;
  t.spacing_ratio = HUGE_VAL;
  check_refuses(t, "target: spacing ratio = inf is outside [0.01, 10]");
  t = board;
  t.spacing_ratio = 0.3;
  check_refuses(t, "target: spacing ratio = 0.3; a chessboard has none, 0 is needed");
}

/* a locale whose decimal mark is a comma changes nothing; skipped where none is installed */
static void test_locale(void **state)
{
  static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "fr_FR.utf8"};
  (void)state;
  bool set = false;
  for (size_t i = 0; i < sizeof names / sizeof *names && !set; i++)
    set = setlocale(LC_NUMERIC, names[i]) != NULL;
  if (!set || strcmp(localeconv()->decimal_point, ",") != 0) {
    print_message("no locale with a decimal comma is installed\n");
    skip();
  }
  check_text("aprilgrid:6x6:0.03:0.3", "aprilgrid:6x6:0.03:0.3");
  refuses("aprilgrid:6x6:0,03:0.3",
          "target 'aprilgrid:6x6:0,03:0.3': TAG_M is '0,03'; " GRID " is needed");
  refuses("chessboard:9x6:100.5", "target: square = 100.5 m is outside [1e-05, 100]");
}

static int reset_locale(void **state)
{
  (void)state;
  return setlocale(LC_NUMERIC, "C") ? 0 : -1;
}

/* analytic: corner by corner from the picture in the header */
static void test_corners_grid(void **state)
{
  (void)state;
  const hl_target t = parsed("aprilgrid:3x2:0.04:0.25");
  assert_int_equal(hl_target_corner_columns(&t), 6);
  assert_int_equal(hl_target_corner_rows(&t), 4);
  assert_int_equal(hl_target_corners(&t), 24);
  static const double x[6] = {0, 0.04, 0.05, 0.09, 0.1, 0.14};
  static const double y[4] = {0, 0.04, 0.05, 0.09};
  for (int k = 0; k < 4; k++)
    for (int i = 0; i < 6; i++) {
      double at[3];
      hl_target_corner(&t, k * 6 + i, at);
      assert_near(at[0], x[i], 1e-15);
      assert_near(at[1], y[k], 1e-15);
      assert_near(at[2], 0, 0);
    }
}

static void test_corners_chessboard(void **state)
{
  (void)state;
  const hl_target t = parsed("chessboard:4x3:0.025");
  assert_int_equal(hl_target_corner_columns(&t), 4);
  assert_int_equal(hl_target_corner_rows(&t), 3);
  assert_int_equal(hl_target_corners(&t), 12);
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 4; i++) {
      double at[3];
      hl_target_corner(&t, k * 4 + i, at);
      assert_near(at[0], 0.025 * i, 0);
      assert_near(at[1], 0.025 * k, 0);
      assert_near(at[2], 0, 0);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_parse),
      cmocka_unit_test(test_parse_extremes),
      cmocka_unit_test(test_numbers),
      cmocka_unit_test(test_numbers_as_strtod),
      cmocka_unit_test(test_spec),
      cmocka_unit_test(test_refuses_kinds),
      cmocka_unit_test(test_refuses_parts),
      cmocka_unit_test(test_refuses_counts),
      cmocka_unit_test(test_refuses_numbers),
      cmocka_unit_test(test_check),
      cmocka_unit_test_teardown(test_locale, reset_locale),
      cmocka_unit_test(test_corners_grid),
      cmocka_unit_test(test_corners_chessboard),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
