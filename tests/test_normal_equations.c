/* Banded normal equations with a border, against dense ones made from the same rows. */
#include <string.h>

#include "../src/normal_equations.h"
#include "near.h"

enum { ROWS = 400, N = 17, M = 3, ALL = N + M };

typedef struct row {
  int first;
  double band[4], border[HL_BORDER_MAX], weight, y;
} row;

static void random_rows(uint64_t seed, row rows[ROWS])
{
  test_random r = {seed};
  for (int i = 0; i < ROWS; i++) {
    rows[i] = (row){.first = (int)(random_uniform(&r) * (N - 3))};
    for (int k = 0; k < 4; k++)
      rows[i].band[k] = random_normal(&r);
    for (int j = 0; j < M; j++)
      rows[i].border[j] = random_normal(&r);
    rows[i].weight = 0.1 + random_uniform(&r);
    rows[i].y = random_normal(&r);
  }
}

static hl_normal banded(const row *rows, int count)
{
  hl_normal a;
  memset(&a, 0xff, sizeof a);
  hl_normal_clear(&a, N, M);
  for (int i = 0; i < count; i++)
    hl_normal_add(&a, rows[i].first, rows[i].band, rows[i].border, rows[i].weight, rows[i].y);
  return a;
}

/* A = X'WX, b = X'Wy written out; returns y'Wy. */
static double dense(const row *rows, int count, double a[ALL][ALL], double b[ALL])
{
  double yy = 0;
  memset(a, 0, sizeof(double[ALL][ALL]));
  memset(b, 0, sizeof(double[ALL]));
  for (int i = 0; i < count; i++) {
    double x[ALL] = {0};
    memcpy(x + rows[i].first, rows[i].band, sizeof rows[i].band);
    memcpy(x + N, rows[i].border, M * sizeof(double));
    for (int p = 0; p < ALL; p++) {
      b[p] += rows[i].weight * x[p] * rows[i].y;
      for (int q = 0; q < ALL; q++)
        a[p][q] += rows[i].weight * x[p] * x[q];
    }
    yy += rows[i].weight * rows[i].y * rows[i].y;
  }
  return yy;
}

static void test_rows_add_up_to_the_dense_matrix(void **state)
{
  (void)state;
  row rows[ROWS];
  double a[ALL][ALL], b[ALL], full[ALL * ALL];
  random_rows(11, rows);
  const hl_normal got = banded(rows, ROWS);
  assert_near(got.yy, dense(rows, ROWS, a, b), 1e-10);
  hl_normal_dense(&got, full);
  for (int i = 0; i < ALL; i++) {
    assert_near(got.rhs[i], b[i], 1e-11);
    for (int j = 0; j < ALL; j++)
      assert_near(full[i * ALL + j], a[i][j], 1e-11);
  }
}

static void test_times_is_the_matrix_product(void **state)
{
  (void)state;
  row rows[ROWS];
  double a[ALL][ALL], b[ALL], x[ALL], got[ALL];
  test_random r = {5};
  random_rows(12, rows);
  dense(rows, ROWS, a, b);
  for (int i = 0; i < ALL; i++)
    x[i] = random_normal(&r);
  const hl_normal normal = banded(rows, ROWS);
  hl_normal_times(&normal, x, got);
  for (int i = 0; i < ALL; i++) {
    double want = 0;
    for (int j = 0; j < ALL; j++)
      want += a[i][j] * x[j];
    assert_near(got[i], want, 1e-10);
  }
}

static void test_merging_parts_is_adding_all_rows(void **state)
{
  (void)state;
  row rows[ROWS];
  double one[ALL * ALL], two[ALL * ALL];
  random_rows(13, rows);
  hl_normal a = banded(rows, 150);
  const hl_normal b = banded(rows + 150, ROWS - 150), whole = banded(rows, ROWS);
  hl_normal_merge(&a, &b);
  hl_normal_dense(&a, one);
  hl_normal_dense(&whole, two);
  for (int i = 0; i < ALL * ALL; i++)
    assert_near(one[i], two[i], 1e-11);
  for (int i = 0; i < ALL; i++)
    assert_near(a.rhs[i], whole.rhs[i], 1e-11);
  assert_near(a.yy, whole.yy, 1e-11);
}

