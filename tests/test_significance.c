/* Tails of the chi-squared and the F distribution. */
#include "../calib/significance.h"

#include "near.h"

typedef struct tail {
  double t, dof, noise_dof, probability;
} tail;

static void assert_relative(double got, double want, double tolerance)
{
  assert_near(got / want, 1, tolerance);
}

static void test_chi_squared(void **state)
{
  (void)state;
  /* mpmath 1.2.1 with 40 digits: gammainc(dof/2, t/2, inf, regularized=True); scipy 1.10.1's
   * stats.chi2.sf agrees to 1e-11 */
  static const tail tails[] = {
      {0.01, 1, HUGE_VAL, 0.92034432544594203624},
      {3.841458820694124, 1, HUGE_VAL, 0.050000000000000057435},
      {5.991464547107979, 2, HUGE_VAL, 0.050000000000000073572},
      {1.5, 9, HUGE_VAL, 0.99714676950594779894},
      {9, 9, HUGE_VAL, 0.4372741889138670641},
      {21.665994333461924, 9, HUGE_VAL, 0.010000000000000005491},
      {60, 9, HUGE_VAL, 1.3406780483959612621e-9},
      {400, 15, HUGE_VAL, 6.9173573191123469685e-76},
      {1300, 2, HUGE_VAL, 5.1119519486511562468e-283},
      {84, 84, HUGE_VAL, 0.47947805379971792696},
      {150, 84, HUGE_VAL, 0.000012912172565563275608},
      {600, 594, HUGE_VAL, 0.42354908158047140555},
      {760, 594, HUGE_VAL, 4.3371204299228295951e-6},
      {20, 0.5, HUGE_VAL, 2.0830304086494313095e-6},
  };
  (void)state;
  for (size_t i = 0; i < sizeof tails / sizeof *tails; i++)
    assert_relative(hl_significance(tails[i].t, tails[i].dof, tails[i].noise_dof),
                    tails[i].probability, 1e-12);
}

static void test_f(void **state)
{
  (void)state;
  /* mpmath 1.2.1 with 40 digits: betainc(n/2, k/2, 0, n/(n + t), regularized=True) */
  static const tail tails[] = {
      {0.5, 1, 3, 0.53047777093295696535},       {10, 2, 5, 0.064150029909958418279},
      {9, 9, 40, 0.45585004802858656934},        {30, 9, 40, 0.0039799782154071749744},
      {21.67, 9, 5541, 0.010087708866451714982}, {60, 15, 5541, 2.7871641617294777833e-7},
      {300, 15, 200, 4.1136430502724209218e-32}, {84, 84, 5541, 0.47993968865301892187},
      {150, 84, 300, 0.00021576553459038870439}, {1, 9, 1e6, 0.99943749578436344634},
      {40, 9, 1e6, 7.6006175699005971631e-6},
  };
  for (size_t i = 0; i < sizeof tails / sizeof *tails; i++)
    assert_relative(hl_significance(tails[i].t, tails[i].dof, tails[i].noise_dof),
                    tails[i].probability, 1e-12);
}

/* Analytic: two degrees of freedom have closed forms. */
static void test_closed_forms(void **state)
{
  (void)state;
  for (int i = 0; i < 18; i++) {
    const double t = 1e-6 * pow(3, i);
    assert_relative(hl_significance(t, 2, HUGE_VAL), exp(-t / 2), 1e-13);
    for (int k = 0; k < 6; k++) {
      const double n = pow(7, k);
      assert_relative(hl_significance(t, 2, n), pow(1 + t / n, -n / 2), 1e-12);
    }
  }
}

static void test_f_tends_to_chi_squared(void **state)
{
  (void)state;
  for (int i = 0; i < 7; i++) {
    const double t = 0.5 * pow(2, i);
    assert_relative(hl_significance(t, 9, 1e12), hl_significance(t, 9, HUGE_VAL), 1e-6);
  }
}

static void test_ends(void **state)
{
  (void)state;
  assert_near(hl_significance(0, 9, HUGE_VAL), 1, 0);
  assert_near(hl_significance(-1, 9, 10), 1, 0);
  assert_near(hl_significance(5, 0, 10), 1, 0);
  assert_near(hl_significance(HUGE_VAL, 9, 10), 0, 0);
  assert_near(hl_significance(1e7, 9, HUGE_VAL), 0, 0);
  assert_true(isnan(hl_significance(NAN, 9, 10)));
  assert_true(isnan(hl_significance(1, NAN, 10)));
  assert_true(isnan(hl_significance(1, 9, NAN)));
}

static void test_limit_is_reached_at_its_rate(void **state)
{
  (void)state;
  static const double dofs[] = {1, 2, 9, 15, 594}, noise[] = {5, 40, 5541, HUGE_VAL};
  for (int i = 0; i < 5; i++)
    for (int k = 0; k < 4; k++)
      for (int n = 0; n < 7; n++) {
        const double rate = 0.5 * pow(20, -n);
        const double limit = hl_significance_limit(rate, dofs[i], noise[k]);
        assert_relative(hl_significance(limit, dofs[i], noise[k]), rate, 1e-10);
      }
  /* scipy 1.10.1: stats.chi2.isf(0.01, 9) */
  assert_near(hl_significance_limit(0.01, 9, HUGE_VAL), 21.665994333461924, 1e-12);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_chi_squared),  cmocka_unit_test(test_f),
      cmocka_unit_test(test_closed_forms), cmocka_unit_test(test_f_tends_to_chi_squared),
      cmocka_unit_test(test_ends),         cmocka_unit_test(test_limit_is_reached_at_its_rate),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
