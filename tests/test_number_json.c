/* Numbers as YAML and Python spell them. */
#include <string.h>

#include "../src/number_json.h"
#include "near.h"

static void spells(const char *text, double want)
{
  json_t *number = hl_number_json(text, strlen(text));
  assert_non_null(number);
  assert_true(json_is_number(number));
  assert_near(json_number_value(number), want, 0);
  json_decref(number);
}

static void test_numbers(void **state)
{
  (void)state;
  spells("0", 0);
  spells("-0.", 0);
  spells("5.", 5);
  spells(".5", 0.5);
  spells("+5", 5);
  spells("-.25", -0.25);
  spells("0.1", 0.1);
  spells("-1.e-3", -1e-3);
  spells("5.3012345678899999e+02", 530.12345678899999);
  spells("1E5", 1e5);
  spells("1e+5", 1e5);
  spells("+1.e5", 1e5);
  spells("0e0", 0);
  spells("640", 640);
  spells("123456789012345678901234567890", 123456789012345678901234567890.0);
  spells("1e-400", 0);
}

static void test_whole_numbers_stay_whole(void **state)
{
  (void)state;
  json_t *number = hl_number_json("640", 3);
  assert_true(json_is_integer(number));
  json_decref(number);
  number = hl_number_json("640.", 4);
  assert_true(json_is_real(number));
  json_decref(number);
}

static void test_no_numbers(void **state)
{
  (void)state;
  static const char *const texts[] = {
      "",     "-",     "+",   ".",     "-.",    "e5",  ".e5",  "1e",   "1e+",  "1.2.3",
      "1,5",  "0x1F",  "017", "-00.5", "1_000", "nan", ".nan", ".Nan", "inf",  "-inf",
      ".inf", "1e999", "12a", " 1",    "1 ",    "--1", "+-1",  "1-",   "1e5.", "1e--5"};
  for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
    assert_null(hl_number_json(texts[i], strlen(texts[i])));
  char many[1000];
  memset(many, '1', sizeof many);
  assert_null(hl_number_json(many, sizeof many));
  spells("12", 12);
  assert_null(hl_number_json("12", 0));
  json_t *first = hl_number_json("123", 2); /* n bytes, not the text */
  assert_near(json_number_value(first), 12, 0);
  json_decref(first);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_numbers),
      cmocka_unit_test(test_whole_numbers_stay_whole),
      cmocka_unit_test(test_no_numbers),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
