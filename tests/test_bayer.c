/* Raw Bayer frames: packed by hand from known samples, and colours of flat and sloping scenes. */
#include "../calib/bayer.h"
#include "files.h"

enum { W = 8, H = 4 };

static unsigned sample(int bits, int i)
{
  return ((unsigned)i * 2654435761u) >> (32 - bits);
}

/* The layouts as the CSI-2 specification draws them, bit by bit. */
static void pack10(const unsigned *s, uint8_t *out)
{
  for (int i = 0; i < 4; i++)
    out[i] = (uint8_t)(s[i] >> 2);
  out[4] = (uint8_t)((s[0] & 3) | (s[1] & 3) << 2 | (s[2] & 3) << 4 | (s[3] & 3) << 6);
}

static void pack12(const unsigned *s, uint8_t *out)
{
  out[0] = (uint8_t)(s[0] >> 4);
  out[1] = (uint8_t)(s[1] >> 4);
  out[2] = (uint8_t)((s[0] & 15) | (s[1] & 15) << 4);
}

static void put_sample(hl_bayer_packing packing, uint8_t *row, int x, const unsigned *row_samples)
{
  if (packing == HL_BAYER_8) {
    row[x] = (uint8_t)row_samples[x];
  } else if (packing == HL_BAYER_WORDS) {
    row[2 * x] = (uint8_t)(row_samples[x] & 255);
    row[2 * x + 1] = (uint8_t)(row_samples[x] >> 8);
  } else if (packing == HL_BAYER_CSI2_10) {
    if (x % 4 == 0)
      pack10(row_samples + x, row + x / 4 * 5);
  } else if (x % 2 == 0) {
    pack12(row_samples + x, row + x / 2 * 3);
  }
}

static void check_packing(hl_bayer_packing packing, int bits)
{
  const size_t stride = hl_bayer_row_bytes(packing, W) + 5; /* drivers pad rows */
  uint8_t bytes[H * (2 * W + 5)] = {0};
  uint16_t out[W * H];
  for (int y = 0; y < H; y++) {
    unsigned row[W];
    for (int x = 0; x < W; x++)
      row[x] = sample(bits, y * W + x + 1);
    for (int x = 0; x < W; x++)
      put_sample(packing, bytes + stride * (size_t)y, x, row);
  }
  const size_t n = stride * (H - 1) + hl_bayer_row_bytes(packing, W);
  assert_int_equal(hl_bayer_unpack(NULL, packing, bits, bytes, n, stride, W, H, out), HL_OK);
  const double full = (double)((1u << bits) - 1);
  for (int i = 0; i < W * H; i++)
    assert_near(out[i], sample(bits, i + 1) * 65535.0 / full, 0.5000001);
  hl_ctx ctx = {0};
  assert_int_equal(hl_bayer_unpack(&ctx, packing, bits, bytes, n - 1, stride, W, H, out),
                   HL_ERR_ARG);
  assert_says(ctx.msg, "a row are needed");
}

static void test_unpack(void **state)
{
  (void)state;
  check_packing(HL_BAYER_8, 8);
  check_packing(HL_BAYER_WORDS, 10);
  check_packing(HL_BAYER_WORDS, 12);
  check_packing(HL_BAYER_WORDS, 16);
  check_packing(HL_BAYER_CSI2_10, 10);
  check_packing(HL_BAYER_CSI2_12, 12);
}

/* Both ends of the scale stay: a clipped sample is full scale, whatever its depth. */
static void test_ends(void **state)
{
  (void)state;
  const uint8_t full[5] = {255, 255, 255, 255, 255};
  const uint8_t none[5] = {0};
  uint16_t out[4];
  assert_int_equal(hl_bayer_unpack(NULL, HL_BAYER_CSI2_10, 10, full, 5, 5, 4, 1, out), HL_OK);
  assert_int_equal(out[3], 65535);
  assert_int_equal(hl_bayer_unpack(NULL, HL_BAYER_CSI2_12, 12, full, 3, 3, 2, 1, out), HL_OK);
  assert_int_equal(out[1], 65535);
  assert_int_equal(hl_bayer_unpack(NULL, HL_BAYER_CSI2_10, 10, none, 5, 5, 4, 1, out), HL_OK);
  assert_int_equal(out[0], 0);
  /* a word above its depth is clipped, not wrapped */
  const uint8_t above[2] = {0, 8};
  assert_int_equal(hl_bayer_unpack(NULL, HL_BAYER_WORDS, 10, above, 2, 2, 1, 1, out), HL_OK);
  assert_int_equal(out[0], 65535);
}

