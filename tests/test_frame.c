/* Codes to linear radiance and mask; files of every kind, whole and broken. */
#include "files.h"
#include "halflight/frame.h"
#include "images.h"

static hl_frame_settings with(hl_transfer transfer, double black, double saturation)
{
  hl_frame_settings s = hl_frame_defaults();
  s.transfer = transfer;
  s.black = black;
  s.saturation = saturation;
  return s;
}

static hl_frame from(const void *codes, int width, int channels, int bits,
                     const hl_frame_settings *s)
{
  hl_frame f = {0};
  assert_int_equal(hl_frame_from_codes(NULL, codes, width, 1, channels, bits, s, &f), HL_OK);
  return f;
}

static void test_defaults_pass_their_check(void **state)
{
  (void)state;
  const hl_frame_settings s = hl_frame_defaults();
  assert_int_equal(hl_fields_check(NULL, hl_frame_fields(), &s), HL_OK);
  assert_int_equal(s.transfer, HL_TRANSFER_AUTO);
  assert_int_equal(hl_frame_fields()->n, 3);
}

/* IEC 61966-2-1: code 10 is below the knee (10/255/12.92), 188 above it (0.50289). */
static void test_eight_bits_are_srgb(void **state)
{
  (void)state;
  const uint8_t codes[] = {0, 10, 188, 254, 255};
  hl_frame f = from(codes, 5, 1, 8, NULL);
  assert_near(f.radiance[0], 0, 0);
  assert_near(f.radiance[1], 10 / 255.0 / 12.92, 1e-9);
  assert_near(f.radiance[2], 0.50289, 1e-5);
  assert_near(f.radiance[4], 1, 1e-7);
  assert_int_equal(f.state[3], HL_SAMPLE_OK);
  assert_int_equal(f.state[4], HL_SAMPLE_CLIPPED);
  assert_int_equal(f.n_clipped, 1);
  assert_int_equal(f.n_unusable, 0);
  assert_near(f.saturation, 1, 1e-15);
  assert_int_equal(f.bits, 8);
  hl_frame_free(&f);
  assert_null(f.radiance);
}

static void test_sixteen_bits_are_linear(void **state)
{
  (void)state;
  const uint16_t codes[] = {0, 1, 32768, 65534, 65535};
  hl_frame f = from(codes, 5, 1, 16, NULL);
  for (int i = 0; i < 5; i++)
    assert_near(f.radiance[i], codes[i] / 65535.0, 1e-7);
  assert_int_equal(f.state[3], HL_SAMPLE_OK);
  assert_int_equal(f.state[4], HL_SAMPLE_CLIPPED);
  hl_frame_free(&f);
}

static void test_transfer_overrides_the_kind(void **state)
{
  (void)state;
  const uint8_t codes[] = {51, 128};
  hl_frame_settings s = with(HL_TRANSFER_LINEAR, 0, 0);
  hl_frame f = from(codes, 2, 1, 8, &s);
  assert_near(f.radiance[0], 0.2, 1e-8);
  hl_frame_free(&f);
  s.transfer = HL_TRANSFER_GAMMA;
  s.gamma = 2;
  f = from(codes, 2, 1, 8, &s);
  assert_near(f.radiance[0], 0.04, 1e-8);
  hl_frame_free(&f);
}

/* (x - b) / (1 - b): black becomes 0, full scale stays 1, below black goes negative. */
static void test_black_of_integers(void **state)
{
  (void)state;
  const uint16_t codes[] = {0, 13107, 39321, 65535}; /* 0, 0.2, 0.6, 1 */
  const hl_frame_settings s = with(HL_TRANSFER_AUTO, 0.2, 0);
  hl_frame f = from(codes, 4, 1, 16, &s);
  assert_near(f.radiance[0], -0.25, 1e-7);
  assert_near(f.radiance[1], 0, 1e-7);
  assert_near(f.radiance[2], 0.5, 1e-7);
  assert_near(f.radiance[3], 1, 1e-7);
  hl_frame_free(&f);
}

