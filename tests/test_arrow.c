/* The arrow against the full normal equations of the same rows. */
#include <stdlib.h>
#include <string.h>

#include "../calib/arrow.h"
#include "near.h"

enum { N = 5, VIEWS = 3, ROWS = 20, ALL = N + VIEWS * HL_POSE_SIZE };

typedef struct scene {
  double theta[VIEWS][ROWS][N], pose[VIEWS][ROWS][HL_POSE_SIZE], residual[VIEWS][ROWS];
  hl_arrow arrow;
  hl_arrow_view view[VIEWS];
  hl_arrow_view *active[VIEWS];
  double h[ALL][ALL], g[ALL];
} scene;

/* `order` says in which order the rows of a view are added. */
static void fill(scene *s, const int *order)
{
  test_random r = {4711};
  for (int v = 0; v < VIEWS; v++)
    for (int i = 0; i < ROWS; i++) {
      for (int k = 0; k < N; k++)
        s->theta[v][i][k] = random_normal(&r) * pow(10, k);
      for (int k = 0; k < HL_POSE_SIZE; k++)
        s->pose[v][i][k] = random_normal(&r) + s->theta[v][i][0];
      s->residual[v][i] = random_normal(&r);
    }
  hl_arrow_clear(&s->arrow, N);
  memset(s->h, 0, sizeof s->h);
  memset(s->g, 0, sizeof s->g);
  for (int v = 0; v < VIEWS; v++) {
    hl_arrow_view_clear(&s->view[v]);
    s->active[v] = &s->view[v];
    for (int i = 0; i < ROWS; i++) {
      const int at = order ? order[i] : i;
      double row[ALL] = {0};
      memcpy(row, s->theta[v][at], sizeof s->theta[v][at]);
      memcpy(row + N + v * HL_POSE_SIZE, s->pose[v][at], sizeof s->pose[v][at]);
      hl_arrow_add(&s->arrow, &s->view[v], s->theta[v][at], s->pose[v][at], s->residual[v][at]);
      for (int a = 0; a < ALL; a++) {
        s->g[a] += row[a] * s->residual[v][at];
        for (int b = 0; b < ALL; b++)
          s->h[a][b] += row[a] * row[b];
      }
    }
  }
}

/* Gauss and Jordan, with pivots: x = -H^-1 g and H^-1. */
static void invert(const scene *s, double inverse[ALL][ALL], double step[ALL])
{
  double a[ALL][2 * ALL] = {{0}};
  for (int i = 0; i < ALL; i++) {
    memcpy(a[i], s->h[i], sizeof s->h[i]);
    a[i][ALL + i] = 1;
  }
  for (int c = 0; c < ALL; c++) {
    int best = c;
    for (int i = c; i < ALL; i++)
      best = fabs(a[i][c]) > fabs(a[best][c]) ? i : best;
    for (int k = 0; k < 2 * ALL; k++) {
      const double swap = a[c][k];
      a[c][k] = a[best][k];
      a[best][k] = swap;
    }
    const double pivot = a[c][c];
    for (int k = 0; k < 2 * ALL; k++)
      a[c][k] /= pivot;
    for (int i = 0; i < ALL; i++) {
      const double f = a[i][c];
      for (int k = 0; i != c && k < 2 * ALL; k++)
        a[i][k] -= f * a[c][k];
    }
  }
  for (int i = 0; i < ALL; i++) {
    step[i] = 0;
    for (int k = 0; k < ALL; k++) {
      inverse[i][k] = a[i][ALL + k];
      step[i] -= inverse[i][k] * s->g[k];
    }
  }
}

