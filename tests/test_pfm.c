/* Portable float maps: byte order, row order, headers as found, and files that are none. */
#include "../src/pfm.h"
#include "files.h"

/* 2 x 2, grey, values 1 2 / 3 4 top row first, so 3 4 1 2 in the file. By hand: IEEE 754 single
 * 1 = 3f800000, 2 = 40000000, 3 = 40400000, 4 = 40800000. */
#define LITTLE "\0\0\x40\x40\0\0\x80\x40\0\0\x80\x3f\0\0\0\x40"
#define BIG "\x40\x40\0\0\x40\x80\0\0\x3f\x80\0\0\x40\0\0\0"

typedef struct decoded {
  hl_status st;
  hl_ctx ctx;
  float *pixels;
  int width, height, channels;
} decoded;

/* From a block of exactly n bytes, so that a sanitizer sees a read past its end. */
static decoded decode(const void *bytes, size_t n)
{
  decoded d = {.width = -7};
  unsigned char *exact = malloc(n ? n : 1);
  assert_non_null(exact);
  memcpy(exact, bytes, n);
  d.st = hl_pfm_decode(&d.ctx, "f.pfm", exact, n, &d.pixels, &d.width, &d.height, &d.channels);
  free(exact);
  return d;
}

static void is_one_to_four(const void *bytes, size_t n)
{
  decoded d = decode(bytes, n);
  assert_int_equal(d.st, HL_OK);
  assert_int_equal(d.width, 2);
  assert_int_equal(d.height, 2);
  assert_int_equal(d.channels, 1);
  for (int i = 0; i < 4; i++)
    assert_near(d.pixels[i], i + 1, 0);
  free(d.pixels);
}

#define IS_ONE_TO_FOUR(text) is_one_to_four(text, sizeof text - 1)

static void test_decode_headers_as_found(void **state)
{
  (void)state;
  IS_ONE_TO_FOUR("Pf\n2 2\n-1.0\n" LITTLE);
  IS_ONE_TO_FOUR("Pf\n2 2\n1.0\n" BIG);
  IS_ONE_TO_FOUR("Pf 2 2 -1 " LITTLE);
  IS_ONE_TO_FOUR("Pf\n# a comment 9 9\n2\t2\n-1e0\n" LITTLE);
  IS_ONE_TO_FOUR("Pf\r\n2 2\r\n-1.000000\r\n" LITTLE);
  IS_ONE_TO_FOUR("Pf\n2 2\n-0.25\n" LITTLE "\n");
}

/* The pixels themselves may begin with the byte of a line feed. */
static void test_decode_keeps_a_line_feed_that_is_a_pixel(void **state)
{
  (void)state;
  const char file[] = "Pf 1 1 -1\r\x0a\x00\x80\x3f";
  decoded d = decode(file, sizeof file - 1);
  assert_int_equal(d.st, HL_OK);
  assert_near(d.pixels[0], 1.0 + 10 * 1.1920928955078125e-07, 1e-12); /* 0x3f80000a */
  free(d.pixels);
}

static void test_decode_three_channels(void **state)
{
  (void)state;
  const char file[] = "PF\n1 1\n-1\n\0\0\x80\x3f\0\0\0\x40\0\0\x40\x40";
  decoded d = decode(file, sizeof file - 1);
  assert_int_equal(d.st, HL_OK);
  assert_int_equal(d.channels, 3);
  for (int i = 0; i < 3; i++)
    assert_near(d.pixels[i], i + 1, 0);
  free(d.pixels);
}

static void refused(const void *bytes, size_t n, const char *part)
{
  decoded d = decode(bytes, n);
  assert_int_equal(d.st, HL_ERR_FORMAT);
  assert_says(d.ctx.msg, part);
  assert_null(d.pixels);
  assert_int_equal(d.width, -7);
}

#define REFUSED(text, part) refused(text, sizeof text - 1, part)

