/* NAME.binary: bit for bit there and back, the published layout, and every refusal. */
#include <float.h>
#include <stdlib.h>

#include "files.h"
#include "merl_scene.h"

enum { VALUES = 3 * HL_MERL_CELLS, HEAD = 12 };
static const size_t file_bytes = HEAD + 8 * (size_t)VALUES;

static void put_int(unsigned char *at, int value)
{
  for (int i = 0; i < 4; i++)
    at[i] = (unsigned char)((unsigned)value >> (8 * i));
}

/* A little-endian machine is taken for granted here, not in the library. */
static unsigned char *table_bytes(double value)
{
  unsigned char *bytes = malloc(file_bytes + 8);
  assert_non_null(bytes);
  put_int(bytes, 90);
  put_int(bytes + 4, 90);
  put_int(bytes + 8, 180);
  for (size_t i = 0; i < VALUES + 1; i++)
    memcpy(bytes + HEAD + 8 * i, &value, sizeof value);
  return bytes;
}

static hl_status read_bytes(void **state, hl_ctx *ctx, const unsigned char *bytes, size_t n,
                            hl_merl *out)
{
  char path[TEST_PATH_MAX];
  path_in(state, "t.binary", path);
  put_file(path, bytes, n);
  const hl_status st = hl_merl_read(ctx, path, out);
  unlink(path);
  return st;
}

static void refused(void **state, const unsigned char *bytes, size_t n, const char *part)
{
  hl_ctx ctx = {0};
  hl_merl merl = {0};
  assert_int_equal(read_bytes(state, &ctx, bytes, n, &merl), HL_ERR_FORMAT);
  assert_null(merl.value);
  assert_says(ctx.msg, "t.binary: ");
  assert_says(ctx.msg, part);
}

static void test_there_and_back(void **state)
{
  char path[TEST_PATH_MAX];
  hl_merl merl = {0}, back = {0};
  test_random r = {9};
  path_in(state, "t.binary", path);
  assert_int_equal(hl_merl_new(NULL, &merl), HL_OK);
  for (size_t i = 0; i < VALUES; i++)
    merl.value[i] = random_normal(&r) * (i % 1000 == 0 ? 1e300 : 1);
  merl.value[17] = DBL_MIN / 8; /* not normal */
  merl.value[18] = -0.0;
  assert_int_equal(hl_merl_write(NULL, path, &merl), HL_OK);
  assert_int_equal(hl_merl_read(NULL, path, &back), HL_OK);
  assert_memory_equal(back.value, merl.value, VALUES * sizeof *merl.value);
  hl_merl_free(&merl);
  hl_merl_free(&back);
  unlink(path);
}

/* Three integers, then red, green and blue, each theta_half by theta_diff by phi_diff. */
static void test_layout(void **state)
{
  char path[TEST_PATH_MAX];
  hl_merl merl = {0};
  unsigned char head[HEAD], want[HEAD];
  double value = 0;
  path_in(state, "t.binary", path);
  assert_int_equal(hl_merl_new(NULL, &merl), HL_OK);
  merl.value[2 * (size_t)HL_MERL_CELLS + hl_merl_cell(5, 6, 7)] = 0.75;
  assert_int_equal(hl_merl_write(NULL, path, &merl), HL_OK);
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  assert_int_equal(fread(head, 1, HEAD, file), HEAD);
  put_int(want, 90);
  put_int(want + 4, 90);
  put_int(want + 8, 180);
  assert_memory_equal(head, want, HEAD);
  assert_int_equal(
      fseek(file, HEAD + 8L * (7 + 180L * 6 + 180L * 90 * 5 + 2L * 180 * 90 * 90), SEEK_SET), 0);
  assert_int_equal(fread(&value, sizeof value, 1, file), 1);
  assert_near(value, 0.75, 0);
  assert_int_equal(fseek(file, 0, SEEK_END), 0);
  assert_int_equal(ftell(file), (long)file_bytes);
  fclose(file);
  hl_merl_free(&merl);
  unlink(path);
}

static void test_refuses_other_shapes(void **state)
{
  unsigned char *bytes = table_bytes(1);
  refused(state, bytes, 5, "5 bytes are no MERL table");
  put_int(bytes + 8, 360);
  refused(state, bytes, file_bytes, "a table of 90 x 90 x 360 cells; one of MERL's, 90 x 90 x 180");
  /* the same number of cells in another order, which the database's own reader would take */
  put_int(bytes, 180);
  put_int(bytes + 8, 90);
  refused(state, bytes, file_bytes, "a table of 180 x 90 x 90 cells");
  put_int(bytes, -90);
  refused(state, bytes, file_bytes, "a table of -90 x 90 x 90 cells");
  free(bytes);
}

static void test_refuses_other_lengths(void **state)
{
  unsigned char *bytes = table_bytes(1);
  refused(state, bytes, 0, "the file is empty");
  refused(state, bytes, HEAD, "truncated: 12 bytes; a table of 90 x 90 x 180 cells has 34992012");
  refused(state, bytes, file_bytes - 1, "truncated: 34992011 bytes");
  refused(state, bytes, file_bytes + 1, "bytes left over after the table: 34992013 bytes");
  free(bytes);
}

static void test_refuses_values(void **state)
{
  unsigned char *bytes = table_bytes(1);
  const double nan = NAN, infinite = -INFINITY, one = 1;
  unsigned char *at = bytes + HEAD + 8 * (HL_MERL_CELLS + hl_merl_cell(12, 0, 179));
  memcpy(at, &nan, sizeof nan);
  refused(state, bytes, file_bytes, "green[12,0,179] = nan; a finite number is needed");
  memcpy(at, &one, sizeof one);
  memcpy(bytes + HEAD, &infinite, sizeof infinite);
  refused(state, bytes, file_bytes, "red[0,0,0] = -inf");
  free(bytes);
  bytes = table_bytes(-1);
  refused(state, bytes, file_bytes, "no cell above the horizon is measured");
  free(bytes);
}

static void test_files(void **state)
{
  char path[TEST_PATH_MAX];
  hl_ctx ctx = {0};
  hl_merl merl = {0};
  path_in(state, "missing.binary", path);
  assert_int_equal(hl_merl_read(&ctx, path, &merl), HL_ERR_IO);
  assert_says(ctx.msg, "missing.binary: cannot open");
  assert_null(merl.value);
  assert_int_equal(hl_merl_new(NULL, &merl), HL_OK);
  merl.value[3] = NAN;
  assert_int_equal(hl_merl_write(&ctx, path, &merl), HL_ERR_ARG);
  assert_says(ctx.msg, "red[0,0,3] = nan");
  merl.value[3] = 1;
  assert_int_equal(hl_merl_write(&ctx, "/nowhere/t.binary", &merl), HL_ERR_IO);
  assert_int_equal(folder_count(*state), 0);
  hl_merl_free(&merl);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_there_and_back),        cmocka_unit_test(test_layout),
      cmocka_unit_test(test_refuses_other_shapes),  cmocka_unit_test(test_files),
      cmocka_unit_test(test_refuses_other_lengths), cmocka_unit_test(test_refuses_values),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
