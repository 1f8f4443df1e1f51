/* Which parts moved, from evidence whose answer is known. */
#include "../calib/drift_parts.h"

#include <string.h>

#include "../calib/significance.h"
#include "near.h"

/* Five parts over 12 changes, each of deviation 1 and independent unless a test says otherwise. */
enum { N = 12, PARTS = 5 };

static void some_parts(hl_part part[PARTS])
{
  static const hl_part parts[PARTS] = {
      {"intrinsics", "focal length", "px", 0, 2, {{1, 0}, {0, 1}}},
      {"intrinsics", "centre", "px", 2, 2, {{1, 0}, {0, 1}}},
      {"intrinsics", "distortion", "px", 4, 2, {{1, 0}, {0, 1}}},
      {"mount", "rotation", "deg", 6, 3, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
      {"mount", "translation", "m", 9, 3, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
  };
  memcpy(part, parts, sizeof parts);
}

static hl_evidence unit_evidence(void)
{
  hl_evidence e = {.n = N, .noise_dof = HUGE_VAL};
  for (int i = 0; i < N; i++)
    e.x[i][i] = 1;
  return e;
}

static hl_drift judged(const hl_evidence *e)
{
  hl_part part[PARTS];
  hl_drift d = {.false_alarm = 0.01};
  some_parts(part);
  hl_parts_judge(e, part, PARTS, &d);
  assert_int_equal(d.n_causes, PARTS);
  return d;
}

static unsigned moved(const hl_drift *d)
{
  unsigned set = 0;
  for (int i = 0; i < d->n_causes; i++)
    set |= (unsigned)d->cause[i].moved << i;
  return set;
}

static void test_verdict_is_the_chi_squared_of_all(void **state)
{
  (void)state;
  hl_evidence e = unit_evidence();
  /* scipy 1.10.1: stats.chi2.isf(0.01, 12) */
  const double limit = 26.216967305535853;
  for (int i = 0; i < N; i++)
    e.z[i] = sqrt(limit / N) * 0.999;
  hl_drift d = judged(&e);
  assert_false(d.drifted);
  assert_int_equal(moved(&d), 0);
  assert_near(d.significance, 0.01, 3e-4);
  for (int i = 0; i < N; i++)
    e.z[i] = sqrt(limit / N) * 1.001;
  d = judged(&e);
  assert_true(d.drifted);
  assert_near(d.significance, 0.01, 3e-4);
}

static void test_few_residuals_widen_the_verdict(void **state)
{
  (void)state;
  hl_evidence e = unit_evidence();
  e.z[0] = 6;
  assert_true(judged(&e).drifted);
  e.noise_dof = 8;
  const hl_drift d = judged(&e);
  assert_false(d.drifted);
  assert_near(d.significance, hl_significance(36, 12, 8), 1e-12);
}

static void test_each_part_alone_is_named_alone(void **state)
{
  (void)state;
  hl_part part[PARTS];
  some_parts(part);
  for (int p = 0; p < PARTS; p++) {
    hl_evidence e = unit_evidence();
    for (int i = 0; i < N; i++)
      e.z[i] = 0.3;
    e.z[part[p].first] = 9;
    const hl_drift d = judged(&e);
    assert_int_equal(moved(&d), 1u << p);
    for (int i = 0; i < PARTS; i++)
      assert_true((d.cause[i].figure > d.cause[i].threshold) == (i == p));
    assert_near(d.cause[p].change[0], 9, 1e-12);
    assert_near(d.cause[p].sigma[0], 1, 1e-12);
  }
}

static void test_two_parts(void **state)
{
  (void)state;
  hl_evidence e = unit_evidence();
  e.z[1] = 12;
  e.z[4] = -8;
  const hl_drift d = judged(&e);
  assert_int_equal(moved(&d), 1u << 0 | 1u << 2);
  assert_near(d.cause[0].figure, 12, 1e-12);
  assert_near(d.cause[2].figure, 8, 1e-12);
  assert_int_equal(d.notes.n, 0);
}

/* Rotation and shift of a mount are one thing, so they go before two parts of the intrinsics that
 * explain the same with fewer numbers. */
static void test_a_knocked_mount_is_one_thing(void **state)
{
  (void)state;
  hl_evidence e = unit_evidence();
  e.x[6][0] = e.x[9][2] = 1; /* fx looks like a rotation, cx like a shift */
  e.x[0][0] = e.x[2][2] = 1e-3;
  e.z[6] = 10;
  e.z[9] = 10;
  const hl_drift d = judged(&e);
  assert_int_equal(moved(&d), 1u << 3 | 1u << 4);
  assert_int_equal(d.notes.n, 3); /* and the other ways are told */
  assert_string_equal(d.notes.note[0].what, "cause");
}

/* A change that another mimics exactly is not told apart: the smaller one is named, the other noted. */
static void test_mimicry_is_noted(void **state)
{
  (void)state;
  hl_evidence e = unit_evidence();
  for (int i = 0; i < 2; i++) { /* the first two of rotation do what the centre does */
    e.x[6 + i][6 + i] = 0;
    e.x[2 + i][6 + i] = 1;
  }
  e.z[2] = 11;
  const hl_drift d = judged(&e);
  assert_int_equal(moved(&d), 1u << 1);
  assert_int_equal(d.notes.n, 1);
  assert_non_null(strstr(d.notes.note[0].why, "rotation would explain it too"));
  /* beside the centre two of the rotation's numbers add nothing, and one thing is left to test */
  assert_near(d.cause[3].significance, 1, 1e-12);
  /* degrees of freedom are those of the columns that differ: 12 changes, 10 directions */
  assert_near(d.significance, hl_significance(121, 10, HUGE_VAL), 1e-30);
}

/* With the others held, a correlated part is known better; with the moved one free, less well. */
static void test_generalised_least_squares(void **state)
{
  (void)state;
  hl_evidence e = unit_evidence();
  /* Cov(fx, cx) = [[1, c], [c, 1]], c = 0.8: x = L^-1 */
  const double c = 0.8, s = 0.6;
  e.x[2][0] = -c / s;
  e.x[2][2] = 1 / s;
  const double fx = 10, cx = 0.3; /* fx moved, cx is noise */
  e.z[0] = fx;
  e.z[2] = (cx - c * fx) / s;
  const hl_drift d = judged(&e);
  assert_int_equal(moved(&d), 1u << 0);
  /* held at 0, cx says that fx is off by the regression c cx, Var = 1 - c^2 */
  assert_near(d.cause[0].change[0], fx - c * cx, 1e-12);
  assert_near(d.cause[0].sigma[0], s, 1e-12);
  /* with fx free, cx is what was measured */
  assert_near(d.cause[1].change[0], cx, 1e-12);
  assert_near(d.cause[1].sigma[0], 1, 1e-12);
}

static void test_threshold_is_where_the_part_test_turns(void **state)
{
  (void)state;
  hl_evidence e = unit_evidence();
  e.z[0] = 1.5;
  e.z[1] = 2;
  const hl_drift d = judged(&e);
  /* five parts share 0.01: 1 - 0.99^(1/5) each; the rate of 2 degrees of freedom in closed form */
  const double rate = 1 - pow(0.99, 0.2);
  assert_near(d.cause[0].threshold, sqrt(-2 * log(rate)), 1e-9);
  assert_near(d.cause[0].figure, 2.5, 1e-12);
  assert_near(d.cause[0].significance, exp(-2.5 * 2.5 / 2), 1e-12);
  /* where nothing moved at all: the mean over all directions, here the same in each */
  assert_near(d.cause[1].threshold, sqrt(-2 * log(rate)), 1e-9);
  assert_near(d.cause[1].figure, 0, 0);
}

static void test_what_nothing_tells(void **state)
{
  (void)state;
  hl_evidence e = unit_evidence();
  for (int i = 9; i < 12; i++)
    e.x[i][i] = 0;
  e.z[10] = 50; /* noise of a direction that no change reaches */
  const hl_drift d = judged(&e);
  assert_false(d.drifted);
  assert_near(d.significance, 1, 0);
  assert_true(isnan(d.cause[4].threshold));
  assert_near(d.cause[4].significance, 1, 0);
}

/* Units that differ by twenty orders of magnitude change nothing but the units. */
static void test_scale_does_not_matter(void **state)
{
  (void)state;
  hl_evidence e = unit_evidence();
  for (int i = 0; i < N; i++)
    for (int k = 0; k < N; k++)
      e.x[i][k] = i == k ? 1 : 0.1 * sin(3 * i + k);
  for (int i = 0; i < N; i++)
    e.z[i] = i == 4 ? 12 : cos(i);
  const hl_drift plain = judged(&e);
  for (int i = 0; i < N; i++)
    for (int k = 4; k < 6; k++)
      e.x[i][k] *= 1e20;
  const hl_drift scaled = judged(&e);
  assert_int_equal(moved(&scaled), moved(&plain));
  assert_near(scaled.significance / plain.significance, 1, 1e-9);
  assert_near(scaled.cause[2].change[0] * 1e20, plain.cause[2].change[0], 1e-9);
  assert_near(scaled.cause[2].significance / plain.cause[2].significance, 1, 1e-9);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_verdict_is_the_chi_squared_of_all),
      cmocka_unit_test(test_few_residuals_widen_the_verdict),
      cmocka_unit_test(test_each_part_alone_is_named_alone),
      cmocka_unit_test(test_two_parts),
      cmocka_unit_test(test_a_knocked_mount_is_one_thing),
      cmocka_unit_test(test_mimicry_is_noted),
      cmocka_unit_test(test_generalised_least_squares),
      cmocka_unit_test(test_threshold_is_where_the_part_test_turns),
      cmocka_unit_test(test_what_nothing_tells),
      cmocka_unit_test(test_scale_does_not_matter),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
