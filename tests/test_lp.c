/* `.lp` files: frame and format. */
#include "files.h"
#include "halflight/export.h"

static void test_write_turns_into_the_frame_of_lp(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "lights.lp", path);
  const char *const names[] = {"a.png", "b 2.png"};
  const double directions[] = {0.6, 0, -0.8, 0, -0.28, -0.96};
  assert_int_equal(hl_lp_write(NULL, path, names, directions, 2), HL_OK);
  size_t n = 0;
  char *text = get_file(path, &n);
  assert_string_equal(text, "2\na.png 0.6 0 0.8\nb 2.png 0 0.28 0.96\n");
  free(text);
}

/* Twelve digits: read back to 1e-12. */
static void test_write_loses_nothing_that_matters(void **state)
{
  char path[TEST_PATH_MAX], name[40];
  path_in(state, "lights.lp", path);
  test_random r = {5};
  for (int i = 0; i < 50; i++) {
    double d[3] = {random_normal(&r), random_normal(&r), random_normal(&r)};
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int k = 0; k < 3; k++)
      d[k] /= length;
    const char *const names[] = {"f"};
    assert_int_equal(hl_lp_write(NULL, path, names, d, 1), HL_OK);
    size_t n = 0;
    char *text = get_file(path, &n);
    double x, y, z;
    int count;
    assert_int_equal(sscanf(text, "%d %39s %lf %lf %lf", &count, name, &x, &y, &z), 5);
    assert_int_equal(count, 1);
    assert_near(x, d[0], 1e-12);
    assert_near(y, -d[1], 1e-12);
    assert_near(z, -d[2], 1e-12);
    free(text);
  }
}

static void refused(void **state, const char *name, const double d[3], int n, const char *part)
{
  char path[TEST_PATH_MAX];
  path_in(state, "none.lp", path);
  const char *const names[] = {name};
  hl_ctx ctx = {0};
  assert_int_equal(hl_lp_write(&ctx, path, names, d, n), HL_ERR_ARG);
  assert_says(ctx.msg, part);
  assert_int_not_equal(access(path, F_OK), 0);
}

static void test_write_refuses(void **state)
{
  const double good[3] = {0, 0, -1}, twice[3] = {0, 0, -2}, none[3] = {0, NAN, -1};
  refused(state, "f", good, 0, "lights = 0; at least 1 is needed");
  refused(state, "f", twice, 1, "direction of light 0 has length 2; 1 is needed");
  refused(state, "f", none, 1, "direction of light 0 has length nan");
  refused(state, "", good, 1, "name of light 0 is empty");
  refused(state, "a\nb", good, 1, "holds a line break");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_write_turns_into_the_frame_of_lp),
      cmocka_unit_test(test_write_loses_nothing_that_matters),
      cmocka_unit_test(test_write_refuses),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
