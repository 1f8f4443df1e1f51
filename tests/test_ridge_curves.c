/* Curves of a sum of ridges: constraints, smoothing, and that held unknowns are rightly held. */
#include "ridge_scene.h"

#include "../src/ridge_rows.h"

typedef struct fixture {
  hl_spline spline;
  hl_ridge_fit fit;
  hl_refine_work work;
  hl_ridge_data data;
} fixture;

/* Two plain lobes; data fill(t1, t2, noise). */
static fixture *fixture_new(int n, double (*fill)(double, double), double noise)
{
  fixture *f = calloc(1, sizeof *f);
  test_random r = {11};
  assert_non_null(f);
  f->spline = ridge_spline(16, sqrt(2.0));
  f->fit.ridges.n = f->fit.axes.n = 2;
  for (int i = 0; i < 2; i++) {
    f->fit.ridges.spline[i] = &f->spline;
    f->fit.ridges.smooth[i] = 1e-6;
  }
  f->fit.axes.axis[0] = ridge_axis(HL_AXIS_FIXED, 0.3, 0.2, 0.9);
  f->fit.axes.axis[1] = ridge_axis(HL_AXIS_FIXED, -0.3, 0.4, 0.8);
  f->data = ridge_samples(n, 1, false, 3);
  for (int i = 0; i < n; i++) {
    const double m[3] = {f->data.normal[0][i], f->data.normal[1][i], f->data.normal[2][i]};
    f->data.y[0][i] = fill(hl_dot(m, f->fit.axes.axis[0].a), hl_dot(m, f->fit.axes.axis[1].a)) +
                      noise * random_normal(&r);
  }
  return f;
}

static void fixture_free(fixture *f)
{
  ridge_samples_free(&f->data);
  free(f);
}

static double hill(double a, double b)
{
  return pow(fmax(0, a), 12) + 0.5 * fmax(0, b);
}

/* Falls where it should rise. */
static double valley(double a, double b)
{
  return 1 - fmax(0, a) + 0.3 * sin(9 * b);
}

/* L2 to L4 of a curve, with Fritsch and Carlson's conditions on every interval of the spline, in the
 * chord: with slopes m at both ends and the secant D, (m0, m1)/D lies in their region M. */
static void assert_physical(const hl_ridges *r, int term, const double *x)
{
  const hl_spline *s = r->spline[term];
  const double *c = x + hl_ridges_first(r, term);
  double before = -1;
  for (int i = 0; i <= 2000; i++) {
    const double value = hl_ridge_value(r, term, x, i / 2000.0);
    assert_true(value >= 0);
    assert_true(value >= before - 1e-12);
    before = value;
  }
  assert_near(hl_ridge_value(r, term, x, 0), 0, 0);
  assert_near(hl_ridge_value(r, term, x, -0.3), 0, 0);
  for (int i = 0; i < s->intervals; i++) {
    const double left = s->left[i], right = i + 1 < s->intervals ? s->left[i + 1] : s->high;
    double value[2] = {0}, slope[2] = {0};
    for (int end = 0; end < 2; end++) {
      double b[4], d[4];
      const double u = end == 0 ? left : right;
      const double p = u - left;
      for (int k = 0; k < 4; k++) {
        const double(*q)[4] = s->poly[i];
        b[k] = q[0][k] + p * (q[1][k] + p * (q[2][k] + p * q[3][k]));
      }
      hl_spline_slopes(s, i, u, d);
      for (int k = 0; k < 4; k++) {
        value[end] += b[k] * c[i + k];
        slope[end] += d[k] * c[i + k];
      }
    }
    const double secant = (value[1] - value[0]) / (right - left);
    const double tiny = 1e-9 * fabs(c[0]);
    assert_true(slope[0] <= tiny && slope[1] <= tiny && secant <= tiny);
    if (secant > -tiny)
      continue;
    const double a = slope[0] / secant, b = slope[1] / secant;
    const double phi = a - (2 * a + b - 3) * (2 * a + b - 3) / (3 * (a + b - 2));
    assert_true(a + b - 2 <= 1e-6 || 2 * a + b - 3 <= 1e-6 || a + 2 * b - 3 <= 1e-6 ||
                phi >= -1e-6);
  }
}

static void test_curves_are_physical(void **state)
{
  (void)state;
  double (*const fills[])(double, double) = {hill, valley};
  for (int k = 0; k < 2; k++) {
    fixture *f = fixture_new(1500, fills[k], 0.05);
    hl_ridge_settle(&f->data, true, 1, &f->work, &f->fit);
    for (int i = 0; i < 2; i++)
      assert_physical(&f->fit.ridges, i, f->fit.curves.x[0]);
    fixture_free(f);
  }
}

