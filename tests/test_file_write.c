/* Files appear whole or not at all. */
#include <sys/stat.h>

#include "files.h"
#include "halflight/export.h"

static void test_write_new_and_again(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "new.txt", path);
  assert_int_equal(hl_file_write(NULL, path, "first", 5), HL_OK);
  assert_int_equal(hl_file_write(NULL, path, "2nd\0x", 5), HL_OK);
  size_t n = 0;
  char *bytes = get_file(path, &n);
  assert_int_equal(n, 5);
  assert_memory_equal(bytes, "2nd\0x", 5);
  free(bytes);
  assert_int_equal(hl_file_write(NULL, path, "", 0), HL_OK);
  free(get_file(path, &n));
  assert_int_equal(n, 0);
  unlink(path);
  assert_int_equal(folder_count(*state), 0);
}

static void test_write_keeps_the_mode(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "mode.txt", path);
  put_text(path, "old");
  assert_int_equal(chmod(path, 0640), 0);
  assert_int_equal(hl_file_write(NULL, path, "new", 3), HL_OK);
  struct stat s;
  assert_int_equal(stat(path, &s), 0);
  assert_int_equal(s.st_mode & 07777, 0640);
  unlink(path);
}

static void test_write_follows_a_link(void **state)
{
  char path[TEST_PATH_MAX], link[TEST_PATH_MAX];
  path_in(state, "real.txt", path);
  path_in(state, "link.txt", link);
  put_text(path, "old");
  assert_int_equal(symlink("real.txt", link), 0);
  assert_int_equal(hl_file_write(NULL, link, "new", 3), HL_OK);
  size_t n = 0;
  char *bytes = get_file(path, &n);
  assert_string_equal(bytes, "new");
  free(bytes);
  struct stat s;
  assert_int_equal(lstat(link, &s), 0);
  assert_true(S_ISLNK(s.st_mode));
  unlink(link);
  unlink(path);
}

static void test_write_pours_into_what_is_no_file(void **state)
{
  (void)state;
  assert_int_equal(hl_file_write(NULL, "/dev/null", "x", 1), HL_OK);
  struct stat s;
  assert_int_equal(stat("/dev/null", &s), 0);
  assert_true(S_ISCHR(s.st_mode));
}

static void test_write_refuses_and_leaves_nothing(void **state)
{
  char path[TEST_PATH_MAX];
  hl_ctx ctx = {0};
  path_in(state, "no-such-folder/out.txt", path);
  assert_int_equal(hl_file_write(&ctx, path, "x", 1), HL_ERR_IO);
  assert_says(ctx.msg, "out.txt: cannot create: No such file or directory");
  assert_int_equal(hl_file_write(&ctx, *state, "x", 1), HL_ERR_IO);
  assert_says(ctx.msg, "cannot write: Is a directory");
  assert_int_equal(folder_count(*state), 0);
}

/* A full disk, as Linux plays one. */
static void test_write_reports_a_full_device(void **state)
{
  (void)state;
  if (access("/dev/full", W_OK) != 0)
    skip();
  hl_ctx ctx = {0};
  assert_int_equal(hl_file_write(&ctx, "/dev/full", "x", 1), HL_ERR_IO);
  assert_says(ctx.msg, "/dev/full: cannot write: No space left on device");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_write_new_and_again),
      cmocka_unit_test(test_write_keeps_the_mode),
      cmocka_unit_test(test_write_follows_a_link),
      cmocka_unit_test(test_write_pours_into_what_is_no_file),
      cmocka_unit_test(test_write_refuses_and_leaves_nothing),
      cmocka_unit_test(test_write_reports_a_full_device),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
