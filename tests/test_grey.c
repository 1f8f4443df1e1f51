/* One plane of a frame: means, codes and what is done to them. */
#include "../calib/grey.h"

#include <stdlib.h>
#include <string.h>

#include "near.h"

static hl_frame frame_of(const void *codes, int width, int height, int channels, int bits)
{
  hl_frame frame;
  assert_int_equal(hl_frame_from_codes(NULL, codes, width, height, channels, bits, NULL, &frame),
                   HL_OK);
  return frame;
}

static hl_grey grey_of(hl_frame *frame)
{
  hl_grey grey;
  assert_int_equal(hl_grey_of(NULL, frame, &grey), HL_OK);
  hl_frame_free(frame);
  return grey;
}

static void test_mean_of_the_channels(void **state)
{
  (void)state;
  const float codes[2][3] = {{1, 2, 6}, {NAN, 4, 8}};
  hl_frame frame = frame_of(codes, 2, 1, 3, 32);
  hl_grey grey = grey_of(&frame);
  assert_near(grey.linear[0], 3, 1e-6);
  assert_near(grey.linear[1], 6, 1e-6);
  hl_grey_free(&grey);
  hl_grey_free(&grey);
}

static void test_unusable_pixels_are_no_edges(void **state)
{
  (void)state;
  const float codes[4] = {5, NAN, INFINITY, 7};
  hl_frame frame = frame_of(codes, 4, 1, 1, 32);
  hl_grey grey = grey_of(&frame);
  const double want[4] = {5, 5, 5, 7};
  for (int i = 0; i < 4; i++)
    assert_near(grey.linear[i], want[i], 0);
  hl_grey_free(&grey);
}

/* An 8-bit frame's own codes come back, whatever it shows, as long as it is not dark. */
static void test_curved_codes_are_srgb(void **state)
{
  (void)state;
  uint8_t codes[256];
  for (int i = 0; i < 256; i++)
    codes[i] = (uint8_t)i;
  hl_frame frame = frame_of(codes, 64, 4, 1, 8);
  hl_grey grey = grey_of(&frame);
  assert_near(grey.white, 1, 0);
  hl_grey_code_curved(&grey);
  assert_true(grey.stride >= HL_GREY_SIDE_MIN && grey.rows >= HL_GREY_SIDE_MIN);
  for (int y = 0; y < 4; y++)
    for (int x = 0; x < 64; x++)
      assert_int_equal(grey.code[y * grey.stride + x], codes[64 * y + x]);
  hl_grey_free(&grey);
}

/* A dark frame is spread to the whole range, but for the brightest thousandth. */
static void test_dark_frames_are_spread(void **state)
{
  (void)state;
  enum { N = 128 };
  float *codes = malloc(N * N * sizeof *codes);
  assert_non_null(codes);
  for (int i = 0; i < N * N; i++)
    codes[i] = (i / 7) % 2 ? 0.002f : 0.0002f;
  codes[700] = 90; /* a lamp */
  hl_frame frame = frame_of(codes, N, N, 1, 32);
  hl_grey grey = grey_of(&frame);
  assert_near(grey.white, 0.002, 1e-9);
  hl_grey_code_curved(&grey);
  assert_int_equal(grey.code[7], 255);
  assert_int_equal(grey.code[0], 89); /* sRGB of 0.1 */
  assert_int_equal(grey.code[(size_t)(700 / N) * (size_t)grey.stride + 700 % N], 255);
  hl_grey_code_linear(&grey, 0.004f);
  assert_int_equal(grey.code[7], 128);
  assert_int_equal(grey.code[0], 13);
  hl_grey_free(&grey);
  free(codes);
}

static void test_black_frames_are_black(void **state)
{
  (void)state;
  const float codes[6] = {0, 0, 0, 0, -1, 0};
  hl_frame frame = frame_of(codes, 3, 2, 1, 32);
  hl_grey grey = grey_of(&frame);
  hl_grey_code_curved(&grey);
  for (int i = 0; i < 3; i++)
    assert_int_equal(grey.code[i], 0);
  hl_grey_code_linear(&grey, 0);
  for (int i = 0; i < 3; i++)
    assert_int_equal(grey.code[i], 0);
  hl_grey_free(&grey);
}

static void test_white_grows_by_a_pixel(void **state)
{
  (void)state;
  uint8_t codes[7 * 5] = {0};
  codes[2 * 7 + 3] = 200;
  codes[0] = 90;
  hl_frame frame = frame_of(codes, 7, 5, 1, 8);
  hl_grey grey = grey_of(&frame);
  hl_grey_code_linear(&grey, 1);
  const int light = grey.code[2 * grey.stride + 3];
  hl_grey_widen(&grey);
  for (int y = 0; y < 5; y++)
    for (int x = 0; x < 7; x++) {
      const int code = grey.code[y * grey.stride + x];
      if (abs(x - 3) <= 1 && abs(y - 2) <= 1)
        assert_int_equal(code, light);
      else if (x <= 1 && y <= 1)
        assert_true(code > 0 && code < light);
      else
        assert_int_equal(code, 0);
    }
  hl_grey_free(&grey);
}

static void test_left_to_right(void **state)
{
  (void)state;
  const uint8_t codes[2][3] = {{10, 20, 30}, {40, 50, 60}};
  hl_frame frame = frame_of(codes, 3, 2, 1, 8);
  hl_grey grey = grey_of(&frame);
  grey.white = 1;
  hl_grey_code_curved(&grey);
  hl_grey_mirror(&grey);
  for (int y = 0; y < 2; y++)
    for (int x = 0; x < 3; x++)
      assert_int_equal(grey.code[y * grey.stride + x], codes[y][2 - x]);
  hl_grey_free(&grey);
}

static void test_between_pixels(void **state)
{
  (void)state;
  const float codes[2][2] = {{1, 2}, {5, 10}};
  hl_frame frame = frame_of(codes, 2, 2, 1, 32);
  hl_grey grey = grey_of(&frame);
  assert_near(hl_grey_at(&grey, 0, 0), 1, 0);
  assert_near(hl_grey_at(&grey, 1, 1), 10, 0);
  assert_near(hl_grey_at(&grey, 0.5, 0), 1.5, 1e-12);
  assert_near(hl_grey_at(&grey, 0.25, 0.5), 0.5 * 1.25 + 0.5 * 6.25, 1e-12);
  assert_near(hl_grey_at(&grey, -3, 9), 5, 0);
  assert_near(hl_grey_at(&grey, NAN, NAN), 1, 0);
  hl_grey_free(&grey);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_mean_of_the_channels),
      cmocka_unit_test(test_unusable_pixels_are_no_edges),
      cmocka_unit_test(test_curved_codes_are_srgb),
      cmocka_unit_test(test_dark_frames_are_spread),
      cmocka_unit_test(test_black_frames_are_black),
      cmocka_unit_test(test_white_grows_by_a_pixel),
      cmocka_unit_test(test_left_to_right),
      cmocka_unit_test(test_between_pixels),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
