/* Where a target is on its sheet, and what is refused. */
#include <string.h>

#include "../src/cli/target_sheet.h"
#include "near.h"

static hl_target parsed(const char *spec)
{
  hl_target t;
  assert_int_equal(hl_target_parse(NULL, spec, &t), HL_OK);
  return t;
}

static hl_sheet planned(const char *spec, hl_picture_kind kind, hl_sheet_settings settings)
{
  hl_ctx ctx = {0};
  hl_sheet s;
  const hl_target t = parsed(spec);
  if (hl_sheet_plan(&ctx, &t, kind, &settings, &s) != HL_OK)
    fail_msg("%s: %s", spec, ctx.msg);
  return s;
}

/* analytic: 2 x 2 tags of 40 mm, 10 mm apart, of 10 bits each */
static void test_grid(void **state)
{
  (void)state;
  const hl_sheet s =
      planned("aprilgrid:2x2:0.04:0.25", HL_PICTURE_PDF, (hl_sheet_settings){0, HL_PAGE_FIT, 0});
  assert_int_equal(s.border_bits, 2);
  assert_near(s.cell_mm, 4, 1e-12);
  assert_near(s.around_mm, 10, 1e-12);
  assert_near(s.span_mm[0], 90, 1e-12);
  assert_near(s.span_mm[1], 90, 1e-12);
  assert_near(s.width_mm, 110 + 2 * 6, 1e-12);
  assert_near(s.height_mm, 110 + 2 * 6 + 20 + 6, 1e-12);
  assert_near(s.first_mm[0], 6 + 10, 1e-12);
  assert_near(s.first_mm[1], 6 + 10, 1e-12);
  assert_near(s.caption_mm, 6 + 110 + 6, 1e-12);
  assert_near(s.left_mm, 6, 1e-12);
  assert_near(s.ruler_mm, 100, 0);
  const hl_sheet one =
      planned("aprilgrid:2x2:0.04:0.25", HL_PICTURE_PDF, (hl_sheet_settings){1, HL_PAGE_FIT, 0});
  assert_int_equal(one.border_bits, 1);
  assert_near(one.cell_mm, 5, 1e-12);
}

/* a chessboard has a square of white around it */
static void test_chessboard(void **state)
{
  (void)state;
  const hl_sheet s =
      planned("chessboard:5x3:0.02", HL_PICTURE_SVG, (hl_sheet_settings){0, HL_PAGE_FIT, 0});
  assert_int_equal(s.border_bits, 0);
  assert_near(s.width_mm, (6 + 2) * 20, 1e-12);
  assert_near(s.height_mm, (4 + 2) * 20 + 20 + 6, 1e-12);
  assert_near(s.first_mm[0], 40, 1e-12);
  assert_near(s.first_mm[1], 40, 1e-12);
  assert_near(s.span_mm[0], 80, 1e-12);
  assert_near(s.span_mm[1], 40, 1e-12);
}

/* the caption needs its room below a small target too */
static void test_small(void **state)
{
  (void)state;
  const hl_sheet s =
      planned("aprilgrid:1x1:0.005:0.3", HL_PICTURE_PDF, (hl_sheet_settings){0, HL_PAGE_FIT, 0});
  assert_near(s.width_mm, 60, 0);
  assert_near(s.first_mm[0], 30 - 2.5, 1e-12);
  assert_near(s.left_mm, 6, 0);
  assert_near(s.ruler_mm, 20, 0);
}