static void test_decode_refuses(void **state)
{
  (void)state;
  REFUSED("", "not a PFM");
  REFUSED("P6\n2 2\n255\n", "not a PFM");
  REFUSED("PF", "not a PFM");
  REFUSED("PF\n", "PFM size '' x ''");
  REFUSED("Pf\n2 2\n-1.0", "truncated: 0 of 16 bytes");
  REFUSED("Pf\n2 2\n-1.0\n", "truncated: 0 of 16 bytes");
  REFUSED("Pf\n2 2\n-1.0\n\0\0\0\0", "f.pfm: PFM of 2 x 2 pixels is truncated: 4 of 16 bytes");
  REFUSED("Pf\n0 2\n-1.0\n" LITTLE, "PFM size '0' x '2'");
  REFUSED("Pf\n-2 2\n-1.0\n" LITTLE, "PFM size '-2' x '2'");
  REFUSED("Pf\n2.5 2\n-1.0\n" LITTLE, "PFM size '2.5' x '2'");
  REFUSED("Pf\n65536 65536\n-1.0\n" LITTLE, "1 to 2^28 pixels");
  REFUSED("Pf\n99999999999999999999999 1\n-1.0\n" LITTLE, "1 to 2^28 pixels");
  REFUSED("Pf\n2 2\n0.0\n" LITTLE, "PFM scale '0.0'");
  REFUSED("Pf\n2 2\nnan\n" LITTLE, "PFM scale 'nan'");
  REFUSED("Pf\n2 2\n\x01\x02\n" LITTLE, "PFM scale '?'");
}

/* Every beginning of a good file is refused, and none is read past its end. */
static void test_decode_refuses_every_beginning(void **state)
{
  (void)state;
  const char file[] = "Pf\n2 2\n-1.0\n" LITTLE;
  for (size_t n = 0; n < sizeof file - 1; n++) {
    decoded d = decode(file, n);
    assert_int_equal(d.st, HL_ERR_FORMAT);
  }
}

static void test_decode_survives_noise(void **state)
{
  (void)state;
  const char file[] = "Pf\n2 2\n-1.0\n" LITTLE;
  test_random r = {99};
  for (int i = 0; i < 20000; i++) {
    char changed[sizeof file];
    memcpy(changed, file, sizeof file);
    for (int k = 0; k < 3; k++)
      changed[(size_t)(random_uniform(&r) * 14)] = (char)(unsigned char)(random_uniform(&r) * 256);
    decoded d = decode(changed, sizeof file - 1);
    if (d.st == HL_OK)
      assert_true((size_t)d.width * (size_t)d.height * (size_t)d.channels <= 4);
    free(d.pixels);
  }
}

static void test_write_then_decode(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "w.pfm", path);
  float pixels[3 * 5 * 4];
  test_random r = {3};
  for (size_t i = 0; i < sizeof pixels / sizeof *pixels; i++)
    pixels[i] = (float)random_normal(&r);
  pixels[7] = NAN;
  for (int channels = 1; channels <= 3; channels += 2) {
    assert_int_equal(hl_pfm_write(NULL, path, pixels, 5, 4, channels), HL_OK);
    size_t n = 0;
    char *bytes = get_file(path, &n);
    decoded d = decode(bytes, n);
    assert_int_equal(d.st, HL_OK);
    assert_int_equal(d.width, 5);
    assert_int_equal(d.height, 4);
    assert_int_equal(d.channels, channels);
    assert_memory_equal(d.pixels, pixels, sizeof(float) * 20 * (size_t)channels);
    free(d.pixels);
    free(bytes);
  }
}

static void test_write_refuses(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "none.pfm", path);
  const float pixels[4] = {0};
  hl_ctx ctx = {0};
  assert_int_equal(hl_pfm_write(&ctx, path, pixels, 2, 1, 2), HL_ERR_ARG);
  assert_says(ctx.msg, "channels = 2; a PFM has 1 or 3");
  assert_int_equal(hl_pfm_write(&ctx, path, pixels, 0, 1, 1), HL_ERR_ARG);
  assert_says(ctx.msg, "size 0 x 1");
  assert_int_equal(hl_pfm_write(&ctx, path, pixels, 65536, 65536, 1), HL_ERR_ARG);
  assert_int_not_equal(access(path, F_OK), 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_decode_headers_as_found),
      cmocka_unit_test(test_decode_keeps_a_line_feed_that_is_a_pixel),
      cmocka_unit_test(test_decode_three_channels),
      cmocka_unit_test(test_decode_refuses),
      cmocka_unit_test(test_decode_refuses_every_beginning),
      cmocka_unit_test(test_decode_survives_noise),
      cmocka_unit_test(test_write_then_decode),
      cmocka_unit_test(test_write_refuses),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
