/* How tags are numbered and turned on the board, from where they are seen. */
#include "../calib/aprilgrid.h"

#include "board_scene.h"

enum { TAGS = 30 };

/* A 6 x 5 board as seen: which tags, how numbered, how turned. */
typedef struct tagged {
  board_scene scene;
  hl_tag tag[TAGS + 1];
  hl_tags tags;
} tagged;

/* Tag (column, row) at position i of the list; its own corner k lies at corner k + turned of the
 * board's. */
static void put(tagged *t, int i, int column, int row, bool top_left, int turned)
{
  const int across = 2 * t->scene.target.columns;
  const int first = 2 * row * across + 2 * column;
  const int corner[4] = {first, first + 1, first + across + 1, first + across};
  t->scene.top_left_ids = top_left;
  t->tag[i].id = board_tag_id(&t->scene, column, row);
  for (int k = 0; k < 4; k++)
    board_truth(&t->scene, corner[(k + turned) % 4], t->tag[i].corner[k]);
}

static int by_id(const void *a, const void *b)
{
  return ((const hl_tag *)a)->id - ((const hl_tag *)b)->id;
}

/* The tags of columns from .. to - 1, rows from .. to - 1. */
static void see(tagged *t, const int columns[2], const int rows[2], bool top_left, int turned)
{
  int n = 0;
  t->scene = board_scene_of("aprilgrid:6x5:0.03:0.3");
  board_place(&t->scene, 0.9, 0.5, -0.4, 2.1);
  for (int row = rows[0]; row < rows[1]; row++)
    for (int column = columns[0]; column < columns[1]; column++)
      put(t, n++, column, row, top_left, turned);
  qsort(t->tag, (size_t)n, sizeof *t->tag, by_id);
  t->tags = (hl_tags){.n = n, .border_bits = 2, .tag = t->tag};
}

static const int all_columns[2] = {0, 6};
static const int all_rows[2] = {0, 5};

/* Whatever the numbering and the turn, every corner comes to its place on the board. */
static void test_every_numbering_and_turn(void **state)
{
  (void)state;
  for (int turned = 0; turned < 4; turned++)
    for (int top_left = 0; top_left < 2; top_left++) {
      tagged t = {0};
      see(&t, all_columns, all_rows, top_left, turned);
      const hl_grid_layout layout = hl_grid_layout_of(&t.scene.target, &t.tags);
      assert_int_equal(layout.top_left_ids, top_left);
      assert_int_equal(layout.turned, turned);
      assert_int_equal(layout.agreeing, layout.pairs);
      for (int i = 0; i < t.tags.n; i++)
        for (int k = 0; k < 4; k++) {
          double truth[2];
          board_truth(&t.scene, hl_grid_corner_index(&t.scene.target, &layout, t.tag[i].id, k),
                      truth);
          assert_near(t.tag[i].corner[k][0], truth[0], 1e-9);
          assert_near(t.tag[i].corner[k][1], truth[1], 1e-9);
        }
    }
}

/* Two tags one above the other, apart in both ways, are enough for both questions. */
static void test_two_tags_are_enough(void **state)
{
  (void)state;
  const int columns[2] = {2, 3};
  const int rows[2] = {1, 3};
  for (int top_left = 0; top_left < 2; top_left++) {
    tagged t = {0};
    see(&t, columns, rows, top_left, 0);
    assert_int_equal(t.tags.n, 2);
    const hl_grid_layout layout = hl_grid_layout_of(&t.scene.target, &t.tags);
    assert_int_equal(layout.top_left_ids, top_left);
    assert_int_equal(layout.turned, 0);
  }
}