/* Wolberg and Alfy's penalty is on jumps of the second derivative: there are none. */
static void test_curves_have_a_continuous_second_derivative(void **state)
{
  (void)state;
  fixture *f = fixture_new(1500, hill, 0.05);
  hl_ridge_settle(&f->data, true, 1, &f->work, &f->fit);
  const hl_spline *s = &f->spline;
  const double *c = f->fit.curves.x[0];
  for (int i = 0; i + 1 < s->intervals; i++) {
    const double h = s->left[i + 1] - s->left[i];
    double before = 0, after = 0, scale = 0;
    for (int k = 0; k < 4; k++) {
      before += (2 * s->poly[i][2][k] + 6 * h * s->poly[i][3][k]) * c[i + k];
      after += 2 * s->poly[i + 1][2][k] * c[i + 1 + k];
      scale +=
          fabs(2 * s->poly[i][2][k] * c[i + k]) + fabs(2 * s->poly[i + 1][2][k] * c[i + 1 + k]);
    }
    assert_near(after, before, 1e-9 * scale + 1e-12);
  }
  fixture_free(f);
}

static void test_free_curves_follow_the_data(void **state)
{
  (void)state;
  fixture *f = fixture_new(1500, valley, 0);
  f->spline = ridge_spline(20, 2);
  hl_ridge_settle(&f->data, true, 1, &f->work, &f->fit);
  const double held = f->fit.curves.misfit;
  f->fit.ridges.free_curves = true;
  hl_curves_forget(&f->fit.curves);
  hl_ridge_settle(&f->data, true, 1, &f->work, &f->fit);
  assert_true(f->fit.curves.misfit < 1e-4 * held);
  fixture_free(f);
}

/* A start from elsewhere comes to the same curves. */
static void test_the_start_does_not_matter(void **state)
{
  (void)state;
  fixture *f = fixture_new(1500, valley, 0.1), *g = fixture_new(1500, valley, 0.1);
  hl_ridge_settle(&f->data, false, 1, &f->work, &f->fit);
  for (int i = 0; i < 16; i++) {
    g->fit.curves.d[0][i] = i % 3;
    g->fit.curves.is_free[0][i] = i % 3 > 0;
  }
  hl_ridge_settle(&g->data, false, 1, &g->work, &g->fit);
  for (int i = 0; i < hl_ridges_columns(&f->fit.ridges); i++)
    assert_near(g->fit.curves.x[0][i], f->fit.curves.x[0][i], 1e-7);
  fixture_free(f);
  fixture_free(g);
}

/* Straight in t costs no roughness: as smooth as can be, Lambert's curve is still fitted. */
static double lambert(double a, double b)
{
  return fmax(0, a) + 2 * fmax(0, b);
}

static void test_lambert_is_not_rough(void **state)
{
  (void)state;
  fixture *f = fixture_new(800, lambert, 0);
  for (int i = 0; i < 2; i++)
    f->fit.ridges.smooth[i] = 100;
  hl_ridge_settle(&f->data, false, 1, &f->work, &f->fit);
  assert_near(f->fit.curves.cost, 0, 1e-9);
  fixture_free(f);
}

/* Generalized cross-validation: noise asks for more smoothing, and the curve it picks is nearer the truth
 * than much less or much more. */
static double off_truth(fixture *f)
{
  double sum = 0;
  hl_ridge_pass pass;
  hl_ridge_rows rows;
  hl_ridge_pass_begin(&f->fit.ridges, &f->fit.axes, &f->data, &pass);
  for (int i = 0; i < f->data.n; i++) {
    double out[HL_RIDGE_CHUNK];
    hl_ridge_rows_at(&pass, i, 1, false, &rows);
    hl_ridge_rows_predict(&pass, &rows, f->fit.curves.x[0], out);
    const double off = out[0] - hill(rows.term[0].t[0], rows.term[1].t[0]);
    sum += off * off;
  }
  return sqrt(sum / f->data.n);
}

static void test_smoothing_follows_the_noise(void **state)
{
  (void)state;
  double chosen[2], off[3];
  for (int k = 0; k < 2; k++) {
    fixture *f = fixture_new(300, hill, k == 0 ? 1e-4 : 0.2);
    f->spline = ridge_spline(24, 2);
    f->fit.ridges.free_curves = true; /* monotone ones are held together already */
    hl_ridge_settle(&f->data, true, 1, &f->work, &f->fit);
    chosen[k] = f->fit.ridges.smooth[0];
    if (k == 1)
      for (int j = 0; j < 3; j++) {
        static const double factor[] = {1, 1e-6, 1e5};
        for (int i = 0; i < 2; i++)
          f->fit.ridges.smooth[i] = chosen[1] * factor[j];
        hl_curves_forget(&f->fit.curves);
        hl_ridge_settle(&f->data, false, 1, &f->work, &f->fit);
        off[j] = off_truth(f);
      }
    fixture_free(f);
  }
  assert_true(chosen[1] > 10 * chosen[0]);
  assert_true(off[0] < off[1]);
  assert_true(off[0] < off[2]);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_curves_are_physical),
      cmocka_unit_test(test_curves_have_a_continuous_second_derivative),
      cmocka_unit_test(test_free_curves_follow_the_data),
      cmocka_unit_test(test_the_start_does_not_matter),
      cmocka_unit_test(test_lambert_is_not_rough),
      cmocka_unit_test(test_smoothing_follows_the_noise),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
