/* The tags' codes: against AprilTag's own pictures of them. */
#include <stdlib.h>
#include <string.h>

#include "halflight/target.h"
#include "near.h"

#ifdef HL_HAVE_APRILTAG
#include <apriltag/tag36h11.h>

static void test_cells(void **state)
{
  (void)state;
  apriltag_family_t *family = tag36h11_create();
  assert_int_equal(family->ncodes, HL_TARGET_TAGS_MAX);
  for (int id = 0; id < HL_TARGET_TAGS_MAX; id++) {
    bool white[HL_TARGET_TAG_CELLS][HL_TARGET_TAG_CELLS];
    assert_int_equal(hl_target_tag_cells(NULL, id, white), HL_OK);
    /* its outermost ring is white, the next the black border */
    image_u8_t *picture = apriltag_to_image(family, id);
    assert_int_equal(picture->width, HL_TARGET_TAG_CELLS + 4);
    for (int y = 0; y < HL_TARGET_TAG_CELLS; y++)
      for (int x = 0; x < HL_TARGET_TAG_CELLS; x++)
        assert_int_equal(white[y][x], picture->buf[(y + 2) * picture->stride + x + 2] == 255);
    free(picture->buf); /* the library keeps image_u8_destroy to itself */
    free(picture);
  }
  tag36h11_destroy(family);
}

static void refuses(int id, const char *message)
{
  hl_ctx ctx = {0};
  bool white[HL_TARGET_TAG_CELLS][HL_TARGET_TAG_CELLS];
  memset(white, 1, sizeof white);
  assert_int_equal(hl_target_tag_cells(&ctx, id, white), HL_ERR_ARG);
  assert_string_equal(ctx.msg, message);
  for (int i = 0; i < HL_TARGET_TAG_CELLS * HL_TARGET_TAG_CELLS; i++)
    assert_true(white[i / HL_TARGET_TAG_CELLS][i % HL_TARGET_TAG_CELLS]);
}

static void test_refusals(void **state)
{
  (void)state;
  refuses(-1, "tag -1 is outside [0, 586] of family tag36h11");
  refuses(587, "tag 587 is outside [0, 586] of family tag36h11");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_cells),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

static void test_unavailable(void **state)
{
  hl_ctx ctx = {0};
  bool white[HL_TARGET_TAG_CELLS][HL_TARGET_TAG_CELLS] = {{false}};
  (void)state;
  assert_int_equal(hl_target_tag_cells(&ctx, 0, white), HL_ERR_UNAVAILABLE);
  assert_non_null(strstr(ctx.msg, "not in this build"));
  assert_non_null(strstr(ctx.msg, "-DHL_WITH_APRILTAG=ON"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_unavailable)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

#endif
