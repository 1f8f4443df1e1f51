/* Joint refinement: from a few degrees off to the minimum, and what it says of it. */
#include "ridge_scene.h"

typedef struct fixture {
  hl_spline spline;
  hl_ridge_fit fit;
  hl_refine_work work;
  hl_ridge_data data;
  double truth[2][3];
} fixture;

static double curve(double t)
{
  return t > 0 ? 1 - pow(1 - t, 1.5) : 0; /* cubic in the chord */
}

static fixture *fixture_new(void)
{
  fixture *f = calloc(1, sizeof *f);
  const double a[2][3] = {{0.4, 0.1, 0.9}, {-0.3, 0.5, 0.8}};
  assert_non_null(f);
  f->spline = ridge_spline(14, sqrt(2.0));
  f->fit.ridges.n = f->fit.axes.n = 2;
  f->data = ridge_samples(1200, 1, false, 5);
  for (int k = 0; k < 2; k++) {
    hl_unit(a[k], f->truth[k]);
    f->fit.ridges.spline[k] = &f->spline;
    f->fit.ridges.smooth[k] = 1e-12;
    f->fit.axes.axis[k] = ridge_axis(HL_AXIS_FREE, a[k][0] + 0.06, a[k][1] - 0.05, a[k][2]);
  }
  for (int i = 0; i < f->data.n; i++) {
    const double m[3] = {f->data.normal[0][i], f->data.normal[1][i], f->data.normal[2][i]};
    f->data.y[0][i] = curve(hl_dot(m, f->truth[0])) + 0.6 * curve(hl_dot(m, f->truth[1]));
  }
  return f;
}

static void fixture_free(fixture *f)
{
  ridge_samples_free(&f->data);
  free(f);
}

static void test_the_minimum_is_found(void **state)
{
  (void)state;
  fixture *f = fixture_new();
  hl_ridge_refine(&f->data, 60, 1e-12, 1, &f->work, &f->fit);
  for (int k = 0; k < 2; k++)
    assert_near(hl_angle(f->fit.axes.axis[k].a, f->truth[k]), 0, 1e-8);
  assert_true(f->fit.converged);
  fixture_free(f);
}

static void test_cost_never_rises(void **state)
{
  (void)state;
  fixture *f = fixture_new();
  double before = HUGE_VAL;
  for (int round = 0; round < 12; round++) {
    hl_ridge_refine(&f->data, 1, 1e-12, 1, &f->work, &f->fit);
    assert_true(f->fit.curves.cost <= before * (1 + 1e-9) + 1e-9);
    before = f->fit.curves.cost;
  }
  fixture_free(f);
}

/* Half the slope of the cost with the curves refitted is the one with them held. */
static void test_the_profiled_slope(void **state)
{
  (void)state;
  fixture *f = fixture_new();
  hl_roughness roughness;
  hl_ridge_slopes *s = &f->work.slopes;
  hl_ridge_settle(&f->data, false, 1, &f->work, &f->fit);
  hl_roughness_from(&f->fit.ridges, &f->work.gram, &roughness);
  hl_ridges_slopes(&f->fit.ridges, &f->fit.axes, &f->data,
                   (const double(*)[HL_GRAM_MAX])f->fit.curves.x, 1, &f->work.ridge, s);
  for (int k = 0; k < s->q; k++) {
    double cost[2];
    for (int side = 0; side < 2; side++) {
      double delta[HL_AXES_MAX] = {0};
      hl_axes moved;
      delta[k] = side == 0 ? -1e-5 : 1e-5;
      hl_axes_move(&f->fit.axes, delta, f->data.mean_view, &moved);
      f->work.trial = f->fit.curves;
      hl_ridges_gram(&f->fit.ridges, &moved, &f->data, 1, &f->work.ridge, &f->work.gram);
      hl_curves_solve(&f->fit.ridges, &f->work.gram, &roughness, &f->work.curves, &f->work.trial);
      cost[side] = f->work.trial.cost;
    }
    assert_near(s->gradient[k], -0.5 * (cost[1] - cost[0]) / 2e-5,
                1e-4 * fabs(s->gradient[k]) + 1e-6);
  }
  fixture_free(f);
}

/* Nothing is sought: the curves alone. */
static void test_fixed_directions_converge_at_once(void **state)
{
  (void)state;
  fixture *f = fixture_new();
  for (int k = 0; k < 2; k++)
    f->fit.axes.axis[k] = ridge_axis(HL_AXIS_FIXED, f->truth[k][0], f->truth[k][1], f->truth[k][2]);
  hl_ridge_refine(&f->data, 10, 1e-9, 1, &f->work, &f->fit);
  assert_true(f->fit.converged);
  assert_int_equal(f->fit.iterations, 0);
  assert_near(f->fit.curves.misfit, 0, 1e-9);
  fixture_free(f);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_the_minimum_is_found),
      cmocka_unit_test(test_cost_never_rises),
      cmocka_unit_test(test_the_profiled_slope),
      cmocka_unit_test(test_fixed_directions_converge_at_once),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
