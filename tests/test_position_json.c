/* POSITION.json holds what the position holds; what is infinite is null. */
#include <jansson.h>

#include "files.h"
#include "halflight/position.h"

static json_t *document_of(const hl_position *p)
{
  static const char *const names[] = {"a \"b\".json", "c.json"};
  char *text = NULL;
  assert_int_equal(hl_position_json(NULL, p, names, &text), HL_OK);
  json_t *root = json_loads(text, 0, NULL);
  free(text);
  assert_non_null(root);
  return root;
}

static hl_position some_position(void)
{
  hl_position p = {.trusted = true,
                   .found = true,
                   .position_m = {1, 2, 3},
                   .covariance_m2 = {{0.1, 0.2, 0.3}, {0.2, 0.4, 0.5}, {0.3, 0.5, 0.6}},
                   .direction = {0, 0, 1},
                   .distance_m = 3,
                   .distance_95_m = {2, 5},
                   .least_distance_m = 2.5,
                   .dof = 1,
                   .n = 2,
                   .n_used = 1};
  p.sight[0].used = true;
  p.sight[1].off_rad = 0.017453292519943295;
  return p;
}

static double number(const json_t *root, const char *member, size_t i)
{
  return json_number_value(json_array_get(json_object_get(root, member), i));
}

static void test_found(void **state)
{
  (void)state;
  const hl_position p = some_position();
  json_t *root = document_of(&p);
  assert_string_equal(json_string_value(json_object_get(root, "format")), "halflight-position");
  assert_string_equal(json_string_value(json_object_get(root, "status")), "ok");
  assert_near(number(root, "position_m", 1), 2, 0);
  const json_t *row = json_array_get(json_object_get(root, "covariance_m2"), 1);
  assert_near(json_number_value(json_array_get(row, 2)), 0.5, 0);
  assert_near(number(root, "distance_95_m", 1), 5, 0);
  const json_t *second = json_array_get(json_object_get(root, "sights"), 1);
  assert_string_equal(json_string_value(json_object_get(second, "name")), "c.json");
  assert_true(json_is_false(json_object_get(second, "used")));
  assert_near(json_number_value(json_object_get(second, "off_deg")), 1, 1e-12);
  json_decref(root);
}

static void test_not_found(void **state)
{
  (void)state;
  hl_position p = some_position();
  p.found = p.trusted = false;
  p.distance_m = p.distance_95_m[1] = HUGE_VAL;
  json_t *root = document_of(&p);
  assert_string_equal(json_string_value(json_object_get(root, "status")), "untrusted");
  assert_true(json_is_null(json_object_get(root, "position_m")));
  assert_true(json_is_null(json_object_get(root, "covariance_m2")));
  assert_true(json_is_null(json_object_get(root, "distance_m")));
  assert_near(json_number_value(json_object_get(root, "least_distance_m")), 2.5, 0);
  json_decref(root);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_found),
      cmocka_unit_test(test_not_found),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
