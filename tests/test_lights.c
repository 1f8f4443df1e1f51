/* lights.json, lights.csv and lights.lp: what goes in comes out, and what is refused. */
#include <locale.h>

#include "files.h"
#include "halflight/lights.h"
#include "halflight/notes.h"
#include "halflight/vec3.h"

static void fill_light(hl_rig_light *l, int i, test_random *r)
{
  double *numbers[] = {l->own_rad2[0], l->covariance_rad2[0]};
  const double d[3] = {0.1 * i, 0.3, -1};
  char text[32];
  snprintf(text, sizeof text, "frame %d.png", i);
  l->file = strdup(text);
  l->label = strdup(i == 1 ? "a,\"b\"" : "");
  l->frame = i;
  l->exposure_us = 1000 + i;
  if (i == 2) {
    assert_true(hl_note_list_add(&l->reasons, "frame", "it is black"));
    return;
  }
  l->found = l->trusted = true;
  hl_unit(d, l->direction);
  hl_tangent_basis(l->direction, l->tangent_basis[0], l->tangent_basis[1]);
  for (int k = 0; k < 2; k++) {
    numbers[k][0] = 1e-6 * (k + 1);
    numbers[k][3] = 2e-6 * (k + 1);
    numbers[k][1] = numbers[k][2] = 1e-7;
    l->ellipse_95_rad[k] = 1e-3 / (k + 1);
    for (int j = 0; j < 3; j++)
      l->by_center[k][j] = random_normal(r);
    for (int j = 0; j < 9; j++)
      l->by_intrinsics[k][j] = random_normal(r);
  }
  for (int k = 0; k < 3; k++) {
    l->color[k] = 1 - 0.1 * k;
    l->intensity[k] = 1 + 0.1 * k;
    l->position_m[k] = l->direction[k];
    l->position_covariance_m2[k][k] = 1e-4;
  }
  l->near = i == 1;
  if (!l->near) {
    memset(l->position_m, 0, sizeof l->position_m);
    memset(l->position_covariance_m2, 0, sizeof l->position_covariance_m2);
  }
  l->intensity_sigma = 0.01;
}

static void fill(hl_lights *out)
{
  test_random r = {11};
  memset(out, 0, sizeof *out);
  out->camera = (hl_camera){
      .width = 640, .height = 480, .fx = 800, .fy = 810, .cx = 320, .cy = 240, .n_distortion = 5};
  out->n_balls = 1;
  out->ball[0] = (hl_sphere){.center_m = {0.1, 0, 1}, .radius_m = 0.05, .has_covariance = true};
  for (int k = 0; k < 3; k++)
    out->ball[0].covariance_m2[k][k] = 1e-8;
  out->n = 3;
  out->light = calloc(3, sizeof *out->light);
  assert_non_null(out->light);
  for (int i = 0; i < 3; i++)
    fill_light(&out->light[i], i, &r);
  hl_notes_add(&out->reasons, "frames", "1 of 3 gave no light");
  hl_notes_add(&out->left_out, "joint", "too few");
  out->light[0].gain = 2;
}

static void test_json_round_trip(void **state)
{
  char path[TEST_PATH_MAX], again[TEST_PATH_MAX];
  path_in(state, "lights.json", path);
  path_in(state, "again.json", again);
  hl_lights a, b;
  fill(&a);
  assert_int_equal(hl_lights_write(NULL, path, &a), HL_OK);
  hl_ctx ctx = {0};
  if (hl_lights_read(&ctx, path, &b) != HL_OK)
    fail_msg("%s", ctx.msg);
  assert_int_equal(b.n, 3);
  assert_int_equal(b.n_balls, 1);
  assert_false(b.trusted);
  assert_string_equal(b.reasons.note[0].why, "1 of 3 gave no light");
  assert_memory_equal(&a.ball[0], &b.ball[0], sizeof a.ball[0]);
  for (int i = 0; i < 3; i++) {
    hl_rig_light one = a.light[i], two = b.light[i];
    assert_string_equal(one.file, two.file);
    assert_string_equal(one.label, two.label);
    one.file = one.label = two.file = two.label = NULL;
    assert_memory_equal(one.direction, two.direction, sizeof one.direction);
    assert_memory_equal(one.by_intrinsics, two.by_intrinsics, sizeof one.by_intrinsics);
    assert_memory_equal(one.position_covariance_m2, two.position_covariance_m2,
                        sizeof one.position_covariance_m2);
    assert_int_equal(one.near, two.near);
    assert_int_equal(one.found, two.found);
  }
  assert_int_equal(hl_lights_write(NULL, again, &b), HL_OK);
  size_t n, m;
  char *first = get_file(path, &n), *second = get_file(again, &m);
  assert_int_equal(n, m);
  assert_memory_equal(first, second, n);
  free(first);
  free(second);
  hl_lights_free(&a);
  hl_lights_free(&b);
}

