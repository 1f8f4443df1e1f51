/* LIGHT.json: the members the file format fixes, numbers that survive the way through text. */
#define _XOPEN_SOURCE 700
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "halflight/export.h"
#include "near.h"

static const double PI = 3.14159265358979323846;

static void note(hl_notes *notes, const char *what, const char *why)
{
  snprintf(notes->note[notes->n].what, sizeof notes->note->what, "%s", what);
  snprintf(notes->note[notes->n].why, sizeof notes->note->why, "%s", why);
  notes->n++;
}

static hl_curve curve(const char *lobe, const char *channel, double height)
{
  hl_curve c = {.lobe = lobe, .channel = channel, .n = 3};
  for (int i = 0; i < c.n; i++) {
    c.angle_rad[i] = i * PI / 12;
    c.value[i] = height / (1 + 3 * i);
  }
  return c;
}

/* A light whose numbers have no short decimal form. */
static hl_light sample(void)
{
  hl_light l = {.trusted = true,
                .found = true,
                .direction = {1.0 / 3, -2.0 / 3, -2.0 / 3},
                .tangent_basis = {{2.0 / 3, 2.0 / 3, -1.0 / 3}, {2.0 / 3, -1.0 / 3, 2.0 / 3}},
                .covariance_rad2 = {{1e-9 / 3, 1e-10 / 7}, {1e-10 / 7, 1e-9 / 9}},
                .ellipse_95_rad = {PI / 1800, PI / 18000},
                .part_stated = {true, true, false, true},
                .part_95_rad = {{PI / 3600, PI / 36000}, {0, 0}, {1, 1}, {PI / 900, PI / 1800}},
                .color = {1, 0.9, 0.1},
                .lobe = HL_LOBE_FORESHORTENED,
                .half_angle_direction = {0.6, 0, -0.8},
                .diffuse_strength = {0.1, 0.2, 0.3},
                .lobe_strength = {0.4, 0.5, 0.7},
                .evidence_highlight = 0.75,
                .channels = 3,
                .n_curves = 2,
                .n_pixels = 1000,
                .n_clipped = 17,
                .n_outliers = 3,
                .iterations = 8,
                .rms = 0.001 / 3,
                .relative_error = 0.0123,
                .condition = 4.5,
                .verdict = HL_NOT_GUARANTEED,
                .proposition = "Proposition 3",
                .stays_free = "k n.h"};
  l.curves[0] = curve("diffuse", "r", 0.1);
  l.curves[1] = curve("specular", "r", 0.4);
  note(&l.used, "perspective view", "half-angle 3 deg");
  note(&l.left_out, "ambient", "gain 0.02 % < 0.5 %");
  return l;
}

static json_t *parsed(const hl_light *light, const hl_timing *timing)
{
  char *text = NULL;
  json_error_t error;
  assert_int_equal(hl_light_json(NULL, light, timing, &text), HL_OK);
  json_t *document = json_loads(text, JSON_REJECT_DUPLICATES, &error);
  if (!document)
    fail_msg("line %d: %s", error.line, error.text);
  free(text);
  return document;
}

static double number_at(const json_t *array, size_t i)
{
  const json_t *value = json_array_get(array, i);
  assert_true(json_is_number(value));
  return json_number_value(value);
}

static double member(const json_t *object, const char *name)
{
  const json_t *value = json_object_get(object, name);
  assert_true(json_is_number(value));
  return json_number_value(value);
}

static void assert_text(const json_t *object, const char *name, const char *want)
{
  const char *got = json_string_value(json_object_get(object, name));
  assert_non_null(got);
  assert_string_equal(got, want);
}

