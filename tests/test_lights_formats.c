/* Lights in other tools' files: axes by lights whose place is plain, there and back, refusals. */
#include <locale.h>

#include "files.h"
#include "halflight/export.h"
#include "halflight/interchange.h"
#include "halflight/vec3.h"

static void holds(const char *text, const char *part)
{
  if (!strstr(text, part))
    fail_msg("no '%s' in: %s", part, text);
}

static hl_rig_light light_at(const char *file, double x, double y, double z)
{
  const double d[3] = {x, y, z};
  hl_rig_light l = {.file = strdup(file),
                    .label = strdup(""),
                    .found = true,
                    .trusted = true,
                    .color = {1, 1, 1},
                    .intensity = {1, 1, 1}};
  hl_unit(d, l.direction);
  return l;
}

/* In the camera's frame, x right, y down, z forward. */
static hl_lights plain_lights(void)
{
  hl_lights out = {.n = 3, .light = calloc(3, sizeof *out.light)};
  assert_non_null(out.light);
  out.light[0] = light_at("right.png", 1, 0, 0);
  out.light[1] = light_at("up.png", 0, -1, 0);
  out.light[2] = light_at("at camera.png", 0, 0, -1);
  return out;
}

static char *text_of(const hl_lights *lights, hl_lights_format format)
{
  char *text = NULL;
  hl_ctx ctx = {0};
  if (hl_lights_text(&ctx, lights, format, &text) != HL_OK)
    fail_msg("%s", ctx.msg);
  return text;
}

static void test_axes_of_lp_dome_and_alicevision(void **state)
{
  (void)state;
  hl_lights lights = plain_lights();
  char *lp = text_of(&lights, HL_LIGHTS_LP), *dome = text_of(&lights, HL_LIGHTS_DOME),
       *alicevision = text_of(&lights, HL_LIGHTS_ALICEVISION);
  assert_string_equal(lp, "3\nright.png 1 0 0\nup.png 0 1 0\nat_camera.png 0 0 1\n");
  holds(dome, "{\"x\": 1, \"y\": 0, \"z\": 0},\n    {\"x\": 0, \"y\": 1, \"z\": 0},\n"
              "    {\"x\": 0, \"y\": 0, \"z\": 1}\n");
  holds(alicevision, "\"lightId\": 0, \"file\": \"right.png\", \"type\": \"directional\", "
                     "\"direction\": [1, 0, 0], \"intensity\": [1, 1, 1]}");
  holds(alicevision, "\"file\": \"up.png\", \"type\": \"directional\", "
                     "\"direction\": [0, -1, 0]");
  holds(alicevision, "\"lightId\": 2, \"file\": \"at camera.png\", \"type\": \"directional\", "
                     "\"direction\": [0, 0, -1]");
  free(lp);
  free(dome);
  free(alicevision);
  hl_lights_free(&lights);
}

/* The n-th matrix of the text. */
static void matrix_of(const char *text, int n, double m[4][4])
{
  static const char mark[] = "matrix4d xformOp:transform = ( ";
  for (int i = 0; i <= n; i++) {
    text = strstr(text, mark);
    assert_non_null(text);
    text += sizeof mark - 1;
  }
  for (int r = 0; r < 4; r++) {
    assert_int_equal(sscanf(text, "(%lf, %lf, %lf, %lf)", &m[r][0], &m[r][1], &m[r][2], &m[r][3]),
                     4);
    text = strchr(text, ')');
    assert_non_null(text);
    text += r < 3 ? 3 : 1;
  }
}

/* A DistantLight shines along its own -z, a row vector times the matrix. */
static void test_axes_of_usda(void **state)
{
  (void)state;
  static const double shines[3][3] = {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}; /* x right, y up */
  hl_lights lights = plain_lights();
  char *text = text_of(&lights, HL_LIGHTS_USDA);
  for (int i = 0; i < 3; i++) {
    double m[4][4], cross[3];
    matrix_of(text, i, m);
    for (int k = 0; k < 3; k++)
      assert_near(0 * m[0][k] + 0 * m[1][k] - 1 * m[2][k] + 0 * m[3][k], shines[i][k], 1e-11);
    hl_cross(m[0], m[1], cross);
    for (int k = 0; k < 3; k++) {
      assert_near(cross[k], m[2][k], 1e-11); /* a turn and no mirror */
      assert_near(hl_norm(m[k]), 1, 1e-11);
      assert_near(m[k][3], 0, 0);
    }
    assert_near(m[3][3], 1, 0);
  }
  assert_int_equal(strncmp(text, "#usda 1.0\n", 10), 0);
  holds(text, "upAxis = \"Y\"");
  free(text);
  hl_lights_free(&lights);
}