/* The residual of the dense system, whatever the path to x. */
static void assert_solves(double a[ALL][ALL], const double *b, const double *x)
{
  for (int i = 0; i < ALL; i++) {
    double sum = 0;
    for (int j = 0; j < ALL; j++)
      sum += a[i][j] * x[j];
    assert_near(sum, b[i], 1e-9);
  }
}

static void test_solution_satisfies_the_dense_system(void **state)
{
  (void)state;
  for (uint64_t seed = 1; seed <= 20; seed++) {
    row rows[ROWS];
    double a[ALL][ALL], b[ALL], x[ALL];
    hl_normal_factor f;
    random_rows(seed, rows);
    dense(rows, ROWS, a, b);
    const hl_normal normal = banded(rows, ROWS);
    assert_int_equal(hl_normal_factorise(&normal, &f), 0);
    hl_normal_solve(&f, normal.rhs, x);
    assert_solves(a, b, x);
  }
}

/* In place, as callers use it. */
static void test_right_hand_side_may_be_the_answer(void **state)
{
  (void)state;
  row rows[ROWS];
  double a[ALL][ALL], b[ALL], x[ALL];
  hl_normal_factor f;
  random_rows(21, rows);
  dense(rows, ROWS, a, b);
  const hl_normal normal = banded(rows, ROWS);
  assert_int_equal(hl_normal_factorise(&normal, &f), 0);
  memcpy(x, normal.rhs, sizeof x);
  hl_normal_solve(&f, x, x);
  assert_solves(a, b, x);
}

static void test_a_border_alone_and_a_band_alone(void **state)
{
  (void)state;
  const double band[4] = {2, 0, 0, 0}, border[HL_BORDER_MAX] = {2};
  hl_normal a;
  hl_normal_factor f;
  double x[4];
  hl_normal_clear(&a, 0, 1);
  hl_normal_add(&a, 0, (const double[4]){0}, border, 1, 6);
  assert_int_equal(hl_normal_factorise(&a, &f), 0);
  hl_normal_solve(&f, a.rhs, x);
  assert_near(x[0], 3, 1e-15);
  hl_normal_clear(&a, 4, 0);
  for (int i = 0; i < 4; i++) {
    double turned[4] = {0};
    turned[i] = band[0];
    hl_normal_add(&a, 0, turned, (const double[HL_BORDER_MAX]){0}, 1, i);
  }
  assert_int_equal(hl_normal_factorise(&a, &f), 0);
  hl_normal_solve(&f, a.rhs, x);
  for (int i = 0; i < 4; i++)
    assert_near(x[i], i / 2.0, 1e-15);
}

/* Without column j: its coefficient is 0 and the others solve the smaller system. */
static void test_a_dropped_column_is_zero_and_gone(void **state)
{
  (void)state;
  for (int dropped = 0; dropped < M; dropped++) {
    row rows[ROWS];
    double a[ALL][ALL], b[ALL], x[ALL], other[ALL];
    hl_normal_factor f;
    random_rows(31, rows);
    hl_normal normal = banded(rows, ROWS);
    hl_normal_drop(&normal, dropped);
    for (int i = 0; i < ROWS; i++)
      rows[i].border[dropped] = 0;
    dense(rows, ROWS, a, b);
    a[N + dropped][N + dropped] = 1;
    assert_int_equal(hl_normal_factorise(&normal, &f), 0);
    hl_normal_solve(&f, normal.rhs, x);
    assert_near(x[N + dropped], 0, 0);
    assert_solves(a, b, x);
    /* also for a right-hand side that was made without knowing */
    memcpy(other, normal.rhs, sizeof other);
    other[N + dropped] = 7;
    hl_normal_solve(&f, other, other);
    for (int i = 0; i < ALL; i++)
      assert_near(other[i], x[i], 0);
  }
}

static void test_what_is_not_positive_definite_is_refused(void **state)
{
  (void)state;
  row rows[ROWS];
  hl_normal_factor f;
  random_rows(41, rows);
  hl_normal a = banded(rows, ROWS);
  a.band[5][0] = -1;
  assert_int_equal(hl_normal_factorise(&a, &f), -1);
  a = banded(rows, ROWS);
  a.band[5][0] = NAN;
  assert_int_equal(hl_normal_factorise(&a, &f), -1);
  a = banded(rows, ROWS);
  a.corner[1][1] = NAN;
  assert_int_equal(hl_normal_factorise(&a, &f), -1);
  hl_normal_clear(&a, N, M);
  assert_int_equal(hl_normal_factorise(&a, &f), -1);
}