static void test_members(void **state)
{
  (void)state;
  const hl_light light = sample();
  const hl_timing timing = {1.5, 2.5, 3.5, 4.5};
  json_t *d = parsed(&light, &timing);
  static const char *const names[] = {"format", "version",  "status",   "reasons",
                                      "lights", "lobes",    "curves",   "fit",
                                      "used",   "left_out", "timing_ms"};
  size_t i = 0;
  const char *key;
  json_t *value;
  json_object_foreach(d, key, value)
  {
    assert_true(i < sizeof names / sizeof *names);
    assert_string_equal(key, names[i]);
    i++;
  }
  assert_int_equal(i, sizeof names / sizeof *names);
  assert_text(d, "format", "halflight-light");
  assert_near(member(d, "version"), 1, 0);
  assert_text(d, "status", "ok");
  assert_int_equal(json_array_size(json_object_get(d, "reasons")), 0);
  assert_string_equal(json_string_value(json_array_get(json_object_get(d, "used"), 0)),
                      "perspective view");
  const json_t *left = json_array_get(json_object_get(d, "left_out"), 0);
  assert_text(left, "what", "ambient");
  assert_text(left, "why", "gain 0.02 % < 0.5 %");
  const json_t *times = json_object_get(d, "timing_ms");
  assert_near(member(times, "read"), 1.5, 0);
  assert_near(member(times, "locate"), 2.5, 0);
  assert_near(member(times, "estimate"), 3.5, 0);
  assert_near(member(times, "export"), 4.5, 0);
  json_decref(d);
}

static void test_light_survives_text(void **state)
{
  (void)state;
  const hl_light light = sample();
  json_t *d = parsed(&light, NULL);
  const json_t *one = json_array_get(json_object_get(d, "lights"), 0);
  const json_t *basis = json_object_get(one, "tangent_basis");
  const json_t *covariance = json_object_get(one, "covariance_rad2");
  for (size_t i = 0; i < 3; i++) {
    assert_near(number_at(json_object_get(one, "direction"), i), light.direction[i], 0);
    assert_near(number_at(json_object_get(one, "color"), i), light.color[i], 0);
    for (size_t k = 0; k < 2; k++)
      assert_near(number_at(json_array_get(basis, k), i), light.tangent_basis[k][i], 0);
  }
  for (size_t i = 0; i < 2; i++)
    for (size_t k = 0; k < 2; k++)
      assert_near(number_at(json_array_get(covariance, i), k), light.covariance_rad2[i][k], 0);
  /* analytic: pi/1800 is a tenth of a degree */
  assert_near(number_at(json_object_get(one, "ellipse_95_deg"), 0), 0.1, 1e-16);
  assert_near(number_at(json_object_get(one, "ellipse_95_deg"), 1), 0.01, 1e-17);
  const json_t *parts = json_object_get(one, "ellipse_parts_deg");
  assert_int_equal(json_object_size(parts), 4);
  assert_near(number_at(json_object_get(parts, "noise"), 0), 0.05, 1e-16);
  assert_near(number_at(json_object_get(parts, "noise"), 1), 0.005, 1e-17);
  assert_near(number_at(json_object_get(parts, "model"), 0), 0, 0);
  assert_near(number_at(json_object_get(parts, "camera"), 0), 0.2, 1e-16);
  assert_near(number_at(json_object_get(parts, "camera"), 1), 0.1, 1e-16);
  /* nothing is known of it, which is not the same as nothing */
  assert_true(json_is_null(json_object_get(parts, "pose")));
  assert_true(json_is_null(json_object_get(one, "position_m")));
  assert_true(json_is_null(json_object_get(d, "timing_ms")));
  json_decref(d);
}