static hl_lights import(const char *path)
{
  hl_lights out;
  hl_ctx ctx = {0};
  bool is = false;
  assert_int_equal(hl_lights_file_is(&ctx, path, &is), HL_OK);
  assert_true(is);
  if (hl_lights_import(&ctx, path, &out) != HL_OK)
    fail_msg("%s", ctx.msg);
  return out;
}

static void test_there_and_back(void **state)
{
  char path[TEST_PATH_MAX];
  test_random r = {7};
  hl_lights lights = {.n = 40, .light = calloc(40, sizeof *lights.light)};
  for (int i = 0; i < lights.n; i++) {
    char name[32];
    snprintf(name, sizeof name, "%02d.png", i + 1);
    lights.light[i] = light_at(name, random_normal(&r), random_normal(&r), random_normal(&r));
    for (int k = 0; k < 3; k++)
      lights.light[i].intensity[k] = 0.5 + random_uniform(&r);
  }
  for (int f = HL_LIGHTS_LP; f <= HL_LIGHTS_ALICEVISION; f++) {
    path_in(state, hl_lights_format_name(f), path);
    char *text = text_of(&lights, (hl_lights_format)f);
    put_text(path, text);
    hl_lights back = import(path);
    assert_int_equal(back.n, lights.n);
    for (int i = 0; i < back.n; i++) {
      assert_true(back.light[i].found);
      assert_near(hl_angle(back.light[i].direction, lights.light[i].direction), 0, 1e-11);
      assert_int_equal(strcmp(back.light[i].file, lights.light[i].file) == 0,
                       !(hl_lights_lost(&lights, (hl_lights_format)f) & HL_LIGHTS_NAMES));
      for (int k = 0; k < 3; k++)
        assert_near(back.light[i].intensity[k],
                    f == HL_LIGHTS_ALICEVISION ? lights.light[i].intensity[k] : 1, 1e-11);
    }
    char *again = text_of(&back, (hl_lights_format)f);
    if (f != HL_LIGHTS_DOME)
      assert_string_equal(again, text);
    free(again);
    free(text);
    hl_lights_free(&back);
  }
  hl_lights_free(&lights);
}

/* As boost's property_tree writes it, every number a text; and the older form, by names. */
static void test_what_alicevision_writes(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "av.json", path);
  put_text(path, "{\"lights\": [{\"viewId\": \"884\", \"type\": \"directional\", \"direction\": "
                 "[\"0.6\", \"0\", \"-0.8\"], \"intensity\": [\"1.5\", \"1\", \"0.5\"]}]}");
  hl_lights lights = import(path);
  assert_int_equal(lights.n, 1);
  assert_string_equal(lights.light[0].file, "884");
  assert_near(lights.light[0].direction[0], 0.6, 1e-15);
  assert_near(lights.light[0].direction[2], -0.8, 1e-15);
  assert_near(lights.light[0].intensity[0], 1.5, 0);
  hl_lights_free(&lights);
  put_text(path, "{\"lights\": {\"led_b\": {\"direction\": [0, 0, -1], \"intensity\": [1, 1, 1]}, "
                 "\"led_a\": {\"direction\": [0, -2, 0], \"intensity\": [1, 1, 1]}}}");
  lights = import(path);
  assert_int_equal(lights.n, 2);
  assert_string_equal(lights.light[0].file, "led_b");
  assert_near(lights.light[1].direction[1], -1, 0);
  hl_lights_free(&lights);
}

/* relight keeps the place of a picture without a highlight with zeros. */
static void test_dome_keeps_places(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "a.dome", path);
  hl_lights lights = plain_lights();
  lights.light[1].found = false;
  char *text = text_of(&lights, HL_LIGHTS_DOME);
  put_text(path, text);
  hl_lights back = import(path);
  assert_int_equal(back.n, 3);
  assert_false(back.light[1].found);
  assert_near(back.light[2].direction[2], -1, 0);
  char *lp = text_of(&back, HL_LIGHTS_LP);
  assert_string_equal(lp, "2\n01 1 0 0\n03 0 0 1\n");
  free(lp);
  free(text);
  hl_lights_free(&back);
  hl_lights_free(&lights);
}

