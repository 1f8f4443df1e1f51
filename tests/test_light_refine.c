/* Gauss-Newton on the direction: it finds the truth, stops, and never climbs. */
#include "light_data.h"

static const double sqrt2 = 1.4142135623730951;

static lit_scene scene_of(lit_lobe lobe)
{
  lit_scene s = lit_glossy();
  s.lobe = lobe;
  s.width = 0.3;
  return s;
}

static hl_light_model model_of(const hl_light_data *data, lit_lobe lobe, const double s[3])
{
  hl_light_model m = {.lobe = lobe == LIT_FORESHORTENED ? HL_LOBE_FORESHORTENED : HL_LOBE_PLAIN,
                      .has_lobe = lobe != LIT_MATTE,
                      .body = 1};
  hl_light_breaks(data, s, 40, 6, &m.spline);
  return m;
}

static hl_refined *start_at(const double s[3])
{
  hl_refined *r = calloc(1, sizeof *r);
  if (!r)
    abort();
  memcpy(r->at.s, s, sizeof r->at.s);
  return r;
}

/* Analytic: pixels hold the model's own values, so the light is the least of the cost; the
 * spline's misfit of the lobe (1e-6 of it) is all that moves it. */
static void test_finds_the_light_from_ten_degrees_off(void **state)
{
  (void)state;
  for (int lobe = LIT_MATTE; lobe <= LIT_FORESHORTENED; lobe++)
    for (int turn = 0; turn < 360; turn += 90) {
      lit_scene scene = scene_of((lit_lobe)lobe);
      lit_data d = lit_gather(&scene, NULL);
      double t[2][3], s[3];
      hl_tangent_basis(scene.light, t[0], t[1]);
      hl_add_scaled(scene.light, tan(10 * LIT_DEG) * cos(turn * LIT_DEG), t[0], s);
      hl_add_scaled(s, tan(10 * LIT_DEG) * sin(turn * LIT_DEG), t[1], s);
      hl_unit(s, s);
      const hl_light_model m = model_of(&d.work->all, (lit_lobe)lobe, s);
      hl_refined *r = start_at(s);
      assert_int_equal(hl_light_refine(&m, &d.work->all, 40, 1e-9, 1, &d.work->model, r), 0);
      assert_true(r->converged);
      assert_true(r->iterations > 1 && r->iterations < 40);
      assert_near(hl_angle(r->at.s, scene.light), 0, 1e-6);
      assert_near(hl_norm(r->at.s), 1, 1e-15);
      free(r);
      lit_data_free(&d);
    }
}

/* Data made by the model itself with an exponent: it comes back. */
static void test_finds_the_exponent(void **state)
{
  (void)state;
  lit_scene scene = scene_of(LIT_PLAIN);
  lit_data d = lit_gather(&scene, NULL);
  hl_light_data *all = &d.work->all;
  hl_light_model m = model_of(all, LIT_PLAIN, scene.light);
  m.masking = true;
  hl_refined *r = start_at(scene.light);
  assert_int_equal(hl_model_fit(&m, all, scene.light, 0.7, 1, &d.work->model, &r->at), 0);
  hl_model_predict(&m, all, &r->at, NULL, 0, all->n, 0, d.work->fit);
  for (int i = 0; i < all->n; i++)
    all->value[0][i] = d.work->fit[i].value;
  lit_direction(49, -57, r->at.s);
  r->at.exponent = 0;
  assert_int_equal(hl_light_refine(&m, all, 60, 1e-9, 1, &d.work->model, r), 0);
  assert_near(r->at.exponent, 0.7, 1e-3);
  assert_near(hl_angle(r->at.s, scene.light), 0, 1e-5);
  free(r);
  lit_data_free(&d);
}

static void test_at_the_end_the_slope_is_gone_and_the_cost_lower(void **state)
{
  (void)state;
  test_random random = {9};
  lit_scene scene = scene_of(LIT_FORESHORTENED);
  scene.noise = 0.01;
  lit_data d = lit_gather(&scene, &random);
  double s[3];
  lit_direction(52, -66, s);
  const hl_light_model m = model_of(&d.work->all, LIT_FORESHORTENED, s);
  hl_refined *r = start_at(s);
  hl_model_step before;
  assert_int_equal(hl_model_fit(&m, &d.work->all, s, 0, 1, &d.work->model, &r->at), 0);
  hl_model_differentiate(&m, &d.work->all, &r->at, 1, &d.work->model, &before);
  const double cost = r->at.cost;
  assert_int_equal(hl_light_refine(&m, &d.work->all, 40, 1e-9, 1, &d.work->model, r), 0);
  assert_true(r->at.cost < cost);
  for (int k = 0; k < 2; k++) {
    /* within a tenth of the standard deviation that the residual implies */
    const double deviation = sqrt(r->step.hessian[k][k] * r->at.cost / d.work->all.n);
    assert_near(r->step.gradient[k], 0, 0.1 * deviation);
    assert_true(fabs(before.gradient[k]) > deviation);
  }
  free(r);
  lit_data_free(&d);
}

