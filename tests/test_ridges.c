/* Sums of ridges: rows against the plain formula, slopes against finite differences. */
#include "ridge_scene.h"

#include "../src/ridge_rows.h"

/* The three ways to look for directions. */
static hl_axes axes_of(int kind)
{
  hl_axes axes = {.n = 3, .light = {0.5, 0.3, 0.8}};
  hl_unit(axes.light, axes.light);
  if (kind == 0) {
    axes.axis[0] = ridge_axis(HL_AXIS_FREE, 0.5, 0.3, 0.9);
    axes.axis[1] = ridge_axis(HL_AXIS_FREE, 0.2, 0.1, 0.9);
    axes.axis[2] = ridge_axis(HL_AXIS_FIXED, -0.3, 0.2, 0.8);
  } else if (kind == 1) {
    axes.seeks_light = true;
    axes.axis[0] = ridge_axis(HL_AXIS_NAMED, 1, 0, 0);
    axes.axis[1] = ridge_axis(HL_AXIS_NAMED, 1, 1, 0);
    axes.axis[2] = ridge_axis(HL_AXIS_FREE, -0.3, 0.2, 0.8);
  } else {
    axes.axis[0] = ridge_axis(HL_AXIS_NAMED, 1, 0, 0);
    axes.axis[1] = ridge_axis(HL_AXIS_PLANE, 0.6, 0.8, 0);
    axes.axis[2] = ridge_axis(HL_AXIS_PLANE, 0.96, -0.28, 0);
  }
  return axes;
}

static double predicted(const hl_ridges *r, const hl_axes *axes, const hl_ridge_data *d,
                        const double *x, int i)
{
  hl_ridge_pass pass;
  hl_ridge_rows rows;
  double out[HL_RIDGE_CHUNK];
  hl_ridge_pass_begin(r, axes, d, &pass);
  hl_ridge_rows_at(&pass, i, 1, false, &rows);
  hl_ridge_rows_predict(&pass, &rows, x, out);
  return out[0];
}

static void test_rows_are_the_model(void **state)
{
  (void)state;
  const hl_spline spline = ridge_spline(10, sqrt(2.0));
  const hl_ridges model = ridge_model(&spline);
  for (int views = 0; views < 2; views++)
    for (int kind = 0; kind < 3; kind++) {
      hl_ridge_data d = ridge_samples(50, 1, views == 1, 5);
      hl_axes axes = axes_of(kind);
      double x[HL_GRAM_MAX];
      for (int i = 0; i < hl_ridges_columns(&model); i++)
        x[i] = sin(i);
      hl_axes_settle(&axes, d.mean_view);
      for (int i = 0; i < d.n; i++) {
        const double n[3] = {d.normal[0][i], d.normal[1][i], d.normal[2][i]};
        double v[3] = {0, 0, 1}, sum = 0;
        for (int k = 0; k < 3 && views; k++)
          v[k] = d.view[k][i];
        for (int j = 0; j < 3; j++) {
          const hl_axis *axis = &axes.axis[j];
          double a[3];
          for (int k = 0; k < 3; k++)
            a[k] = kind == 0 || (kind == 1 && j == 2) ? axis->a[k]
                                                      : axis->cs * axes.light[k] + axis->cv * v[k];
          hl_unit(a, a);
          sum += (j == 1 ? 1 / hl_dot(n, v) : 1) * hl_ridge_value(&model, j, x, hl_dot(n, a));
        }
        assert_near(predicted(&model, &axes, &d, x, i), sum, 1e-9);
      }
      ridge_samples_free(&d);
    }
}

/* Half the slope of r'Wr, and the matrices, by central differences. */
static void test_slopes_are_those_of_the_cost(void **state)
{
  (void)state;
  const hl_spline spline = ridge_spline(10, sqrt(2.0));
  const hl_ridges model = ridge_model(&spline);
  hl_ridge_work *work = calloc(1, sizeof *work);
  hl_ridge_slopes *s = calloc(1, sizeof *s), *t = calloc(1, sizeof *t);
  assert_true(work && s && t);
  for (int views = 0; views < 2; views++)
    for (int kind = 0; kind < 3; kind++) {
      hl_ridge_data d = ridge_samples(3000, 3, views == 1, 6);
      hl_axes axes = axes_of(kind);
      double x[HL_CHANNELS_MAX][HL_GRAM_MAX];
      for (int c = 0; c < 3; c++)
        for (int i = 0; i < hl_ridges_columns(&model); i++)
          x[c][i] = cos(0.3 * i + c);
      hl_axes_settle(&axes, d.mean_view);
      hl_ridges_slopes(&model, &axes, &d, (const double(*)[HL_GRAM_MAX])x, 1, work, s);
      assert_int_equal(s->q, hl_axes_parameters(&axes));
      for (int k = 0; k < s->q; k++) {
        const double step = 1e-5;
        double cost[2];
        for (int side = 0; side < 2; side++) {
          double delta[HL_AXES_MAX] = {0};
          hl_axes moved;
          delta[k] = side == 0 ? -step : step;
          hl_axes_move(&axes, delta, d.mean_view, &moved);
          hl_ridges_slopes(&model, &moved, &d, (const double(*)[HL_GRAM_MAX])x, 1, work, t);
          cost[side] = t->cost;
        }
        const double slope = -0.5 * (cost[1] - cost[0]) / (2 * step);
        assert_near(s->gradient[k], slope, 1e-5 * s->cost);
      }
      ridge_samples_free(&d);
    }
  free(work);
  free(s);
  free(t);
}

