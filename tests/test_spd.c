/* Small symmetric positive definite matrices: solved, inverted, scaled by ten orders, refused. */
#include "../calib/spd.h"
#include "near.h"

/* A' A + ridge of a seeded A, rows scaled by 10^0, 10^-1 ... */
static void make(int n, double ridge, bool scaled, double *out)
{
  test_random r = {99};
  double a[HL_SPD_MAX][HL_SPD_MAX];
  for (int i = 0; i < n; i++)
    for (int k = 0; k < n; k++)
      a[i][k] = random_normal(&r);
  for (int i = 0; i < n; i++)
    for (int k = 0; k < n; k++) {
      double sum = i == k ? ridge : 0;
      for (int j = 0; j < n; j++)
        sum += a[j][i] * a[j][k];
      out[i * n + k] = sum * (scaled ? pow(10, -i - k) : 1);
    }
}

static void test_solve(void **state)
{
  (void)state;
  for (int n = 1; n <= HL_SPD_MAX; n++)
    for (int scaled = 0; scaled < 2; scaled++) {
      double a[HL_SPD_MAX * HL_SPD_MAX], x[HL_SPD_MAX], b[HL_SPD_MAX];
      hl_spd f;
      make(n, 0.5, scaled, a);
      for (int i = 0; i < n; i++)
        x[i] = (i - 3.5) * (scaled ? pow(10, i) : 1);
      for (int i = 0; i < n; i++) {
        b[i] = 0;
        for (int k = 0; k < n; k++)
          b[i] += a[i * n + k] * x[k];
      }
      assert_true(hl_spd_factor(a, n, 0, &f, NULL));
      hl_spd_solve(&f, b, b);
      for (int i = 0; i < n; i++)
        assert_near(b[i] / x[i], 1, 1e-9);
    }
}

static void test_inverse(void **state)
{
  (void)state;
  const int n = 9;
  double a[HL_SPD_MAX * HL_SPD_MAX], inverse[HL_SPD_MAX * HL_SPD_MAX];
  hl_spd f;
  make(n, 0.5, true, a);
  assert_true(hl_spd_factor(a, n, 0, &f, NULL));
  hl_spd_inverse(&f, inverse);
  for (int i = 0; i < n; i++)
    for (int k = 0; k < n; k++) {
      double sum = 0;
      for (int j = 0; j < n; j++)
        sum += a[i * n + j] * inverse[j * n + k];
      assert_near(sum * pow(10, i - k), i == k, 1e-9);
      assert_near(inverse[i * n + k], inverse[k * n + i], 0);
    }
}

/* Damping enlarges the diagonal by its own share. */
static void test_damping(void **state)
{
  (void)state;
  const double a[4] = {4, 1, 1, 9};
  const double damped[4] = {4 * 1.5, 1, 1, 9 * 1.5};
  const double b[2] = {3, -2};
  double x[2], y[2];
  hl_spd f;
  assert_true(hl_spd_factor(a, 2, 0.5, &f, NULL));
  hl_spd_solve(&f, b, x);
  assert_true(hl_spd_factor(damped, 2, 0, &f, NULL));
  hl_spd_solve(&f, b, y);
  assert_near(x[0], y[0], 1e-14);
  assert_near(x[1], y[1], 1e-14);
}

static void test_singular(void **state)
{
  (void)state;
  hl_spd f;
  int row = -1;
  const double twice[9] = {1, 0, 2, 0, 1, 0, 2, 0, 4}; /* the third column is the first, twice */
  assert_false(hl_spd_factor(twice, 3, 0, &f, &row));
  assert_int_equal(row, 2);
  const double empty[4] = {1, 0, 0, 0};
  assert_false(hl_spd_factor(empty, 2, 0, &f, &row));
  assert_int_equal(row, 1);
  const double lost[4] = {NAN, 0, 0, 1};
  assert_false(hl_spd_factor(lost, 2, 0, &f, &row));
  assert_int_equal(row, 0);
  const double negative[4] = {1, 2, 2, 1};
  assert_false(hl_spd_factor(negative, 2, 0, &f, NULL));
}

/* Of [1 c; c 1] in the 1-norm: (1 + c) / (1 - c), whatever the units. */
static void test_condition(void **state)
{
  (void)state;
  const double c = 0.99, unit = 1e7;
  const double a[4] = {1, c * unit, c * unit, unit * unit};
  hl_spd f;
  int weakest = -1;
  double own = 0;
  assert_true(hl_spd_factor(a, 2, 0, &f, NULL));
  assert_near(hl_spd_condition(a, &f, &weakest, &own), (1 + c) / (1 - c), 1e-9);
  assert_near(own, 1 - c * c, 1e-12);
  const double three[9] = {1, 0, 0, 0, 1, c, 0, c, 1};
  assert_true(hl_spd_factor(three, 3, 0, &f, NULL));
  hl_spd_condition(three, &f, &weakest, NULL);
  assert_true(weakest == 1 || weakest == 2);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_solve),     cmocka_unit_test(test_inverse),
      cmocka_unit_test(test_damping),   cmocka_unit_test(test_singular),
      cmocka_unit_test(test_condition),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
