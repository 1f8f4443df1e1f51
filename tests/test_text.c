/* Growing text, and numbers in it. */
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
      cmocka_unit_test(test_numbers_from_another_locale),
      cmocka_unit_test(test_text_grows),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
