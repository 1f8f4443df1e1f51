/* LIGHT.json and FIT.json as reflectances: the radiance that was fitted comes back, and every refusal
 * names file, member and value. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "halflight/export.h"
#include "halflight/reflectance.h"
#include "light_scene.h"

/* ---- what was fitted comes back */

static void normalise(double v[3])
{
  hl_unit(v, v);
}

/* A light whose curves are known in closed form: body with bends, masked foreshortened lobe. */
static const double body[3][3] = {{0.5, 0.2, 0.1}, {0.3, -0.1, 0.2}, {0.1, 0.05, -0.02}};
static const double cos_view = 0.7, exponent = 1.3;

static double lobe_of(double angle, int c)
{
  const double u = 2 * sin(angle / 2);
  return (0.5 + 0.2 * c) * exp(-u * u / 0.04);
}

static hl_light known_light(int channels)
{
  static const char *const names[3] = {"r", "g", "b"};
  hl_light l = {.trusted = true,
                .found = true,
                .direction = {0.4, -0.5, -0.7},
                .mean_view = {0.1, 0, -1},
                .lobe = HL_LOBE_FORESHORTENED,
                .masking_exponent = exponent,
                .mean_cos_view = cos_view,
                .channels = channels};
  normalise(l.direction);
  normalise(l.mean_view);
  for (int c = 0; c < channels; c++) {
    l.diffuse_view_slope[c] = body[c][1];
    for (int lobe = 0; lobe < 2; lobe++) {
      hl_curve *curve = &l.curves[l.n_curves++];
      curve->lobe = lobe ? "specular" : "diffuse";
      curve->channel = channels == 1 ? "grey" : names[c];
      curve->n = HL_CURVE_POINTS;
      for (int i = 0; i < curve->n; i++) {
        const double share = (double)i / (curve->n - 1);
        const double angle = 90 * LIT_DEG * (lobe ? share * share : share), d = cos(angle);
        curve->angle_rad[i] = angle;
        curve->value[i] =
            lobe ? lobe_of(angle, c) : d * (body[c][0] + body[c][1] * cos_view + body[c][2] * d);
      }
      curve->value[curve->n - 1] = 0;
    }
  }
  return l;
}

static double smith(double x)
{
  return 2 * x / (x + sqrt(0.01 + 0.99 * x * x));
}

static hl_reflectance there_and_back(void **state, const hl_light *light)
{
  char path[TEST_PATH_MAX];
  hl_ctx ctx = {0};
  hl_reflectance r;
  path_in(state, "light.json", path);
  assert_int_equal(hl_light_json_write(NULL, path, light, NULL), HL_OK);
  if (hl_reflectance_read(&ctx, path, &r) != HL_OK)
    fail_msg("%s", ctx.msg);
  return r;
}

/* Under its own light, under others, seen from elsewhere: the model's formula, to the curves' 121
 * points. */
static void test_the_models_formula_comes_back(void **state)
{
  test_random random = {6};
  for (int channels = 1; channels <= 3; channels += 2) {
    const hl_light light = known_light(channels);
    const hl_reflectance r = there_and_back(state, &light);
    assert_int_equal(r.channels, channels);
    assert_int_equal(r.n_terms, 2);
    assert_int_equal(r.notes.n, 0);
    assert_true(r.camera_frame && r.has_light);
    for (int k = 0; k < 3000; k++) {
      double n[3], s[3], v[3], h[3], got[3];
      for (int i = 0; i < 3; i++) {
        n[i] = random_normal(&random);
        s[i] = k % 3 ? random_normal(&random) : light.direction[i];
        v[i] = k % 2 ? random_normal(&random) : light.mean_view[i];
      }
      normalise(n);
      normalise(s);
      normalise(v);
      const double ns = hl_dot(n, s), nv = hl_dot(n, v);
      hl_add_scaled(s, 1, v, h);
      normalise(h);
      if (ns < 0.01 || nv < 0.01)
        continue;
      hl_reflectance_at(&r, n, s, v, got);
      for (int c = 0; c < channels; c++) {
        const double lobe = lobe_of(hl_angle(n, h), c) / nv * pow(smith(ns) * smith(nv), exponent);
        const double want = ns * (body[c][0] + body[c][1] * nv + body[c][2] * ns) + lobe;
        assert_near(got[c], want, 2e-4 * lobe + 2e-5);
      }
    }
  }
}

