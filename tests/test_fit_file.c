/* FIT.json: there and back, by hand, and what is refused. */
#include "files.h"
#include "fit_scene.h"

#define HEAD "{\"format\":\"halflight-fit\",\"version\":1,\"model\":\"ridge\","
#define CURVE "\"curve\":{\"t\":[0,0.5,1],\"value\":[0,1,4]}"
#define TERM "{\"role\":\"lobe\",\"direction\":[0,0.6,0.8]," CURVE "}"

static hl_status read_text(void **state, const char *text, hl_ctx *ctx, hl_fit *out)
{
  char path[TEST_PATH_MAX];
  path_in(state, "fit.json", path);
  put_text(path, text);
  return hl_fit_read(ctx, path, out);
}

static void test_written_then_read(void **state)
{
  for (int channels = 1; channels <= 3; channels += 2)
    for (int given = 0; given < 2; given++) {
      scene s = scene_dichromatic(1500);
      s.channels = channels;
      const hl_fit_known known = {.light = given ? s.light : NULL};
      hl_fit *fit = scene_fit(&s, HL_FIT_DICHROMATIC, &known, NULL);
      hl_fit *back = calloc(1, sizeof *back);
      char *text = NULL, path[TEST_PATH_MAX];
      assert_non_null(back);
      path_in(state, "out.json", path);
      assert_int_equal(hl_fit_json(NULL, fit, &text), HL_OK);
      put_text(path, text);
      assert_int_equal(hl_fit_read(NULL, path, back), HL_OK);
      assert_int_equal(back->n_terms, fit->n_terms);
      assert_int_equal(back->channels, channels);
      assert_int_equal(back->verdict, fit->verdict);
      assert_string_equal(back->proposition, fit->proposition);
      assert_string_equal(back->stays_free, fit->stays_free);
      assert_int_equal(back->light_given, given);
      assert_near(back->relative_error, fit->relative_error, 0);
      assert_near(back->direction_sigma_rad, fit->direction_sigma_rad, 1e-15);
      assert_near(back->least_angle_rad, fit->least_angle_rad, 1e-12);
      for (int k = 0; k < 3; k++)
        assert_near(back->light[k], fit->light[k], 1e-15);
      for (int i = 0; i < fit->n_terms; i++) {
        const hl_term *a = &fit->term[i], *b = &back->term[i];
        assert_int_equal(a->role, b->role);
        assert_int_equal(a->foreshortened, b->foreshortened);
        assert_int_equal(a->in_plane, b->in_plane);
        assert_string_equal(a->name, b->name);
        assert_int_equal(a->n, b->n);
        for (int k = 0; k < a->n; k++) {
          assert_near(b->t[k], a->t[k], 0);
          for (int c = 0; c < channels; c++)
            assert_near(b->value[c][k], a->value[c][k], 0);
        }
      }
      free(text);
      free(fit);
      free(back);
    }
}

static void test_written_by_hand(void **state)
{
  hl_fit *fit = calloc(1, sizeof *fit);
  assert_non_null(fit);
  assert_int_equal(read_text(state, HEAD "\"terms\":[" TERM "]}", NULL, fit), HL_OK);
  assert_int_equal(fit->n_terms, 1);
  assert_int_equal(fit->channels, 1);
  assert_near(fit->view[2], 1, 0);
  assert_near(fit->term[0].strength[0], 4, 0);
  assert_near(hl_term_value(&fit->term[0], 0, 0.75), 2.5, 1e-15);
  assert_near(hl_term_value(&fit->term[0], 0, -1), 0, 0);
  assert_near(hl_term_value(&fit->term[0], 0, 2), 4, 0);
  const double n[3] = {0, 0.6, 0.8}, v[3] = {0, 0, 1};
  double value[3];
  hl_fit_at(fit, n, v, value);
  assert_near(value[0], 4, 1e-12);
  free(fit);
}

