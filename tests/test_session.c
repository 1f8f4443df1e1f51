/* A session in memory: what is appended, what is refused, where its files are. */
#include <sys/stat.h>

#include "files.h"
#include "halflight/session.h"

static hl_session_frame named(char *file)
{
  return (hl_session_frame){.file = file, .label = NULL};
}

static void test_append_copies(void **state)
{
  hl_session s;
  char file[] = "frames/0001.png";
  char label[] = "L01";
  assert_int_equal(hl_session_new(NULL, *state, &s), HL_OK);
  assert_int_equal(s.n_balls, 1);
  assert_true(s.locked.focus_dioptre < 0);
  const hl_session_frame f = {.file = file, .label = label, .timestamp_ns = 5, .gain = 2};
  assert_int_equal(hl_session_append(NULL, &s, &f), HL_OK);
  file[0] = label[0] = 'x';
  assert_string_equal(s.frame[0].file, "frames/0001.png");
  assert_string_equal(s.frame[0].label, "L01");
  for (int i = 0; i < 100; i++) {
    char name[16];
    snprintf(name, sizeof name, "%d.png", i);
    const hl_session_frame more = named(name);
    assert_int_equal(hl_session_append(NULL, &s, &more), HL_OK);
  }
  assert_int_equal(s.n, 101);
  assert_string_equal(s.frame[100].file, "99.png");
  hl_session_free(&s);
  assert_int_equal(s.n, 0);
  hl_session_free(NULL);
}

static void test_append_refuses(void **state)
{
  static const char *const leave[] = {"",        "/etc/passwd", "../a.png", "a/../../b", "a//b",
                                      "./a.png", "a/",          "..",       "a/."};
  hl_session s;
  hl_ctx ctx = {0};
  char good[] = "a.png";
  assert_int_equal(hl_session_new(NULL, *state, &s), HL_OK);
  for (size_t i = 0; i < sizeof leave / sizeof *leave; i++) {
    char file[32];
    snprintf(file, sizeof file, "%s", leave[i]);
    const hl_session_frame f = named(file);
    assert_int_equal(hl_session_append(&ctx, &s, &f), HL_ERR_ARG);
    assert_says(ctx.msg, "no plain path within the session's folder");
  }
  hl_session_frame f = named(good);
  assert_int_equal(hl_session_append(&ctx, &s, &f), HL_OK);
  assert_int_equal(hl_session_append(&ctx, &s, &f), HL_ERR_ARG);
  assert_says(ctx.msg, "\"a.png\" is in the session already, as frame 0");
  char other[] = "b.png";
  char latin[] = "\xe9";
  f = named(other);
  f.label = latin;
  assert_int_equal(hl_session_append(&ctx, &s, &f), HL_ERR_ARG);
  assert_says(ctx.msg, "UTF-8");
  f = named(other);
  f.exposure_us = -1;
  assert_int_equal(hl_session_append(&ctx, &s, &f), HL_ERR_ARG);
  assert_says(ctx.msg, "exposure_us = -1");
  f = named(other);
  strcpy(f.sha256, "ABC");
  assert_int_equal(hl_session_append(&ctx, &s, &f), HL_ERR_ARG);
  assert_says(ctx.msg, "64 lower-case hex digits");
  assert_int_equal(s.n, 1);
  hl_session_free(&s);
}

static void test_paths_on_disk(void **state)
{
  char link[TEST_PATH_MAX];
  char sub[TEST_PATH_MAX];
  hl_session s;
  hl_ctx ctx = {0};
  char *path = NULL;
  assert_int_equal(hl_session_new(NULL, *state, &s), HL_OK);
  path_in(state, "out", link);
  assert_int_equal(symlink("/etc", link), 0);
  assert_int_equal(hl_session_path(&ctx, &s, "out/passwd", &path), HL_ERR_FORMAT);
  assert_says(ctx.msg, "leads out of the session's folder");
  /* what does not exist there leaves it as well */
  assert_int_equal(hl_session_path(&ctx, &s, "out/halflight-is-not-there", &path), HL_ERR_FORMAT);
  path_in(state, "nowhere", link);
  assert_int_equal(symlink("/nowhere/at/all", link), 0);
  assert_int_equal(hl_session_path(&ctx, &s, "nowhere", &path), HL_ERR_FORMAT);
  path_in(state, "loop", link);
  assert_int_equal(symlink("loop", link), 0);
  assert_int_equal(hl_session_path(&ctx, &s, "loop", &path), HL_ERR_FORMAT);
  /* a link that stays inside is welcome, and so is what does not exist yet */
  path_in(state, "sub", sub);
  assert_int_equal(mkdir(sub, 0777), 0);
  path_in(state, "in", link);
  assert_int_equal(symlink("sub", link), 0);
  assert_int_equal(hl_session_path(&ctx, &s, "in/later/a.png", &path), HL_OK);
  char expected[TEST_PATH_MAX];
  path_in(state, "in/later/a.png", expected);
  assert_string_equal(path, expected);
  free(path);
  rmdir(sub);
  hl_session_free(&s);
}

/* A folder beside it whose name begins the same is not within. */
static void test_sibling(void **state)
{
  char folder[TEST_PATH_MAX];
  char beside[TEST_PATH_MAX];
  char link[TEST_PATH_MAX];
  hl_session s;
  hl_ctx ctx = {0};
  char *path = NULL;
  path_in(state, "dome", folder);
  path_in(state, "dome-b", beside);
  path_in(state, "dome/other", link);
  assert_int_equal(mkdir(folder, 0777), 0);
  assert_int_equal(mkdir(beside, 0777), 0);
  assert_int_equal(symlink("../dome-b", link), 0);
  assert_int_equal(hl_session_new(NULL, folder, &s), HL_OK);
  assert_int_equal(hl_session_path(&ctx, &s, "other/a.png", &path), HL_ERR_FORMAT);
  unlink(link);
  rmdir(beside);
  rmdir(folder);
  assert_int_equal(hl_session_path(&ctx, &s, "a.png", &path), HL_ERR_IO);
  assert_says(ctx.msg, "cannot open");
  hl_session_free(&s);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_append_copies),
      cmocka_unit_test(test_append_refuses),
      cmocka_unit_test(test_paths_on_disk),
      cmocka_unit_test(test_sibling),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
