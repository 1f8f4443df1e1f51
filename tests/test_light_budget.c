/* Fewer samples than pixels, and a time to be done in: what is used, what is said, how good it is. */
#include <stdio.h>

#include "light_data.h"

static const char *why_of(const hl_notes *notes, const char *what)
{
  for (int i = 0; i < notes->n; i++)
    if (strcmp(notes->note[i].what, what) == 0)
      return notes->note[i].why;
  return "";
}

static lit_scene large(void)
{
  lit_scene s = lit_ball(55);
  s.noise = 0.004;
  return s;
}

static hl_light_settings with_pixels(int pixels)
{
  hl_light_settings settings = hl_light_defaults();
  settings.pixels = pixels;
  return settings;
}

static void test_no_more_samples_than_asked_for_and_it_says_so(void **state)
{
  (void)state;
  const lit_scene s = large();
  lit_shot one = lit_shot_of(&s, 1);
  for (int pixels = 300; pixels < one.surface.n; pixels *= 3) {
    char part[64];
    const hl_light_settings settings = with_pixels(pixels);
    const hl_light light = lit_light_of(&one, &settings);
    assert_in_range(light.n_pixels, pixels / 2, pixels);
    snprintf(part, sizeof part, "%d of %d: means", light.n_pixels, one.surface.n);
    assert_non_null(strstr(why_of(&light.left_out, "pixels"), part));
    /* few cannot tell a plain lobe from a foreshortened one; that is stated, then */
    assert_near(lit_error_deg(&s, &light), 0, 1.5 * light.ellipse_95_rad[0] / LIT_DEG);
    if (pixels >= 900)
      assert_near(lit_error_deg(&s, &light), 0, 0.06);
  }
  const hl_light_settings enough = with_pixels(one.surface.n);
  const hl_light all = lit_light_of(&one, &enough);
  assert_int_equal(all.n_pixels, one.surface.n);
  assert_string_equal(why_of(&all.left_out, "pixels"), "");
  lit_shot_free(&one);
}

/* Samples left out take their share of the information with them; blocks' means keep it. */
static void test_the_stated_noise_holds(void **state)
{
  enum { DRAWS = 24 };
  static const int pixels[] = {300, 2000};
  const lit_scene s = large();
  (void)state;
  for (int k = 0; k < 2; k++) {
    double sum = 0, stated = 0, whole = 0;
    for (uint64_t draw = 0; draw < DRAWS; draw++) {
      lit_shot one = lit_shot_of(&s, 100 + draw);
      const hl_light_settings settings = with_pixels(pixels[k]);
      const hl_light light = lit_light_of(&one, &settings), all = lit_light_of(&one, NULL);
      const double error = lit_error_deg(&s, &light) * LIT_DEG;
      sum += error * error;
      stated += light.covariance_rad2[0][0] + light.covariance_rad2[1][1];
      whole += all.covariance_rad2[0][0] + all.covariance_rad2[1][1];
      lit_shot_free(&one);
    }
    print_message("%d pixels: scatter %.3g, stated %.3g, of all pixels %.3g\n", pixels[k], sum,
                  stated, whole);
    /* a sum of 48 squares, or of 24 where one of the axes is all of it */
    assert_true(sum < 2 * stated);
    assert_true(stated > 0.9 * whole);
    assert_true(k == 0 || stated < 2 * whole);
  }
}

static void swap(double *a, double *b)
{
  const double t = *a;
  *a = *b;
  *b = t;
}