/* A sample counts as clipped from half a code below saturation; the linear level follows. */
static void test_saturation_of_integers(void **state)
{
  (void)state;
  const uint8_t codes[] = {199, 200, 201};
  hl_frame_settings s = with(HL_TRANSFER_LINEAR, 0.1, 200.0 / 255);
  hl_frame f = from(codes, 3, 1, 8, &s);
  assert_int_equal(f.state[0], HL_SAMPLE_OK);
  assert_int_equal(f.state[1], HL_SAMPLE_CLIPPED);
  assert_int_equal(f.state[2], HL_SAMPLE_CLIPPED);
  assert_near(f.saturation, (200.0 / 255 - 0.1) / 0.9, 1e-15);
  hl_frame_free(&f);
  s.saturation = 200.4 / 255;
  f = from(codes, 3, 1, 8, &s);
  assert_int_equal(f.state[1], HL_SAMPLE_CLIPPED);
  hl_frame_free(&f);
  s.saturation = 200.6 / 255;
  f = from(codes, 3, 1, 8, &s);
  assert_int_equal(f.state[1], HL_SAMPLE_OK);
  hl_frame_free(&f);
}

static void test_floats_keep_what_they_hold(void **state)
{
  (void)state;
  const float codes[] = {-2.5f, 0, 1e-30f, 7, 1e30f, NAN, INFINITY, -INFINITY};
  hl_frame f = from(codes, 8, 1, 32, NULL);
  for (int i = 0; i < 5; i++) {
    assert_near(f.radiance[i], codes[i], 0);
    assert_int_equal(f.state[i], HL_SAMPLE_OK);
  }
  for (int i = 5; i < 8; i++) {
    assert_near(f.radiance[i], 0, 0);
    assert_int_equal(f.state[i], HL_SAMPLE_UNUSABLE);
  }
  assert_int_equal(f.n_unusable, 3);
  assert_int_equal(f.n_clipped, 0);
  assert_near(f.saturation, 0, 0);
  hl_frame_free(&f);
}

static void test_saturation_of_floats(void **state)
{
  (void)state;
  const float codes[] = {0.5f, 0.74f, 0.75f, 9};
  const hl_frame_settings s = with(HL_TRANSFER_AUTO, 0.25, 0.75);
  hl_frame f = from(codes, 4, 1, 32, &s);
  assert_near(f.radiance[0], 0.25, 0);
  assert_near(f.saturation, 0.5, 0);
  assert_int_equal(f.state[1], HL_SAMPLE_OK);
  assert_int_equal(f.state[2], HL_SAMPLE_CLIPPED);
  assert_int_equal(f.state[3], HL_SAMPLE_CLIPPED);
  hl_frame_free(&f);
}

/* What leaves the range of a float on the way is unusable, not infinite. */
static void test_overflow_is_unusable(void **state)
{
  (void)state;
  const float codes[] = {1e30f};
  hl_frame_settings s = with(HL_TRANSFER_GAMMA, 0, 0);
  hl_frame f = from(codes, 1, 1, 32, &s);
  assert_int_equal(f.state[0], HL_SAMPLE_UNUSABLE);
  assert_near(f.radiance[0], 0, 0);
  hl_frame_free(&f);
}

static void test_alpha_is_dropped(void **state)
{
  (void)state;
  const uint16_t codes[] = {1, 2, 3, 65535, 4, 5, 6, 65535};
  hl_frame f = from(codes, 2, 4, 16, NULL);
  assert_int_equal(f.channels, 3);
  for (int i = 0; i < 6; i++)
    assert_near(f.radiance[i], (i + 1) / 65535.0, 1e-12);
  assert_int_equal(f.n_clipped, 0);
  hl_frame_free(&f);
}

static void refused(const hl_frame_settings *s, int width, int channels, int bits, hl_status want,
                    const char *part)
{
  const uint16_t codes[16] = {0};
  hl_ctx ctx = {0};
  hl_frame f;
  hl_frame before;
  memset(&f, 0x5a, sizeof f);
  before = f;
  assert_int_equal(hl_frame_from_codes(&ctx, codes, width, 1, channels, bits, s, &f), want);
  assert_says(ctx.msg, part);
  assert_memory_equal(&f, &before, sizeof f);
}

