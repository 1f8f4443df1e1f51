/* CAMERA.json with its views: there and back to the last bit, and what is refused. */
#include "corner_scene.h"
#include "files.h"

/* Three views, one of them left out, of no calibration in particular: every number another. */
static hl_calibration some_calibration(hl_lens_model model)
{
  hl_calibration c = {.trusted = false,
                      .camera = board_camera(model),
                      .target = board_target(),
                      .n_views = 3,
                      .noise_px = 0.1 / 3,
                      .coverage = 0.87,
                      .tilt_deg = 61.0 / 7,
                      .condition = 1e5 / 3,
                      .scatter = 1.0 / 7,
                      .corners_used = 251,
                      .corners_left_out = 2,
                      .n_projections = 2};
  const int n = hl_camera_intrinsics_count(&c.camera);
  c.camera.has_covariance = true;
  for (int i = 0; i < n; i++)
    c.camera.covariance[i * n + i] = (i + 1) / 3.0;
  c.camera.rms_px = 0.2 / 3;
  c.camera.observations = 251;
  c.reasons = (hl_notes){1, {{"coverage", "4 % of the frame's cells hold corners"}}};
  c.used = (hl_notes){2, {{"pinhole", "asked for"}, {"levels", "every corner its own"}}};
  c.left_out = (hl_notes){1, {{"rational", "not asked for"}}};
  c.view = calloc(3, sizeof *c.view);
  assert_non_null(c.view);
  for (int v = 0; v < 3; v++) {
    hl_view_pose *p = &c.view[v];
    snprintf(p->name, sizeof p->name, "frames/view %d.png", v);
    p->used = v != 1;
    p->seen = 100 + v;
    p->rms_px = (v + 1) / 7.0;
    p->cam_from_board = (hl_pose){{0.1 / 3, -0.2, 0.3 * v}, {0.01, -0.02 / 3, 0.4 + v}};
    if (!p->used) {
      snprintf(p->why, sizeof p->why, "rms 1.2 px, 4.1 times the median");
      continue;
    }
    p->corners = 99 + v;
    for (int i = 0; i < HL_POSE_SIZE; i++) {
      p->own_covariance[i][i] = 1e-6 * (i + 1) / 3;
      for (int k = 0; k < n; k++)
        p->by_intrinsics[i][k] = (i - k) / 7.0 + v;
    }
  }
  c.projection[0] = (hl_projection){{319.5, 239.5}, HUGE_VAL, {{0.01, 0.002}, {0.002, 0.02}}};
  c.projection[1] = (hl_projection){{0, 479}, 0.4 / 3, {{0.3, -0.1}, {-0.1, 0.2}}};
  return c;
}

static void same_notes(const hl_notes *a, const hl_notes *b)
{
  assert_int_equal(a->n, b->n);
  for (int i = 0; i < a->n; i++) {
    assert_string_equal(a->note[i].what, b->note[i].what);
    assert_string_equal(a->note[i].why, b->note[i].why);
  }
}

static void test_there_and_back(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "camera.json", path);
  for (int model = 0; model < 3; model++) {
    hl_calibration a = some_calibration((hl_lens_model)model), b;
    assert_int_equal(hl_calibration_write(NULL, path, &a), HL_OK);
    assert_int_equal(hl_calibration_read(NULL, path, &b), HL_OK);
    assert_memory_equal(&b.camera, &a.camera, sizeof a.camera);
    assert_memory_equal(&b.target, &a.target, sizeof a.target);
    assert_int_equal(b.n_views, 3);
    assert_memory_equal(b.view, a.view, 3 * sizeof *a.view);
    assert_int_equal(b.n_projections, 2);
    assert_memory_equal(b.projection, a.projection, sizeof a.projection);
    assert_false(b.trusted);
    assert_int_equal(b.reasons.n, 1);
    assert_string_equal(b.reasons.note[0].why, "coverage: 4 % of the frame's cells hold corners");
    same_notes(&b.used, &a.used);
    same_notes(&b.left_out, &a.left_out);
    assert_near(b.noise_px, a.noise_px, 0);
    assert_near(b.coverage, a.coverage, 0);
    assert_near(b.tilt_deg, a.tilt_deg, 0);
    assert_near(b.condition, a.condition, 0);
    assert_near(b.scatter, a.scatter, 0);
    assert_int_equal(b.corners_used, a.corners_used);
    assert_int_equal(b.corners_left_out, a.corners_left_out);
    /* the same text again */
    char *one = NULL, *two = NULL;
    snprintf(b.reasons.note[0].what, sizeof b.reasons.note[0].what, "coverage");
    snprintf(b.reasons.note[0].why, sizeof b.reasons.note[0].why, "%s", a.reasons.note[0].why);
    assert_int_equal(hl_calibration_json(NULL, &a, &one), HL_OK);
    assert_int_equal(hl_calibration_json(NULL, &b, &two), HL_OK);
    assert_string_equal(one, two);
    free(one);
    free(two);
    hl_calibration_free(&a);
    hl_calibration_free(&b);
  }
}

