/* Whole files in memory. */
#include "../src/file_read.h"
#include "files.h"

static void test_read_around_the_growing_steps(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "f", path);
  const size_t sizes[] = {1, 65535, 65536, 65537, 131072, 300001};
  for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
    char *want = malloc(sizes[i]);
    assert_non_null(want);
    for (size_t k = 0; k < sizes[i]; k++)
      want[k] = (char)(k * 7 % 127);
    put_file(path, want, sizes[i]);
    unsigned char *bytes = NULL;
    size_t n = 0;
    assert_int_equal(hl_file_read(NULL, path, 1 << 20, &bytes, &n), HL_OK);
    assert_int_equal(n, sizes[i]);
    assert_memory_equal(bytes, want, n);
    assert_int_equal(bytes[n], 0);
    free(bytes);
    free(want);
  }
}

static void test_read_up_to_the_limit(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "f", path);
  put_text(path, "12345");
  unsigned char *bytes = NULL;
  size_t n = 0;
  hl_ctx ctx = {0};
  assert_int_equal(hl_file_read(&ctx, path, 5, &bytes, &n), HL_OK);
  free(bytes);
  bytes = NULL;
  assert_int_equal(hl_file_read(&ctx, path, 4, &bytes, &n), HL_ERR_FORMAT);
  assert_says(ctx.msg, "over 4 bytes, the largest accepted");
  assert_null(bytes);
}

static void test_read_refuses(void **state)
{
  char path[TEST_PATH_MAX];
  unsigned char *bytes = NULL;
  size_t n = 77;
  hl_ctx ctx = {0};
  path_in(state, "gone", path);
  assert_int_equal(hl_file_read(&ctx, path, 4, &bytes, &n), HL_ERR_IO);
  assert_says(ctx.msg, "gone: cannot open: No such file or directory");
  assert_int_equal(hl_file_read(&ctx, *state, 4, &bytes, &n), HL_ERR_IO);
  assert_says(ctx.msg, "cannot read: Is a directory");
  path_in(state, "empty", path);
  put_text(path, "");
  assert_int_equal(hl_file_read(&ctx, path, 4, &bytes, &n), HL_ERR_FORMAT);
  assert_says(ctx.msg, "empty: the file is empty");
  assert_null(bytes);
  assert_int_equal(n, 77);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_read_around_the_growing_steps),
      cmocka_unit_test(test_read_up_to_the_limit),
      cmocka_unit_test(test_read_refuses),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
