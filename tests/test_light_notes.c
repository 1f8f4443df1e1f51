/* Verdicts: each has its words, and the words fit the frame. */
#include "../src/light_work.h"
#include "files.h"
#include "halflight/notes.h"
#include "light_scene.h"

static const hl_note *note_of(const hl_notes *notes, const char *what)
{
  for (int i = 0; i < notes->n; i++)
    if (strcmp(notes->note[i].what, what) == 0)
      return &notes->note[i];
  return NULL;
}

static void assert_noted(const hl_notes *notes, const char *what, const char *part)
{
  const hl_note *note = note_of(notes, what);
  if (!note)
    print_error("no note `%s'\n", what);
  assert_non_null(note);
  assert_says(note->why, part);
}

/* Every note has words, of one line, not cut short; `trusted` is the absence of reasons. */
static void assert_sound(const hl_light *light)
{
  const hl_notes *const all[3] = {&light->reasons, &light->used, &light->left_out};
  for (int k = 0; k < 3; k++) {
    assert_true(all[k]->n >= 0 && all[k]->n <= HL_NOTES_MAX);
    for (int i = 0; i < all[k]->n; i++) {
      const hl_note *note = &all[k]->note[i];
      assert_true(strlen(note->what) > 0 && strlen(note->what) < sizeof note->what - 1);
      assert_says(note->why, "");
      assert_true(strlen(note->why) < sizeof note->why - 1);
      assert_null(strstr(note->why, "nan"));
      assert_null(strstr(note->why, "inf"));
    }
  }
  assert_int_equal(light->trusted, light->reasons.n == 0);
}

static hl_light noisy(lit_scene *s)
{
  test_random random = {5};
  s->noise = 0.002;
  hl_surface surface = lit_surface(s);
  hl_frame frame = lit_frame(s, &surface, &random);
  hl_light out;
  assert_int_equal(lit_status(&frame, &surface, NULL, NULL, &out), HL_OK);
  lit_frame_free(&frame);
  hl_surface_free(&surface);
  assert_sound(&out);
  return out;
}

static void test_glossy_under_oblique_light_is_unique(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  const hl_light light = noisy(&s);
  assert_true(light.trusted);
  assert_int_equal(light.verdict, HL_UNIQUE);
  assert_non_null(strstr(light.proposition, "Proposition 5"));
  assert_true(strlen(light.stays_free) > 0);
  assert_noted(&light.used, "plain lobe", "%");
  assert_noted(&light.left_out, "foreshortened lobe", "");
  assert_noted(&light.left_out, "ambient", "%");
  assert_null(note_of(&light.used, "censored clipping"));
}

/* Remark 3: with the light at the view the two axes are one. */
static void test_light_at_the_view_is_said_to_be_ambiguous(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  for (int i = 0; i < 3; i++)
    s.light[i] = -s.ball.center_m[i] / hl_norm(s.ball.center_m);
  const hl_light light = noisy(&s);
  assert_near(lit_error_deg(&s, &light), 0, 0.05);
  assert_int_equal(light.verdict, HL_AMBIGUOUS);
  assert_non_null(strstr(light.proposition, "Remark 3"));
  assert_true(strlen(light.stays_free) > 0);
}

static void test_a_matte_ball_is_said_to_be_matte(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  s.lobe = LIT_MATTE;
  const hl_light light = noisy(&s);
  assert_int_equal(light.verdict, HL_UNIQUE);
  assert_non_null(strstr(light.proposition, "Propositions 1 and 2"));
  assert_noted(&light.left_out, "lobe", "matte");
  assert_near(light.evidence_highlight, 0, 0.01);
}

/* No body: the lobe's axis alone. */
static void test_a_mirror_without_a_body_is_one_curve(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  s.body[0] = 0;
  s.width = 0.2;
  const hl_light light = lit_estimate(&s, NULL);
  assert_sound(&light);
  assert_int_equal(light.verdict, HL_UNIQUE);
  assert_true(strstr(light.proposition, "Propositions 1 and 2") != NULL ||
              light.diffuse_strength[0] > 0);
  assert_near(light.diffuse_strength[0], 0, 1e-3);
  assert_near(light.evidence_highlight, 1, 0.05);
}

