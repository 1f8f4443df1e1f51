/* Terms that a scene needs and does not need, on reflectances that are not the fitted basis. */
#include "files.h"
#include "term_scene.h"

enum { DRAWS = 12 };
static const unsigned all_terms = (1U << HL_LIGHT_TERMS) - 1;

static double distance_of(const term_scene *t, const hl_light *light)
{
  double away[3];
  hl_add_scaled(light->position_m, -1, t->base.ball.center_m, away);
  return hl_norm(away) / t->base.ball.radius_m;
}

static term_scene at_side(term_shader shader)
{
  term_scene t = term_ball(shader);
  lit_direction(80, 30, t.base.light);
  return t;
}

static const term_shader shaders[] = {TERM_GGX, TERM_PHONG, TERM_OREN_NAYAR};
static const char *const optional[] = {"ambient", "near", "backscatter", "outlier rejection"};

/* What a scene does not need is left out with a figure, and the answer is the one without trying. */
static void test_plain_scenes_need_none(void **state)
{
  (void)state;
  for (int k = 0; k < 3; k++) {
    const term_scene t = term_ball(shaders[k]);
    hl_light_settings none = hl_light_defaults();
    none.without = all_terms & ~(1U << HL_LIGHT_BENDS);
    const hl_light light = term_estimate(&t, NULL, 11), bare = term_estimate(&t, &none, 11);
    assert_memory_equal(light.direction, bare.direction, sizeof light.direction);
    assert_memory_equal(light.lobe_strength, bare.lobe_strength, sizeof light.lobe_strength);
    assert_false(light.near);
    for (int i = 0; i < 4; i++) {
      assert_null(term_note(&light.used, optional[i]));
      assert_non_null(term_note(&light.left_out, optional[i]));
      assert_string_equal(term_note(&bare.left_out, optional[i]), "not asked for");
    }
  }
}

/* 5 % of the median radiance. */
static void test_ambient_is_found(void **state)
{
  (void)state;
  for (int k = 0; k < 2; k++) {
    term_scene t = k == 0 ? term_ball(TERM_GGX) : at_side(TERM_OREN_NAYAR);
    const hl_light without = term_estimate(&t, NULL, 12);
    t.ambient = 0.05 * 0.25;
    const hl_light light = term_estimate(&t, NULL, 12);
    assert_non_null(term_note(&light.used, "ambient"));
    assert_near(light.ambient[0], t.ambient, 0.1 * t.ambient);
    assert_true(lit_error_deg(&t.base, &light) < 1.5 * lit_error_deg(&t.base, &without) + 0.005);
    hl_light_settings none = hl_light_defaults();
    none.without = 1U << HL_LIGHT_AMBIENT;
    const hl_light bare = term_estimate(&t, &none, 12);
    assert_true(lit_error_deg(&t.base, &bare) > 3 * lit_error_deg(&t.base, &light));
    assert_null(term_note(&bare.used, "ambient"));
  }
}

static void test_near_light_is_placed(void **state)
{
  (void)state;
  static const double radii[] = {5, 10};
  for (int side = 0; side < 2; side++)
    for (int i = 0; i < 2; i++) {
      term_scene t = side == 0 ? term_ball(TERM_GGX) : at_side(TERM_GGX);
      t.distance_radii = radii[i];
      const hl_light light = term_estimate(&t, NULL, 13);
      assert_true(light.near);
      assert_non_null(term_note(&light.used, "near"));
      double truth[3], off[3];
      hl_add_scaled(t.base.ball.center_m, radii[i] * t.base.ball.radius_m, t.base.light, truth);
      hl_add_scaled(light.position_m, -1, truth, off);
      assert_true(hl_norm(off) < 0.05 * radii[i] * t.base.ball.radius_m);
      assert_true(lit_error_deg(&t.base, &light) < 0.15);
      hl_light_settings none = hl_light_defaults();
      none.without = 1U << HL_LIGHT_NEAR;
      const hl_light distant = term_estimate(&t, &none, 13);
      assert_false(distant.near);
      assert_true(lit_error_deg(&t.base, &distant) > 10 * lit_error_deg(&t.base, &light));
    }
}

