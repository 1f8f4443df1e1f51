/* Memory that runs out, at every allocation in turn: each call ends with HL_ERR_MEMORY and its one line,
 * frees what it took, and leaves no file behind. */
#include "corner_scene.h"
#include "documents.h"
#include "files.h"
#include "fit_scene.h"
#include "light_scene.h"
#include "memory_faults.h"

enum { CALLS_MAX = 100000 };

static char folder[] = "/tmp/halflight-memory-XXXXXX";

/* One call; `made` is the file that it leaves on success, NULL for none. */
typedef struct trial {
  const char *name;
  hl_status (*run)(hl_ctx *ctx, const char *path);
  const char *made;
  const char *given; /* file that it reads, NULL for none */
  int spares;        /* allocations that it can do without: blocks that were to shrink */
} trial;

static hl_status failed_once(const trial *t, long at, int onwards, hl_ctx *ctx)
{
  char path[TEST_PATH_MAX];
  const char *file = t->made ? t->made : t->given ? t->given : "none";
  snprintf(path, sizeof path, "%s/%s", folder, file);
  const long blocks = faults.blocks;
  faults.count = 0;
  faults.onwards = onwards;
  faults.at = at;
  const hl_status st = t->run(ctx, path);
  faults.at = 0;
  if (faults.blocks != blocks) {
    print_error("%s, allocation %ld: %ld blocks lost\n", t->name, at, faults.blocks - blocks);
    fail();
  }
  return st;
}

/* n = 1, 2, 3 ... until a run passes. */
static void walk(const trial *t, int onwards)
{
  const int files = folder_count(folder);
  int spared = 0;
  for (long at = 1; at < CALLS_MAX; at++) {
    hl_ctx ctx = {0};
    const hl_status st = failed_once(t, at, onwards, &ctx);
    if (faults.count < at) {
      if (st != HL_OK)
        print_error("%s: %s\n", t->name, ctx.msg);
      assert_int_equal(st, HL_OK);
      assert_true(at > 1); /* or nothing was tried */
      break;
    }
    if (st == HL_OK && spared < t->spares) {
      spared++;
      continue;
    }
    if (st != HL_ERR_MEMORY) {
      print_error("%s, allocation %ld%s: status %d, %s\n", t->name, at,
                  onwards ? " and all after it" : "", st, ctx.msg);
      fail();
    }
    assert_int_equal(ctx.status, HL_ERR_MEMORY);
    assert_true(ctx.msg[0] != '\0');
    assert_int_equal(folder_count(folder), files);
  }
  if (t->made) {
    char path[TEST_PATH_MAX];
    snprintf(path, sizeof path, "%s/%s", folder, t->made);
    assert_int_equal(unlink(path), 0);
  }
}

/* ---- files written */

static hl_status write_camera(hl_ctx *ctx, const char *path)
{
  const hl_camera camera = document_camera();
  return hl_camera_write(ctx, path, &camera);
}

static hl_status write_sphere(hl_ctx *ctx, const char *path)
{
  const hl_sphere sphere = document_sphere();
  const hl_sphere_fit fit = {.radius_px = 10};
  return hl_sphere_write(ctx, path, &sphere, &fit);
}

static hl_status write_calibration(hl_ctx *ctx, const char *path)
{
  hl_view_pose view;
  const hl_calibration calibration = document_calibration(&view);
  return hl_calibration_write(ctx, path, &calibration);
}

static hl_status write_pose(hl_ctx *ctx, const char *path)
{
  const hl_board_pose pose = document_pose();
  return hl_board_pose_write(ctx, path, &pose);
}

static hl_status write_light(hl_ctx *ctx, const char *path)
{
  hl_light light = document_light();
  const hl_timing timing = {0};
  light.used = (hl_notes){1, {{"ambient", "as \"told\""}}};
  return hl_light_json_write(ctx, path, &light, &timing);
}

static hl_status write_curves(hl_ctx *ctx, const char *path)
{
  const hl_light light = document_light();
  return hl_curves_csv_write(ctx, path, &light);
}

static hl_status write_lp(hl_ctx *ctx, const char *path)
{
  static const double direction[3] = {0, 0, -1};
  static const char *const name = "a.png";
  return hl_lp_write(ctx, path, &name, direction, 1);
}

static hl_status write_fit(hl_ctx *ctx, const char *path)
{
  const hl_fit fit = document_fit();
  char *text = NULL;
  hl_status st = hl_fit_json(ctx, &fit, &text);
  if (st == HL_OK)
    st = hl_file_write(ctx, path, text, strlen(text));
  free(text);
  return st;
}