static void test_terms_of_a_light(void **state)
{
  hl_light light = known_light(3);
  light.trusted = false;
  light.ambient[1] = 0.01;
  light.backscatter[2][1] = 0.01;
  hl_reflectance r = there_and_back(state, &light);
  double h[3];
  hl_add_scaled(light.direction, 1, light.mean_view, h);
  normalise(h);
  for (int i = 0; i < 3; i++) {
    assert_near(r.light[i], light.direction[i], 1e-15);
    assert_near(r.view[i], light.mean_view[i], 1e-15);
    assert_near(r.term[0].axis[i], light.direction[i], 1e-15);
    assert_near(r.term[1].axis[i], h[i], 1e-15);
  }
  assert_string_equal(r.term[0].name, "diffuse");
  assert_string_equal(r.term[1].name, "specular");
  assert_int_equal(r.notes.n, 3);
  assert_string_equal(r.notes.note[0].what, "untrusted light");
  assert_string_equal(r.notes.note[1].what, "ambient");
  assert_string_equal(r.notes.note[2].what, "backscatter");
  /* a matte ball has one term, a plain lobe is not foreshortened */
  light.lobe = HL_LOBE_PLAIN;
  assert_false(there_and_back(state, &light).term[1].foreshortened);
  light.lobe = HL_LOBE_AUTO;
  light.n_curves = 1;
  light.channels = 1;
  light.curves[0].channel = "grey";
  assert_int_equal(there_and_back(state, &light).n_terms, 1);
}

/* A frame that was really estimated: radiance at its pixels, to what the monotone curves cost. */
static void test_a_frame_comes_back(void **state)
{
  lit_scene s = lit_glossy();
  s.lobe = LIT_FORESHORTENED;
  s.width = 0.3;
  s.channels = 3;
  s.body[1] = 0.1;
  lit_shot shot = lit_shot_of(&s, 1);
  const hl_light light = lit_light_of(&shot, NULL);
  const hl_reflectance r = there_and_back(state, &light);
  double difference = 0, sum = 0;
  for (int i = 0; i < shot.surface.n; i++) {
    const double *n = shot.surface.normal + 3 * i;
    double got[3];
    if (hl_dot(n, s.light) < 0.05)
      continue;
    hl_reflectance_at(&r, n, light.direction, shot.surface.view + 3 * i, got);
    for (int c = 0; c < 3; c++) {
      const double want = (double)shot.frame.radiance[3 * shot.surface.pixel[i] + c];
      difference += fabs(got[c] - want);
      sum += want;
    }
  }
  assert_true(difference < 3e-3 * sum); /* ours, rounded up */
  lit_shot_free(&shot);
}

static void test_a_fit_comes_back(void **state)
{
  char path[TEST_PATH_MAX], *text = NULL;
  hl_fit fit = {.trusted = true, .model = HL_FIT_DICHROMATIC, .channels = 1, .n_terms = 1};
  fit.n_samples = 100;
  fit.has_light = fit.light_given = true;
  fit.light[2] = fit.view[2] = 1;
  fit.term[0] = (hl_term){.role = HL_TERM_LOBE, .in_plane = true, .cs = 1, .cv = 1, .n = 3};
  snprintf(fit.term[0].name, sizeof fit.term[0].name, "h");
  fit.term[0].direction[2] = 1;
  for (int i = 0; i < 3; i++) {
    fit.term[0].t[i] = i / 2.0;
    fit.term[0].value[0][i] = 3 * i;
  }
  fit.term[0].shown[1] = 1;
  snprintf(fit.proposition, sizeof fit.proposition, "Proposition 5");
  path_in(state, "fit.json", path);
  assert_int_equal(hl_fit_json(NULL, &fit, &text), HL_OK);
  put_text(path, text);
  free(text);
  hl_reflectance r;
  hl_ctx ctx = {0};
  if (hl_reflectance_read(&ctx, path, &r) != HL_OK)
    fail_msg("%s", ctx.msg);
  assert_int_equal(r.n_terms, 1);
  assert_false(r.camera_frame);
  assert_false(r.term[0].fixed_axis);
  assert_near(r.term[0].value[0][2], 6, 0);
}