static void test_lobes_and_curves(void **state)
{
  (void)state;
  const hl_light light = sample();
  json_t *d = parsed(&light, NULL);
  const json_t *diffuse = json_array_get(json_object_get(d, "lobes"), 0);
  const json_t *specular = json_array_get(json_object_get(d, "lobes"), 1);
  assert_text(diffuse, "name", "diffuse");
  assert_text(diffuse, "axis", "light");
  assert_near(number_at(json_object_get(diffuse, "strength"), 2), 0.3, 0);
  assert_text(specular, "name", "specular");
  assert_text(specular, "axis", "half-angle");
  assert_text(specular, "foreshortening", "1/(n.v)");
  assert_near(number_at(json_object_get(specular, "direction"), 2), -0.8, 0);
  const json_t *curves = json_object_get(d, "curves");
  assert_int_equal(json_array_size(curves), 2);
  const json_t *c = json_array_get(curves, 1);
  assert_text(c, "lobe", "specular");
  assert_text(c, "channel", "r");
  assert_text(c, "quantity", "radiance");
  assert_int_equal(json_array_size(json_object_get(c, "angle_deg")), 3);
  assert_near(number_at(json_object_get(c, "angle_deg"), 2), 30, 1e-13);
  assert_near(number_at(json_object_get(c, "value"), 2), 0.4 / 7, 0);
  json_decref(d);
}

static void test_fit(void **state)
{
  (void)state;
  const hl_light light = sample();
  json_t *d = parsed(&light, NULL);
  const json_t *fit = json_object_get(d, "fit");
  assert_near(member(fit, "pixels"), 1000, 0);
  assert_near(member(fit, "clipped"), 17, 0);
  assert_near(member(fit, "outliers"), 3, 0);
  assert_near(member(fit, "iterations"), 8, 0);
  assert_near(member(fit, "rms"), light.rms, 0);
  assert_near(member(fit, "relative_error"), light.relative_error, 0);
  assert_near(member(fit, "condition"), 4.5, 0);
  assert_text(fit, "lobe", "foreshortened");
  assert_near(member(json_object_get(fit, "evidence"), "highlight"), 0.75, 0);
  assert_near(member(json_object_get(fit, "evidence"), "shading"), 0.25, 0);
  const json_t *identifiability = json_object_get(fit, "identifiability");
  assert_text(identifiability, "verdict", "not guaranteed");
  assert_text(identifiability, "proposition", "Proposition 3");
  assert_text(identifiability, "free", "k n.h");
  json_decref(d);
}

static void test_verdicts(void **state)
{
  (void)state;
  static const char *const words[] = {"unique", "ambiguous", "not guaranteed"};
  for (int v = HL_UNIQUE; v <= HL_NOT_GUARANTEED; v++) {
    hl_light light = sample();
    light.verdict = (hl_identifiability)v;
    json_t *d = parsed(&light, NULL);
    assert_text(json_object_get(json_object_get(d, "fit"), "identifiability"), "verdict", words[v]);
    json_decref(d);
  }
}

static void test_plain_and_matte(void **state)
{
  (void)state;
  hl_light light = sample();
  light.lobe = HL_LOBE_PLAIN;
  json_t *d = parsed(&light, NULL);
  assert_text(json_array_get(json_object_get(d, "lobes"), 1), "foreshortening", "none");
  json_decref(d);
  light.lobe = HL_LOBE_AUTO; /* no lobe: a matte ball */
  light.n_curves = 1;
  d = parsed(&light, NULL);
  assert_int_equal(json_array_size(json_object_get(d, "lobes")), 1);
  assert_text(json_object_get(d, "fit"), "lobe", "none");
  json_decref(d);
}

static void test_grey_frame_has_three_equal_colours(void **state)
{
  (void)state;
  hl_light light = sample();
  light.channels = 1;
  json_t *d = parsed(&light, NULL);
  const json_t *strength =
      json_object_get(json_array_get(json_object_get(d, "lobes"), 0), "strength");
  const json_t *color = json_object_get(json_array_get(json_object_get(d, "lights"), 0), "color");
  for (size_t i = 0; i < 3; i++) {
    assert_near(number_at(strength, i), 0.1, 0);
    assert_near(number_at(color, i), 1, 0);
  }
  json_decref(d);
}

