/* Standard error is held back, comes back, and what was said is known. */
#include "../calib/hush.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "files.h"

/* Standard error into a file of ours, so that we see what gets through. */
static int redirect(const char *path)
{
  const int kept = dup(STDERR_FILENO);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  assert_true(kept >= 0 && dup2(fileno(file), STDERR_FILENO) >= 0);
  fclose(file);
  return kept;
}

static void test_held_back(void **state)
{
  char path[TEST_PATH_MAX];
  char line[64] = "?";
  char other[64] = "?";
  size_t n;
  path_in(state, "stderr.txt", path);
  const int kept = redirect(path);
  hl_hush hush;
  fputs("before\n", stderr);
  hl_hush_begin(&hush);
  fputs("first\nsecond\n", stderr);
  hl_hush_end(&hush, line, sizeof line);
  fputs("between\n", stderr);
  hl_hush_begin(&hush);
  hl_hush_end(&hush, other, sizeof other);
  hl_hush_begin(&hush);
  fputs("third\n", stderr);
  hl_hush_end(&hush, NULL, 0);
  fputs("after\n", stderr);
  fflush(stderr);
  dup2(kept, STDERR_FILENO);
  close(kept);
  char *text = get_file(path, &n);
  assert_string_equal(text, "before\nbetween\nafter\n");
  assert_string_equal(line, "first");
  assert_string_equal(other, "");
  free(text);
}

static void test_shared(void **state)
{
  char path[TEST_PATH_MAX];
  char line[64] = "?";
  size_t n;
  path_in(state, "shared.txt", path);
  const int kept = redirect(path);
  hl_hush hush;
  fputs("before\n", stderr);
  hl_hush_share();
  fputs("one\n", stderr);
  hl_hush_share();
  hl_hush_leave();
  fputs("still one\n", stderr);
  hl_hush_leave();
  fputs("between\n", stderr);
  hl_hush_begin(&hush);
  fputs("heard\n", stderr);
  hl_hush_end(&hush, line, sizeof line);
  fflush(stderr);
  dup2(kept, STDERR_FILENO);
  close(kept);
  char *text = get_file(path, &n);
  assert_string_equal(text, "before\nbetween\n");
  assert_string_equal(line, "heard");
  free(text);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_held_back),
      cmocka_unit_test(test_shared),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
