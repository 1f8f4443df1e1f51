/* SAMPLES.csv: what is read, and what is refused with line and column. */
#include <locale.h>

#include "files.h"
#include "halflight/samples.h"

static hl_status read_text(void **state, const char *text, hl_ctx *ctx, hl_samples *out)
{
  char path[TEST_PATH_MAX];
  path_in(state, "samples.csv", path);
  put_text(path, text);
  return hl_samples_read(ctx, path, out);
}

static void test_grey(void **state)
{
  hl_samples s;
  assert_int_equal(read_text(state, "nx,ny,nz,value\n0,0,1,2.5\n0.6,0,0.8,1e-3\n", NULL, &s),
                   HL_OK);
  assert_int_equal(s.n, 2);
  assert_int_equal(s.channels, 1);
  assert_null(s.view);
  assert_null(s.value[1]);
  assert_near(s.value[0][0], 2.5, 0);
  assert_near(s.value[0][1], 1e-3, 0);
  assert_near(s.normal[3], 0.6, 1e-16);
  assert_near(s.normal[5], 0.8, 1e-16);
  hl_samples_free(&s);
  assert_int_equal(s.n, 0);
}

/* Any order, other columns among them, spaces, a byte order mark, Windows line ends, remarks. */
static void test_colour_in_any_order(void **state)
{
  hl_samples s;
  const char *text = "\xef\xbb\xbf# a table\r\n b , g,R, id, vx,vy,vz,nz,ny,nx\r\n\r\n"
                     "3,2,1, 7 ,0,0.6,0.8,1,0,-0\r\n#5\r\n6, 5 ,4,8,0,0,1,0.8,-6e-1,0\r\n";
  assert_int_equal(read_text(state, text, NULL, &s), HL_OK);
  assert_int_equal(s.n, 2);
  assert_int_equal(s.channels, 3);
  for (int c = 0; c < 3; c++) {
    assert_near(s.value[c][0], 1 + c, 0);
    assert_near(s.value[c][1], 4 + c, 0);
  }
  assert_near(s.view[1], 0.6, 1e-16);
  assert_near(s.normal[4], -0.6, 1e-16);
  hl_samples_free(&s);
}

/* Seventeen digits and the fast path say the same as strtod. */
static void test_numbers_are_exact(void **state)
{
  static const double values[] = {0.1,    123456.789, 1.0 / 3,          2.2250738585072014e-308,
                                  5e-324, 1e22,       9007199254740992, 0.000123456789012345};
  for (size_t i = 0; i < sizeof values / sizeof *values; i++)
    for (int digits = 15; digits <= 17; digits += 2) {
      char text[128], number[40];
      hl_samples s;
      snprintf(number, sizeof number, "%.*g", digits, values[i]);
      snprintf(text, sizeof text, "nx,ny,nz,value\n0,0,1,%s\n", number);
      assert_int_equal(read_text(state, text, NULL, &s), HL_OK);
      assert_near(s.value[0][0], strtod(number, NULL), 0);
      hl_samples_free(&s);
    }
}

static void test_the_locale_does_not_matter(void **state)
{
  hl_samples s;
  if (!setlocale(LC_NUMERIC, "de_DE.UTF-8") && !setlocale(LC_NUMERIC, "de_DE.utf8"))
    skip();
  const hl_status st = read_text(state, "nx,ny,nz,value\n0,0,1,1.25e1\n", NULL, &s);
  setlocale(LC_NUMERIC, "C");
  assert_int_equal(st, HL_OK);
  assert_near(s.value[0][0], 12.5, 0);
  hl_samples_free(&s);
}

static void test_nearly_unit_vectors_are_made_unit(void **state)
{
  hl_samples s;
  assert_int_equal(
      read_text(state, "nx,ny,nz,value,vx,vy,vz\n0,0.6045,0.806,1,0,0,0.995\n", NULL, &s), HL_OK);
  assert_near(s.normal[1], 0.6, 1e-12);
  assert_near(s.view[2], 1, 1e-15);
  hl_samples_free(&s);
}