static void test_from_codes_refuses(void **state)
{
  (void)state;
  hl_frame_settings s = with(HL_TRANSFER_AUTO, NAN, 0);
  refused(&s, 2, 1, 16, HL_ERR_ARG, "black = nan");
  s = with(HL_TRANSFER_AUTO, 0, NAN);
  refused(&s, 2, 1, 16, HL_ERR_ARG, "saturation = nan");
  s = with(HL_TRANSFER_AUTO, 0, -1);
  refused(&s, 2, 1, 16, HL_ERR_ARG, "saturation = -1");
  s = with(HL_TRANSFER_AUTO, 0, 1.5);
  refused(&s, 2, 1, 16, HL_ERR_ARG, "saturation = 1.5 is outside [0, 1], the scale of a 16-bit");
  s = with(HL_TRANSFER_AUTO, 0.5, 0.5);
  refused(&s, 2, 1, 16, HL_ERR_ARG, "black = 0.5 is not below saturation = 0.5");
  s = with(HL_TRANSFER_AUTO, 1, 0);
  refused(&s, 2, 1, 8, HL_ERR_ARG, "black = 1 is not below saturation = 1");
  s = with(HL_TRANSFER_GAMMA, 0, 0);
  s.gamma = 0;
  refused(&s, 2, 1, 16, HL_ERR_ARG, "gamma = 0 is outside [0.1, 10]");
  s = with((hl_transfer)9, 0, 0);
  refused(&s, 2, 1, 16, HL_ERR_ARG, "transfer = 9");
  refused(NULL, 0, 1, 16, HL_ERR_FORMAT, "size 0 x 1");
  refused(NULL, 1 << 29, 1, 16, HL_ERR_FORMAT, "1 to 2^28 pixels");
  refused(NULL, 2, 2, 16, HL_ERR_FORMAT, "channels = 2; 1, 3 or 4 are accepted");
  refused(NULL, 2, 1, 12, HL_ERR_ARG, "bits = 12");
  hl_ctx ctx = {0};
  hl_frame f;
  assert_int_equal(hl_frame_from_codes(&ctx, NULL, 1, 1, 1, 8, NULL, &f), HL_ERR_ARG);
}

static void test_free_takes_nothing(void **state)
{
  (void)state;
  hl_frame f = {0};
  hl_frame_free(NULL);
  hl_frame_free(&f);
  assert_null(f.state);
}

/* ---- files */

static void test_read_pfm(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "any-name", path);
  const float pixels[] = {-1, 0.5f, 2, 3, NAN, 5};
  assert_int_equal(hl_pfm_write(NULL, path, pixels, 1, 2, 3), HL_OK);
  hl_frame f;
  assert_int_equal(hl_frame_read(NULL, path, NULL, &f), HL_OK);
  assert_int_equal(f.width, 1);
  assert_int_equal(f.height, 2);
  assert_int_equal(f.channels, 3);
  assert_int_equal(f.bits, 32);
  assert_near(f.radiance[0], -1, 0);
  assert_near(f.radiance[5], 5, 0);
  assert_int_equal(f.state[4], HL_SAMPLE_UNUSABLE);
  hl_frame_free(&f);
}

static void read_refused(void **state, const void *bytes, size_t n, hl_status want,
                         const char *part)
{
  char path[TEST_PATH_MAX];
  path_in(state, "bad.png", path);
  put_file(path, bytes, n);
  hl_ctx ctx = {0};
  hl_frame f = {.width = -7};
  assert_int_equal(hl_frame_read(&ctx, path, NULL, &f), want);
  assert_says(ctx.msg, part);
  assert_says(ctx.msg, "bad.png: ");
  assert_int_equal(f.width, -7);
}

static void test_read_refuses_what_is_no_image(void **state)
{
  read_refused(state, "{\"format\":1}", 12, HL_ERR_FORMAT,
               "not an image: PNG, JPEG, TIFF, EXR or PFM is needed");
  read_refused(state, "", 0, HL_ERR_FORMAT, "the file is empty");
  read_refused(state, "PF\n9 9\n-1\n1234", 14, HL_ERR_FORMAT, "truncated: 4 of 972 bytes");
  char path[TEST_PATH_MAX];
  path_in(state, "missing.png", path);
  hl_ctx ctx = {0};
  hl_frame f;
  assert_int_equal(hl_frame_read(&ctx, path, NULL, &f), HL_ERR_IO);
  assert_says(ctx.msg, "missing.png: cannot open: ");
  assert_int_equal(hl_frame_read(&ctx, *state, NULL, &f), HL_ERR_IO);
  assert_says(ctx.msg, "cannot read: ");
}

static void test_read_names_the_file_of_a_bad_setting(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "s.pfm", path);
  const float pixels[] = {1};
  assert_int_equal(hl_pfm_write(NULL, path, pixels, 1, 1, 1), HL_OK);
  const hl_frame_settings s = with(HL_TRANSFER_AUTO, 2, 1);
  hl_ctx ctx = {0};
  hl_frame f;
  assert_int_equal(hl_frame_read(&ctx, path, &s, &f), HL_ERR_ARG);
  assert_says(ctx.msg, "s.pfm: black = 2 is not below saturation = 1");
}

