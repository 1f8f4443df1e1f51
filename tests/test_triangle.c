/* Least squares fed row by row, against the normal equations. */
#include "../calib/triangle.h"

#include <string.h>

#include "near.h"

enum { N = 7, ROWS = 40 };

static void some_problem(uint64_t seed, double a[ROWS][N], double y[ROWS])
{
  test_random r = {seed};
  for (int i = 0; i < ROWS; i++) {
    y[i] = random_normal(&r);
    for (int k = 0; k < N; k++)
      a[i][k] = (k == 3 ? 1e-6 : 1) * random_normal(&r); /* columns of unlike size */
  }
}

static void feed(hl_triangle *t, double a[ROWS][N], const double y[ROWS], const int *order)
{
  hl_triangle_clear(t, N);
  for (int i = 0; i < ROWS; i++) {
    double row[N];
    const int at = order ? order[i] : i;
    memcpy(row, a[at], sizeof row);
    hl_triangle_add(t, row, y[at]);
  }
}

/* R'R = A'A and R'z = A'y. */
static void test_keeps_the_normal_equations(void **state)
{
  (void)state;
  double a[ROWS][N], y[ROWS];
  hl_triangle t;
  some_problem(3, a, y);
  feed(&t, a, y, NULL);
  assert_int_equal(t.rows, ROWS);
  double zz = 0, yy = 0;
  for (int i = 0; i < N; i++)
    zz += t.z[i] * t.z[i];
  for (int i = 0; i < ROWS; i++)
    yy += y[i] * y[i];
  assert_near(zz + t.rest, yy, 1e-12 * yy);
  for (int i = 0; i < N; i++) {
    const double scale_i = i == 3 ? 1e-6 : 1;
    double got_y = 0, want_y = 0;
    for (int r = 0; r < ROWS; r++)
      want_y += a[r][i] * y[r];
    for (int r = 0; r < N; r++)
      got_y += t.r[r][i] * t.z[r];
    assert_near(got_y, want_y, 1e-12 * scale_i);
    for (int k = 0; k < N; k++) {
      double got = 0, want = 0;
      if (k < i)
        assert_near(t.r[i][k], 0, 0);
      for (int r = 0; r < ROWS; r++)
        want += a[r][i] * a[r][k];
      for (int r = 0; r < N; r++)
        got += t.r[r][i] * t.r[r][k];
      assert_near(got, want, 1e-12 * scale_i * (k == 3 ? 1e-6 : 1) * ROWS);
    }
  }
}

static void test_order_of_rows_does_not_matter(void **state)
{
  (void)state;
  double a[ROWS][N], y[ROWS];
  int order[ROWS];
  hl_triangle t, u;
  some_problem(4, a, y);
  for (int i = 0; i < ROWS; i++)
    order[i] = (i * 7 + 3) % ROWS;
  feed(&t, a, y, NULL);
  feed(&u, a, y, order);
  assert_near(u.rest, t.rest, 1e-12 * t.rest);
  for (int i = 0; i < N; i++)
    for (int k = i; k < N; k++)
      assert_near(fabs(u.r[i][k]), fabs(t.r[i][k]), 1e-11);
}

/* Exact data leave nothing, and the triangle gives the truth back. */
static void test_exact_data(void **state)
{
  (void)state;
  double a[ROWS][N], y[ROWS], x[N];
  hl_triangle t;
  some_problem(5, a, y);
  for (int i = 0; i < ROWS; i++) {
    y[i] = 0;
    for (int k = 0; k < N; k++)
      y[i] += a[i][k] * (k + 1);
  }
  feed(&t, a, y, NULL);
  assert_near(t.rest, 0, 1e-20);
  for (int i = N - 1; i >= 0; i--) {
    x[i] = t.z[i];
    for (int k = i + 1; k < N; k++)
      x[i] -= t.r[i][k] * x[k];
    x[i] /= t.r[i][i];
    assert_near(x[i], i + 1, i == 3 ? 1e-7 : 1e-12);
  }
}

/* A row of zeros says nothing about the unknowns. */
static void test_zero_row_is_all_rest(void **state)
{
  (void)state;
  double row[N] = {0};
  hl_triangle t;
  hl_triangle_clear(&t, N);
  hl_triangle_add(&t, row, 3);
  assert_near(t.rest, 9, 0);
  for (int i = 0; i < N; i++)
    assert_near(t.r[i][i], 0, 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_keeps_the_normal_equations),
      cmocka_unit_test(test_order_of_rows_does_not_matter),
      cmocka_unit_test(test_exact_data),
      cmocka_unit_test(test_zero_row_is_all_rest),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
