/* The helper that all other tests lean on. */
#include "near.h"

static void test_near_accepts_what_is_near(void **state)
{
  (void)state;
  assert_true(is_near(1.0, 1.0, 0));
  assert_true(is_near(1.0, 1.5, 0.5));
  assert_true(is_near(-1.0, -1.5, 0.5));
}

static void test_near_refuses_what_is_far(void **state)
{
  (void)state;
  assert_false(is_near(1.0, 1.5, 0.49));
  assert_false(is_near(1.0, -1.0, 1.9));
}

static void test_near_refuses_what_is_no_number(void **state)
{
  (void)state;
  assert_false(is_near(NAN, 0, 1));
  assert_false(is_near(0, NAN, 1));
  assert_false(is_near(NAN, NAN, 1));
  assert_false(is_near(0, 0, NAN));
  assert_false(is_near(INFINITY, 0, 1e300));
  assert_false(is_near(INFINITY, INFINITY, 1));
}

/* Mean 0 and variance 1 to five standard errors; mean 1/2 for the uniform one. */
static void test_random_has_its_moments(void **state)
{
  (void)state;
  test_random r = {12345};
  double sum = 0, squares = 0, uniform = 0;
  const int n = 20000;
  for (int i = 0; i < n; i++) {
    const double x = random_normal(&r);
    sum += x;
    squares += x * x;
    uniform += random_uniform(&r);
  }
  assert_near(sum / n, 0, 5 / sqrt(n));
  assert_near(squares / n, 1, 5 * sqrt(2.0 / n));
  assert_near(uniform / n, 0.5, 5 / sqrt(12.0 * n));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_near_accepts_what_is_near),
      cmocka_unit_test(test_near_refuses_what_is_far),
      cmocka_unit_test(test_near_refuses_what_is_no_number),
      cmocka_unit_test(test_random_has_its_moments),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