static void test_refusals(void **state)
{
  static const struct {
    const char *text, *words;
  } cases[] = {
      {"nx,ny,value\n0,0,1\n", "line 1: no column nz"},
      {"nx,ny,nz\n0,0,1\n", "line 1: no column value"},
      {"nx,ny,nz,r,g\n0,0,1,1,1\n", "line 1: no column b"},
      {"nx,ny,nz,value,vx\n0,0,1,1,0\n", "line 1: no column vy"},
      {"nx,ny,nz,value,r,g,b\n0,0,1,1,1,1,1\n", "value and r, g, b"},
      {"nx,ny,nz,value,nx\n0,0,1,1,0\n", "column nx comes twice"},
      {"nx,ny,nz,value\n0,0,1\n", "line 2: 3 values"},
      {"nx,ny,nz,value\n0,0,1,1,5\n", "line 2: 5 values"},
      {"nx,ny,nz,value\n0,0,1,1\n0,0,1,x\n", "line 3: value = 'x'"},
      {"nx,ny,nz,value\n0,0,1,\n", "line 2: value = ''"},
      {"nx,ny,nz,value\n0,0,1,nan\n", "line 2: value = 'nan'"},
      {"nx,ny,nz,value\n0,inf,1,1\n", "line 2: ny = 'inf'"},
      {"nx,ny,nz,value\n0,0,1,1.5.2\n", "line 2: value = '1.5.2'"},
      {"nx,ny,nz,value\n0,0,1,0x10\n", "line 2: value = '0x10'"},
      {"nx,ny,nz,value\n0,0,1,-0.5\n", "line 2: value = -0.5"},
      {"nx,ny,nz,value\n0,0,0,1\n", "line 2: length of (nx,ny,nz) = 0"},
      {"nx,ny,nz,value\n0,0,1.02,1\n", "line 2: length of (nx,ny,nz) = 1.02"},
      {"nx,ny,nz,value,vx,vy,vz\n0,0,1,1,0,0,2\n", "line 2: length of (vx,vy,vz) = 2"},
      {"nx;ny;nz;value\n0;0;1;1\n", "line 1: no column nx"},
      {"nx,ny,nz,value\n", "no samples"},
      {"", "no samples"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    hl_ctx ctx = {0};
    hl_samples s = {.n = -7};
    assert_int_equal(read_text(state, cases[i].text, &ctx, &s), HL_ERR_FORMAT);
    assert_says(ctx.msg, cases[i].words);
    assert_int_equal(s.n, -7);
  }
  hl_ctx ctx = {0};
  hl_samples s;
  assert_int_equal(hl_samples_read(&ctx, "/nowhere/samples.csv", &s), HL_ERR_IO);
  assert_says(ctx.msg, "/nowhere/samples.csv");
}

/* Growing past the first room, and a last line without its end. */
static void test_many_rows(void **state)
{
  enum { ROWS = 5000 };
  char *text = malloc(ROWS * 20 + 40), *at = text;
  hl_samples s;
  assert_non_null(text);
  at += sprintf(at, "nx,ny,nz,value\n");
  for (int i = 0; i < ROWS; i++)
    at += sprintf(at, "0,0,1,%d%s", i, i + 1 < ROWS ? "\n" : "");
  assert_int_equal(read_text(state, text, NULL, &s), HL_OK);
  assert_int_equal(s.n, ROWS);
  for (int i = 0; i < ROWS; i++)
    assert_near(s.value[0][i], i, 0);
  hl_samples_free(&s);
  free(text);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_grey),
      cmocka_unit_test(test_colour_in_any_order),
      cmocka_unit_test(test_numbers_are_exact),
      cmocka_unit_test(test_the_locale_does_not_matter),
      cmocka_unit_test(test_nearly_unit_vectors_are_made_unit),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_many_rows),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
