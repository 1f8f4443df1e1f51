/* Non-negative least squares: known answers, and the conditions every answer must meet. */
#include <string.h>

#include "../src/nnls.h"
#include "near.h"

/* x >= 0, w = b - Ax <= 0, and w = 0 where x > 0 (Karush, Kuhn, Tucker); `scale` of b and w. */
static void assert_optimal(const double *a, const double *b, int n, const double *x, double scale)
{
  for (int i = 0; i < n; i++) {
    double w = b[i];
    for (int j = 0; j < n; j++)
      w -= a[i * n + j] * x[j];
    assert_true(x[i] >= 0);
    assert_true(w <= 1e-8 * scale);
    if (x[i] > 0)
      assert_near(w / scale, 0, 1e-8);
  }
}

/* A = X'X, b = X'y of random rows. */
static double random_problem(uint64_t seed, int rows, int n, double *a, double *b)
{
  test_random r = {seed};
  double largest = 0;
  memset(a, 0, sizeof *a * (size_t)(n * n));
  memset(b, 0, sizeof *b * (size_t)n);
  for (int p = 0; p < rows; p++) {
    double x[HL_NNLS_MAX];
    const double y = random_normal(&r);
    for (int i = 0; i < n; i++)
      x[i] = random_normal(&r);
    for (int i = 0; i < n; i++) {
      b[i] += x[i] * y;
      for (int j = 0; j < n; j++)
        a[i * n + j] += x[i] * x[j];
    }
  }
  for (int i = 0; i < n; i++)
    largest = fmax(largest, fabs(b[i]));
  return largest;
}

static void test_a_diagonal_clips_at_zero(void **state)
{
  (void)state;
  const double a[9] = {2, 0, 0, 0, 4, 0, 0, 0, 8}, b[3] = {6, -4, 2};
  double x[3] = {-1, -1, -1};
  assert_int_equal(hl_nnls(a, b, 3, x), 0);
  assert_near(x[0], 3, 1e-15);
  assert_near(x[1], 0, 0);
  assert_near(x[2], 0.25, 1e-15);
}

/* By hand: unconstrained (2, -1); with x1 held at 0, x0 = 3/2. */
static void test_holding_one_moves_the_other(void **state)
{
  (void)state;
  const double a[4] = {2, 1, 1, 2}, b[2] = {3, 0};
  double x[2];
  assert_int_equal(hl_nnls(a, b, 2, x), 0);
  assert_near(x[0], 1.5, 1e-15);
  assert_near(x[1], 0, 0);
}

static void test_one_unknown(void **state)
{
  (void)state;
  const double a = 4, up = 2, down = -2, none = 0;
  double x;
  assert_int_equal(hl_nnls(&a, &up, 1, &x), 0);
  assert_near(x, 0.5, 1e-15);
  assert_int_equal(hl_nnls(&a, &down, 1, &x), 0);
  assert_near(x, 0, 0);
  assert_int_equal(hl_nnls(&none, &up, 1, &x), 0);
  assert_near(x, 0, 0);
}

static void test_a_positive_answer_is_least_squares(void **state)
{
  (void)state;
  enum { SIZE = 12 };
  double a[SIZE * SIZE], b[SIZE], x[SIZE];
  random_problem(3, 60, SIZE, a, b);
  for (int i = 0; i < SIZE; i++) {
    b[i] = 0;
    for (int j = 0; j < SIZE; j++)
      b[i] += a[i * SIZE + j] * (j + 1);
  }
  assert_int_equal(hl_nnls(a, b, SIZE, x), 0);
  for (int i = 0; i < SIZE; i++)
    assert_near(x[i], i + 1, 1e-10);
}

static void test_answers_are_optimal(void **state)
{
  (void)state;
  static double a[HL_NNLS_MAX * HL_NNLS_MAX];
  double b[HL_NNLS_MAX], x[HL_NNLS_MAX];
  for (uint64_t seed = 1; seed <= 60; seed++) {
    const int n = 2 + (int)(seed * 7 % (HL_NNLS_MAX - 1));
    const double scale = random_problem(seed, 3 * n, n, a, b);
    assert_int_equal(hl_nnls(a, b, n, x), 0);
    assert_optimal(a, b, n, x, scale);
  }
}