/* D'WX and D'WD: from predictions moved by a small step, sample by sample. */
static void test_products_of_slopes(void **state)
{
  (void)state;
  const hl_spline spline = ridge_spline(8, sqrt(2.0));
  const hl_ridges model = ridge_model(&spline);
  hl_ridge_work *work = calloc(1, sizeof *work);
  hl_ridge_slopes *s = calloc(1, sizeof *s);
  assert_true(work && s);
  hl_ridge_data d = ridge_samples(300, 1, false, 7);
  hl_axes axes = axes_of(0);
  double x[1][HL_GRAM_MAX];
  const int columns = hl_ridges_columns(&model);
  for (int i = 0; i < columns; i++)
    x[0][i] = cos(0.3 * i);
  hl_ridges_slopes(&model, &axes, &d, (const double(*)[HL_GRAM_MAX])x, 1, work, s);
  double inner[HL_AXES_MAX][HL_AXES_MAX] = {{0}}, cross[HL_AXES_MAX][HL_GRAM_MAX] = {{0}};
  for (int i = 0; i < d.n; i++) {
    double by[HL_AXES_MAX];
    for (int k = 0; k < s->q; k++) {
      double value[2];
      for (int side = 0; side < 2; side++) {
        double delta[HL_AXES_MAX] = {0};
        hl_axes moved;
        delta[k] = side == 0 ? -1e-5 : 1e-5;
        hl_axes_move(&axes, delta, d.mean_view, &moved);
        value[side] = predicted(&model, &moved, &d, x[0], i);
      }
      by[k] = (value[1] - value[0]) / 2e-5;
    }
    for (int k = 0; k < s->q; k++) {
      for (int l = 0; l < s->q; l++)
        inner[k][l] += d.w[i] * by[k] * by[l];
      for (int j = 0; j < columns; j++) {
        double unit[HL_GRAM_MAX] = {0};
        unit[j] = 1;
        cross[k][j] += d.w[i] * by[k] * predicted(&model, &axes, &d, unit, i);
      }
    }
  }
  for (int k = 0; k < s->q; k++) {
    for (int l = 0; l < s->q; l++)
      assert_near(s->inner[k][l], inner[k][l], 1e-5 * inner[k][k]);
    for (int j = 0; j < columns; j++)
      assert_near(s->cross[0][k][j], cross[k][j], 1e-5 * inner[k][k] + 1e-4);
  }
  ridge_samples_free(&d);
  free(work);
  free(s);
}

static void test_threads_do_not_change_a_bit(void **state)
{
  (void)state;
  const hl_spline spline = ridge_spline(12, sqrt(2.0));
  const hl_ridges model = ridge_model(&spline);
  hl_ridge_work *work = calloc(1, sizeof *work);
  hl_gram *one = calloc(1, sizeof *one), *three = calloc(1, sizeof *three);
  assert_true(work && one && three);
  hl_ridge_data d = ridge_samples(20000, 3, false, 8);
  const hl_axes axes = axes_of(0);
  hl_ridges_gram(&model, &axes, &d, 1, work, one);
  hl_ridges_gram(&model, &axes, &d, 3, work, three);
  assert_memory_equal(one->a, three->a, sizeof(double) * (size_t)(one->n * one->n));
  assert_memory_equal(one->b, three->b, sizeof one->b[0] * 3);
  ridge_samples_free(&d);
  free(work);
  free(one);
  free(three);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_rows_are_the_model),
      cmocka_unit_test(test_slopes_are_those_of_the_cost),
      cmocka_unit_test(test_products_of_slopes),
      cmocka_unit_test(test_threads_do_not_change_a_bit),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