/* Blanks in names, line ends of Windows, a mark of byte order, directions that are not unit. */
static void test_lp_of_others(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "other.lp", path);
  put_text(path, "\xef\xbb\xbf"
                 "2\r\n\r\nC:\\my dome\\a 1.jpg\t3 0 4\r\nb.jpg 0 1e0 0");
  hl_lights lights = import(path);
  assert_int_equal(lights.n, 2);
  assert_string_equal(lights.light[0].file, "C:\\my dome\\a 1.jpg");
  assert_near(lights.light[0].direction[0], 0.6, 1e-15);
  assert_near(lights.light[0].direction[2], -0.8, 1e-15);
  assert_near(lights.light[1].direction[1], -1, 0);
  char *quoted = text_of(&lights, HL_LIGHTS_ALICEVISION);
  holds(quoted, "\"file\": \"C:\\\\my dome\\\\a 1.jpg\"");
  free(quoted);
  hl_lights_free(&lights);
}

/* A lamp of irradiance E at the ball, D away: a SphereLight of 4 D^2 E at its place. */
static void test_usda_of_a_near_light(void **state)
{
  (void)state;
  hl_lights lights = plain_lights();
  hl_rig_light *l = &lights.light[0];
  lights.n_balls = 1;
  lights.ball[0] = (hl_sphere){.center_m = {0.1, 0, 1}, .radius_m = 0.03};
  l->near = true;
  memcpy(l->position_m, (double[3]){0.6, -0.2, 1}, sizeof l->position_m);
  memcpy(l->intensity, (double[3]){2, 1, 0.5}, sizeof l->intensity);
  char *text = text_of(&lights, HL_LIGHTS_USDA);
  holds(text, "def SphereLight \"light_001\"");
  holds(text, "color3f inputs:color = (1, 0.5, 0.25)");
  holds(text, "float inputs:intensity = 2.32\n"); /* 4 (0.5^2 + 0.2^2) 2 */
  holds(text, "xformOp:translate = (0.6, 0.2, -1)");
  holds(text, "def DistantLight \"light_002\"");
  assert_int_equal(hl_lights_lost(&lights, HL_LIGHTS_USDA), 0);
  assert_int_equal(hl_lights_lost(&lights, HL_LIGHTS_ALICEVISION), HL_LIGHTS_POSITIONS);
  free(text);
  lights.n_balls = 0; /* how far from the ball is not known */
  text = text_of(&lights, HL_LIGHTS_USDA);
  assert_null(strstr(text, "SphereLight"));
  assert_int_equal(hl_lights_lost(&lights, HL_LIGHTS_USDA), HL_LIGHTS_POSITIONS);
  free(text);
  hl_lights_free(&lights);
}

/* What is not UTF-8 would spoil the JSON; what is stays. */
static void test_names_of_any_code_page(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "names.json", path);
  hl_lights lights = {.n = 2, .light = calloc(2, sizeof *lights.light)};
  lights.light[0] = light_at("m\xfc"
                             "ll\xc3.png",
                             0, 0, -1);
  lights.light[1] = light_at("m\xc3\xbcll \"\xf0\x9f\x92\xa1\".png", 0, 0, -1);
  char *text = text_of(&lights, HL_LIGHTS_ALICEVISION);
  put_text(path, text);
  hl_lights back = import(path);
  assert_string_equal(back.light[0].file, "m?ll?.png");
  assert_string_equal(back.light[1].file, lights.light[1].file);
  free(text);
  hl_lights_free(&back);
  hl_lights_free(&lights);
}

static void test_point_whatever_the_locale(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "locale.lp", path);
  put_text(path, "1\na 0.6 0 0.8\n");
  if (!setlocale(LC_ALL, "de_DE.UTF-8") && !setlocale(LC_ALL, "de_DE.utf8"))
    skip();
  hl_lights lights = import(path);
  for (int f = 0; hl_lights_format_name(f); f++) {
    char *text = text_of(&lights, (hl_lights_format)f);
    assert_non_null(strstr(text, "0.8"));
    assert_null(strstr(text, "0,8"));
    free(text);
  }
  setlocale(LC_ALL, "C");
  hl_lights_free(&lights);
}

static void refused(void **state, const char *text, const char *part)
{
  char path[TEST_PATH_MAX];
  path_in(state, "bad", path);
  put_text(path, text);
  hl_lights out = {.n = 77};
  hl_ctx ctx = {0};
  assert_int_equal(hl_lights_import(&ctx, path, &out), HL_ERR_FORMAT);
  assert_says(ctx.msg, part);
  assert_int_equal(out.n, 77);
}