static void test_threads_and_order_change_no_bit(void **state)
{
  (void)state;
  lit_scene s = large();
  s.channels = 3;
  lit_shot one = lit_shot_of(&s, 2);
  hl_light_settings settings = with_pixels(2500); /* in several blocks */
  const hl_light light = lit_light_of(&one, &settings);
  settings.threads = 3;
  const hl_light threaded = lit_light_of(&one, &settings);
  assert_memory_equal(light.direction, threaded.direction, sizeof light.direction);
  assert_memory_equal(light.covariance_rad2, threaded.covariance_rad2,
                      sizeof light.covariance_rad2);
  hl_surface *surface = &one.surface;
  for (int i = 0, j = surface->n - 1; i < j; i++, j--) {
    const int pixel = surface->pixel[i];
    surface->pixel[i] = surface->pixel[j];
    surface->pixel[j] = pixel;
    swap(&surface->footprint[i], &surface->footprint[j]);
    for (int k = 0; k < 3; k++) {
      swap(&surface->normal[3 * i + k], &surface->normal[3 * j + k]);
      swap(&surface->view[3 * i + k], &surface->view[3 * j + k]);
    }
  }
  const hl_light turned = lit_light_of(&one, &settings);
  assert_memory_equal(light.direction, turned.direction, sizeof light.direction);
  lit_shot_free(&one);
}

/* Every pixel is in one cell, whose value is its pixels' mean. */
static void test_cells_are_their_pixels_means(void **state)
{
  (void)state;
  const lit_scene s = large();
  test_random random = {3};
  lit_data d = lit_gather(&s, &random);
  hl_light_work *work = d.work;
  const int n = work->all.n;
  hl_light_find_blocks(work, &d.surface);
  hl_light_to_cells(work, 3000);
  const hl_light_data *cells = &work->all, *pixels = &work->aside.all;
  double *sum = calloc((size_t)cells->n, sizeof *sum);
  int *count = calloc((size_t)cells->n, sizeof *count), single = 0, total = 0;
  if (!sum || !count)
    abort();
  assert_in_range(cells->n, 1500, 3000);
  for (int p = 0; p < n; p++) {
    const int cell = work->owner[p];
    assert_in_range(cell, 0, cells->n - 1);
    sum[cell] += pixels->value[0][p];
    count[cell]++;
  }
  for (int i = 0; i < cells->n; i++) {
    assert_int_equal(count[i], hl_light_area(cells, i));
    assert_near(sum[i] / count[i], cells->value[0][i], 1e-12);
    single += count[i] == 1;
    total += count[i];
  }
  assert_int_equal(total, n);
  assert_int_equal(hl_light_pixels(cells), n);
  assert_true(single > 0 && single < cells->n);
  free(sum);
  free(count);
  lit_data_free(&d);
}

/* The cost on cells is that on pixels, but for a few percent: what is chosen by it stays chosen. */
static void test_the_cost_means_the_same(void **state)
{
  (void)state;
  const lit_scene s = large();
  test_random random = {4};
  lit_data d = lit_gather(&s, &random);
  hl_light_work *work = d.work;
  hl_light_model model = {.lobe = HL_LOBE_PLAIN, .has_lobe = true, .body = 1};
  double cost[2];
  hl_light_find_blocks(work, &d.surface);
  hl_light_breaks(&work->all, s.light, 24, 6, &model.spline);
  for (int k = 0; k < 2; k++) {
    if (k == 1)
      hl_light_to_cells(work, 3000);
    hl_light_weigh(&work->all, hl_light_final_noise, NULL);
    assert_int_equal(hl_model_fit(&model, &work->all, s.light, 0, 1, &work->model, &work->best.at),
                     0);
    cost[k] = work->best.at.cost;
  }
  assert_near(cost[1] / cost[0], 1, 0.05);
  lit_data_free(&d);
}

