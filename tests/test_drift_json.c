/* What `drift --json` prints. */
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/drift.h"
#include "near.h"

static hl_drift some_drift(void)
{
  hl_drift d = {.drifted = true,
                .significance = 1e-20,
                .false_alarm = 0.01,
                .n_causes = 2,
                .mean_px = 0.5,
                .max_px = 1.5,
                .implied = {{0.001, 0, 0}, {0, 0, 0.25}}};
  d.cause[0] = (hl_drift_cause){"intrinsics", "focal length", 3.5, 0.4,        "px",
                                1e-19,        true,           2,   {3.4, 3.6}, {0.1, 0.2}};
  d.cause[1] =
      (hl_drift_cause){"mount", "translation", 0, NAN, "m", 1, false, 3, {0, 0, 0}, {1, 1, 1}};
  d.notes.n = 1;
  d.notes.note[0] = (hl_note){"mount", "said \"so\""};
  return d;
}

static void test_members(void **state)
{
  (void)state;
  const hl_drift d = some_drift();
  char *text = NULL;
  assert_int_equal(hl_drift_json(NULL, &d, &text), HL_OK);
  json_t *root = json_loads(text, 0, NULL);
  free(text);
  assert_non_null(root);
  const char *format, *verdict, *what, *part, *unit, *why;
  int version, moved;
  double significance, rate, figure, threshold, probability, change, deviation, mean, max, shift;
  json_t *second;
  assert_int_equal(
      json_unpack(root,
                  "{s:s,s:i,s:s,s:f,s:f,s:[{s:s,s:s,s:b,s:f,s:f,s:s,s:f,s:[f*],s:[f*]},o],"
                  "s:{s:f,s:f},s:{s:[f*],s:[F,F,f]},s:[{s:s}]}",
                  "format", &format, "version", &version, "verdict", &verdict, "significance",
                  &significance, "false_alarm", &rate, "causes", "what", &what, "part", &part,
                  "moved", &moved, "figure", &figure, "threshold", &threshold, "unit", &unit,
                  "significance", &probability, "change", &change, "deviation", &deviation, &second,
                  "projection_difference_px", "mean", &mean, "max", &max, "implied_motion",
                  "rotation_rad", &change, "translation_m", &shift, &shift, &shift, "notes", "why",
                  &why),
      0);
  assert_string_equal(format, "halflight-drift");
  assert_int_equal(version, 1);
  assert_string_equal(verdict, "drifted");
  assert_near(significance, 1e-20, 0);
  assert_near(rate, 0.01, 0);
  assert_string_equal(what, "intrinsics");
  assert_string_equal(part, "focal length");
  assert_string_equal(unit, "px");
  assert_true(moved);
  assert_near(figure, 3.5, 0);
  assert_near(threshold, 0.4, 0);
  assert_near(probability, 1e-19, 0);
  assert_near(deviation, 0.1, 0);
  assert_near(mean, 0.5, 0);
  assert_near(max, 1.5, 0);
  assert_near(shift, 0.25, 0);
  assert_string_equal(why, "said \"so\"");
  /* nothing tells it: no number */
  assert_true(json_is_null(json_object_get(second, "threshold")));
  assert_true(json_is_false(json_object_get(second, "moved")));
  assert_int_equal(json_array_size(json_object_get(second, "change")), 3);
  json_decref(root);
}

static void test_same(void **state)
{
  (void)state;
  hl_drift d = some_drift();
  char *text = NULL;
  d.drifted = false;
  d.n_causes = d.notes.n = 0;
  d.mean_px = NAN;
  assert_int_equal(hl_drift_json(NULL, &d, &text), HL_OK);
  json_t *root = json_loads(text, 0, NULL);
  free(text);
  assert_string_equal(json_string_value(json_object_get(root, "verdict")), "same");
  assert_int_equal(json_array_size(json_object_get(root, "causes")), 0);
  assert_true(json_is_array(json_object_get(root, "notes")));
  assert_true(
      json_is_null(json_object_get(json_object_get(root, "projection_difference_px"), "mean")));
  json_decref(root);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_members),
      cmocka_unit_test(test_same),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