static hl_status write_lights(hl_ctx *ctx, const char *path)
{
  hl_rig_light light;
  const hl_lights lights = document_lights(&light);
  return hl_lights_write(ctx, path, &lights);
}

static hl_status write_lights_csv(hl_ctx *ctx, const char *path)
{
  hl_rig_light light;
  const hl_lights lights = document_lights(&light);
  return hl_lights_csv_write(ctx, path, &lights);
}

static hl_status write_lights_lp(hl_ctx *ctx, const char *path)
{
  hl_rig_light light;
  const hl_lights lights = document_lights(&light);
  return hl_lights_lp_write(ctx, path, &lights);
}

static hl_status write_position(hl_ctx *ctx, const char *path)
{
  static const char *const names[2] = {"a.json", "b.json"};
  const hl_position position = {.n = 2, .found = true};
  char *text = NULL;
  hl_status st = hl_position_json(ctx, &position, names, &text);
  if (st == HL_OK)
    st = hl_file_write(ctx, path, text, strlen(text));
  free(text);
  return st;
}

static hl_status write_pfm(hl_ctx *ctx, const char *path)
{
  static const float pixels[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  return hl_pfm_write(ctx, path, pixels, 4, 2, 1);
}

static hl_status write_session(hl_ctx *ctx, const char *path)
{
  (void)path;
  hl_session session;
  const hl_session_frame frame = {.file = "a.png", .label = "one"};
  hl_status st = hl_session_new(ctx, folder, &session);
  if (st != HL_OK)
    return st;
  st = hl_session_append(ctx, &session, &frame);
  if (st == HL_OK)
    st = hl_session_write(ctx, &session);
  hl_session_free(&session);
  return st;
}

static void test_what_is_written(void **state)
{
  (void)state;
  static const trial trials[] = {
      {"camera", write_camera, "camera.json", NULL, 0},
      {"sphere", write_sphere, "sphere.json", NULL, 0},
      {"calibration", write_calibration, "calibration.json", NULL, 0},
      {"pose", write_pose, "pose.json", NULL, 0},
      {"light", write_light, "light.json", NULL, 0},
      {"curves", write_curves, "curves.csv", NULL, 0},
      {"lp", write_lp, "one.lp", NULL, 0},
      {"fit", write_fit, "fit.json", NULL, 0},
      {"lights", write_lights, "lights.json", NULL, 0},
      {"lights csv", write_lights_csv, "lights.csv", NULL, 0},
      {"lights lp", write_lights_lp, "lights.lp", NULL, 0},
      {"position", write_position, "position.json", NULL, 0},
      {"pfm", write_pfm, "frame.pfm", NULL, 0},
      {"session", write_session, "session.json", NULL, 0},
  };
  for (size_t i = 0; i < sizeof trials / sizeof trials[0]; i++)
    for (int onwards = 0; onwards < 2; onwards++)
      walk(&trials[i], onwards);
}

/* ---- files read */

static hl_status read_camera(hl_ctx *ctx, const char *path)
{
  hl_camera out;
  return hl_camera_read(ctx, path, &out);
}

static hl_status read_sphere(hl_ctx *ctx, const char *path)
{
  hl_sphere out;
  return hl_sphere_read(ctx, path, &out);
}

static hl_status read_calibration(hl_ctx *ctx, const char *path)
{
  hl_calibration out;
  const hl_status st = hl_calibration_read(ctx, path, &out);
  if (st == HL_OK)
    hl_calibration_free(&out);
  return st;
}

static hl_status read_pose(hl_ctx *ctx, const char *path)
{
  hl_board_pose out;
  return hl_board_pose_read(ctx, path, &out);
}

static hl_status read_reflectance(hl_ctx *ctx, const char *path)
{
  hl_reflectance out;
  return hl_reflectance_read(ctx, path, &out);
}

static hl_status read_fit(hl_ctx *ctx, const char *path)
{
  hl_fit out;
  return hl_fit_read(ctx, path, &out);
}

static hl_status read_sight(hl_ctx *ctx, const char *path)
{
  char sphere[TEST_PATH_MAX];
  hl_sight out;
  snprintf(sphere, sizeof sphere, "%s/sphere.json", folder);
  return hl_sight_read(ctx, path, sphere, &out);
}

static hl_status read_lights(hl_ctx *ctx, const char *path)
{
  hl_lights out;
  const hl_status st = hl_lights_read(ctx, path, &out);
  if (st == HL_OK)
    hl_lights_free(&out);
  return st;
}

static hl_status import_lights(hl_ctx *ctx, const char *path)
{
  hl_lights out;
  const hl_status st = hl_lights_import(ctx, path, &out);
  if (st == HL_OK)
    hl_lights_free(&out);
  return st;
}

static hl_status convert_lights(hl_ctx *ctx, const char *path)
{
  (void)path;
  hl_rig_light light;
  const hl_lights lights = document_lights(&light);
  hl_status st = HL_OK;
  for (int format = 0; st == HL_OK && hl_lights_format_name(format); format++) {
    char *text = NULL;
    st = hl_lights_text(ctx, &lights, (hl_lights_format)format, &text);
    free(text);
  }
  return st;
}

static hl_status read_frame(hl_ctx *ctx, const char *path)
{
  hl_frame out;
  const hl_status st = hl_frame_read(ctx, path, NULL, &out);
  if (st == HL_OK)
    hl_frame_free(&out);
  return st;
}

static hl_status read_samples(hl_ctx *ctx, const char *path)
{
  hl_samples out;
  const hl_status st = hl_samples_read(ctx, path, &out);
  if (st == HL_OK)
    hl_samples_free(&out);
  return st;
}

static hl_status read_corners(hl_ctx *ctx, const char *path)
{
  const hl_target target = {HL_TARGET_CHESSBOARD, 3, 3, 0.03, 0};
  hl_corners out;
  const hl_status st = hl_corners_read(ctx, path, &target, &out);
  if (st == HL_OK)
    hl_corners_free(&out);
  return st;
}

static hl_status read_session(hl_ctx *ctx, const char *path)
{
  (void)path;
  hl_session out;
  const hl_status st = hl_session_read(ctx, folder, &out);
  if (st == HL_OK)
    hl_session_free(&out);
  return st;
}

static hl_status convert_camera(hl_ctx *ctx, const char *path)
{
  (void)path;
  const hl_camera camera = document_camera();
  hl_status st = HL_OK;
  for (int format = 0; st == HL_OK && hl_camera_format_name(format); format++) {
    char *text = NULL;
    st = hl_camera_text(ctx, &camera, (hl_camera_format)format, &text);
    free(text);
  }
  return st;
}

static void test_what_is_read(void **state)
{
  (void)state;
  static const trial trials[] = {
      {"camera json", read_camera, NULL, "camera.json", 0},
      {"camera opencv", read_camera, NULL, "camera.yml", 0},
      {"camera mrcal", read_camera, NULL, "camera.cameramodel", 0},
      {"camera texts", convert_camera, NULL, NULL, 0},
      {"sphere", read_sphere, NULL, "sphere.json", 0},
      {"calibration", read_calibration, NULL, "calibration.json", 0},
      {"pose", read_pose, NULL, "pose.json", 0},
      {"reflectance of a light", read_reflectance, NULL, "light.json", 0},
      {"reflectance of a fit", read_reflectance, NULL, "fit.json", 0},
      {"sight", read_sight, NULL, "light.json", 0},
      {"fit", read_fit, NULL, "fit.json", 0},
      {"lights", read_lights, NULL, "lights.json", 0},
      {"lights imported", import_lights, NULL, "lights.json", 0},
      {"one light imported", import_lights, NULL, "light.json", 0},
      {"lp imported", import_lights, NULL, "rig.lp", 0},
      {"dome imported", import_lights, NULL, "rig.dome", 0},
      {"AliceVision's imported", import_lights, NULL, "rig.json", 0},
      {"lights texts", convert_lights, NULL, NULL, 0},
      {"frame", read_frame, NULL, "frame.pfm", 0},
      {"samples", read_samples, NULL, "samples.csv", 0},
      {"corners", read_corners, NULL, "corners.vnl", 0},
      {"session", read_session, NULL, "session.json", 0},
  };
  char path[TEST_PATH_MAX];
  for (int format = 0; hl_camera_format_name(format); format++) {
    static const char *const names[] = {"camera.json", "camera.yml", "camera.yaml",
                                        "camera.cameramodel"};
    const hl_camera camera = document_camera();
    char *text = NULL;
    assert_int_equal(hl_camera_text(NULL, &camera, (hl_camera_format)format, &text), HL_OK);
    snprintf(path, sizeof path, "%s/%s", folder, names[format]);
    put_text(path, text);
    free(text);
  }
  for (int format = HL_LIGHTS_LP; format <= HL_LIGHTS_ALICEVISION; format++) {
    static const char *const names[] = {"rig.lp", "rig.dome", "rig.json"};
    hl_rig_light light;
    const hl_lights lights = document_lights(&light);
    char *text = NULL;
    assert_int_equal(hl_lights_text(NULL, &lights, (hl_lights_format)format, &text), HL_OK);
    snprintf(path, sizeof path, "%s/%s", folder, names[format]);
    put_text(path, text);
    free(text);
  }
  static const struct {
    hl_status (*write)(hl_ctx *ctx, const char *path);
    const char *name;
  } made[] = {
      {write_sphere, "sphere.json"}, {write_calibration, "calibration.json"},
      {write_pose, "pose.json"},     {write_light, "light.json"},
      {write_fit, "fit.json"},       {write_lights, "lights.json"},
      {write_pfm, "frame.pfm"},      {write_session, "session.json"},
  };
  for (size_t i = 0; i < sizeof made / sizeof made[0]; i++) {
    snprintf(path, sizeof path, "%s/%s", folder, made[i].name);
    assert_int_equal(made[i].write(NULL, path), HL_OK);
  }
  snprintf(path, sizeof path, "%s/samples.csv", folder);
  put_text(path, "nx,ny,nz,value\n0,0,1,0.5\n0.6,0,0.8,0.25\n");
  snprintf(path, sizeof path, "%s/corners.vnl", folder);
  put_text(path, "a 1 2\na 3 2\na 5 2\na 1 4\na 3 4\na 5 4\na 1 6\na 3 6\na 5 6\n");
  for (size_t i = 0; i < sizeof trials / sizeof trials[0]; i++)
    for (int onwards = 0; onwards < 2; onwards++) {
      /* where jansson cannot make room for a longer word, once, it leaves out a letter and goes on */
      faults.sparing = !onwards;
      walk(&trials[i], onwards);
    }
  faults.sparing = 0;
}

/* ---- what is worked out */

static hl_status estimate(hl_ctx *ctx, const char *path)
{
  (void)path;
  const lit_scene s = lit_ball(12);
  hl_surface surface;
  hl_light_work *work = NULL;
  hl_status st = hl_surface_of_sphere(ctx, &s.camera, &s.ball, 0.05, &surface);
  if (st != HL_OK)
    return st;
  const long at = faults.at;
  faults.at = 0; /* the scene is the test's own */
  const long count = faults.count;
  hl_frame frame = lit_frame(&s, &surface, NULL);
  faults.count = count;
  faults.at = at;
  st = hl_light_work_new(ctx, surface.n, s.channels, &work);
  if (st == HL_OK) {
    hl_light light;
    hl_light_settings settings = hl_light_defaults();
    settings.threads = 1;
    st = hl_light_estimate(ctx, work, &frame, &surface, &settings, &light);
  }
  hl_light_work_free(work);
  lit_frame_free(&frame);
  hl_surface_free(&surface);
  return st;
}

static scene dichromatic_samples;

static hl_status fit(hl_ctx *ctx, const char *path)
{
  (void)path;
  static hl_samples samples;
  if (!samples.n)
    samples = scene_samples(&dichromatic_samples);
  hl_fit out;
  hl_fit_settings settings = hl_fit_defaults();
  settings.threads = 1;
  return hl_fit_samples(ctx, &samples, HL_FIT_DICHROMATIC, NULL, &settings, &out);
}

static hl_status draw(hl_ctx *ctx, const char *path)
{
  (void)path;
  static const double light[3] = {0, 0, -1};
  const hl_fit fitted = document_fit();
  hl_reflectance reflectance;
  hl_viewing viewing;
  hl_frame normals = {0}, image = {0};
  hl_surface surface = {0};
  hl_status st = hl_reflectance_of_fit(ctx, &fitted, &reflectance);
  if (st == HL_OK)
    st = hl_reflectance_aim(ctx, &reflectance, reflectance.term[1].name, 1, 1);
  if (st == HL_OK)
    st = hl_viewing_along(ctx, NULL, false, &viewing);
  if (st == HL_OK)
    st = hl_normals_of_ball(ctx, 8, &viewing, &normals);
  if (st == HL_OK)
    st = hl_surface_of_parallel_view(ctx, &normals, viewing.view, 0.05, &surface);
  if (st == HL_OK)
    st = hl_relight(ctx, &reflectance, &surface, light, &image);
  hl_frame_free(&image);
  hl_surface_free(&surface);
  hl_frame_free(&normals);
  return st;
}

static hl_status table(hl_ctx *ctx, const char *path)
{
  (void)path;
  const hl_fit fitted = document_fit();
  hl_reflectance reflectance;
  hl_merl merl = {0};
  hl_merl_ball ball = {0};
  static const double light[3] = {0, 0, 1};
  hl_status st = hl_reflectance_of_fit(ctx, &fitted, &reflectance);
  if (st == HL_OK)
    st = hl_merl_new(ctx, &merl);
  if (st == HL_OK) {
    for (int i = 0; i < 3 * HL_MERL_CELLS; i++)
      merl.value[i] = 1;
    st = hl_merl_ball_from_afar(ctx, &merl, 6, light, NULL, &ball);
  }
  hl_merl_ball_free(&ball);
  hl_merl_free(&merl);
  return st;
}

static hl_frame disk;

static hl_status locate(hl_ctx *ctx, const char *path)
{
  (void)path;
  const hl_camera camera = {
      .width = 160, .height = 120, .fx = 200, .fy = 200, .cx = 80, .cy = 60, .n_distortion = 5};
  hl_sphere out;
  hl_sphere_fit seen;
  return hl_sphere_locate(ctx, &disk, &camera, 0.02, NULL, &out, &seen);
}

static void draw_disk(void)
{
  static float pixels[120 * 160];
  for (int y = 0; y < 120; y++)
    for (int x = 0; x < 160; x++) {
      const double off = 30 - hypot(x - 80, y - 60);
      pixels[y * 160 + x] = (float)(0.05 + 0.6 * fmin(fmax(off + 0.5, 0), 1));
    }
  assert_int_equal(hl_frame_from_codes(NULL, pixels, 160, 120, 1, 32, NULL, &disk), HL_OK);
}

static void test_what_is_worked_out(void **state)
{
  (void)state;
  static const trial trials[] = {
      {"estimate", estimate, NULL, NULL, 4}, {"fit", fit, NULL, NULL, 0},
      {"draw", draw, NULL, NULL, 4},         {"table", table, NULL, NULL, 0},
      {"locate", locate, NULL, NULL, 0},
  };
  dichromatic_samples = scene_dichromatic(120);
  draw_disk();
  for (size_t i = 0; i < sizeof trials / sizeof trials[0]; i++) {
    char path[TEST_PATH_MAX] = "";
    assert_int_equal(trials[i].run(NULL, path), HL_OK); /* what is made once, is */
    walk(&trials[i], 0);
  }
  hl_frame_free(&disk);
}

#if defined HL_HAVE_OPENCV
static hl_corners views;

static hl_status calibrate(hl_ctx *ctx, const char *path)
{
  (void)path;
  hl_calibration_settings settings = hl_calibration_defaults();
  hl_calibration out;
  settings.model = HL_MODEL_PINHOLE;
  const hl_status st = hl_calibrate(ctx, &views, &settings, &out);
  if (st == HL_OK)
    hl_calibration_free(&out);
  return st;
}

static hl_status compare(hl_ctx *ctx, const char *path)
{
  (void)path;
  hl_view_pose view;
  const hl_calibration a = document_calibration(&view);
  hl_drift out;
  return hl_drift_cameras(ctx, &a, &a, NULL, &out);
}

static void test_calibration(void **state)
{
  (void)state;
  const hl_camera camera = board_camera(HL_LENS_PINHOLE);
  const hl_target target = {HL_TARGET_CHESSBOARD, 5, 4, 0.03, 0};
  const board_hold hold = board_held(&camera);
  hl_corners clean = board_views(&camera, &target, 6, 3, &hold, NULL);
  views = board_noisy(&clean, 0.1, 3);
  const trial trials[] = {{"calibrate", calibrate, NULL, NULL, 0},
                          {"drift", compare, NULL, NULL, 0}};
  for (int i = 0; i < 2; i++) {
    assert_int_equal(trials[i].run(NULL, ""), HL_OK);
    walk(&trials[i], 0);
  }
  hl_corners_free(&views);
  hl_corners_free(&clean);
}
#endif

/* That a failure is caused at all, and that a lost block shows. */
static void test_the_wraps_work(void **state)
{
  (void)state;
  const long before = faults.blocks;
  faults.count = 0;
  faults.at = 2;
  void *volatile a = malloc(10);
  void *volatile b = malloc(10);
  faults.at = 0;
  assert_non_null(a);
  /* NOLINTNEXTLINE(clang-analyzer-unix.Malloc): b is NULL */
  assert_null(b);
  assert_int_equal(faults.blocks, before + 1);
  free(a);
  assert_int_equal(faults.blocks, before);
}

static int make_folder(void **state)
{
  (void)state;
  faults_begin();
  return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
  char *name = strdup(folder);
  *state = name;
  return folder_free(state);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
    cmocka_unit_test(test_the_wraps_work),
    cmocka_unit_test(test_what_is_written),
    cmocka_unit_test(test_what_is_read),
    cmocka_unit_test(test_what_is_worked_out),
#if defined HL_HAVE_OPENCV
    cmocka_unit_test(test_calibration),
#endif
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