/* No time is asserted: what was left out for want of it is said, and the answer is one. */
static void test_a_budget_says_what_it_left_out(void **state)
{
  (void)state;
  const lit_scene s = large();
  lit_shot one = lit_shot_of(&s, 5);
  hl_light_settings settings = hl_light_defaults();
  settings.budget_ms = 0.01;
  const hl_light hurried = lit_light_of(&one, &settings);
  const hl_notes *left = &hurried.left_out;
  assert_true(hurried.n_pixels <= 400);
  assert_non_null(strstr(why_of(left, "pixels"), ", budget 0.01 ms"));
  assert_string_equal(why_of(left, "masking and bent body"), "not tried, budget 0.01 ms");
  assert_non_null(strstr(why_of(left, "budget"), "not held: "));
  assert_string_equal(why_of(left, "bound"), "not derived for want of time");
  assert_true(hurried.efficiency == 0);
  assert_string_equal(why_of(left, "backscatter"), "not tried, budget 0.01 ms");
  assert_string_equal(why_of(left, "ambient"), "not tried, budget 0.01 ms");
  assert_near(lit_error_deg(&s, &hurried), 0, 1.5 * hurried.ellipse_95_rad[0] / LIT_DEG);
  settings.without = 1U << HL_LIGHT_BACKSCATTER;
  settings.budget_ms = 1e6;
  const hl_light easy = lit_light_of(&one, &settings);
  settings.budget_ms = 0;
  const hl_light unhurried = lit_light_of(&one, &settings);
  assert_string_equal(why_of(&easy.left_out, "backscatter"), "not asked for");
  assert_string_equal(why_of(&easy.left_out, "pixels"), "");
  assert_string_equal(why_of(&easy.left_out, "budget"), "");
  assert_memory_equal(easy.direction, unhurried.direction, sizeof easy.direction);
  lit_shot_free(&one);
}

/* Runs of three neighbours and the brightest, no more than asked for, and the same from any order. */
static void test_a_glance_is_runs_and_the_brightest(void **state)
{
  (void)state;
  enum { MOST = 900 };
  const lit_scene s = large();
  test_random random = {6};
  lit_data d = lit_gather(&s, &random);
  hl_light_work *work = d.work;
  int brightest = 0, alone = 0, *index = calloc(MOST, sizeof *index);
  if (!index)
    abort();
  for (int i = 1; i < d.surface.n; i++)
    if (d.frame.radiance[d.surface.pixel[i]] > d.frame.radiance[d.surface.pixel[brightest]])
      brightest = i;
  assert_int_equal(hl_light_gather(NULL, work, &d.frame, &d.surface, MOST), HL_OK);
  const int n = work->all.n;
  assert_in_range(n, MOST * 2 / 3 - 3, MOST);
  bool found = false;
  for (int i = 0; i < n; i++) {
    const bool after = i > 0 && work->index[i - 1] == work->index[i] - 1;
    const bool before = i + 1 < n && work->index[i + 1] == work->index[i] + 1;
    alone += !after && !before;
    found = found || work->index[i] == brightest;
    assert_true(i == 0 || work->index[i] > work->index[i - 1]);
    index[i] = d.surface.pixel[work->index[i]];
  }
  assert_true(found);
  assert_true(alone < n / 10);
  for (int i = 0, j = d.surface.n - 1; i < j; i++, j--) {
    const int pixel = d.surface.pixel[i];
    d.surface.pixel[i] = d.surface.pixel[j];
    d.surface.pixel[j] = pixel;
  }
  assert_int_equal(hl_light_gather(NULL, work, &d.frame, &d.surface, MOST), HL_OK);
  assert_int_equal(work->all.n, n);
  for (int i = 0; i < n; i++)
    assert_int_equal(d.surface.pixel[work->index[i]], index[i]);
  free(index);
  lit_data_free(&d);
}

static void refused(const hl_light_settings *settings, const char *part)
{
  hl_ctx ctx = {0};
  assert_int_equal(hl_fields_check(&ctx, hl_light_fields(), settings), HL_ERR_ARG);
  assert_non_null(strstr(ctx.msg, part));
}

static void test_settings_refused(void **state)
{
  (void)state;
  hl_light_settings s = with_pixels(-1);
  refused(&s, "pixels = -1");
  s = hl_light_defaults();
  s.budget_ms = NAN;
  refused(&s, "budget_ms = nan");
  s.budget_ms = -5;
  refused(&s, "budget_ms = -5");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_no_more_samples_than_asked_for_and_it_says_so),
      cmocka_unit_test(test_the_stated_noise_holds),
      cmocka_unit_test(test_threads_and_order_change_no_bit),
      cmocka_unit_test(test_cells_are_their_pixels_means),
      cmocka_unit_test(test_the_cost_means_the_same),
      cmocka_unit_test(test_a_budget_says_what_it_left_out),
      cmocka_unit_test(test_a_glance_is_runs_and_the_brightest),
      cmocka_unit_test(test_settings_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
