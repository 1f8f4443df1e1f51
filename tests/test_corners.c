/* The set of corners: views come in, keep their corners, and go. */
#include <stdio.h>
#include <string.h>

#include "files.h"
#include "halflight/corners.h"

static const hl_target board = {HL_TARGET_CHESSBOARD, 3, 2, 0.01, 0};

static void test_views_keep_their_corners_while_the_set_grows(void **state)
{
  (void)state;
  hl_corners set = hl_corners_of(&board);
  assert_int_equal(set.n_views, 0);
  for (int i = 0; i < 100; i++) {
    char name[16];
    hl_view *view = NULL;
    snprintf(name, sizeof name, "%d.png", i);
    assert_int_equal(hl_corners_add(NULL, &set, name, &view), HL_OK);
    assert_true(view->used);
    for (int k = 0; k < 6; k++)
      assert_near(view->corner[k].sigma, 0, 0);
    view->corner[5].x = i;
  }
  assert_int_equal(set.n_views, 100);
  for (int i = 0; i < 100; i++)
    assert_near(set.view[i].corner[5].x, i, 0);
  assert_string_equal(set.view[77].name, "77.png");
  hl_corners_free(&set);
  assert_int_equal(set.n_views, 0);
  hl_corners_free(&set);
  hl_corners_free(NULL);
}

static void test_names_have_bounds(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  hl_view *view = NULL;
  char name[HL_VIEW_NAME_MAX + 1];
  hl_corners set = hl_corners_of(&board);
  memset(name, 'a', sizeof name);
  name[HL_VIEW_NAME_MAX] = '\0';
  assert_int_equal(hl_corners_add(&ctx, &set, name, &view), HL_ERR_ARG);
  assert_says(ctx.msg, "name of view 0 has 256 bytes; 1 .. 255 are accepted");
  assert_int_equal(hl_corners_add(&ctx, &set, "", &view), HL_ERR_ARG);
  assert_int_equal(hl_corners_add(&ctx, &set, NULL, &view), HL_ERR_ARG);
  assert_null(view);
  name[HL_VIEW_NAME_MAX - 1] = '\0';
  assert_int_equal(hl_corners_add(&ctx, &set, name, &view), HL_OK);
  assert_string_equal(view->name, name);
  hl_corners_free(&set);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_views_keep_their_corners_while_the_set_grows),
      cmocka_unit_test(test_names_have_bounds),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