/* A file with `from` replaced by `to` is refused with a message that holds `part`. */
static void refused(void **state, const char *from, const char *to, const char *part)
{
  char path[TEST_PATH_MAX];
  path_in(state, "bad.json", path);
  hl_lights a, b;
  fill(&a);
  char *text = NULL;
  assert_int_equal(hl_lights_json(NULL, &a, &text), HL_OK);
  char *at = strstr(text, from);
  assert_non_null(at);
  const size_t size = strlen(text) + strlen(to) + 1;
  char *bad = malloc(size);
  assert_non_null(bad);
  snprintf(bad, size, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
  put_file(path, bad, strlen(bad));
  hl_ctx ctx = {0};
  assert_int_equal(hl_lights_read(&ctx, path, &b), HL_ERR_FORMAT);
  assert_says(ctx.msg, part);
  free(bad);
  free(text);
  hl_lights_free(&a);
}

static void test_refusals(void **state)
{
  refused(state, "\"version\": 1", "\"version\": 2", "version");
  refused(state, "halflight-lights", "halflight-light", "halflight-light");
  refused(state, "\"trusted\": false", "\"trusted\": 0", "trusted is not true or false");
  refused(state, "\"ball\": 0", "\"ball\": 1", "lights[0]: ball = 1");
  refused(state, "\"found\": true", "\"found\": null", "lights[0]: found is not true or false");
  refused(state, "\"direction\": [", "\"direction\": [1, 1, 1], \"other\": [",
          "lights[0]: direction has length");
  refused(state, "\"reasons\": [", "\"reason\": [", "reasons is no list");
  refused(state, "\"own_rad2\": [[", "\"own_rad2\": [[-", "is no covariance");
  hl_lights none;
  hl_ctx ctx = {0};
  assert_int_equal(hl_lights_read(&ctx, "/nonexistent/lights.json", &none), HL_ERR_IO);
}

static void test_csv(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "lights.csv", path);
  hl_lights a;
  fill(&a);
  assert_int_equal(hl_lights_csv_write(NULL, path, &a), HL_OK);
  size_t n;
  char *text = get_file(path, &n);
  int rows = 0, commas = 0, quoted = 0;
  for (const char *c = text; *c; c++) {
    quoted ^= *c == '"';
    commas += *c == ',' && !quoted;
    if (*c == '\n') {
      assert_int_equal(commas, 23);
      commas = 0;
      rows++;
    }
  }
  assert_int_equal(rows, 4);
  assert_non_null(strstr(text, "1,frame 1.png,\"a,\"\"b\"\"\",yes,0,"));
  assert_non_null(strstr(text, "2,frame 2.png,,no,0,,,,,,,,,,,,,,,,1002,,,\n"));
  assert_non_null(strstr(text, ",exposure_us,gain,off_dome,dome_off_deg\n"));
  free(text);
  hl_lights_free(&a);
}

/* Fifteen lights of a ring about z, one of them 5 degrees nearer to it, one not found. */
static hl_lights ring(void)
{
  hl_lights a;
  memset(&a, 0, sizeof a);
  a.camera = (hl_camera){
      .width = 640, .height = 480, .fx = 800, .fy = 810, .cx = 320, .cy = 240, .n_distortion = 5};
  a.n_balls = 1;
  a.ball[0] = (hl_sphere){.center_m = {0, 0, 1}, .radius_m = 0.05};
  a.n = 16;
  a.light = calloc(16, sizeof *a.light);
  assert_non_null(a.light);
  for (int i = 0; i < a.n; i++) {
    hl_rig_light *l = &a.light[i];
    test_random r = {3};
    fill_light(l, i, &r);
    l->near = false;
    const double angle = (i == 9 ? 40 : 45) / 57.29577951308232, t = 0.4 * i;
    const double d[3] = {sin(angle) * cos(t), sin(angle) * sin(t), -cos(angle)};
    memcpy(l->direction, d, sizeof d);
    hl_tangent_basis(l->direction, l->tangent_basis[0], l->tangent_basis[1]);
  }
  return a;
}

