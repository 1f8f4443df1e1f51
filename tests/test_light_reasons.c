/* Each reason, provoked, with the figures it must name. */
#include "../src/light_work.h"
#include "files.h"
#include "halflight/notes.h"
#include "light_data.h"

typedef struct judged {
  lit_data d;
  hl_light_settled settled;
  hl_light_spread spread;
  hl_light light;
} judged;

/* Nothing to complain of, before a test makes it. */
static judged sound(const lit_scene *s)
{
  judged j = {.d = lit_gather(s, NULL)};
  j.spread.explained = j.spread.structure = 1;
  j.settled.variant[0].converged = true;
  memcpy(j.light.direction, s->light, sizeof s->light);
  j.light.mean_view[2] = -1;
  memcpy(j.d.work->best.at.s, s->light, sizeof s->light);
  return j;
}

static const char *reason(judged *j, const char *what)
{
  memset(&j->light.reasons, 0, sizeof j->light.reasons);
  hl_light_judge(j->d.work, &j->settled, &j->spread, &j->light);
  assert_int_equal(j->light.trusted, j->light.reasons.n == 0);
  for (int i = 0; i < j->light.reasons.n; i++) {
    assert_true(strlen(j->light.reasons.note[i].why) < HL_NOTE_TEXT_MAX - 1);
    if (strcmp(j->light.reasons.note[i].what, what) == 0)
      return j->light.reasons.note[i].why;
  }
  return "";
}

/* An ellipse of `wide_deg` that one part makes. */
static void widen(judged *j, hl_light_part part, double wide_deg)
{
  memset(j->light.part_95_rad, 0, sizeof j->light.part_95_rad);
  j->light.part_95_rad[part][0] = j->light.ellipse_95_rad[0] = wide_deg * LIT_DEG;
}

static void test_a_wide_ellipse_names_its_part(void **state)
{
  (void)state;
  lit_scene s = lit_ball(20);
  judged j = sound(&s);
  assert_string_equal(reason(&j, "uncertain"), "");
  assert_true(j.light.trusted);
  widen(&j, HL_PART_NOISE, 10); /* twice too wide: 4 frames, 2 stops, a ball twice as wide */
  assert_says(reason(&j, "uncertain"), "average 4 frames, expose 2.0 stops more");
  assert_false(j.light.trusted);
  widen(&j, HL_PART_MODEL, 10);
  j.spread.structure = 7;
  assert_says(reason(&j, "uncertain"), "structure, 7.0 times noise");
  widen(&j, HL_PART_POSE, 10);
  assert_says(reason(&j, "uncertain"), "locate it more");
  widen(&j, HL_PART_CAMERA, 10);
  assert_says(reason(&j, "uncertain"), "calibrate with more views");
  widen(&j, HL_PART_NOISE, 1);
  assert_string_equal(reason(&j, "uncertain"), "");
  lit_data_free(&j.d);
}

static void test_a_light_behind_the_ball_is_said(void **state)
{
  (void)state;
  lit_scene s = lit_ball(20);
  lit_direction(140, 20, s.light);
  judged j = sound(&s);
  widen(&j, HL_PART_NOISE, 10);
  assert_says(reason(&j, "uncertain"), "140 deg from the view, behind the ball");
  lit_data_free(&j.d);
}

static void test_what_else_is_wrong(void **state)
{
  (void)state;
  lit_scene s = lit_ball(20);
  judged j = sound(&s);
  j.spread.explained = 0.3;
  assert_says(reason(&j, "model"), "explains 30 %");
  j.settled.variant[0].converged = false;
  assert_says(reason(&j, "not converged"), "still moved");
  j.settled.outliers = j.d.work->all.n / 2;
  j.settled.sought = 10 * j.d.work->all.n; /* pixels, of which these are the cells */
  assert_string_equal(reason(&j, "outliers"), "");
  j.settled.sought = j.d.work->all.n;
  assert_says(reason(&j, "outliers"), "50 % of the pixels");
  lit_data_free(&j.d);
}

/* Four codes, on a ball that is settled on its pixels and on one that is settled on cells. */
static void test_too_few_codes(void **state)
{
  (void)state;
  for (int px = 30; px <= 60; px += 30) {
    for (int codes = 4; codes <= 4096; codes *= 1024) {
      lit_scene s = lit_ball(px);
      judged j = sound(&s);
      const size_t n = (size_t)j.d.frame.width * (size_t)j.d.frame.height;
      float most = 0;
      for (size_t i = 0; i < n; i++)
        most = fmaxf(most, j.d.frame.radiance[i]);
      for (size_t i = 0; i < n; i++)
        j.d.frame.radiance[i] =
            roundf(j.d.frame.radiance[i] / most * (float)(codes - 1)) / (float)(codes - 1);
      assert_int_equal(hl_light_estimate(NULL, j.d.work, &j.d.frame, &j.d.surface, NULL, &j.light),
                       HL_OK);
      const char *why = "";
      for (int i = 0; i < j.light.reasons.n; i++)
        if (strcmp(j.light.reasons.note[i].what, "codes") == 0)
          why = j.light.reasons.note[i].why;
      if (codes == 4)
        assert_says(why, "too few codes");
      else
        assert_string_equal(why, "");
      lit_data_free(&j.d);
    }
  }
}

/* A bell clipped some stops below its peak: the flank that is left tells how many. */
static void test_stops_from_the_flank(void **state)
{
  (void)state;
  for (int stops = 1; stops <= 3; stops++) {
    lit_scene s = lit_ball(40);
    s.width = 0.4;
    s.body[0] = 1e-3;
    s.gloss[0] = 1;
    s.saturation = pow(2, -stops);
    judged j = sound(&s);
    assert_int_equal(hl_light_estimate(NULL, j.d.work, &j.d.frame, &j.d.surface, NULL, &j.light),
                     HL_OK);
    j.d.work->brightness.lit = j.d.work->brightness.clipped;
    const char *why = reason(&j, "clipped"), *by = strstr(why, "by ");
    assert_says(why, "100 % of the lit pixels are clipped");
    assert_non_null(by);
    assert_near(strtod(by + 3, NULL), stops, 0.35);
    lit_data_free(&j.d);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_a_wide_ellipse_names_its_part),
      cmocka_unit_test(test_a_light_behind_the_ball_is_said),
      cmocka_unit_test(test_what_else_is_wrong),
      cmocka_unit_test(test_stops_from_the_flank),
      cmocka_unit_test(test_too_few_codes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