/* Fewer rows than unknowns: many answers, any of them optimal. */
static void test_a_singular_matrix_still_has_an_answer(void **state)
{
  (void)state;
  enum { SIZE = 20 };
  double a[SIZE * SIZE], b[SIZE], x[SIZE];
  for (uint64_t seed = 1; seed <= 20; seed++) {
    const double scale = random_problem(seed, 8, SIZE, a, b);
    assert_int_equal(hl_nnls(a, b, SIZE, x), 0);
    for (int i = 0; i < SIZE; i++) {
      double w = b[i];
      for (int j = 0; j < SIZE; j++)
        w -= a[i * SIZE + j] * x[j];
      assert_true(x[i] >= 0);
      assert_true(w <= 1e-5 * scale); /* the ridge on zero pivots, 1e-12 of the diagonal */
    }
  }
}

static void test_nothing_wanted_is_nothing(void **state)
{
  (void)state;
  enum { SIZE = 9 };
  double a[SIZE * SIZE], b[SIZE], x[SIZE];
  random_problem(4, 40, SIZE, a, b);
  for (int i = 0; i < SIZE; i++)
    b[i] = -1 - i;
  assert_int_equal(hl_nnls(a, b, SIZE, x), 0);
  for (int i = 0; i < SIZE; i++)
    assert_near(x[i], 0, 0);
}

/* Powers of two change no digit. */
static void test_scale_does_not_matter(void **state)
{
  (void)state;
  enum { SIZE = 30 };
  double a[SIZE * SIZE], b[SIZE], x[SIZE], y[SIZE];
  random_problem(5, 90, SIZE, a, b);
  assert_int_equal(hl_nnls(a, b, SIZE, x), 0);
  for (int i = 0; i < SIZE * SIZE; i++)
    a[i] = ldexp(a[i], 80);
  for (int i = 0; i < SIZE; i++)
    b[i] = ldexp(b[i], -120);
  assert_int_equal(hl_nnls(a, b, SIZE, y), 0);
  for (int i = 0; i < SIZE; i++)
    assert_near(ldexp(y[i], 200), x[i], 1e-12);
}

/* Columns from 1 to 1e8 in size. */
static void test_unlike_columns(void **state)
{
  (void)state;
  enum { SIZE = 17 };
  double a[SIZE * SIZE], b[SIZE], x[SIZE];
  random_problem(6, 70, SIZE, a, b);
  for (int i = 0; i < SIZE; i++) {
    const double k = pow(10, i / 2.0);
    b[i] *= k;
    for (int j = 0; j < SIZE; j++) {
      a[i * SIZE + j] *= k;
      a[j * SIZE + i] *= k;
    }
  }
  assert_int_equal(hl_nnls(a, b, SIZE, x), 0);
  for (int i = 0; i < SIZE; i++) {
    const double k = pow(10, i / 2.0);
    double w = b[i];
    for (int j = 0; j < SIZE; j++)
      w -= a[i * SIZE + j] * x[j];
    assert_true(x[i] >= 0);
    assert_true(w <= 1e-7 * k);
    if (x[i] > 0)
      assert_near(w / k, 0, 1e-6);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_a_diagonal_clips_at_zero),
      cmocka_unit_test(test_holding_one_moves_the_other),
      cmocka_unit_test(test_one_unknown),
      cmocka_unit_test(test_a_positive_answer_is_least_squares),
      cmocka_unit_test(test_answers_are_optimal),
      cmocka_unit_test(test_a_singular_matrix_still_has_an_answer),
      cmocka_unit_test(test_nothing_wanted_is_nothing),
      cmocka_unit_test(test_scale_does_not_matter),
      cmocka_unit_test(test_unlike_columns),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
