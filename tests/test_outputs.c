/* The files of one run: all or none, and what was there before comes back. */
#include "../src/cli/outputs.h"

#include <sys/stat.h>

#include "files.h"

static void assert_holds(const char *path, const char *want)
{
  size_t n = 0;
  char *text = get_file(path, &n);
  assert_string_equal(text, want);
  free(text);
}

/* Three outputs in the test's folder; the first two are there already. */
static hl_outputs *planned(void **state)
{
  static const char *const names[] = {"a", "b", "c"};
  hl_outputs *o = calloc(1, sizeof *o);
  assert_non_null(o);
  for (int i = 0; i < 3; i++) {
    int at = -1;
    assert_int_equal(hl_outputs_add(NULL, o, *state, names[i], &at), HL_OK);
    assert_int_equal(at, i);
  }
  put_text(o->path[0], "old a");
  put_text(o->path[1], "old b");
  assert_int_equal(chmod(o->path[0], 0640), 0);
  assert_int_equal(hl_outputs_begin(NULL, o), HL_OK);
  return o;
}

static unsigned mode_of(const char *path)
{
  struct stat at;
  assert_int_equal(stat(path, &at), 0);
  return (unsigned)at.st_mode & 0777;
}

static void remove_all(hl_outputs *o)
{
  for (int i = 0; i < 3; i++)
    unlink(o->path[i]);
  free(o);
}

static void test_commit_replaces_and_keeps_the_mode(void **state)
{
  hl_outputs *o = planned(state);
  for (int i = 0; i < 3; i++)
    put_text(o->stage[i], "new");
  assert_int_equal(hl_outputs_commit(NULL, o), HL_OK);
  hl_outputs_end(NULL, o);
  for (int i = 0; i < 3; i++)
    assert_holds(o->path[i], "new");
  assert_int_equal(mode_of(o->path[0]), 0640);
  assert_int_equal(folder_count(*state), 3);
  remove_all(o);
}

/* One stage, `missing`, was never written: its rename fails, and the others are undone. */
static void test_failed_commit_puts_back(void **state)
{
  for (int missing = 0; missing < 3; missing++) {
    hl_outputs *o = planned(state);
    for (int i = 0; i < 3; i++)
      if (i != missing)
        put_text(o->stage[i], "new");
    hl_ctx ctx = {0};
    assert_int_equal(hl_outputs_commit(&ctx, o), HL_ERR_IO);
    assert_says(ctx.msg, o->path[missing]);
    assert_says(ctx.msg, "cannot be written: ");
    hl_outputs_end(&ctx, o);
    assert_holds(o->path[0], "old a");
    assert_holds(o->path[1], "old b");
    assert_int_equal(mode_of(o->path[0]), 0640);
    assert_int_equal(folder_count(*state), 2);
    remove_all(o);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_commit_replaces_and_keeps_the_mode),
      cmocka_unit_test(test_failed_commit_puts_back),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
