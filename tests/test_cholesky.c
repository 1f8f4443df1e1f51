/* Cholesky's factor: against products, and where there is none. */
#include <string.h>

#include "../src/cholesky.h"
#include "near.h"

enum { SIZE = 9, STRIDE = 11 };

/* A = B'B of random B, upper triangle; x and b = A x. */
static void problem(uint64_t seed, double *a, double *x, double *b)
{
  test_random r = {seed};
  double rows[2 * SIZE][SIZE];
  memset(a, 0, sizeof(double) * SIZE * STRIDE);
  for (int i = 0; i < 2 * SIZE; i++)
    for (int j = 0; j < SIZE; j++)
      rows[i][j] = random_normal(&r);
  for (int i = 0; i < SIZE; i++) {
    x[i] = random_normal(&r);
    b[i] = 0;
  }
  for (int i = 0; i < SIZE; i++)
    for (int j = 0; j < SIZE; j++) {
      double sum = 0;
      for (int k = 0; k < 2 * SIZE; k++)
        sum += rows[k][i] * rows[k][j];
      b[i] += sum * x[j];
      if (j >= i)
        a[i * STRIDE + j] = sum;
    }
}

static void test_solving(void **state)
{
  (void)state;
  for (uint64_t seed = 1; seed <= 10; seed++) {
    double a[SIZE * STRIDE], x[SIZE], b[SIZE], half[SIZE], square = 0, form = 0;
    problem(seed, a, x, b);
    assert_int_equal(hl_cholesky(a, SIZE, STRIDE, 1e-14), 0);
    memcpy(half, b, sizeof half);
    hl_cholesky_forward(a, SIZE, STRIDE, half);
    for (int i = 0; i < SIZE; i++) {
      square += half[i] * half[i];
      form += b[i] * x[i];
    }
    hl_cholesky_solve(a, SIZE, STRIDE, b);
    for (int i = 0; i < SIZE; i++)
      assert_near(b[i], x[i], 1e-9);
    assert_near(square / form, 1, 1e-10);
  }
}

/* Rank one: pivots are raised and counted, and the answer is finite. */
static void test_a_singular_matrix(void **state)
{
  (void)state;
  double a[9] = {1, 2, 3, 0, 4, 6, 0, 0, 9}, b[3] = {1, 2, 3};
  assert_int_equal(hl_cholesky(a, 3, 3, 1e-12), 2);
  hl_cholesky_solve(a, 3, 3, b);
  assert_near(b[0] + 2 * b[1] + 3 * b[2], 1, 1e-6);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_solving),
      cmocka_unit_test(test_a_singular_matrix),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
