/* Normal equations of several terms against dense rows. */
#include <stdlib.h>
#include <string.h>

#include "../src/gram.h"
#include "near.h"

enum { ROWS = 40, SPLINE = 9, COLUMNS = 2 * SPLINE + 2 };

/* Two splines, a linear column and a column of ones, as runs and as dense rows. */
typedef struct problem {
  int at[3][ROWS];
  double value[3][ROWS][4];
  double dense[ROWS][COLUMNS];
  double w[ROWS], y[HL_CHANNELS_MAX][ROWS];
} problem;

static void make(problem *p)
{
  test_random r = {3};
  memset(p, 0, sizeof *p);
  for (int i = 0; i < ROWS; i++) {
    for (int t = 0; t < 3; t++) {
      const int run = t < 2 ? 4 : 1;
      p->at[t][i] = t < 2 ? t * SPLINE + (int)(random_uniform(&r) * (SPLINE - 3)) : 2 * SPLINE;
      for (int k = 0; k < run; k++) {
        p->value[t][i][k] = random_normal(&r);
        p->dense[i][p->at[t][i] + k] = p->value[t][i][k];
      }
    }
    p->dense[i][COLUMNS - 1] = 1;
    p->w[i] = random_between(&r, 0.1, 2);
    for (int c = 0; c < HL_CHANNELS_MAX; c++)
      p->y[c][i] = random_normal(&r);
  }
}

static hl_gram *gram_of(const problem *p, int from, int to)
{
  hl_gram *g = malloc(sizeof *g);
  const double *y[HL_CHANNELS_MAX];
  hl_runs runs[3];
  assert_non_null(g);
  hl_gram_clear(g, COLUMNS, HL_CHANNELS_MAX);
  for (int c = 0; c < HL_CHANNELS_MAX; c++)
    y[c] = p->y[c] + from;
  for (int t = 0; t < 3; t++)
    runs[t] = (hl_runs){t < 2 ? 4 : 1, p->at[t] + from, p->value[t] + from};
  for (int t = 0; t < 3; t++) {
    for (int s = t; s < 3; s++)
      hl_gram_add(g, &runs[t], &runs[s], to - from, p->w + from);
    hl_gram_add_data(g, &runs[t], to - from, p->w + from, y);
    hl_gram_add_constant(g, COLUMNS - 1, &runs[t], to - from, p->w + from);
  }
  hl_gram_add_constant_data(g, COLUMNS - 1, to - from, p->w + from, y);
  hl_gram_add_square(g, to - from, p->w + from, y);
  return g;
}

static void test_products_of_dense_rows(void **state)
{
  (void)state;
  problem p;
  make(&p);
  hl_gram *g = gram_of(&p, 0, ROWS);
  for (int i = 0; i < COLUMNS; i++)
    for (int j = i; j < COLUMNS; j++) {
      double sum = 0;
      for (int k = 0; k < ROWS; k++)
        sum += p.w[k] * p.dense[k][i] * p.dense[k][j];
      assert_near(g->a[i * COLUMNS + j], sum, 1e-12);
    }
  for (int c = 0; c < HL_CHANNELS_MAX; c++) {
    double x[HL_GRAM_MAX], cost = 0;
    for (int i = 0; i < COLUMNS; i++) {
      double sum = 0;
      x[i] = 0.3 * i - 2;
      for (int k = 0; k < ROWS; k++)
        sum += p.w[k] * p.dense[k][i] * p.y[c][k];
      assert_near(g->b[c][i], sum, 1e-12);
    }
    for (int k = 0; k < ROWS; k++) {
      double r = p.y[c][k];
      for (int i = 0; i < COLUMNS; i++)
        r -= p.dense[k][i] * x[i];
      cost += p.w[k] * r * r;
    }
    assert_near(hl_gram_cost(g, c, x) / cost, 1, 1e-12);
  }
  free(g);
}

static void test_parts_add_up(void **state)
{
  (void)state;
  problem p;
  make(&p);
  hl_gram *whole = gram_of(&p, 0, ROWS), *first = gram_of(&p, 0, 13);
  hl_gram *rest = gram_of(&p, 13, ROWS);
  hl_gram_merge(first, rest);
  for (int i = 0; i < COLUMNS * COLUMNS; i++)
    assert_near(first->a[i], whole->a[i], 1e-12);
  hl_gram_subtract(whole, rest);
  hl_gram_subtract(first, rest);
  for (int i = 0; i < COLUMNS; i++)
    assert_near(whole->b[1][i], first->b[1][i], 1e-12);
  free(whole);
  free(first);
  free(rest);
}

static void test_without_a_term(void **state)
{
  (void)state;
  problem p;
  make(&p);
  hl_gram *whole = gram_of(&p, 0, ROWS), *out = malloc(sizeof *out);
  assert_non_null(out);
  hl_gram_without(whole, SPLINE, SPLINE, out);
  assert_int_equal(out->n, COLUMNS - SPLINE);
  for (int i = 0; i < out->n; i++)
    for (int j = i; j < out->n; j++) {
      const int k = i < SPLINE ? i : i + SPLINE, l = j < SPLINE ? j : j + SPLINE;
      assert_near(out->a[i * out->n + j], whole->a[k * COLUMNS + l], 0);
    }
  assert_near(out->b[2][out->n - 1], whole->b[2][COLUMNS - 1], 0);
  free(whole);
  free(out);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_products_of_dense_rows),
      cmocka_unit_test(test_parts_add_up),
      cmocka_unit_test(test_without_a_term),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
