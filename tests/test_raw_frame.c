/* Buffers of a driver: which formats are read, and what becomes of their bytes. */
#include "../calib/raw_frame.h"
#include "files.h"

static uint32_t fourcc(const char *text)
{
  return (uint32_t)(unsigned char)text[0] | (uint32_t)(unsigned char)text[1] << 8 |
         (uint32_t)(unsigned char)text[2] << 16 | (uint32_t)(unsigned char)text[3] << 24;
}

static const uint64_t packed = UINT64_C(11) << 56 | 1;

static void test_formats(void **state)
{
  (void)state;
  const hl_raw_format *f = hl_raw_format_of(fourcc("BA10"), packed);
  assert_non_null(f);
  assert_int_equal(f->order, HL_BAYER_GRBG);
  assert_int_equal(f->packing, HL_BAYER_CSI2_10);
  f = hl_raw_format_of(fourcc("BA10"), 0);
  assert_non_null(f);
  assert_int_equal(f->packing, HL_BAYER_WORDS);
  assert_int_equal(f->bits, 10);
  assert_null(hl_raw_format_of(fourcc("YUYV"), 0));
  assert_null(hl_raw_format_of(fourcc("BA10"), 1));
}

static void test_colours_in_order(void **state)
{
  (void)state;
  const uint8_t bytes[] = {1, 2, 3, 255, 0, 128, 9, 9}; /* two pixels and padding */
  uint16_t codes[6];
  hl_capture_frame out = {0};
  assert_int_equal(hl_raw_develop(NULL, hl_raw_format_of(fourcc("BG24"), 0), HL_PIXELS_PROCESSED,
                                  bytes, sizeof bytes, 8, 2, 1, NULL, codes, &out),
                   HL_OK);
  const uint16_t red_first[] = {257, 514, 771, 65535, 0, 128 * 257};
  assert_memory_equal(codes, red_first, sizeof codes);
  assert_int_equal(out.codes_mean.transfer, HL_TRANSFER_SRGB);
  assert_int_equal(hl_raw_develop(NULL, hl_raw_format_of(fourcc("RG24"), 0), HL_PIXELS_PROCESSED,
                                  bytes, sizeof bytes, 8, 2, 1, NULL, codes, &out),
                   HL_OK);
  assert_int_equal(codes[0], 771);
  assert_int_equal(codes[2], 257);
}

static void test_raw(void **state)
{
  (void)state;
  const uint8_t bytes[] = {10, 20, 30, 40}; /* RG / GB */
  uint16_t samples[4];
  uint16_t codes[12];
  hl_capture_frame out = {0};
  const hl_raw_format *f = hl_raw_format_of(fourcc("RGGB"), 0);
  assert_int_equal(
      hl_raw_develop(NULL, f, HL_PIXELS_RAW_GREEN, bytes, 4, 2, 2, 2, samples, codes, &out), HL_OK);
  assert_int_equal(out.width, 1);
  assert_int_equal(out.channels, 1);
  assert_int_equal(codes[0], 25 * 257);
  assert_int_equal(
      hl_raw_develop(NULL, f, HL_PIXELS_RAW_DEMOSAICED, bytes, 4, 2, 2, 2, samples, codes, &out),
      HL_OK);
  assert_int_equal(out.width, 2);
  assert_int_equal(out.channels, 3);
  assert_int_equal(out.codes_mean.transfer, HL_TRANSFER_LINEAR);
  assert_int_equal(codes[0], 10 * 257);
  assert_int_equal(codes[1], 25 * 257);
  assert_int_equal(codes[2], 40 * 257);
}

static void test_refused(void **state)
{
  (void)state;
  const uint8_t bytes[12] = {0};
  uint16_t codes[12];
  hl_ctx ctx = {0};
  hl_capture_frame out = {0};
  assert_int_equal(hl_raw_develop(&ctx, hl_raw_format_of(fourcc("BG24"), 0), HL_PIXELS_RAW_GREEN,
                                  bytes, 12, 6, 2, 2, codes, codes, &out),
                   HL_ERR_ARG);
  assert_says(ctx.msg, "format BG24 are not raw-green");
  assert_int_equal(hl_raw_develop(&ctx, hl_raw_format_of(fourcc("BG24"), 0), HL_PIXELS_PROCESSED,
                                  bytes, 11, 6, 2, 2, codes, codes, &out),
                   HL_ERR_ARG);
  assert_says(ctx.msg, "in 11 bytes");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_formats),
      cmocka_unit_test(test_colours_in_order),
      cmocka_unit_test(test_raw),
      cmocka_unit_test(test_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
