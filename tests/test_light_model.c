/* The light model's rows: slopes against differences, and sums that do not depend on threads. */
#include <stdio.h>

#include "light_data.h"

typedef struct example {
  const char *name;
  hl_light_model model;
  double saturation;
  int channels;
} example;

static const example examples[] = {
    {"matte", {.body = 1}, 0, 1},
    {"plain", {.lobe = HL_LOBE_PLAIN, .has_lobe = true, .body = 1}, 0, 1},
    {"foreshortened", {.lobe = HL_LOBE_FORESHORTENED, .has_lobe = true, .body = 1}, 0, 1},
    {"masking",
     {.lobe = HL_LOBE_FORESHORTENED, .has_lobe = true, .masking = true, .body = 1},
     0,
     1},
    {"further body columns",
     {.lobe = HL_LOBE_PLAIN, .has_lobe = true, .masking = true, .body = 3},
     0,
     1},
    {"ambient", {.lobe = HL_LOBE_PLAIN, .has_lobe = true, .body = 1, .ambient = true}, 0, 1},
    {"clipped", {.lobe = HL_LOBE_PLAIN, .has_lobe = true, .body = 1}, 0.6, 1},
    {"all of it, in colour",
     {.lobe = HL_LOBE_FORESHORTENED, .has_lobe = true, .masking = true, .body = 3, .ambient = true},
     0.6,
     3},
    {"near", {.lobe = HL_LOBE_PLAIN, .has_lobe = true, .body = 1, .near = true}, 0, 1},
    {"near, matte", {.body = 1, .near = true}, 0, 1},
    {"backscatter",
     {.lobe = HL_LOBE_PLAIN, .has_lobe = true, .body = 1, .backscatter = true},
     0,
     1},
    {"near and all of it",
     {.lobe = HL_LOBE_FORESHORTENED,
      .has_lobe = true,
      .masking = true,
      .body = 3,
      .ambient = true,
      .backscatter = true,
      .near = true},
     0.6,
     3},
};
enum { EXAMPLES = sizeof examples / sizeof *examples };
static const double exponent = 0.4, nearness = 0.15;

typedef struct setup {
  const example *of;
  lit_data data;
  hl_light_model model;
  double s[3], exponent, nearness;
} setup;

/* Looked at 3 degrees off the light, so that residuals do not vanish. */
static setup setup_of(const example *e)
{
  test_random random = {77};
  lit_scene scene = lit_glossy();
  scene.lobe = e->model.lobe == HL_LOBE_FORESHORTENED ? LIT_FORESHORTENED : LIT_PLAIN;
  scene.width = 0.3;
  scene.noise = 0.01;
  scene.ambient = 0.05;
  scene.saturation = e->saturation;
  scene.channels = e->channels;
  scene.gloss[1] = 0.5;
  scene.body[2] = 0.1;
  setup out = {.of = e, .data = lit_gather(&scene, &random), .model = e->model};
  out.exponent = e->model.masking ? exponent : 0;
  out.nearness = e->model.near ? nearness : 0;
  lit_direction(48, -62, out.s);
  hl_light_breaks(&out.data.work->all, out.s, 20, 6, &out.model.spline);
  return out;
}

static hl_model_point fit_at(setup *u, const double s[3], double at_exponent, int threads)
{
  hl_model_point point;
  memset(&point, 0, sizeof point);
  hl_light_work *w = u->data.work;
  assert_int_equal(hl_model_fit_near(&u->model, &w->all, s, at_exponent, u->nearness, threads,
                                     &w->model, &point),
                   0);
  return point;
}

static bool is_nearness(const hl_light_model *model, int k)
{
  return model->near && k == hl_model_nearness(model);
}

static double cost_at(setup *u, const hl_model_point *from, int k, double step)
{
  double s[3];
  lit_moved(from, k == 0 ? step : 0, k == 1 ? step : 0, s);
  setup moved = *u;
  const bool by_nearness = is_nearness(&u->model, k);
  moved.nearness += by_nearness ? step : 0;
  return fit_at(&moved, s, u->exponent + (k == 2 && !by_nearness ? step : 0), 1).cost;
}

