/* Which matrices can be covariances. */
#include "../src/psd.h"
#include "near.h"

/* Analytic: [[1, r], [r, 1]] has eigenvalues 1 + r and 1 - r; scale does not matter. */
static void test_pair(void **state)
{
  (void)state;
  const double scales[] = {1e-30, 1e-6, 1, 1e12};
  for (int i = 0; i < 4; i++) {
    const double s = scales[i];
    const double good[] = {s, 0.99 * s, 0.99 * s, s};
    const double edge[] = {s, -s, -s, s};
    const double bad[] = {s, 1.01 * s, 1.01 * s, s};
    assert_true(hl_psd_check(good, 2));
    assert_true(hl_psd_check(edge, 2));
    assert_false(hl_psd_check(bad, 2));
  }
}

/* Each pair is allowed, all three together are not: eigenvalue 1 - 2 * 0.6. */
static void test_triple(void **state)
{
  (void)state;
  const double bad[] = {1, -0.6, -0.6, -0.6, 1, -0.6, -0.6, -0.6, 1};
  const double good[] = {1, -0.4, -0.4, -0.4, 1, -0.4, -0.4, -0.4, 1};
  assert_false(hl_psd_check(bad, 3));
  assert_true(hl_psd_check(good, 3));
}

static void test_refusals(void **state)
{
  (void)state;
  const double lopsided[] = {1, 0.5, 0.4, 1};
  const double negative[] = {-1, 0, 0, 1};
  const double not_a_number[] = {1, NAN, NAN, 1};
  const double infinite[] = {INFINITY, 0, 0, 1};
  const double from_nothing[] = {0, 0.1, 0.1, 1};
  assert_false(hl_psd_check(lopsided, 2));
  assert_false(hl_psd_check(negative, 2));
  assert_false(hl_psd_check(not_a_number, 2));
  assert_false(hl_psd_check(infinite, 2));
  assert_false(hl_psd_check(from_nothing, 2));
  assert_false(hl_psd_check(lopsided, 0));
  assert_false(hl_psd_check(lopsided, 13));
}

static void test_a_fixed_unknown_is_allowed(void **state)
{
  (void)state;
  const double fixed[] = {0, 0, 0, 1};
  assert_true(hl_psd_check(fixed, 2));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_pair),
      cmocka_unit_test(test_triple),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_a_fixed_unknown_is_allowed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
