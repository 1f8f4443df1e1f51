/* The final curves: of the promised shape whatever the frame, and the true ones where it is clean.
 */
#include "light_scene.h"

static const double half_pi = 1.5707963267948966;

static hl_light noisy(lit_scene *s, uint64_t seed)
{
  test_random random = {seed};
  hl_surface surface = lit_surface(s);
  hl_frame frame = lit_frame(s, &surface, &random);
  hl_light out;
  assert_int_equal(lit_status(&frame, &surface, NULL, NULL, &out), HL_OK);
  lit_frame_free(&frame);
  hl_surface_free(&surface);
  return out;
}

/* From 0 to 90 degrees, finite, never rising, never negative, 0 at the end (paper L1 to L4). */
static void assert_shape(const hl_light *light)
{
  assert_true(light->n_curves == light->channels || light->n_curves == 2 * light->channels);
  for (int k = 0; k < light->n_curves; k++) {
    const hl_curve *c = &light->curves[k];
    assert_true(c->n > 1 && c->n <= HL_CURVE_POINTS);
    assert_near(c->angle_rad[0], 0, 0);
    assert_near(c->angle_rad[c->n - 1], half_pi, 1e-12);
    assert_near(c->value[c->n - 1], 0, 0);
    for (int i = 0; i < c->n; i++) {
      assert_true(isfinite(c->value[i]) && c->value[i] >= 0);
      if (i > 0) {
        assert_true(c->angle_rad[i] > c->angle_rad[i - 1]);
        assert_true(c->value[i] <= c->value[i - 1] * (1 + 1e-12));
      }
    }
  }
}

static void test_shape_holds_whatever_the_material(void **state)
{
  (void)state;
  static const double widths[] = {0.04, 0.15, 0.4};
  for (int lobe = LIT_MATTE; lobe <= LIT_FORESHORTENED; lobe++)
    for (int k = 0; k < 3; k++) {
      lit_scene s = lit_ball(25);
      s.lobe = (lit_lobe)lobe;
      s.width = widths[k];
      s.noise = 0.02;
      s.saturation = k == 1 ? 0.6 : 0;
      s.ambient = k == 2 ? 0.05 : 0;
      s.channels = k == 0 ? 3 : 1;
      lit_direction(20 + 40 * k, 100, s.light);
      const hl_light light = noisy(&s, 40 + (uint64_t)k);
      assert_shape(&light);
    }
}

/* A lobe that dips at the highlight, and a body that falls with n.s: neither curve follows. */
static void test_shape_holds_for_data_of_another_shape(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  s.gloss[0] = -0.3;
  s.width = 0.3;
  const hl_light light = lit_estimate(&s, NULL);
  assert_shape(&light);
}

static void test_names(void **state)
{
  (void)state;
  static const char *const names[3] = {"r", "g", "b"};
  lit_scene s = lit_glossy();
  hl_light light = lit_estimate(&s, NULL);
  assert_int_equal(light.n_curves, 2);
  for (int k = 0; k < 2; k++)
    assert_string_equal(light.curves[k].channel, "grey");
  s.channels = 3;
  light = lit_estimate(&s, NULL);
  assert_int_equal(light.n_curves, 6);
  for (int c = 0; c < 3; c++) {
    int diffuse = 0, specular = 0;
    for (int k = 0; k < 6; k++)
      if (strcmp(light.curves[k].channel, names[c]) == 0) {
        diffuse += strcmp(light.curves[k].lobe, "diffuse") == 0;
        specular += strcmp(light.curves[k].lobe, "specular") == 0;
      }
    assert_int_equal(diffuse, 1);
    assert_int_equal(specular, 1);
  }
}

static const hl_curve *curve_of(const hl_light *light, const char *lobe, int channel)
{
  for (int k = 0; k < light->n_curves; k++)
    if (strcmp(light->curves[k].lobe, lobe) == 0 && channel-- == 0)
      return &light->curves[k];
  fail();
  return NULL;
}

/* Analytic: the scene's own curves come back, in the frame's units, a channel each. */
static void curves_are_true(lit_lobe lobe, double scale)
{
  lit_scene s = lit_glossy();
  s.lobe = lobe;
  s.width = 0.3;
  s.channels = 3;
  s.scale = scale;
  s.body[0] = 0.7;
  s.body[1] = 0.1;
  s.gloss[2] = 0.4;
  const hl_light light = lit_estimate(&s, NULL);
  assert_shape(&light);
  assert_int_equal(light.lobe, lobe == LIT_PLAIN ? HL_LOBE_PLAIN : HL_LOBE_FORESHORTENED);
  for (int c = 0; c < 3; c++) {
    const hl_curve *diffuse = curve_of(&light, "diffuse", c);
    const hl_curve *specular = curve_of(&light, "specular", c);
    assert_near(light.diffuse_strength[c], scale * s.body[c], 2e-3 * scale);
    assert_near(light.lobe_strength[c], scale * s.gloss[c], 2e-3 * scale);
    assert_near(diffuse->value[0], light.diffuse_strength[c], 1e-12 * scale);
    assert_near(specular->value[0], light.lobe_strength[c], 1e-12 * scale);
    for (int i = 0; i < diffuse->n; i++)
      assert_near(diffuse->value[i], scale * s.body[c] * cos(diffuse->angle_rad[i]), 2e-3 * scale);
    for (int i = 0; i < specular->n; i++)
      if (specular->angle_rad[i] < 60 * LIT_DEG) /* as far as this light shows */
        assert_near(specular->value[i],
                    scale * s.gloss[c] * lit_lobe_at(&s, 2 * sin(specular->angle_rad[i] / 2)),
                    5e-3 * scale);
  }
}

static void test_curves_are_the_truth(void **state)
{
  (void)state;
  curves_are_true(LIT_PLAIN, 1);
  curves_are_true(LIT_FORESHORTENED, 3000);
}

static void test_a_matte_ball_has_a_body_alone(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  s.lobe = LIT_MATTE;
  s.noise = 0.002;
  s.channels = 3;
  s.body[1] = 0.2;
  const hl_light light = noisy(&s, 3);
  assert_shape(&light);
  assert_int_equal(light.lobe, HL_LOBE_AUTO);
  assert_int_equal(light.n_curves, 3);
  for (int c = 0; c < 3; c++) {
    assert_near(light.diffuse_strength[c], s.body[c], 0.002);
    assert_near(light.lobe_strength[c], 0, 0);
  }
  assert_near(light.color[0], 1, 0.01);
  assert_near(light.color[1], 0.5, 0.01);
}

/* The light's colour is the lobe's, whatever the body's. */
static void test_colour_is_the_lobes(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  s.channels = 3;
  s.width = 0.3;
  const double body[3] = {0.1, 0.2, 0.7}, gloss[3] = {0.8, 0.6, 0.2};
  memcpy(s.body, body, sizeof body);
  memcpy(s.gloss, gloss, sizeof gloss);
  const hl_light light = lit_estimate(&s, NULL);
  for (int c = 0; c < 3; c++)
    assert_near(light.color[c], gloss[c] / 0.8, 0.005);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_shape_holds_whatever_the_material),
      cmocka_unit_test(test_shape_holds_for_data_of_another_shape),
      cmocka_unit_test(test_names),
      cmocka_unit_test(test_curves_are_the_truth),
      cmocka_unit_test(test_a_matte_ball_has_a_body_alone),
      cmocka_unit_test(test_colour_is_the_lobes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