static void test_the_limit_is_kept_and_said(void **state)
{
  (void)state;
  lit_scene scene = scene_of(LIT_PLAIN);
  lit_data d = lit_gather(&scene, NULL);
  double s[3];
  lit_direction(60, -40, s);
  const hl_light_model m = model_of(&d.work->all, LIT_PLAIN, s);
  hl_refined *r = start_at(s);
  assert_int_equal(hl_light_refine(&m, &d.work->all, 0, 1e-9, 1, &d.work->model, r), 0);
  assert_int_equal(r->iterations, 0);
  assert_false(r->converged);
  assert_memory_equal(r->at.s, s, sizeof s);
  assert_int_equal(hl_light_refine(&m, &d.work->all, 1, 1e-12, 1, &d.work->model, r), 0);
  assert_int_equal(r->iterations, 1);
  assert_false(r->converged);
  free(r);
  lit_data_free(&d);
}

static void test_threads_change_no_bit(void **state)
{
  (void)state;
  test_random random = {10};
  lit_scene scene = scene_of(LIT_PLAIN);
  scene.noise = 0.01;
  scene.saturation = 0.7;
  lit_data d = lit_gather(&scene, &random);
  double s[3], first[3] = {0};
  lit_direction(50, -70, s);
  const hl_light_model m = model_of(&d.work->all, LIT_PLAIN, s);
  static const int threads[] = {1, 2, 3, 8};
  for (int i = 0; i < 4; i++) {
    hl_refined *r = start_at(s);
    assert_int_equal(hl_light_refine(&m, &d.work->all, 20, 1e-7, threads[i], &d.work->model, r), 0);
    if (i == 0)
      memcpy(first, r->at.s, sizeof first);
    assert_memory_equal(r->at.s, first, sizeof first);
    free(r);
  }
  lit_data_free(&d);
}

static void test_what_cannot_be_fitted_is_refused(void **state)
{
  (void)state;
  lit_scene scene = scene_of(LIT_PLAIN);
  lit_data d = lit_gather(&scene, NULL);
  const hl_light_model m = model_of(&d.work->all, LIT_PLAIN, scene.light);
  hl_refined *r = start_at(scene.light);
  d.work->all.value[0][d.work->ranked[0].index] = NAN;
  assert_int_equal(hl_light_refine(&m, &d.work->all, 9, 1e-9, 1, &d.work->model, r), -1);
  free(r);
  lit_data_free(&d);
}

/* Every interval of breaks holds enough lit pixels, all are in order, from 0 to sqrt(2). */
static void test_breaks_hold_pixels(void **state)
{
  (void)state;
  static const double angles[] = {0, 30, 80, 120};
  lit_scene scene = lit_glossy();
  lit_data d = lit_gather(&scene, NULL);
  const hl_light_data *all = &d.work->all;
  for (int a = 0; a < 4; a++)
    for (int count = 1; count <= 60; count += 13) {
      double s[3];
      int held[HL_SPLINE_MAX] = {0};
      hl_spline spline;
      lit_direction(angles[a], 20, s);
      hl_light_breaks(all, s, count, 6, &spline);
      assert_true(spline.n <= HL_SPLINE_MAX && spline.intervals <= count);
      assert_near(spline.low, 0, 0);
      assert_near(spline.high, sqrt2, 1e-15);
      for (int i = 1; i < spline.intervals; i++)
        assert_true(spline.left[i] > spline.left[i - 1]);
      for (int i = 0; i < all->n; i++) {
        const double n[3] = {all->normal[0][i], all->normal[1][i], all->normal[2][i]};
        double h[3] = {all->view[0][i], all->view[1][i], all->view[2][i]}, u[3];
        hl_add_scaled(h, 1, s, h);
        hl_unit(h, h);
        hl_add_scaled(n, -1, h, u);
        if (hl_dot(n, s) > 0)
          held[hl_spline_interval(&spline, hl_norm(u))]++;
      }
      for (int i = 0; i < spline.intervals; i++)
        assert_true(held[i] >= 6);
    }
  lit_data_free(&d);
}

/* Nothing lit: one interval, and no crash. */
static void test_breaks_of_nothing(void **state)
{
  (void)state;
  const double s[3] = {0, 0, -1};
  const hl_light_data none = {.channels = 1};
  hl_spline spline;
  hl_light_breaks(&none, s, 40, 6, &spline);
  assert_int_equal(spline.intervals, 1);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_finds_the_light_from_ten_degrees_off),
      cmocka_unit_test(test_finds_the_exponent),
      cmocka_unit_test(test_at_the_end_the_slope_is_gone_and_the_cost_lower),
      cmocka_unit_test(test_the_limit_is_kept_and_said),
      cmocka_unit_test(test_threads_change_no_bit),
      cmocka_unit_test(test_what_cannot_be_fitted_is_refused),
      cmocka_unit_test(test_breaks_hold_pixels),
      cmocka_unit_test(test_breaks_of_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
