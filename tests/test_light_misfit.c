/* What the model's share of the ellipse is where the model holds, and where it does not. */
#include "../src/light_work.h"
#include "term_scene.h"

static const double inside = 5.991464547107982; /* chi-square, 2 degrees, 95 % */

/* d' C^-1 d of the truth. */
static double distance2(const hl_light *light, const double truth[3])
{
  const double(*c)[2] = light->covariance_rad2;
  const double d[2] = {hl_dot(light->tangent_basis[0], truth),
                       hl_dot(light->tangent_basis[1], truth)};
  const double det = c[0][0] * c[1][1] - c[0][1] * c[1][0];
  return (c[1][1] * d[0] * d[0] - 2 * c[0][1] * d[0] * d[1] + c[0][0] * d[1] * d[1]) / det;
}

static void test_relative_size(void **state)
{
  (void)state;
  double one[2][2] = {{1, 0}, {0, 1}}, twice[2][2] = {{2, 0}, {0, 2}}, a[2][2] = {{3, 1}, {1, 3}};
  double tilted[2][2] = {{2, 1}, {1, 2}}, flat[2][2] = {{1, 1}, {1, 1}};
  assert_near(hl_light_relative_size(a, one), 4, 1e-12);
  assert_near(hl_light_relative_size(a, twice), 2, 1e-12);
  assert_near(hl_light_relative_size(tilted, tilted), 1, 1e-12);
  assert_near(hl_light_relative_size(a, tilted), 2, 1e-12); /* 2/1 along (1,-1), 4/3 along (1,1) */
  assert_near(hl_light_relative_size(a, flat), 1, 1e-12);   /* no covariance to compare with */
}

/* Where it holds, the model's share of the trace is a small one: sampling alone. */
static void test_little_where_the_model_holds(void **state)
{
  (void)state;
  enum { DRAWS = 6 };
  static const lit_lobe lobes[] = {LIT_MATTE, LIT_PLAIN, LIT_FORESHORTENED};
  for (int k = 0; k < 3; k++) {
    double noise = 0, model = 0;
    lit_scene s = lit_glossy();
    s.lobe = lobes[k];
    s.width = 0.25;
    s.noise = 0.004;
    for (uint64_t draw = 1; draw <= DRAWS; draw++) {
      lit_shot shot = lit_shot_of(&s, draw);
      const hl_light light = lit_light_of(&shot, NULL);
      lit_shot_free(&shot);
      noise += light.part_rad2[HL_PART_NOISE][0][0] + light.part_rad2[HL_PART_NOISE][1][1];
      model += light.part_rad2[HL_PART_MODEL][0][0] + light.part_rad2[HL_PART_MODEL][1][1];
    }
    if (!(model < 0.5 * noise))
      print_error("lobe %d: model %.3g, noise %.3g\n", k, model, noise);
    assert_true(model < 0.5 * noise);
  }
}

/* Fresnel and masking, a lobe about the mirror direction, a rough body: nothing that the model describes. The
 * noise's ellipse alone holds few of the lights, the whole one nearly all. */
static void test_holds_the_light_where_the_model_does_not(void **state)
{
  (void)state;
  static const term_shader shaders[] = {TERM_GGX, TERM_PHONG, TERM_OREN_NAYAR};
  static const double angles[] = {20, 40, 60, 75};
  int all = 0, held = 0, held_by_noise = 0;
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 4; i++) {
      term_scene t = term_ball(shaders[k]);
      for (int c = 0; c < 3; c++)
        t.roughness[c] = shaders[k] == TERM_OREN_NAYAR ? 0.5 : 0.35;
      lit_direction(angles[i], 100 * i - 60, t.base.light);
      hl_light light = term_estimate(&t, NULL, (uint64_t)(10 * k + i + 1));
      const double m2 = distance2(&light, t.base.light);
      memcpy(light.covariance_rad2, light.part_rad2[HL_PART_NOISE], sizeof light.covariance_rad2);
      const double by_noise = distance2(&light, t.base.light);
      print_message("shader %d, light at %g deg: m2 %.2f, of the noise alone %.2f\n", k, angles[i],
                    m2, by_noise);
      all++;
      held += m2 < inside;
      held_by_noise += by_noise < inside;
    }
  assert_true(held >= all - 2);
  assert_true(held_by_noise < held - 2);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_relative_size),
      cmocka_unit_test(test_little_where_the_model_holds),
      cmocka_unit_test(test_holds_the_light_where_the_model_does_not),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