static void test_refusals(void **state)
{
  refused(state, "two\n", "line 1: 'two' is no count of lights; a whole number in [1, 100000]");
  refused(state, "0\n", "line 1: '0' is no count");
  refused(state, "1.5\n", "line 1: '1.5' is no count");
  refused(state, "2\na 0 0 1\n", "line 2: the file ends after 1 lights; its first line says 2");
  refused(state, "1\na 0 0 1\nb 0 0 1\n", "line 3: a line after the last of the 1 lights");
  refused(state, "1\n\n0 0 1\n", "line 3: '0 0 1'; a file's name and x y z are needed");
  refused(state, "1\na 0,5 0 1\n", "line 2: x = '0,5' is no number; digits with a decimal point");
  refused(state, "1\na 0 nan 1\n", "line 2: y = 'nan' is no number");
  refused(state, "1\na 0 0 0\n", "line 2: direction 0 0 0 has length 0; at least 0.0001 is needed");
  refused(state, "{\"directions\": 3}", "directions is no list");
  refused(state, "{\"directions\": []}", "0 lights; 1 to 100000 are accepted");
  refused(state, "{\"directions\": [{\"x\": 1, \"y\": \"2\", \"z\": 0}]}",
          "directions[0]: y is no number; x, y and z are needed");
  refused(state, "{\"directions\": [[1, 0, 0]]}", "directions[0]: x is no number");
  refused(state, "{\"lights\": [{\"direction\": [0, 0], \"intensity\": [1, 1, 1]}]}",
          "lights[0]: direction has 2 numbers; 3, as a directional light has, are needed");
  refused(state, "{\"lights\": [{\"direction\": [0, 0, \"x\"], \"intensity\": [1, 1, 1]}]}",
          "lights[0]: direction[2] is no number");
  refused(state, "{\"lights\": [{\"direction\": [0, 0, 1]}]}",
          "lights[0]: intensity has 0 numbers");
  refused(state, "{\"lights\": 1}", "lights is no list");
  refused(state, "{\"format\": \"other\"}", "no lights are known in it");
  refused(state, "{\"format\": \"halflight-light\", \"version\": 1, \"lights\": []}",
          "lights holds no light");
  refused(state, "{\"directions\": [", "not JSON");
  hl_lights none = {.n = 0};
  hl_ctx ctx = {0};
  char *text = NULL;
  assert_int_equal(hl_lights_text(&ctx, &none, HL_LIGHTS_USDA, &text), HL_ERR_ARG);
  assert_says(ctx.msg, "none of 0 lights was found; at least 1 is needed");
  hl_lights lights = plain_lights();
  assert_int_equal(hl_lights_text(&ctx, &lights, (hl_lights_format)9, &text), HL_ERR_ARG);
  assert_null(text);
  hl_lights_free(&lights);
}

static void test_what_holds_lights(void **state)
{
  static const struct {
    const char *name, *text;
    bool is;
  } files[] = {{"a.lp", "two\n", true},
               {"a.txt", "3\n", true},
               {"a.yml", "%YAML:1.0\n", false},
               {"a.json", "{\"format\": \"halflight-lights\"}", true},
               {"b.json", "{\"format\": \"halflight-camera\", \"lights\": 1}", false},
               {"c.json", "{\"directions\": []}", true},
               {"d.json", "{\"lights\"", false},
               {"a.cameramodel", "{ 'lensmodel': 'LENSMODEL_PINHOLE' }", false}};
  char path[TEST_PATH_MAX];
  for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
    bool is = !files[i].is;
    path_in(state, files[i].name, path);
    put_text(path, files[i].text);
    assert_int_equal(hl_lights_file_is(NULL, path, &is), HL_OK);
    assert_int_equal(is, files[i].is);
  }
  bool is;
  path_in(state, "missing", path);
  assert_int_equal(hl_lights_file_is(NULL, path, &is), HL_ERR_IO);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_axes_of_lp_dome_and_alicevision),
      cmocka_unit_test(test_axes_of_usda),
      cmocka_unit_test(test_there_and_back),
      cmocka_unit_test(test_what_alicevision_writes),
      cmocka_unit_test(test_dome_keeps_places),
      cmocka_unit_test(test_lp_of_others),
      cmocka_unit_test(test_usda_of_a_near_light),
      cmocka_unit_test(test_names_of_any_code_page),
      cmocka_unit_test(test_point_whatever_the_locale),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_what_holds_lights),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