/* A plain reader of cameras takes it too, and a plain camera is a calibration without views. */
static void test_plain_camera(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "camera.json", path);
  hl_calibration a = some_calibration(HL_LENS_PINHOLE), b;
  hl_camera camera;
  assert_int_equal(hl_calibration_write(NULL, path, &a), HL_OK);
  assert_int_equal(hl_camera_read(NULL, path, &camera), HL_OK);
  assert_memory_equal(&camera, &a.camera, sizeof camera);
  assert_int_equal(hl_camera_write(NULL, path, &camera), HL_OK);
  assert_int_equal(hl_calibration_read(NULL, path, &b), HL_OK);
  assert_memory_equal(&b.camera, &a.camera, sizeof camera);
  assert_int_equal(b.n_views, 0);
  assert_null(b.view);
  assert_int_equal(b.target.columns, 0);
  assert_true(b.trusted);
  hl_calibration_free(&a);
  hl_calibration_free(&b);
}

/* The first `from` in the text of a good file becomes `to`; the reader names file and member. */
static void spoilt(void **state, const char *from, const char *to, const char *part)
{
  char path[TEST_PATH_MAX];
  char *text = NULL;
  hl_ctx ctx = {0};
  path_in(state, "camera.json", path);
  hl_calibration a = some_calibration(HL_LENS_PINHOLE), b = {.noise_px = -7};
  assert_int_equal(hl_calibration_json(NULL, &a, &text), HL_OK);
  const char *at = strstr(text, from);
  if (!at)
    print_error("no '%s' in the text\n", from);
  assert_non_null(at);
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  fprintf(file, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
  fclose(file);
  assert_int_equal(hl_calibration_read(&ctx, path, &b), HL_ERR_FORMAT);
  assert_says(ctx.msg, "camera.json: ");
  assert_says(ctx.msg, part);
  assert_near(b.noise_px, -7, 0);
  free(text);
  hl_calibration_free(&a);
}

static void test_refusals(void **state)
{
  spoilt(state, "\"untrusted\"", "\"maybe\"", "status: 'ok' or 'untrusted' is needed");
  spoilt(state, "\"status\"", "\"stat\"", "status is missing");
  spoilt(state, "aprilgrid:6x6", "aprilgrid:0x6", "target");
  spoilt(state, "\"target\"", "\"aim\"", "target is missing");
  spoilt(state, "\"reasons\": [", "\"reasons\": [3,", "reasons: a text");
  spoilt(state, "\"coverage\": 0.87", "\"coverage\": 1.87", "coverage = 1.87");
  spoilt(state, "\"views\"", "\"views\": [],\"other\"", "views: a list of views is needed");
  spoilt(state, "\"file\"", "\"name\"", "views[0]: file is missing");
  spoilt(state, "\"used\": true", "\"used\": 1", "views[0]: used: true or false is needed");
  spoilt(state, "\"seen\": 100", "\"seen\": -1", "views[0]: seen = -1");
  spoilt(state, "\"seen\": 101", "\"seen\": 0.5", "views[1]: seen = 0.5");
  spoilt(state, "\"cam_from_board\": [", "\"cam_from_board\": [1,", "cam_from_board = ");
  spoilt(state, "\"own_covariance\"", "\"covariances\"", "own_covariance is missing");
  spoilt(state, "\"own_covariance\": [", "\"own_covariance\": [[1,2,3,4,5,6],",
         "6 rows of 6 numbers");
  spoilt(state, "\"by_intrinsics\": [", "\"by_intrinsics\": [[1],", "6 rows of 9 numbers");
  spoilt(state, "\"projection_uncertainty\": [", "\"projection_uncertainty\": [7,", "pixel");
  spoilt(state, "\"distance_m\": null", "\"distance_m\": -1", "distance_m = -1");
}

/* An own covariance that is none. */
static void test_no_covariance(void **state)
{
  char path[TEST_PATH_MAX];
  hl_ctx ctx = {0};
  path_in(state, "camera.json", path);
  hl_calibration a = some_calibration(HL_LENS_PINHOLE), b;
  a.view[2].own_covariance[0][1] = a.view[2].own_covariance[1][0] = 1;
  assert_int_equal(hl_calibration_write(NULL, path, &a), HL_OK);
  assert_int_equal(hl_calibration_read(&ctx, path, &b), HL_ERR_FORMAT);
  assert_says(ctx.msg, "views[2]: own_covariance: a symmetric 6 x 6 matrix");
  hl_calibration_free(&a);
}

/* A camera that no reader would take is not written. */
static void test_not_written(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "nothing.json", path);
  hl_calibration a = some_calibration(HL_LENS_PINHOLE);
  a.camera.fx = NAN;
  assert_int_equal(hl_calibration_write(NULL, path, &a), HL_ERR_FORMAT);
  assert_int_equal(access(path, F_OK), -1);
  hl_calibration_free(&a);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_there_and_back), cmocka_unit_test(test_plain_camera),
      cmocka_unit_test(test_refusals),       cmocka_unit_test(test_no_covariance),
      cmocka_unit_test(test_not_written),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