/* ---- refusals */

#define HEAD "{\"format\":\"halflight-light\",\"version\":1,\"status\":\"ok\","
#define LIGHTS "\"lights\":[{\"direction\":[0,0,-1]}],"
#define DIFFUSE "\"lobes\":[{\"name\":\"diffuse\"}],"
#define CURVE(lobe, channel, angles, values)                                                       \
  "{\"lobe\":\"" lobe "\",\"channel\":\"" channel "\",\"angle_deg\":" angles ",\"value\":" values  \
  "}"
#define GREY "\"curves\":[" CURVE("diffuse", "grey", "[0,90]", "[1,0]") "],"
#define FIT "\"fit\":{}}"

static hl_status read_text(void **state, const char *text, hl_ctx *ctx, hl_reflectance *out)
{
  char path[TEST_PATH_MAX];
  path_in(state, "t.json", path);
  put_text(path, text);
  return hl_reflectance_read(ctx, path, out);
}

static void refused(void **state, const char *text, const char *part)
{
  hl_ctx ctx = {0};
  hl_reflectance r = {.n_terms = -7};
  assert_int_equal(read_text(state, text, &ctx, &r), HL_ERR_FORMAT);
  assert_says(ctx.msg, "t.json: ");
  assert_says(ctx.msg, part);
  assert_int_equal(r.n_terms, -7);
}

/* What a file of an older program lacks is noted. */
static void test_the_least_that_is_read(void **state)
{
  hl_reflectance r;
  hl_ctx ctx = {0};
  if (read_text(state, HEAD LIGHTS DIFFUSE GREY FIT, &ctx, &r) != HL_OK)
    fail_msg("%s", ctx.msg);
  assert_int_equal(r.notes.n, 1);
  assert_string_equal(r.notes.note[0].what, "diffuse");
  const double n[3] = {0, 0.6, -0.8}, s[3] = {0, 0, -1};
  double out[3];
  hl_reflectance_at(&r, n, s, s, out);
  assert_near(out[1], 0.8, 1e-15);
}

static void test_refuses_documents(void **state)
{
  refused(state, "{\"format\":\"halflight-camera\",\"version\":1}",
          "format = 'halflight-camera'; 'halflight-light' or 'halflight-fit' is needed");
  refused(state, "[]", "not a JSON object; one of format 'halflight-light' or 'halflight-fit'");
  refused(state, "{\"format\":\"halflight-light\",\"version\":2}",
          "version = 2 is newer than this program");
  refused(state, "{\"format\":\"halflight-fit\",\"version\":1}", "model");
  char path[TEST_PATH_MAX];
  hl_ctx ctx = {0};
  hl_reflectance r;
  path_in(state, "missing.json", path);
  assert_int_equal(hl_reflectance_read(&ctx, path, &r), HL_ERR_IO);
}

