/* SHA-256 of files: the examples of FIPS 180-4, and a file longer than one read. */
#include "files.h"
#include "halflight/session.h"

static void check(void **state, const void *bytes, size_t n, const char *expected)
{
  char path[TEST_PATH_MAX];
  char sum[65];
  path_in(state, "bytes", path);
  put_file(path, bytes, n);
  assert_int_equal(hl_file_sha256(NULL, path, sum), HL_OK);
  assert_string_equal(sum, expected);
}

static void test_standard(void **state)
{
  check(state, "", 0, "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  check(state, "abc", 3, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

static void test_long(void **state)
{
  char *million = malloc(1000000);
  assert_non_null(million);
  memset(million, 'a', 1000000);
  check(state, million, 1000000,
        "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  free(million);
}

static void test_missing(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  char sum[65];
  assert_int_equal(hl_file_sha256(&ctx, "/nowhere/at/all", sum), HL_ERR_IO);
  assert_says(ctx.msg, "/nowhere/at/all: cannot open");
  assert_int_equal(hl_file_sha256(&ctx, "/", sum), HL_ERR_IO);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_standard),
      cmocka_unit_test(test_long),
      cmocka_unit_test(test_missing),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