/* d cost = -2 D'W r by the envelope theorem: the curves are at their best. */
static void gradient_matches(const example *e)
{
  setup u = setup_of(e);
  hl_light_work *w = u.data.work;
  hl_model_step step;
  w->model.keep_smoothing = false;
  const hl_model_point at = fit_at(&u, u.s, u.exponent, 1);
  w->model.keep_smoothing = true;
  hl_model_differentiate(&u.model, &w->all, &at, 1, &w->model, &step);
  double size = 0;
  for (int k = 0; k < hl_model_nonlinear(&u.model); k++)
    size = fmax(size, fabs(2 * step.gradient[k]));
  assert_true(size > 1);
  for (int k = 0; k < hl_model_nonlinear(&u.model); k++) {
    const double h = 1e-5;
    const double slope = (cost_at(&u, &at, k, h) - cost_at(&u, &at, k, -h)) / (2 * h);
    if (!is_near(-2 * step.gradient[k], slope, 2e-5 * size))
      print_error("%s, coordinate %d\n", e->name, k);
    assert_near(-2 * step.gradient[k], slope, 2e-5 * size);
  }
  lit_data_free(&u.data);
}

static void test_gradient_of_the_profiled_cost(void **state)
{
  (void)state;
  for (int i = 0; i < EXAMPLES; i++)
    gradient_matches(&examples[i]);
}

/* A pixel whose prediction has a corner within the step: the shadow's edge, the end of masking. */
static bool has_corner(const setup *u, int i, double step)
{
  const hl_light_data *d = &u->data.work->all;
  const double n[3] = {d->normal[0][i], d->normal[1][i], d->normal[2][i]};
  double toward[3];
  hl_add_scaled(u->s, -u->nearness, n, toward);
  const double nl = hl_dot(n, toward) / hl_norm(toward), w = d->footprint[i];
  return fabs(nl + w / 2) < 2 * step || fabs(nl - w / 2) < 2 * step || fabs(nl - 0.01) < 2 * step;
}

static void slopes_match(const example *e)
{
  setup u = setup_of(e);
  hl_light_work *w = u.data.work;
  const int n = w->all.n;
  const double h = 1e-6;
  w->model.keep_smoothing = false;
  const hl_model_point at = fit_at(&u, u.s, u.exponent, 1);
  hl_model_pixel *here = calloc((size_t)n, sizeof *here), *low = calloc((size_t)n, sizeof *low),
                 *high = calloc((size_t)n, sizeof *high);
  assert_true(here && low && high);
  for (int c = 0; c < e->channels; c++)
    for (int k = 0; k < hl_model_nonlinear(&u.model); k++) {
      hl_model_point moved = at;
      int compared = 0;
      hl_model_predict(&u.model, &w->all, &at, NULL, 0, n, c, here);
      lit_moved(&at, k == 0 ? h : 0, k == 1 ? h : 0, moved.s);
      const bool by_nearness = is_nearness(&u.model, k);
      const double bend = k == 2 && !by_nearness ? h : 0, nearer = by_nearness ? h : 0;
      moved.exponent = at.exponent + bend;
      moved.nearness = at.nearness + nearer;
      hl_model_predict(&u.model, &w->all, &moved, NULL, 0, n, c, high);
      lit_moved(&at, k == 0 ? -h : 0, k == 1 ? -h : 0, moved.s);
      moved.exponent = at.exponent - bend;
      moved.nearness = at.nearness - nearer;
      hl_model_predict(&u.model, &w->all, &moved, NULL, 0, n, c, low);
      for (int i = 0; i < n; i++) {
        const double slope = (high[i].value - low[i].value) / (2 * h);
        if (has_corner(&u, i, h))
          continue;
        compared++;
        if (!is_near(here[i].slope[k], slope, 1e-5 * (1 + fabs(slope))))
          print_error("%s, channel %d, coordinate %d, pixel %d\n", e->name, c, k, i);
        assert_near(here[i].slope[k], slope, 1e-5 * (1 + fabs(slope)));
        assert_near(here[i].profiled[k], here[i].slope[k], 0);
      }
      assert_true(compared > 9 * n / 10);
    }
  free(here);
  free(low);
  free(high);
  lit_data_free(&u.data);
}

static void test_slopes_of_the_prediction(void **state)
{
  (void)state;
  for (int i = 0; i < EXAMPLES; i++)
    slopes_match(&examples[i]);
}

/* Profiled slopes are what is left of D beside the columns: their products are the Gauss-Newton
 * matrix, and with the residual they give the same gradient, which the columns cannot. */