static void test_untrusted(void **state)
{
  (void)state;
  hl_light light = sample();
  light.trusted = false;
  note(&light.reasons, "clipped", "61 % of the highlight");
  note(&light.reasons, "", "no more \"light\"\n");
  json_t *d = parsed(&light, NULL);
  assert_text(d, "status", "untrusted");
  const json_t *reasons = json_object_get(d, "reasons");
  assert_string_equal(json_string_value(json_array_get(reasons, 0)),
                      "clipped: 61 % of the highlight");
  assert_string_equal(json_string_value(json_array_get(reasons, 1)), "no more \"light\"\n");
  assert_int_equal(json_array_size(json_object_get(d, "lights")), 1);
  json_decref(d);
}

/* Without a direction only the reasons mean anything, whatever else the struct holds. */
static void test_nothing_found(void **state)
{
  (void)state;
  hl_light light = sample();
  light.found = false;
  note(&light.reasons, "black", "no pixel above the noise");
  json_t *d = parsed(&light, NULL);
  assert_text(d, "status", "untrusted");
  static const char *const lists[] = {"lights", "lobes", "curves", "used", "left_out"};
  for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
    assert_true(json_is_array(json_object_get(d, lists[i])));
    assert_int_equal(json_array_size(json_object_get(d, lists[i])), 0);
  }
  assert_int_equal(json_array_size(json_object_get(d, "reasons")), 1);
  assert_true(json_is_null(json_object_get(json_object_get(d, "fit"), "rms")));
  json_decref(d);
}

static void test_not_finite_becomes_null(void **state)
{
  (void)state;
  hl_light light = sample();
  light.condition = INFINITY;
  light.ellipse_95_rad[0] = NAN;
  json_t *d = parsed(&light, NULL);
  assert_true(json_is_null(json_object_get(json_object_get(d, "fit"), "condition")));
  const json_t *one = json_array_get(json_object_get(d, "lights"), 0);
  assert_true(json_is_null(json_array_get(json_object_get(one, "ellipse_95_deg"), 0)));
  json_decref(d);
}

static void test_same_text_every_time(void **state)
{
  (void)state;
  const hl_light light = sample();
  char *a = NULL;
  char *b = NULL;
  assert_int_equal(hl_light_json(NULL, &light, NULL, &a), HL_OK);
  assert_int_equal(hl_light_json(NULL, &light, NULL, &b), HL_OK);
  assert_string_equal(a, b);
  assert_int_equal(a[strlen(a) - 1], '\n');
  free(a);
  free(b);
}

static void test_file(void **state)
{
  (void)state;
  char folder[] = "/tmp/halflight-XXXXXX";
  char path[64];
  char got[20000];
  char *want = NULL;
  const hl_light light = sample();
  assert_non_null(mkdtemp(folder));
  snprintf(path, sizeof path, "%s/light.json", folder);
  assert_int_equal(hl_light_json_write(NULL, path, &light, NULL), HL_OK);
  assert_int_equal(hl_light_json(NULL, &light, NULL, &want), HL_OK);
  FILE *f = fopen(path, "rb");
  assert_non_null(f);
  const size_t n = fread(got, 1, sizeof got - 1, f);
  fclose(f);
  got[n] = '\0';
  assert_string_equal(got, want);
  free(want);
  unlink(path);
  rmdir(folder);
}

static void test_no_folder_is_refused(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  const hl_light light = sample();
  assert_int_equal(hl_light_json_write(&ctx, "/no/such/folder/light.json", &light, NULL),
                   HL_ERR_IO);
  assert_non_null(strstr(ctx.msg, "/no/such/folder/light.json"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_members),
      cmocka_unit_test(test_light_survives_text),
      cmocka_unit_test(test_lobes_and_curves),
      cmocka_unit_test(test_fit),
      cmocka_unit_test(test_verdicts),
      cmocka_unit_test(test_plain_and_matte),
      cmocka_unit_test(test_grey_frame_has_three_equal_colours),
      cmocka_unit_test(test_untrusted),
      cmocka_unit_test(test_nothing_found),
      cmocka_unit_test(test_not_finite_becomes_null),
      cmocka_unit_test(test_same_text_every_time),
      cmocka_unit_test(test_file),
      cmocka_unit_test(test_no_folder_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
