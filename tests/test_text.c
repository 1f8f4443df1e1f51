/* Growing text, and numbers in it. */
#include <locale.h>
#include <stdlib.h>
#include <string.h>

#include "../src/number_text.h"
#include "../src/text.h"
#include "near.h"

static void test_numbers(void **state)
{
  (void)state;
  char text[HL_NUMBER_TEXT_MAX];
  assert_string_equal(hl_number_text(0.5, 6, text), "0.5");
  assert_string_equal(hl_number_text(-1.25e-20, 6, text), "-1.25e-20");
  assert_string_equal(hl_number_text(12, 6, text), "12");
  assert_string_equal(hl_number_text(0.1, 17, text), "0.10000000000000001");
  assert_string_equal(hl_number_text(-INFINITY, 6, text), "-inf");
}

static void test_exact_numbers(void **state)
{
  (void)state;
  static const struct {
    double value;
    const char *text;
  } known[] = {{640, "640.0"},
               {0.1, "0.1"},
               {-0.0, "-0.0"},
               {1e-5, "1.0e-05"},
               {0.3, "0.3"},
               {0.1 + 0.2, "0.30000000000000004"},
               {1e22, "1.0e+22"},
               {-2.5e-300, "-2.5e-300"},
               {123456789, "123456789.0"},
               {4.9406564584124654e-324, "4.94065645841247e-324"}};
  char text[HL_NUMBER_TEXT_MAX];
  for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
    assert_string_equal(hl_number_text_exact(known[i].value, text), known[i].text);
  test_random r = {3};
  for (int i = 0; i < 20000; i++) {
    const double value = random_normal(&r) * pow(10, random_between(&r, -30, 30));
    hl_number_text_exact(value, text);
    assert_true(strtod(text, NULL) == value);
    assert_non_null(strchr(text, '.'));
  }
  hl_text list = {0};
  hl_text_exact(&list, (const double[3]){1, -0.5, 1e-9}, 3);
  assert_string_equal(list.bytes, "1.0, -0.5, 1.0e-09");
  free(list.bytes);
}

/* What printf makes of numbers elsewhere: a comma, or the two bytes of an Arabic decimal mark. */
static void test_numbers_from_another_locale(void **state)
{
  (void)state;
  char comma[] = "-1,5e-09",
       two_bytes[] = "12\xd9\xab"
                     "25",
       point[] = "0.5", none[] = "-17";
  hl_number_text_point(comma);
  hl_number_text_point(two_bytes);
  hl_number_text_point(point);
  hl_number_text_point(none);
  assert_string_equal(comma, "-1.5e-09");
  assert_string_equal(two_bytes, "12.25");
  assert_string_equal(point, "0.5");
  assert_string_equal(none, "-17");
}

static void test_numbers_are_read(void **state)
{
  (void)state;
  static const struct {
    const char *text;
    double value;
  } good[] = {{"0.1", 0.1},  {"-12.5e-3", -0.0125},
              {"+7", 7},     {"1e2", 100},
              {".5", 0.5},   {"5.", 5},
              {"1e-400", 0}, {"0.10000000000000001", 0.1},
              {"-0", 0},     {"4294967295.999999", 4294967295.999999}};
  static const char *const bad[] = {
      "",      ".",   "-",   "1.2.3", "1,5",
      "0x1p3", "nan", "inf", "1e400", "1e",
      "1 2",   " 1",  "--1", "1-2",   "1234567890123456789012345678901234567890"};
  double value = 0;
  for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
    assert_true(hl_number_parse(good[i].text, strlen(good[i].text), &value));
    assert_near(value, good[i].value, 0);
  }
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
    assert_false(hl_number_parse(bad[i], strlen(bad[i]), &value));
  assert_true(hl_number_parse("123456", 3, &value));
  assert_near(value, 123, 0);
  assert_false(hl_number_parse("1\0002", 3, &value));
}

/* Where the test's machine has a locale with a comma. */
static void test_numbers_are_read_in_another_locale(void **state)
{
  (void)state;
  static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "fr_FR.utf8"};
  for (int i = 0; i < 4; i++)
    if (setlocale(LC_NUMERIC, names[i])) {
      double value = 0;
      const bool read = hl_number_parse("1.5", 3, &value);
      const bool comma = hl_number_parse("1,5", 3, &value);
      setlocale(LC_NUMERIC, "C");
      assert_true(read && !comma);
      assert_near(value, 1.5, 0);
      return;
    }
  skip();
}

static void test_text_grows(void **state)
{
  (void)state;
  hl_text text = {0};
  for (int i = 0; i < 1000; i++)
    hl_text_add(&text, "abc");
  hl_text_number(&text, 0.25, 6);
  assert_false(text.failed);
  assert_int_equal(text.n, 3004);
  assert_int_equal(strlen(text.bytes), 3004);
  assert_string_equal(text.bytes + 2997, "abc0.25");
  free(text.bytes);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_numbers),
      cmocka_unit_test(test_exact_numbers),
      cmocka_unit_test(test_numbers_from_another_locale),
      cmocka_unit_test(test_numbers_are_read),
      cmocka_unit_test(test_numbers_are_read_in_another_locale),
      cmocka_unit_test(test_text_grows),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