static void test_against_full(void **state)
{
  (void)state;
  static scene s;
  double inverse[ALL][ALL], step[ALL], by[HL_INTRINSICS_MAX];
  double covariance[HL_INTRINSICS_MAX * HL_INTRINSICS_MAX];
  hl_arrow_fault fault;
  fill(&s, NULL);
  invert(&s, inverse, step);
  assert_true(hl_arrow_factor(&s.arrow, s.active, VIEWS, 0, &fault));
  hl_arrow_step(&s.arrow, s.active, VIEWS, by);
  hl_spd_inverse(&s.arrow.schur, covariance);
  for (int i = 0; i < N; i++) {
    assert_near(by[i] / step[i], 1, 1e-7);
    for (int k = 0; k < N; k++)
      assert_near(covariance[i * N + k], inverse[i][k], 1e-7 * sqrt(inverse[i][i] * inverse[k][k]));
  }
  for (int v = 0; v < VIEWS; v++) {
    const int at = N + v * HL_POSE_SIZE;
    double pose[HL_POSE_SIZE], own[HL_POSE_SIZE * HL_POSE_SIZE];
    hl_arrow_view_step(&s.view[v], N, by, pose);
    hl_spd_inverse(&s.view[v].factor, own);
    for (int i = 0; i < HL_POSE_SIZE; i++) {
      assert_near(pose[i], step[at + i], 1e-7 * sqrt(inverse[at + i][at + i]));
      /* Cov(pose) = B^-1 + G Cov(theta) G', Cov(pose, theta) = G Cov(theta) */
      for (int k = 0; k < HL_POSE_SIZE; k++) {
        double sum = own[i * HL_POSE_SIZE + k];
        for (int a = 0; a < N; a++)
          for (int b = 0; b < N; b++)
            sum += s.view[v].w[a][i] * covariance[a * N + b] * s.view[v].w[b][k];
        assert_near(sum, inverse[at + i][at + k],
                    1e-7 * sqrt(inverse[at + i][at + i] * inverse[at + k][at + k]));
      }
      for (int k = 0; k < N; k++) {
        double sum = 0;
        for (int a = 0; a < N; a++)
          sum -= s.view[v].w[a][i] * covariance[a * N + k];
        assert_near(sum, inverse[at + i][k], 1e-7 * sqrt(inverse[at + i][at + i] * inverse[k][k]));
      }
    }
  }
}

/* The pulls of all views are the right-hand side of the intrinsics' step. */
static void test_pulls(void **state)
{
  (void)state;
  static scene s;
  double by[HL_INTRINSICS_MAX], sum[HL_INTRINSICS_MAX] = {0};
  hl_arrow_fault fault;
  fill(&s, NULL);
  assert_true(hl_arrow_factor(&s.arrow, s.active, VIEWS, 0, &fault));
  hl_arrow_step(&s.arrow, s.active, VIEWS, by);
  for (int v = 0; v < VIEWS; v++) {
    double pull[HL_INTRINSICS_MAX];
    hl_arrow_view_pull(&s.view[v], N, pull);
    for (int i = 0; i < N; i++)
      sum[i] += pull[i];
  }
  hl_spd_solve(&s.arrow.schur, sum, sum);
  for (int i = 0; i < N; i++)
    assert_near(sum[i] / by[i], 1, 1e-7);
}

static void test_order_of_rows(void **state)
{
  (void)state;
  static scene a, b;
  int order[ROWS];
  double one[HL_INTRINSICS_MAX], two[HL_INTRINSICS_MAX];
  hl_arrow_fault fault;
  for (int i = 0; i < ROWS; i++)
    order[i] = (7 * i + 3) % ROWS;
  fill(&a, NULL);
  fill(&b, order);
  assert_true(hl_arrow_factor(&a.arrow, a.active, VIEWS, 0, &fault));
  assert_true(hl_arrow_factor(&b.arrow, b.active, VIEWS, 0, &fault));
  hl_arrow_step(&a.arrow, a.active, VIEWS, one);
  hl_arrow_step(&b.arrow, b.active, VIEWS, two);
  for (int i = 0; i < N; i++)
    assert_near(two[i] / one[i], 1, 1e-8);
}

static void test_faults(void **state)
{
  (void)state;
  static scene s;
  hl_arrow_fault fault;
  fill(&s, NULL);
  for (int i = 0; i < HL_POSE_SIZE; i++) /* the second view says nothing about unknown 4 */
    s.view[1].b[4 * HL_POSE_SIZE + i] = s.view[1].b[i * HL_POSE_SIZE + 4] = 0;
  assert_false(hl_arrow_factor(&s.arrow, s.active, VIEWS, 0, &fault));
  assert_int_equal(fault.view, 1);
  assert_int_equal(fault.unknown, 4);
  fill(&s, NULL);
  for (int v = 0; v < VIEWS; v++) /* nothing is left of intrinsic 2 */
    memset(s.view[v].e[2], 0, sizeof s.view[v].e[2]);
  for (int i = 0; i < N; i++)
    s.arrow.a[2 * N + i] = s.arrow.a[i * N + 2] = 0;
  assert_false(hl_arrow_factor(&s.arrow, s.active, VIEWS, 0, &fault));
  assert_int_equal(fault.view, -1);
  assert_int_equal(fault.unknown, 2);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_against_full),
      cmocka_unit_test(test_pulls),
      cmocka_unit_test(test_order_of_rows),
      cmocka_unit_test(test_faults),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