static void profiled_slopes_match(const example *e)
{
  setup u = setup_of(e);
  hl_light_work *w = u.data.work;
  const hl_light_data *d = &w->all;
  const int q = hl_model_nonlinear(&u.model);
  hl_model_step step;
  double hessian[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX] = {{0}}, gradient[HL_NONLINEAR_MAX] = {0};
  double cost = 0;
  w->model.keep_smoothing = false;
  const hl_model_point at = fit_at(&u, u.s, u.exponent, 1);
  hl_model_differentiate(&u.model, d, &at, 1, &w->model, &step);
  for (int c = 0; c < e->channels; c++) {
    hl_model_predict(&u.model, d, &at, step.solved, 0, d->n, c, w->fit);
    for (int i = 0; i < d->n; i++) {
      const hl_model_pixel *f = &w->fit[i];
      const double r = d->value[c][i] - f->value, weight = d->weight[c][i];
      if ((d->clipped[i] >> c & 1) && !(r > 0))
        continue;
      cost += weight * r * r;
      for (int a = 0; a < q; a++) {
        gradient[a] += weight * r * f->profiled[a];
        for (int b = 0; b < q; b++)
          hessian[a][b] += weight * f->profiled[a] * f->profiled[b];
      }
    }
  }
  /* The cost of a fit counts its smoothing too, a millionth of the weights. */
  assert_near(step.cost, cost, 1e-9 * cost);
  assert_near(at.cost, cost, 1e-3 * cost);
  assert_true(at.cost >= cost * (1 - 1e-9));
  for (int a = 0; a < q; a++)
    for (int b = 0; b < q; b++) {
      const double size = sqrt(hessian[a][a] * hessian[b][b]);
      if (!is_near(step.hessian[a][b], hessian[a][b], 2e-3 * size))
        print_error("%s, coordinates %d and %d\n", e->name, a, b);
      assert_near(step.hessian[a][b], hessian[a][b], 2e-3 * size);
      assert_near(step.hessian[a][b], step.hessian[b][a], 1e-12 * size);
    }
  for (int a = 0; a < q; a++)
    assert_near(gradient[a], step.gradient[a], 2e-3 * sqrt(hessian[a][a] * cost));
  lit_data_free(&u.data);
}

static void test_profiled_slopes_make_the_system(void **state)
{
  (void)state;
  for (int i = 0; i < EXAMPLES; i++)
    profiled_slopes_match(&examples[i]);
}

/* At the best curves no small change of any coefficient lowers the cost: sums by hand. */
static void test_curves_are_the_best(void **state)
{
  (void)state;
  setup u = setup_of(&examples[6]); /* clipped samples pull on one side only */
  hl_light_work *w = u.data.work;
  const hl_light_data *d = &w->all;
  w->model.keep_smoothing = false;
  const hl_model_point at = fit_at(&u, u.s, u.exponent, 1);
  const int columns = u.model.spline.n + hl_model_border(&u.model);
  double best = 0;
  for (int j = -1; j < columns; j++)
    for (int sign = -1; sign <= (j < 0 ? -1 : 1); sign += 2) {
      hl_model_point other = at;
      double cost = 0;
      if (j >= 0)
        other.x[0][j] += sign * 0.01;
      hl_model_predict(&u.model, d, &other, NULL, 0, d->n, 0, w->fit);
      for (int i = 0; i < d->n; i++) {
        const double r = d->value[0][i] - w->fit[i].value;
        if (!(d->clipped[i] & 1) || r > 0)
          cost += d->weight[0][i] * r * r;
      }
      if (j < 0)
        best = cost;
      else
        assert_true(cost > best * (1 - 1e-6));
    }
  lit_data_free(&u.data);
}

/* Clipped pixels above the level cost nothing; were they data, they would cost much. */
static void test_clipped_samples_are_one_sided(void **state)
{
  (void)state;
  setup u = setup_of(&examples[6]);
  hl_light_work *w = u.data.work;
  w->model.keep_smoothing = false;
  const double censored = fit_at(&u, u.s, 0, 1).cost;
  assert_true(w->brightness.clipped > 50);
  memset(w->all.clipped, 0, (size_t)w->all.n);
  const double taken_as_data = fit_at(&u, u.s, 0, 1).cost;
  assert_true(censored < taken_as_data);
  lit_data_free(&u.data);
}

static void threads_agree(const example *e)
{
  static const int threads[] = {2, 3, 8};
  setup u = setup_of(e);
  hl_light_work *w = u.data.work;
  hl_model_step one;
  w->model.keep_smoothing = false;
  const hl_model_point at = fit_at(&u, u.s, u.exponent, 1);
  hl_model_differentiate(&u.model, &w->all, &at, 1, &w->model, &one);
  for (int i = 0; i < 3; i++) {
    hl_model_step many;
    const hl_model_point other = fit_at(&u, u.s, u.exponent, threads[i]);
    assert_memory_equal(&other.cost, &at.cost, sizeof at.cost);
    const int columns = (u.model.has_lobe ? u.model.spline.n : 0) + hl_model_border(&u.model);
    for (int c = 0; c < e->channels; c++)
      assert_memory_equal(other.x[c], at.x[c], sizeof(double) * (size_t)columns);
    hl_model_differentiate(&u.model, &w->all, &other, threads[i], &w->model, &many);
    assert_memory_equal(many.gradient, one.gradient, sizeof one.gradient);
    assert_memory_equal(many.hessian, one.hessian, sizeof one.hessian);
    assert_memory_equal(&many.cost, &one.cost, sizeof one.cost);
  }
  lit_data_free(&u.data);
}