static void test_refuses_lights_and_lobes(void **state)
{
  refused(state, HEAD "\"lights\":[]," DIFFUSE GREY FIT, "lights is empty: no light was found");
  refused(state, HEAD DIFFUSE GREY FIT, "lights is missing or no list");
  refused(state, HEAD "\"lights\":[7]," DIFFUSE GREY FIT, "lights[0] is no object");
  refused(state, HEAD "\"lights\":[{\"direction\":[0,0]}]," DIFFUSE GREY FIT,
          "direction = [0,0]; an array of 3 numbers is needed");
  refused(state, HEAD "\"lights\":[{\"direction\":[0,0,0]}]," DIFFUSE GREY FIT,
          "lights[0].direction or fit.mean_view is 0");
  refused(state, HEAD LIGHTS DIFFUSE GREY "\"used\":[]}", "fit is missing");
  refused(state, HEAD LIGHTS GREY FIT, "lobes is missing or no list");
  refused(state, HEAD LIGHTS "\"lobes\":[]," GREY FIT, "lobes[0] is no object");
  refused(state, HEAD LIGHTS "\"lobes\":[{\"name\":\"sheen\"}]," GREY FIT,
          "lobes[0].name = 'sheen'; 'diffuse' or 'specular' is needed");
  refused(state,
          HEAD LIGHTS "\"lobes\":[{\"name\":\"diffuse\"},{\"name\":\"specular\","
                      "\"foreshortening\":\"1/(n.s)\"}]," GREY FIT,
          "foreshortening = '1/(n.s)'; 'none' or '1/(n.v)' is needed");
  refused(state,
          HEAD LIGHTS "\"lobes\":[{\"name\":\"diffuse\"},{\"name\":\"diffuse\"},"
                      "{\"name\":\"diffuse\"}]," GREY FIT,
          "lobes has 3 elements; 1 or 2 are needed");
  refused(state,
          HEAD LIGHTS "\"lobes\":[{\"name\":\"diffuse\",\"view_slope\":[0,0,0],"
                      "\"at_cos_view\":2}]," GREY FIT,
          "at_cos_view = 2; a number in [0, 1] is needed");
}

#define WITH(curves) HEAD LIGHTS DIFFUSE "\"curves\":[" curves "]," FIT

static void test_refuses_curves(void **state)
{
  refused(state, HEAD LIGHTS DIFFUSE FIT, "curves is missing or no list");
  refused(state, WITH(CURVE("specular", "grey", "[0,90]", "[1,0]")),
          "curve of lobe 'specular', which lobes has not");
  refused(state, WITH(CURVE("diffuse", "x", "[0,90]", "[1,0]")), "channel = 'x'; 'r', 'g' and 'b'");
  refused(state,
          WITH(CURVE("diffuse", "r", "[0,90]", "[1,0]") "," CURVE("diffuse", "grey", "[0,90]",
                                                                  "[1,0]")),
          "channel = 'grey'");
  refused(state, WITH(CURVE("diffuse", "r", "[0,90]", "[1,0]")),
          "lobe 'diffuse' has no curve of channel 1; a curve for each of 3 is needed");
  refused(state, WITH(CURVE("diffuse", "grey", "[0]", "[1]")),
          "angle_deg of a curve has 1 numbers; 2 to 121 are needed");
  refused(state, WITH(CURVE("diffuse", "grey", "[0,90]", "[1]")),
          "value = [1]; an array of 2 numbers is needed");
  refused(state, WITH(CURVE("diffuse", "grey", "[0,90]", "[1,null]")),
          "value[1] = null; a finite number is needed");
  refused(state, WITH(CURVE("diffuse", "grey", "[0,0,90]", "[1,1,0]")),
          "angle_deg[0] = 0; ascending angles in [0, 90] are needed");
  refused(state, WITH(CURVE("diffuse", "grey", "[0,120]", "[1,0]")), "angle_deg[1] = 120");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_the_models_formula_comes_back),
      cmocka_unit_test(test_terms_of_a_light),
      cmocka_unit_test(test_a_frame_comes_back),
      cmocka_unit_test(test_a_fit_comes_back),
      cmocka_unit_test(test_the_least_that_is_read),
      cmocka_unit_test(test_refuses_documents),
      cmocka_unit_test(test_refuses_lights_and_lobes),
      cmocka_unit_test(test_refuses_curves),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
