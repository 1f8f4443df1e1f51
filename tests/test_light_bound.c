/* The bound against dense algebra, its noise against the noise that was put in. */
#include "light_data.h"

typedef struct bound_case {
  lit_data d;
  hl_light_model model;
  hl_light light;
} bound_case;

/* A fitted ball with noise of variance noise^2 + shot y, y in units of the level. */
static bound_case bound_of(lit_lobe lobe, double noise, double shot)
{
  bound_case b;
  lit_scene s = lit_ball(20);
  test_random random = {7};
  s.lobe = lobe;
  s.width = 0.3;
  b.d = lit_gather(&s, NULL);
  hl_light_data *all = &b.d.work->all;
  for (int i = 0; i < all->n; i++) {
    const double y = all->value[0][i];
    all->value[0][i] += sqrt(noise * noise + shot * y) * random_normal(&random);
  }
  b.model =
      (hl_light_model){.lobe = lobe == LIT_FORESHORTENED ? HL_LOBE_FORESHORTENED : HL_LOBE_PLAIN,
                       .has_lobe = lobe != LIT_MATTE,
                       .body = 1};
  memset(&b.light, 0, sizeof b.light);
  memcpy(b.d.work->refined.at.s, s.light, sizeof s.light);
  hl_light_breaks(all, s.light, 20, 12, &b.model.spline);
  if (hl_light_refine(&b.model, all, 10, 1e-6, 1, &b.d.work->model, &b.d.work->refined) != 0)
    abort();
  b.d.work->best = b.d.work->refined;
  for (int k = 0; k < 2; k++)
    b.light.part_rad2[HL_PART_NOISE][k][k] = 1;
  hl_light_bound(b.d.work, &b.model, &b.d.surface, 1, &b.light);
  return b;
}

/* Inverse of [D X]' W [D X], the tangents' corner: the curves eliminated one after the other. */
static void dense_bound(bound_case *b, double out[2][2])
{
  enum { MOST = HL_COLUMNS_MAX + 2 };
  static double g[MOST][MOST], row[MOST];
  const hl_light_data *all = &b->d.work->all;
  const hl_model_point at = b->d.work->model.trial; /* the curves under the noise's weights */
  hl_model_point *unit = &b->d.work->refined.at;
  const int n = 2 + b->model.spline.n * b->model.has_lobe + 1;
  memset(g, 0, sizeof g);
  *unit = at;
  for (int i = 0; i < all->n; i++) {
    hl_model_pixel p;
    hl_model_predict(&b->model, all, &at, NULL, i, 1, 0, &p);
    row[0] = p.slope[0];
    row[1] = p.slope[1];
    for (int j = 0; j < n - 2; j++) {
      memset(unit->x, 0, sizeof unit->x);
      unit->x[0][j] = 1;
      hl_model_predict(&b->model, all, unit, NULL, i, 1, 0, &p);
      row[2 + j] = p.value;
    }
    for (int u = 0; u < n; u++)
      for (int v = 0; v < n; v++)
        g[u][v] += all->weight[0][i] * row[u] * row[v];
  }
  for (int p = n - 1; p >= 2; p--)
    for (int u = 0; u < p; u++)
      for (int v = 0; v < p; v++)
        g[u][v] -= g[u][p] * g[p][v] / g[p][p];
  const double det = g[0][0] * g[1][1] - g[0][1] * g[1][0];
  out[0][0] = g[1][1] / det;
  out[1][1] = g[0][0] / det;
  out[0][1] = out[1][0] = -g[0][1] / det;
}

static void bound_is_the_dense_one(lit_lobe lobe)
{
  bound_case b = bound_of(lobe, 0.004, 0);
  double want[2][2];
  dense_bound(&b, want);
  const double trace = want[0][0] + want[1][1];
  assert_true(trace > 0);
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++)
      assert_near(b.light.bound_rad2[u][v] / trace, want[u][v] / trace, 0.005);
  lit_data_free(&b.d);
}

static void test_bound_of_a_plain_lobe(void **state)
{
  (void)state;
  bound_is_the_dense_one(LIT_PLAIN);
}

static void test_bound_of_a_foreshortened_lobe(void **state)
{
  (void)state;
  bound_is_the_dense_one(LIT_FORESHORTENED);
}

static void test_bound_of_a_matte_ball(void **state)
{
  (void)state;
  bound_is_the_dense_one(LIT_MATTE);
}

/* The weights are 1 / variance of the noise that was put in: of a sensor alone, and of photons too. */
static void noise_is_found(double noise, double shot)
{
  bound_case b = bound_of(LIT_PLAIN, noise, shot);
  const hl_light_data *all = &b.d.work->all;
  double ratio = 0;
  for (int i = 0; i < all->n; i++) {
    const double y = fmax(b.d.work->fit[i].value, 0);
    ratio += 1 / (all->weight[0][i] * (noise * noise + shot * y)) / all->n;
  }
  assert_near(ratio, 1, 0.2);
  lit_data_free(&b.d);
}

static void test_noise_of_a_sensor(void **state)
{
  (void)state;
  noise_is_found(0.01, 0);
}

static void test_noise_of_photons(void **state)
{
  (void)state;
  noise_is_found(0.004, 1e-4);
}

/* Noise alone, stated by the estimate itself, reaches nine tenths of the bound and never more. */
static void test_efficiency_where_the_model_holds(void **state)
{
  (void)state;
  for (int lobe = LIT_MATTE; lobe <= LIT_FORESHORTENED; lobe++) {
    lit_scene s = lit_ball(30);
    s.lobe = (lit_lobe)lobe;
    s.width = 0.3;
    s.noise = 0.01;
    lit_shot shot = lit_shot_of(&s, 11);
    const hl_light light = lit_light_of(&shot, NULL);
    if (!(light.efficiency >= 0.9))
      print_error("lobe %d: efficiency %.3f\n", lobe, light.efficiency);
    assert_true(light.efficiency >= 0.9 && light.efficiency <= 1);
    assert_true(light.bound_rad2[0][0] > 0 && light.bound_rad2[1][1] > 0);
    lit_shot_free(&shot);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_bound_of_a_plain_lobe),
      cmocka_unit_test(test_bound_of_a_foreshortened_lobe),
      cmocka_unit_test(test_bound_of_a_matte_ball),
      cmocka_unit_test(test_noise_of_a_sensor),
      cmocka_unit_test(test_noise_of_photons),
      cmocka_unit_test(test_efficiency_where_the_model_holds),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
