/* Pictures that a capture writes: what is read back is what was written, colours in order. */
#include "capture_scene.h"

static void check(void **state, int channels, int bits)
{
  enum { W = 5, H = 3 };
  uint16_t codes[W * H * 3];
  float pixels[W * H * 3];
  char path[TEST_PATH_MAX];
  hl_frame frame;
  for (int i = 0; i < W * H * channels; i++) {
    codes[i] = (uint16_t)(i * 4099 + 7);
    pixels[i] = (float)codes[i] * 3.5f;
  }
  const hl_capture_frame f = {.codes = bits == 16 ? (const void *)codes : pixels,
                              .width = W,
                              .height = H,
                              .channels = channels,
                              .bits = bits};
  path_in(state, "picture", path);
  assert_int_equal(hl_capture_picture_write(NULL, path, &f), HL_OK);
  assert_int_equal(hl_frame_read(NULL, path, NULL, &frame), HL_OK);
  assert_int_equal(frame.width, W);
  assert_int_equal(frame.height, H);
  assert_int_equal(frame.channels, channels);
  assert_int_equal(frame.bits, strcmp(hl_capture_picture_ending(bits), "png") == 0 ? 16 : 32);
  for (int i = 0; i < W * H * channels; i++) {
    if (bits == 16)
      assert_near((double)frame.radiance[i] * 65535, codes[i], 0.01);
    else
      assert_near(frame.radiance[i], pixels[i], 0);
  }
  hl_frame_free(&frame);
}

static void test_there_and_back(void **state)
{
  check(state, 1, 16);
  check(state, 3, 16);
  check(state, 1, 32);
  check(state, 3, 32);
}

static void test_nowhere(void **state)
{
  (void)state;
  const uint16_t code = 1;
  hl_ctx ctx = {0};
  const hl_capture_frame f = {.codes = &code, .width = 1, .height = 1, .channels = 1, .bits = 16};
  assert_int_equal(hl_capture_picture_write(&ctx, "/nowhere/at/all", &f), HL_ERR_IO);
  assert_says(ctx.msg, "/nowhere/at/all: cannot create");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_there_and_back),
      cmocka_unit_test(test_nowhere),
  };
  return cmocka_run_group_tests(tests, folder_new, tree_free);
}