/* A + R with R = sum of w_i d_i d_i' (d = 1, -2, 1) and the ridge, written out. */
static void test_smoothing_is_second_differences(void **state)
{
  (void)state;
  row rows[ROWS];
  double a[ALL][ALL], b[ALL], got[ALL * ALL];
  hl_smoothing smooth = {.ridge = 0.25};
  random_rows(51, rows);
  dense(rows, ROWS, a, b);
  for (int i = 0; i + 2 < N; i++) {
    smooth.bend[i] = 0.5 + i;
    const double d[3] = {1, -2, 1};
    for (int k = 0; k < 3; k++)
      for (int l = 0; l < 3; l++)
        a[i + k][i + l] += smooth.bend[i] * d[k] * d[l];
  }
  for (int i = 0; i < ALL; i++)
    a[i][i] += 0.25;
  hl_normal normal = banded(rows, ROWS);
  hl_normal_regularise(&normal, &smooth);
  hl_normal_dense(&normal, got);
  for (int i = 0; i < ALL; i++)
    for (int j = 0; j < ALL; j++)
      assert_near(got[i * ALL + j], a[i][j], 1e-10);
}

/* Twice the weights, twice the smoothing: the fit does not change. */
static void test_smoothing_follows_the_weights(void **state)
{
  (void)state;
  row rows[ROWS];
  hl_smoothing one, two;
  random_rows(61, rows);
  const hl_normal a = banded(rows, ROWS);
  for (int i = 0; i < ROWS; i++)
    rows[i].weight *= 1024;
  const hl_normal b = banded(rows, ROWS);
  hl_smoothing_from(&a, 1e-6, 1e-12, &one);
  hl_smoothing_from(&b, 1e-6, 1e-12, &two);
  for (int i = 0; i + 2 < N; i++) {
    assert_true(one.bend[i] > 0);
    assert_near(two.bend[i], 1024 * one.bend[i], 0);
  }
  assert_true(one.ridge > 0);
  assert_near(two.ridge, 1024 * one.ridge, 0);
}

/* Columns that no row touches are carried on from their neighbours, in a straight line but for the
 * ridge, a thousandth of their bending's weight. */
static void test_an_empty_interval_is_bridged(void **state)
{
  (void)state;
  const double border[HL_BORDER_MAX] = {0};
  hl_normal a;
  hl_smoothing smooth;
  hl_normal_factor f;
  double x[ALL];
  hl_normal_clear(&a, N, M);
  for (int i = 0; i + 3 < N; i++)
    if (i + 3 < 6 || i > 9)
      for (int k = 0; k < 4; k++) {
        double band[4] = {0};
        band[k] = 1;
        hl_normal_add(&a, i, band, border, 1, 3.0 + 2 * (i + k));
      }
  hl_smoothing_from(&a, 1e-6, 1e-12, &smooth);
  hl_normal_regularise(&a, &smooth);
  assert_int_equal(hl_normal_factorise(&a, &f), 0);
  hl_normal_solve(&f, a.rhs, x);
  for (int i = 0; i < N; i++)
    assert_near(x[i], 3.0 + 2 * i, 0.1);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_rows_add_up_to_the_dense_matrix),
      cmocka_unit_test(test_times_is_the_matrix_product),
      cmocka_unit_test(test_merging_parts_is_adding_all_rows),
      cmocka_unit_test(test_solution_satisfies_the_dense_system),
      cmocka_unit_test(test_right_hand_side_may_be_the_answer),
      cmocka_unit_test(test_a_border_alone_and_a_band_alone),
      cmocka_unit_test(test_a_dropped_column_is_zero_and_gone),
      cmocka_unit_test(test_what_is_not_positive_definite_is_refused),
      cmocka_unit_test(test_smoothing_is_second_differences),
      cmocka_unit_test(test_smoothing_follows_the_weights),
      cmocka_unit_test(test_an_empty_interval_is_bridged),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