/* Noise alone: the position scatters as its covariance says. */
static void test_position_scatters_as_stated(void **state)
{
  (void)state;
  term_scene t = at_side(TERM_GGX);
  t.distance_radii = 8;
  t.base.noise = 0.002;
  double sum = 0, squares = 0, stated = 0;
  for (int i = 0; i < DRAWS; i++) {
    const hl_light light = term_estimate(&t, NULL, 100 + (uint64_t)i);
    assert_true(light.near);
    double along = 0;
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) {
        along += light.direction[a] * light.position_covariance_m2[a][b] * light.direction[b];
        assert_near(light.position_covariance_m2[a][b], light.position_covariance_m2[b][a],
                    1e-9 * light.position_covariance_m2[a][a]);
      }
    const double r = t.base.ball.radius_m;
    stated += sqrt(along) / r / DRAWS;
    sum += distance_of(&t, &light);
    squares += distance_of(&t, &light) * distance_of(&t, &light);
  }
  const double mean = sum / DRAWS, scatter = sqrt((squares - sum * mean) / (DRAWS - 1));
  assert_true(scatter > 0.5 * stated && scatter < 1.8 * stated);
  assert_near(mean, t.distance_radii, 3 * stated);
}

/* The pose's share: a ball known to 1 mm moves the light at least as much. */
static void test_pose_enters_the_position(void **state)
{
  (void)state;
  term_scene t = at_side(TERM_GGX);
  t.distance_radii = 8;
  const hl_light sharp = term_estimate(&t, NULL, 14);
  t.base.ball.has_covariance = true;
  for (int k = 0; k < 3; k++)
    t.base.ball.covariance_m2[k][k] = t.base.ball.held_covariance_m2[k][k] = 1e-6;
  const hl_light blurred = term_estimate(&t, NULL, 14);
  assert_true(sharp.near && blurred.near);
  for (int k = 0; k < 3; k++)
    assert_true(blurred.position_covariance_m2[k][k] > sharp.position_covariance_m2[k][k]);
}

static void test_normal_map_has_no_distance(void **state)
{
  (void)state;
  term_scene t = term_ball(TERM_GGX);
  t.distance_radii = 5;
  lit_shot shot = term_shot(&t, 15);
  shot.surface.is_ball = false;
  memset(&shot.surface.ball, 0, sizeof shot.surface.ball);
  const hl_light light = lit_light_of(&shot, NULL);
  assert_false(light.near);
  assert_says(term_note(&light.left_out, "near"), "only a ball");
  lit_shot_free(&shot);
}

static void test_backscatter_is_found(void **state)
{
  (void)state;
  term_scene t = term_ball(TERM_OREN_NAYAR);
  t.backscatter = 0.2;
  hl_light_settings none = hl_light_defaults();
  none.without = 1U << HL_LIGHT_BACKSCATTER | 1U << HL_LIGHT_NEAR;
  const hl_light light = term_estimate(&t, NULL, 16), bare = term_estimate(&t, &none, 16);
  assert_non_null(term_note(&light.used, "backscatter"));
  assert_true(light.backscatter[0][0] + light.backscatter[0][1] > 0.1);
  assert_true(light.rms < 0.5 * bare.rms);
  assert_true(lit_error_deg(&t.base, &light) < lit_error_deg(&t.base, &bare));
}

/* A tenth of the ball under a label. */
static void test_label_is_left_out(void **state)
{
  (void)state;
  for (int k = 0; k < 3; k++) {
    term_scene t = term_ball(shaders[k]);
    const hl_light without = term_estimate(&t, NULL, 17);
    t.label = 0.1;
    const hl_light light = term_estimate(&t, NULL, 17);
    assert_non_null(term_note(&light.used, "outlier rejection"));
    assert_true(light.n_outliers > 0.09 * light.n_pixels &&
                light.n_outliers < 0.2 * light.n_pixels);
    assert_true(lit_error_deg(&t.base, &light) < 2 * lit_error_deg(&t.base, &without) + 0.005);
    hl_light_settings none = hl_light_defaults();
    none.without = 1U << HL_LIGHT_OUTLIERS;
    const hl_light bare = term_estimate(&t, &none, 17);
    assert_int_equal(bare.n_outliers, 0);
    assert_true(lit_error_deg(&t.base, &bare) > 3);
  }
}