static void test_threads_change_no_bit(void **state)
{
  (void)state;
  for (int i = 0; i < EXAMPLES; i++)
    threads_agree(&examples[i]);
}

/* In parts and at once: the same values. */
static void test_prediction_in_parts(void **state)
{
  (void)state;
  setup u = setup_of(&examples[EXAMPLES - 1]);
  hl_light_work *w = u.data.work;
  hl_model_pixel part[100];
  w->model.keep_smoothing = false;
  const hl_model_point at = fit_at(&u, u.s, u.exponent, 1);
  hl_model_predict(&u.model, &w->all, &at, NULL, 0, w->all.n, 1, w->fit);
  for (int first = 0; first + 100 <= w->all.n; first += 997) {
    hl_model_predict(&u.model, &w->all, &at, NULL, first, 100, 1, part);
    for (int i = 0; i < 100; i++) {
      assert_memory_equal(&part[i].value, &w->fit[first + i].value, sizeof part[i].value);
      assert_memory_equal(part[i].slope, w->fit[first + i].slope, sizeof part[i].slope);
    }
  }
  lit_data_free(&u.data);
}

/* A pixel that sees no light predicts nothing, or the ambient. */
static void test_shadow_predicts_the_ambient(void **state)
{
  (void)state;
  for (int ambient = 0; ambient < 2; ambient++) {
    setup u = setup_of(&examples[ambient ? 5 : 1]);
    hl_light_work *w = u.data.work;
    const hl_light_data *d = &w->all;
    int dark = 0;
    w->model.keep_smoothing = false;
    const hl_model_point at = fit_at(&u, u.s, 0, 1);
    const double want = ambient ? at.x[0][u.model.spline.n + 1] : 0;
    hl_model_predict(&u.model, d, &at, NULL, 0, d->n, 0, w->fit);
    for (int i = 0; i < d->n; i++) {
      const double n[3] = {d->normal[0][i], d->normal[1][i], d->normal[2][i]};
      if (hl_dot(n, u.s) < -d->footprint[i]) {
        assert_near(w->fit[i].value, want, 1e-15);
        dark++;
      }
    }
    assert_true(dark > 100);
    lit_data_free(&u.data);
  }
}

/* The mirrored problem: x, y and z of every vector turned about; nothing knows of the axes. */
static void test_rotation_changes_no_cost(void **state)
{
  (void)state;
  setup u = setup_of(&examples[3]);
  hl_light_work *w = u.data.work;
  w->model.keep_smoothing = false;
  const double before = fit_at(&u, u.s, u.exponent, 1).cost;
  for (int i = 0; i < w->all.n; i++) {
    double **both[2] = {w->all.normal, w->all.view};
    for (int b = 0; b < 2; b++) {
      const double x = both[b][0][i];
      both[b][0][i] = both[b][1][i];
      both[b][1][i] = -both[b][2][i];
      both[b][2][i] = -x;
    }
  }
  const double turned[3] = {u.s[1], -u.s[2], -u.s[0]};
  assert_near(fit_at(&u, turned, u.exponent, 1).cost, before, 1e-9 * before);
  lit_data_free(&u.data);
}

static void test_what_is_no_number_is_refused(void **state)
{
  (void)state;
  setup u = setup_of(&examples[1]);
  hl_light_work *w = u.data.work;
  hl_model_point point;
  w->model.keep_smoothing = false;
  w->all.value[0][w->ranked[0].index] = NAN;
  assert_int_equal(hl_model_fit(&u.model, &w->all, u.s, 0, 1, &w->model, &point), -1);
  lit_data_free(&u.data);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_gradient_of_the_profiled_cost),
      cmocka_unit_test(test_slopes_of_the_prediction),
      cmocka_unit_test(test_profiled_slopes_make_the_system),
      cmocka_unit_test(test_curves_are_the_best),
      cmocka_unit_test(test_clipped_samples_are_one_sided),
      cmocka_unit_test(test_threads_change_no_bit),
      cmocka_unit_test(test_prediction_in_parts),
      cmocka_unit_test(test_shadow_predicts_the_ambient),
      cmocka_unit_test(test_rotation_changes_no_cost),
      cmocka_unit_test(test_what_is_no_number_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