static void test_refused(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  const uint8_t bytes[32] = {0};
  uint16_t out[32];
  assert_int_equal(hl_bayer_unpack(&ctx, HL_BAYER_CSI2_10, 10, bytes, 32, 16, 6, 2, out),
                   HL_ERR_ARG);
  assert_says(ctx.msg, "a multiple of 4");
  assert_int_equal(hl_bayer_unpack(&ctx, HL_BAYER_CSI2_12, 12, bytes, 32, 16, 5, 2, out),
                   HL_ERR_ARG);
  assert_int_equal(hl_bayer_unpack(&ctx, HL_BAYER_WORDS, 17, bytes, 32, 16, 4, 2, out), HL_ERR_ARG);
  assert_says(ctx.msg, "17 bits");
  assert_int_equal(hl_bayer_unpack(&ctx, HL_BAYER_8, 8, bytes, 32, 3, 4, 2, out), HL_ERR_ARG);
}

/* Colour of a sample, told another way than the code does. */
static int colour(const char *cell, int x, int y)
{
  const char c = cell[2 * (y % 2) + x % 2];
  return c == 'R' ? 0 : c == 'G' ? 1 : 2;
}

static const char *const cells[] = {"RGGB", "GRBG", "GBRG", "BGGR"};

static void test_flat_colours(void **state)
{
  (void)state;
  static const uint16_t flat[3] = {10000, 30000, 50001};
  for (int order = 0; order < 4; order++) {
    uint16_t codes[W * H];
    uint16_t green[W * H / 4];
    uint16_t rgb[3 * W * H];
    for (int i = 0; i < W * H; i++)
      codes[i] = flat[colour(cells[order], i % W, i / W)];
    hl_bayer_green((hl_bayer_order)order, codes, W, H, green);
    for (int i = 0; i < W * H / 4; i++)
      assert_int_equal(green[i], flat[1]);
    hl_bayer_demosaic((hl_bayer_order)order, codes, W, H, rgb);
    for (int i = 0; i < 3 * W * H; i++)
      assert_int_equal(rgb[i], flat[i % 3]);
  }
}

/* A plane of light is reproduced by means of neighbours that lie around a sample: inside exactly;
 * and a green pixel stands for (2x + 0.5, 2y + 0.5). */
static void test_slope(void **state)
{
  (void)state;
  for (int order = 0; order < 4; order++) {
    uint16_t codes[W * H];
    uint16_t green[W * H / 4];
    uint16_t rgb[3 * W * H];
    for (int i = 0; i < W * H; i++)
      codes[i] = (uint16_t)(1000 + 200 * (i % W) + 400 * (i / W));
    hl_bayer_green((hl_bayer_order)order, codes, W, H, green);
    for (int i = 0; i < W * H / 4; i++)
      assert_near(green[i],
                  1000 + 200 * (2 * (i % (W / 2)) + 0.5) + 400 * (2 * (i / (W / 2)) + 0.5), 0.5);
    hl_bayer_demosaic((hl_bayer_order)order, codes, W, H, rgb);
    for (int y = 1; y < H - 1; y++)
      for (int x = 1; x < W - 1; x++)
        for (int c = 0; c < 3; c++)
          assert_near(rgb[3 * (y * W + x) + c], 1000 + 200 * x + 400 * y, 0.5);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_unpack),  cmocka_unit_test(test_ends),
      cmocka_unit_test(test_refused), cmocka_unit_test(test_flat_colours),
      cmocka_unit_test(test_slope),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