static void test_pages(void **state)
{
  (void)state;
  const hl_sheet upright =
      planned("aprilgrid:4x5:0.03:0.3", HL_PICTURE_PDF, (hl_sheet_settings){0, HL_PAGE_A4, 0});
  assert_near(upright.width_mm, 210, 0);
  assert_near(upright.height_mm, 297, 0);
  assert_near(upright.first_mm[0] + upright.span_mm[0] / 2, 105, 1e-12);
  assert_near(upright.first_mm[1] + upright.span_mm[1] / 2, (297 - 26) / 2.0, 1e-12);
  const hl_sheet across =
      planned("chessboard:9x6:0.02", HL_PICTURE_PDF, (hl_sheet_settings){0, HL_PAGE_A4, 0});
  assert_near(across.width_mm, 297, 0);
  assert_near(across.height_mm, 210, 0);
  const hl_sheet a3 =
      planned("aprilgrid:6x6:0.03:0.3", HL_PICTURE_PDF, (hl_sheet_settings){0, HL_PAGE_A3, 0});
  assert_near(a3.width_mm, 297, 0);
  assert_near(a3.height_mm, 420, 0);
  const hl_sheet letter =
      planned("chessboard:7x4:0.025", HL_PICTURE_PDF, (hl_sheet_settings){0, HL_PAGE_LETTER, 0});
  assert_near(letter.width_mm, 279.4, 0);
  assert_near(letter.height_mm, 215.9, 0);
}

/* 3 mm bits at 25.4 / 3 n dpi are n pixels, and the first corner is between four of them */
static void test_whole_pixels(void **state)
{
  (void)state;
  const double pixel = 3.0 / 7;
  const hl_sheet s = planned("aprilgrid:6x6:0.03:0.3", HL_PICTURE_PNG,
                             (hl_sheet_settings){0, HL_PAGE_A3, 25.4 / pixel});
  assert_true(s.whole_pixels);
  for (int i = 0; i < 2; i++)
    assert_near(s.first_mm[i] / pixel, round(s.first_mm[i] / pixel), 1e-9);
  assert_int_equal(hl_sheet_pixels(&s, 297), 693);
  const hl_sheet not_whole =
      planned("aprilgrid:6x6:0.03:0.3", HL_PICTURE_PNG, (hl_sheet_settings){0, HL_PAGE_A3, 0});
  assert_near(not_whole.dpi, 300, 0);
  assert_false(not_whole.whole_pixels);
  /* bits of 7 pixels, but a gap of 17.5 */
  const hl_sheet gap = planned("aprilgrid:6x6:0.03:0.25", HL_PICTURE_PNG,
                               (hl_sheet_settings){0, HL_PAGE_A3, 25.4 / pixel});
  assert_false(gap.whole_pixels);
}

static void refuses(const char *spec, hl_picture_kind kind, hl_sheet_settings settings,
                    const char *message)
{
  hl_ctx ctx = {0};
  hl_sheet s;
  memset(&s, 0x5a, sizeof s);
  const hl_sheet before = s;
  const hl_target t = parsed(spec);
  assert_int_equal(hl_sheet_plan(&ctx, &t, kind, &settings, &s), HL_ERR_ARG);
  assert_string_equal(ctx.msg, message);
  assert_memory_equal(&s, &before, sizeof s);
}

static void test_refuses_pages(void **state)
{
  (void)state;
  refuses("aprilgrid:6x6:0.03:0.3", HL_PICTURE_PDF, (hl_sheet_settings){0, HL_PAGE_A4, 0},
          "--page a4: the target needs 255.0 x 281.0 mm, the page has 210.0 x 297.0; a tag of at "
          "most 0.0244 m, or --page a3 or fit, is needed");
  refuses("chessboard:9x6:0.04", HL_PICTURE_PDF, (hl_sheet_settings){0, HL_PAGE_LETTER, 0},
          "--page letter: the target needs 480.0 x 386.0 mm, the page has 215.9 x 279.4; a square "
          "of at most 0.0211 m, or --page fit, is needed");
  refuses("aprilgrid:6x6:0.8:0.3", HL_PICTURE_PDF, (hl_sheet_settings){0, HL_PAGE_FIT, 0},
          "the target needs a sheet of 6640 x 6666 mm; one of at most 5080 mm can be drawn");
}