static void test_dome_round_trip(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "lights.json", path);
  hl_lights a = ring(), b;
  assert_int_equal(hl_lights_find_dome(NULL, &a), HL_OK);
  assert_int_equal(a.dome.shape, HL_DOME_RINGS);
  assert_int_equal(a.dome.n, 15);
  for (int i = 0; i < a.n; i++)
    assert_int_equal(a.light[i].off_dome, i == 9);
  assert_near(a.light[9].dome_off, 5 / 57.29577951308232, 1e-6);
  assert_int_equal(hl_lights_write(NULL, path, &a), HL_OK);
  hl_ctx ctx = {0};
  if (hl_lights_read(&ctx, path, &b) != HL_OK)
    fail_msg("%s", ctx.msg);
  char *one = NULL, *two = NULL;
  assert_int_equal(hl_lights_json(NULL, &a, &one), HL_OK);
  assert_int_equal(hl_lights_json(NULL, &b, &two), HL_OK);
  assert_string_equal(one, two);
  assert_true(b.light[9].off_dome);
  assert_memory_equal(&a.dome.fit[HL_DOME_RINGS].axis, &b.dome.fit[HL_DOME_RINGS].axis,
                      3 * sizeof(double));
  assert_int_equal(hl_lights_csv_write(NULL, path, &b), HL_OK);
  size_t n;
  char *table = get_file(path, &n);
  assert_non_null(strstr(table, ",yes,5\n"));
  free(table);
  free(one);
  free(two);
  hl_lights_free(&a);
  hl_lights_free(&b);
}

/* The near lights of a rig are fitted by where they are: on a sphere about a point that is not the ball. */
static void test_dome_of_positions(void **state)
{
  (void)state;
  hl_lights a = ring();
  test_random r = {4};
  for (int i = 0; i < a.n; i++) {
    hl_rig_light *l = &a.light[i];
    double d[3] = {random_normal(&r), random_normal(&r), -fabs(random_normal(&r))};
    const double center[3] = {0.1, 0, 0.9};
    hl_unit(d, d);
    l->near = true;
    hl_add_scaled(center, i == 5 ? 0.6 : 0.7, d, l->position_m);
    for (int k = 0; k < 3; k++)
      l->position_covariance_m2[k][k] = 1e-6;
  }
  assert_int_equal(hl_lights_find_dome(NULL, &a), HL_OK);
  assert_true(a.dome.positions);
  assert_int_equal(a.dome.shape, HL_DOME_SPHERE);
  assert_near(a.dome.fit[HL_DOME_SPHERE].radius_m, 0.7, 1e-6);
  for (int i = 0; i < a.n; i++)
    assert_int_equal(a.light[i].off_dome, i == 5);
  assert_near(a.light[5].dome_off, 0.1, 1e-6);
  hl_lights_free(&a);
}

static void test_dome_refused(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "bad.json", path);
  hl_lights a = ring(), b;
  char *text = NULL;
  assert_int_equal(hl_lights_find_dome(NULL, &a), HL_OK);
  assert_int_equal(hl_lights_json(NULL, &a, &text), HL_OK);
  const struct {
    const char *from, *to, *part;
  } all[] = {
      {"\"shape\": \"rings\"", "\"shape\": \"torus\"", "dome: shape = \"torus\""},
      {"\"shape\": \"rings\"", "\"shape\": \"sphere\"", "dome: shape = \"sphere\" is not among"},
      {"\"light\": 9", "\"light\": 99", "light"},
      {"\"distance\"", "\"distances\"", "dome: distance and outliers are no lists for 16 lights"},
      {"\"half_angle_rad\"", "\"half_angle\"", "dome: half_angle_rad is no list of 1 to 8"},
  };
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
    hl_ctx ctx = {0};
    char *bad = malloc(strlen(text) + 32);
    char *at = strstr(text, all[i].from);
    assert_non_null(bad);
    assert_non_null(at);
    sprintf(bad, "%.*s%s%s", (int)(at - text), text, all[i].to, at + strlen(all[i].from));
    put_file(path, bad, strlen(bad));
    free(bad);
    assert_int_equal(hl_lights_read(&ctx, path, &b), HL_ERR_FORMAT);
    assert_says(ctx.msg, all[i].part);
  }
  free(text);
  hl_lights_free(&a);
}

static void test_lp_of_those_found(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "lights.lp", path);
  hl_lights a;
  fill(&a);
  assert_int_equal(hl_lights_lp_write(NULL, path, &a), HL_OK);
  size_t n;
  char *text = get_file(path, &n);
  assert_int_equal(strncmp(text, "2\nframe_0.png 0 -0.28", 20), 0);
  free(text);
  a.light[0].found = a.light[1].found = false;
  hl_ctx ctx = {0};
  assert_int_equal(hl_lights_lp_write(&ctx, path, &a), HL_ERR_ARG);
  hl_lights_free(&a);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_json_round_trip),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_csv),
      cmocka_unit_test(test_dome_round_trip),
      cmocka_unit_test(test_dome_of_positions),
      cmocka_unit_test(test_dome_refused),
      cmocka_unit_test(test_lp_of_those_found),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