static void test_read_refuses_every_beginning_of_a_png(void **state)
{
  for (size_t n = 8; n < sizeof png_2x2_rgb16; n++)
    read_refused(state, png_2x2_rgb16, n, HL_ERR_FORMAT, "PNG is truncated");
}

static void test_read_refuses_every_beginning_of_a_jpeg(void **state)
{
  for (size_t n = 3; n < sizeof jpeg_16x16_grey - 1; n += 7)
    read_refused(state, jpeg_16x16_grey, n, HL_ERR_FORMAT, "JPEG is truncated");
}

#ifdef HL_HAVE_OPENCV
/* The samples' values are those the scripts in images.h put in. */
static void test_read_png(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "f.pfm", path);
  put_file(path, png_2x2_rgb16, sizeof png_2x2_rgb16);
  hl_frame f;
  assert_int_equal(hl_frame_read(NULL, path, NULL, &f), HL_OK);
  assert_int_equal(f.width, 2);
  assert_int_equal(f.height, 2);
  assert_int_equal(f.channels, 3);
  assert_int_equal(f.bits, 16);
  for (int i = 0; i < 11; i++)
    assert_near(f.radiance[i], 1000.0 * (i + 1) / 65535, 1e-8);
  assert_int_equal(f.state[11], HL_SAMPLE_CLIPPED);
  hl_frame_free(&f);
}

static void test_read_jpeg(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "f.jpg", path);
  put_file(path, jpeg_16x16_grey, sizeof jpeg_16x16_grey);
  hl_frame f;
  assert_int_equal(hl_frame_read(NULL, path, NULL, &f), HL_OK);
  assert_int_equal(f.width, 16);
  assert_int_equal(f.channels, 1);
  assert_int_equal(f.bits, 8);
  for (int i = 0; i < 256; i++)
    assert_near(f.radiance[i], 0.21404, 2e-3); /* sRGB of 0.5 (128 / 255), a flat image */
  hl_frame_free(&f);
}

static void test_read_refuses_damage(void **state)
{
  unsigned char damaged[sizeof png_2x2_rgb16];
  memcpy(damaged, png_2x2_rgb16, sizeof damaged);
  damaged[45] ^= 0xff; /* inside IDAT */
  read_refused(state, damaged, sizeof damaged, HL_ERR_FORMAT, "PNG is damaged");
  read_refused(state, "II*\0\xff\xff\xff\xff", 8, HL_ERR_FORMAT, "TIFF is damaged");
  read_refused(state, "\x76\x2f\x31\x01\x02\0\0\0garbage", 15, HL_ERR_FORMAT, "EXR is damaged");
}
#else
static void test_read_without_opencv_says_so(void **state)
{
  read_refused(state, png_2x2_rgb16, sizeof png_2x2_rgb16, HL_ERR_UNAVAILABLE,
               "PNG frame needs OpenCV: build with -DHL_WITH_OPENCV=ON, or give a PFM");
}
#endif

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_defaults_pass_their_check),
      cmocka_unit_test(test_eight_bits_are_srgb),
      cmocka_unit_test(test_sixteen_bits_are_linear),
      cmocka_unit_test(test_transfer_overrides_the_kind),
      cmocka_unit_test(test_black_of_integers),
      cmocka_unit_test(test_saturation_of_integers),
      cmocka_unit_test(test_floats_keep_what_they_hold),
      cmocka_unit_test(test_saturation_of_floats),
      cmocka_unit_test(test_overflow_is_unusable),
      cmocka_unit_test(test_alpha_is_dropped),
      cmocka_unit_test(test_from_codes_refuses),
      cmocka_unit_test(test_free_takes_nothing),
      cmocka_unit_test(test_read_pfm),
      cmocka_unit_test(test_read_refuses_what_is_no_image),
      cmocka_unit_test(test_read_names_the_file_of_a_bad_setting),
      cmocka_unit_test(test_read_refuses_every_beginning_of_a_png),
      cmocka_unit_test(test_read_refuses_every_beginning_of_a_jpeg),
#ifdef HL_HAVE_OPENCV
      cmocka_unit_test(test_read_png),
      cmocka_unit_test(test_read_jpeg),
      cmocka_unit_test(test_read_refuses_damage),
#else
      cmocka_unit_test(test_read_without_opencv_says_so),
#endif
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