/* One row alone looks alike in both numberings: Kalibr's is taken. */
static void test_one_row_is_kalibrs(void **state)
{
  (void)state;
  const int rows[2] = {1, 2};
  for (int top_left = 0; top_left < 2; top_left++) {
    tagged t = {0};
    see(&t, all_columns, rows, top_left, 0);
    const hl_grid_layout layout = hl_grid_layout_of(&t.scene.target, &t.tags);
    assert_false(layout.top_left_ids);
    assert_int_equal(layout.turned, 0);
    assert_int_equal(layout.agreeing, layout.pairs);
  }
}

/* An id twice, or none of the target's, counts for nothing. */
static void test_twice_and_foreign_do_not_count(void **state)
{
  (void)state;
  tagged t = {0};
  see(&t, all_columns, all_rows, false, 0);
  t.tag[TAGS] = t.tag[TAGS - 1]; /* 29 twice */
  t.tags.n = TAGS + 1;
  assert_true(hl_grid_counts(&t.scene.target, &t.tags, 0));
  assert_true(hl_grid_counts(&t.scene.target, &t.tags, 28));
  assert_false(hl_grid_counts(&t.scene.target, &t.tags, 29));
  assert_false(hl_grid_counts(&t.scene.target, &t.tags, 30));
  t.tag[TAGS].id = 30;
  assert_true(hl_grid_counts(&t.scene.target, &t.tags, 29));
  assert_false(hl_grid_counts(&t.scene.target, &t.tags, 30));
  t.tag[TAGS].corner[0][0] += 500; /* wherever they are */
  const hl_grid_layout layout = hl_grid_layout_of(&t.scene.target, &t.tags);
  assert_int_equal(layout.agreeing, layout.pairs);
}

/* Two tags that changed places are left out, and nobody else. */
static void test_misplaced_tags(void **state)
{
  (void)state;
  tagged t = {0};
  see(&t, all_columns, all_rows, false, 0);
  hl_tag kept = t.tag[8];
  memcpy(t.tag[8].corner, t.tag[21].corner, sizeof kept.corner);
  memcpy(t.tag[21].corner, kept.corner, sizeof kept.corner);
  const hl_grid_layout layout = hl_grid_layout_of(&t.scene.target, &t.tags);
  assert_int_equal(layout.turned, 0);
  assert_false(layout.top_left_ids);
  hl_grid_leave_out(&t.scene.target, &layout, &t.tags);
  for (int i = 0; i < TAGS; i++)
    assert_int_equal(hl_grid_counts(&t.scene.target, &t.tags, i), i != 8 && i != 21);
}

/* Another number of columns is noticed, and told. */
static void test_columns(void **state)
{
  (void)state;
  tagged t = {0};
  see(&t, all_columns, all_rows, false, 0);
  assert_int_equal(hl_grid_columns_of(&t.scene.target, &t.tags), 6);
  hl_target other = t.scene.target;
  other.columns = 5;
  other.rows = 6;
  const hl_grid_layout layout = hl_grid_layout_of(&other, &t.tags);
  assert_true(layout.agreeing < 0.7 * layout.pairs);
  assert_int_equal(hl_grid_columns_of(&other, &t.tags), 6);
}

/* Tags that lie anyhow fit no number of columns. */
static void test_no_columns(void **state)
{
  (void)state;
  tagged t = {0};
  test_random random = {17};
  see(&t, all_columns, all_rows, false, 0);
  for (int i = 0; i < TAGS; i++) {
    const double by[2] = {random_between(&random, -300, 300), random_between(&random, -200, 200)};
    for (int k = 0; k < 4; k++)
      for (int axis = 0; axis < 2; axis++)
        t.tag[i].corner[k][axis] += by[axis];
  }
  assert_int_equal(hl_grid_columns_of(&t.scene.target, &t.tags), 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_every_numbering_and_turn),
      cmocka_unit_test(test_two_tags_are_enough),
      cmocka_unit_test(test_one_row_is_kalibrs),
      cmocka_unit_test(test_twice_and_foreign_do_not_count),
      cmocka_unit_test(test_misplaced_tags),
      cmocka_unit_test(test_columns),
      cmocka_unit_test(test_no_columns),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