/* A direction of the plane follows light and view. */
static void test_a_direction_of_the_plane(void **state)
{
  hl_fit *fit = calloc(1, sizeof *fit);
  assert_non_null(fit);
  assert_int_equal(read_text(state,
                             HEAD "\"light\":{\"direction\":[1,0,0],\"given\":true},\"terms\":[{"
                                  "\"role\":\"lobe\",\"direction\":[0.70710678,0,0.70710678],"
                                  "\"plane\":[1,1],\"foreshortening\":\"1/(n.v)\"," CURVE "}]}",
                             NULL, fit),
                   HL_OK);
  const double n[3] = {0.6, 0, 0.8}, v[3] = {0, 0, 1}, w[3] = {0, 1, 0};
  assert_near(hl_term_argument(fit, &fit->term[0], n, v), 1.4 / sqrt(2), 1e-12);
  assert_near(hl_term_argument(fit, &fit->term[0], n, w), 0.6 / sqrt(2), 1e-12);
  double value[3];
  hl_fit_at(fit, n, v, value);
  assert_near(value[0], hl_term_value(&fit->term[0], 0, 1.4 / sqrt(2)) / 0.8, 1e-12);
  free(fit);
}

static void test_refusals(void **state)
{
  static const struct {
    const char *text, *words;
  } cases[] = {
      {"{\"format\":\"halflight-light\",\"version\":1}", "format"},
      {"{\"format\":\"halflight-fit\",\"version\":2,\"model\":\"ridge\"}", "version"},
      {"{\"format\":\"halflight-fit\",\"version\":1,\"model\":\"spline\",\"terms\":[]}",
       "model = 'spline' is none of"},
      {HEAD "\"terms\":[]}", "terms has 0 members"},
      {HEAD "\"x\":1}", "terms has 0 members"},
      {HEAD "\"terms\":[{\"direction\":[0,0,1]," CURVE "}]}", "terms[0].role"},
      {HEAD "\"terms\":[" TERM ",{\"role\":\"lobe\",\"direction\":[0,0,2]," CURVE "}]}",
       "terms[1].direction has length 2"},
      {HEAD "\"terms\":[{\"role\":\"lobe\",\"direction\":[0,0,1]}]}", "terms[0].curve.t"},
      {HEAD "\"terms\":[{\"role\":\"lobe\",\"direction\":[0,0,1],\"curve\":{\"t\":[0,0,1],"
            "\"value\":[0,1,4]}}]}",
       "curve.t[1] = 0 does not ascend"},
      {HEAD "\"terms\":[{\"role\":\"lobe\",\"direction\":[0,0,1],\"curve\":{\"t\":[0,1],"
            "\"value\":[0,1,4]}}]}",
       "value"},
      {HEAD "\"terms\":[" TERM ",{\"role\":\"lobe\",\"direction\":[0,0,1],\"curve\":{\"t\":[0,1],"
            "\"value\":[[0,1],[0,1],[0,1]]}}]}",
       "terms[1].value has 3 channels"},
      {HEAD "\"terms\":[{\"role\":\"lobe\",\"direction\":[0,0,1],\"plane\":[1,1]," CURVE "}]}",
       "terms[0].plane is relative to a light"},
      {HEAD "\"terms\":[{\"role\":\"lobe\",\"direction\":[0,0,1],\"plane\":[0,0]," CURVE "}]}",
       "plane = [0, 0]"},
      {HEAD "\"domain\":\"cube\",\"terms\":[" TERM "]}", "domain = 'cube'"},
      {HEAD "\"view\":[0,0,0],\"terms\":[" TERM "]}", "view has length 0"},
  };
  hl_fit *fit = calloc(1, sizeof *fit);
  assert_non_null(fit);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    hl_ctx ctx = {0};
    fit->n_terms = -5;
    assert_int_equal(read_text(state, cases[i].text, &ctx, fit), HL_ERR_FORMAT);
    assert_says(ctx.msg, cases[i].words);
    assert_int_equal(fit->n_terms, -5);
  }
  free(fit);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_written_then_read),
      cmocka_unit_test(test_written_by_hand),
      cmocka_unit_test(test_a_direction_of_the_plane),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