/* Asked for, a term is used whatever it saves, and a light that is far stays where it is. */
static void test_forced_terms(void **state)
{
  (void)state;
  const term_scene t = term_ball(TERM_GGX);
  static const hl_light_term forced[] = {HL_LIGHT_AMBIENT, HL_LIGHT_NEAR, HL_LIGHT_BACKSCATTER,
                                         HL_LIGHT_BENDS};
  static const char *const names[] = {"ambient", "near", "backscatter", "masking and bent body"};
  for (int i = 0; i < 4; i++) {
    hl_light_settings with = hl_light_defaults();
    with.with = 1U << forced[i];
    const hl_light light = term_estimate(&t, &with, 18);
    assert_non_null(term_note(&light.used, names[i]));
    assert_null(term_note(&light.left_out, names[i]));
    assert_true(lit_error_deg(&t.base, &light) < 0.3);
    if (light.near)
      assert_true(distance_of(&t, &light) > 60);
  }
  hl_light_settings without = hl_light_defaults();
  without.without = 1U << HL_LIGHT_BENDS;
  const term_scene rough = term_ball(TERM_OREN_NAYAR);
  const hl_light light = term_estimate(&rough, &without, 18);
  assert_string_equal(term_note(&light.left_out, "masking and bent body"), "not asked for");
  assert_near(light.masking_exponent, 0, 0);
}

/* A lobe of one roughness in three colours is one shape; of two roughnesses it is not. */
static void test_colored_lobe(void **state)
{
  (void)state;
  for (int k = 0; k < 2; k++) {
    term_scene t = term_ball(TERM_GGX);
    t.base.channels = 3;
    t.gloss[1] = 0.6;
    t.gloss[2] = 0.3;
    t.albedo[2] = 0.1;
    t.roughness[2] = k == 0 ? 0.2 : 0.3;
    const hl_light light = term_estimate(&t, NULL, 20);
    assert_true(lit_error_deg(&t.base, &light) < 0.05);
    assert_non_null(term_note(k == 0 ? &light.left_out : &light.used, "colored-lobe"));
    assert_null(term_note(k == 0 ? &light.used : &light.left_out, "colored-lobe"));
  }
  const term_scene grey = term_ball(TERM_GGX);
  const hl_light light = term_estimate(&grey, NULL, 20);
  assert_says(term_note(&light.left_out, "colored-lobe"), "one channel");
  assert_says(term_note(&light.left_out, "response"), "not tried");
}

static void refused(unsigned with, unsigned without, const char *part)
{
  const term_scene t = term_ball(TERM_GGX);
  lit_shot shot = term_shot(&t, 19);
  hl_light_settings s = hl_light_defaults();
  hl_ctx ctx = {0};
  hl_light out;
  s.with = with;
  s.without = without;
  assert_int_equal(lit_status(&shot.frame, &shot.surface, &s, &ctx, &out), HL_ERR_ARG);
  assert_says(ctx.msg, part);
  lit_shot_free(&shot);
}

static void test_contradictions_are_refused(void **state)
{
  (void)state;
  refused(1U << HL_LIGHT_NEAR, 1U << HL_LIGHT_NEAR, "near is asked for both with and without");
  refused(1U << HL_LIGHT_TERMS, 0, "only the 7 lowest bits are terms");
  refused(1U << HL_LIGHT_RESPONSE, 0, "one frame cannot tell");
  refused(0, 1U << 31, "without = 0x80000000");
}

static void test_names(void **state)
{
  (void)state;
  assert_string_equal(hl_light_term_name(HL_LIGHT_AMBIENT), "ambient");
  assert_string_equal(hl_light_term_name(HL_LIGHT_COLORED_LOBE), "colored-lobe");
  assert_string_equal(hl_light_term_name(HL_LIGHT_BENDS), "bends");
  assert_null(hl_light_term_name(HL_LIGHT_TERMS));
  assert_null(hl_light_term_name((hl_light_term)-1));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_plain_scenes_need_none),
      cmocka_unit_test(test_ambient_is_found),
      cmocka_unit_test(test_near_light_is_placed),
      cmocka_unit_test(test_position_scatters_as_stated),
      cmocka_unit_test(test_pose_enters_the_position),
      cmocka_unit_test(test_normal_map_has_no_distance),
      cmocka_unit_test(test_backscatter_is_found),
      cmocka_unit_test(test_label_is_left_out),
      cmocka_unit_test(test_forced_terms),
      cmocka_unit_test(test_colored_lobe),
      cmocka_unit_test(test_contradictions_are_refused),
      cmocka_unit_test(test_names),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