/* what the refusal of a page offers fits, and the next tenth of a millimetre does not */
static void test_offered_size(void **state)
{
  const hl_sheet_settings a4 = {0, HL_PAGE_A4, 0};
  hl_sheet s;
  (void)state;
  hl_target t = parsed("aprilgrid:6x6:0.0244:0.3");
  assert_int_equal(hl_sheet_plan(NULL, &t, HL_PICTURE_PDF, &a4, &s), HL_OK);
  t = parsed("aprilgrid:6x6:0.0245:0.3");
  assert_int_equal(hl_sheet_plan(NULL, &t, HL_PICTURE_PDF, &a4, &s), HL_ERR_ARG);
}

static void test_refuses_cells(void **state)
{
  const hl_sheet_settings fit = {0, HL_PAGE_FIT, 0};
  const hl_sheet_settings one_bit = {1, HL_PAGE_FIT, 0};
  (void)state;
  refuses("aprilgrid:6x6:0.0003:0.3", HL_PICTURE_PDF, fit,
          "bits of 0.03 mm cannot be printed; at least 0.05 mm, a tag of 0.0005 m, is needed");
  refuses("chessboard:9x6:0.00004", HL_PICTURE_SVG, fit,
          "squares of 0.04 mm cannot be printed; at least 0.05 mm, a square of 5e-05 m, is needed");
  refuses("aprilgrid:6x6:0.03:0.09", HL_PICTURE_PDF, fit,
          "spacing ratio 0.09 leaves less white between the tags than one bit of theirs; with "
          "--border-bits 2 at least 0.1 is needed");
  refuses("aprilgrid:6x6:0.03:0.12", HL_PICTURE_PDF, one_bit,
          "spacing ratio 0.12 leaves less white between the tags than one bit of theirs; with "
          "--border-bits 1 at least 0.125 is needed");
  planned("aprilgrid:6x6:0.03:0.1", HL_PICTURE_PDF, fit);
  planned("aprilgrid:6x6:0.03:0.125", HL_PICTURE_PDF, one_bit);
}

static void test_refuses_pixels(void **state)
{
  (void)state;
  refuses("aprilgrid:6x6:0.005:0.3", HL_PICTURE_PNG, (hl_sheet_settings){0, HL_PAGE_FIT, 72},
          "--dpi 72: bits would be 1.4 pixels large; 2 pixels, --dpi 102, is needed");
  refuses(
      "chessboard:9x6:0.03", HL_PICTURE_PNG, (hl_sheet_settings){0, HL_PAGE_FIT, 1200},
      "--dpi 1200: the sheet of 360.0 x 296.0 mm would be larger than 16384 pixels; --dpi 1155, "
      "or a .pdf, is needed");
  planned("aprilgrid:6x6:0.005:0.3", HL_PICTURE_PNG, (hl_sheet_settings){0, HL_PAGE_FIT, 102});
  planned("chessboard:9x6:0.03", HL_PICTURE_PNG, (hl_sheet_settings){0, HL_PAGE_FIT, 1155});
}

static void test_refuses_options(void **state)
{
  (void)state;
  refuses("chessboard:9x6:0.03", HL_PICTURE_PDF, (hl_sheet_settings){1, HL_PAGE_FIT, 0},
          "--border-bits 1: a chessboard has no tags; leave it out");
  refuses("aprilgrid:6x6:0.03:0.3", HL_PICTURE_SVG, (hl_sheet_settings){0, HL_PAGE_FIT, 600},
          "--dpi 600: only a .png has pixels; leave it out");
  const hl_target wrong = {HL_TARGET_APRILGRID, 6, 0, 0.03, 0.3};
  const hl_sheet_settings fit = {0, HL_PAGE_FIT, 0};
  hl_sheet s;
  assert_int_equal(hl_sheet_plan(NULL, &wrong, HL_PICTURE_PDF, &fit, &s), HL_ERR_ARG);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_grid),           cmocka_unit_test(test_chessboard),
      cmocka_unit_test(test_small),          cmocka_unit_test(test_pages),
      cmocka_unit_test(test_whole_pixels),   cmocka_unit_test(test_refuses_pages),
      cmocka_unit_test(test_offered_size),   cmocka_unit_test(test_refuses_cells),
      cmocka_unit_test(test_refuses_pixels), cmocka_unit_test(test_refuses_options),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