static void test_clipping_is_said(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  s.saturation = 0.6;
  const hl_light light = noisy(&s);
  char count[16];
  snprintf(count, sizeof count, "%d pixels", light.n_clipped);
  assert_true(light.n_clipped > 50);
  assert_noted(&light.used, "censored clipping", count);
  assert_true(light.trusted);
}

/* Four fifths of what is lit are clipped: an answer, but not one to trust. */
static void test_too_much_clipping_is_a_reason(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  s.saturation = 0.08;
  const hl_light light = noisy(&s);
  assert_true(light.found);
  assert_false(light.trusted);
  assert_noted(&light.reasons, "clipped", "expose less");
}

static void test_ambient_is_used_when_it_is_there(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  s.ambient = 0.1;
  const hl_light light = noisy(&s);
  assert_noted(&light.used, "ambient", "%");
  assert_true(light.trusted);
}

static void test_the_lobe_that_was_asked_for(void **state)
{
  (void)state;
  const lit_scene s = lit_glossy();
  hl_light_settings settings = hl_light_defaults();
  settings.lobe = HL_LOBE_FORESHORTENED;
  const hl_light light = lit_estimate(&s, &settings);
  assert_sound(&light);
  assert_int_equal(light.lobe, HL_LOBE_FORESHORTENED);
  assert_noted(&light.left_out, "plain lobe", "not asked for");
}

/* What is known of the geometry's uncertainty, and whether the ball follows the camera. */
static void test_uncertain_geometry_is_said(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  s.across = 2;
  hl_light light = noisy(&s);
  assert_noted(&light.left_out, "pose uncertainty", "without a covariance");
  assert_noted(&light.left_out, "camera uncertainty", "states none");
  s.ball.has_covariance = true;
  s.ball.covariance_m2[2][2] = 1e-10;
  light = noisy(&s);
  assert_noted(&light.used, "pose uncertainty", "part of the ellipse");
  s.camera.has_covariance = true;
  s.camera.covariance[0] = 0.01;
  light = noisy(&s);
  assert_noted(&light.used, "camera uncertainty", "does not say how it depends on the camera");
  s.ball.n_intrinsics = 4;
  light = noisy(&s);
  assert_noted(&light.used, "camera uncertainty", "found through it");
  s.ball.n_intrinsics = 9;
  light = noisy(&s);
  assert_noted(&light.used, "camera uncertainty", "a camera of 9 intrinsics, this one has 4");
}

/* A ball half painted: one material under one light does not explain it. */
static void test_what_the_model_does_not_explain_is_a_reason(void **state)
{
  (void)state;
  test_random random = {6};
  lit_scene s = lit_glossy();
  hl_surface surface = lit_surface(&s);
  hl_frame frame = lit_frame(&s, &surface, NULL);
  for (int i = 0; i < surface.n; i++)
    frame.radiance[surface.pixel[i]] = (float)random_uniform(&random);
  hl_light light;
  assert_int_equal(lit_status(&frame, &surface, NULL, NULL, &light), HL_OK);
  assert_sound(&light);
  assert_false(light.trusted);
  assert_noted(&light.reasons, "model", "explains");
  lit_frame_free(&frame);
  hl_surface_free(&surface);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_glossy_under_oblique_light_is_unique),
      cmocka_unit_test(test_light_at_the_view_is_said_to_be_ambiguous),
      cmocka_unit_test(test_a_matte_ball_is_said_to_be_matte),
      cmocka_unit_test(test_uncertain_geometry_is_said),
      cmocka_unit_test(test_a_mirror_without_a_body_is_one_curve),
      cmocka_unit_test(test_clipping_is_said),
      cmocka_unit_test(test_too_much_clipping_is_a_reason),
      cmocka_unit_test(test_ambient_is_used_when_it_is_there),
      cmocka_unit_test(test_the_lobe_that_was_asked_for),
      cmocka_unit_test(test_what_the_model_does_not_explain_is_a_reason),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
