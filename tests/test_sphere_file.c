/* SPHERE.json: there and back, and what is refused. */
#include "files.h"
#include "halflight/sphere.h"

#define HEAD "{\"format\":\"halflight-sphere\",\"version\":1,"

static hl_status read_text(void **state, const char *text, hl_ctx *ctx, hl_sphere *out)
{
  char path[TEST_PATH_MAX];
  path_in(state, "sphere.json", path);
  put_text(path, text);
  return hl_sphere_read(ctx, path, out);
}

static void test_read(void **state)
{
  hl_sphere s;
  assert_int_equal(
      read_text(state, HEAD "\"center_m\":[0.01,-0.02,0.3],\"radius_m\":0.025}", NULL, &s), HL_OK);
  assert_near(s.center_m[0], 0.01, 0);
  assert_near(s.center_m[1], -0.02, 0);
  assert_near(s.center_m[2], 0.3, 0);
  assert_near(s.radius_m, 0.025, 0);
  assert_false(s.has_covariance);
}

/* Seventeen digits carry a double exactly. */
static void test_write_then_read(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "out.json", path);
  const hl_sphere s = {.center_m = {0.1 / 3, -1.0 / 7, 2.0 / 3},
                       .radius_m = 0.1 / 7,
                       .has_covariance = true,
                       .covariance_m2 = {{1e-12, 1e-13, 0}, {1e-13, 2e-12, 0}, {0, 0, 3e-10}}};
  const hl_sphere_fit fit = {
      .center_px = {1, 2}, .radius_px = 3, .rms_px = 0.1, .arc = 0.9, .n_points = 77};
  const hl_sphere_fit *const fits[] = {NULL, &fit};
  for (int i = 0; i < 2; i++) {
    hl_sphere back;
    assert_int_equal(hl_sphere_write(NULL, path, &s, fits[i]), HL_OK);
    assert_int_equal(hl_sphere_read(NULL, path, &back), HL_OK);
    for (int k = 0; k < 3; k++) {
      assert_near(back.center_m[k], s.center_m[k], 0);
      for (int m = 0; m < 3; m++)
        assert_near(back.covariance_m2[k][m], s.covariance_m2[k][m], 0);
    }
    assert_near(back.radius_m, s.radius_m, 0);
    assert_true(back.has_covariance);
  }
}

/* A pose found through an uncertain camera. */
static hl_sphere following(void)
{
  hl_sphere s = {.center_m = {0.1 / 3, -1.0 / 7, 2.0 / 3},
                 .radius_m = 0.1 / 7,
                 .has_covariance = true,
                 .n_intrinsics = 9,
                 .covariance_m2 = {{1e-11, 1e-13, 0}, {1e-13, 2e-11, 0}, {0, 0, 3e-9}},
                 .held_covariance_m2 = {{1e-12 / 3, 1e-13, 0}, {1e-13, 2e-12, 0}, {0, 0, 3e-10}}};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 9; j++)
      s.by_intrinsics[i][j] = 1e-4 * (i + 1) / (j + 3);
  return s;
}

static void test_camera_share_there_and_back(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "out.json", path);
  const hl_sphere s = following();
  hl_sphere back;
  assert_int_equal(hl_sphere_write(NULL, path, &s, NULL), HL_OK);
  assert_int_equal(hl_sphere_read(NULL, path, &back), HL_OK);
  assert_int_equal(back.n_intrinsics, 9);
  for (int i = 0; i < 3; i++) {
    for (int k = 0; k < 3; k++)
      assert_near(back.held_covariance_m2[i][k], s.held_covariance_m2[i][k], 0);
    for (int j = 0; j < 9; j++)
      assert_near(back.by_intrinsics[i][j], s.by_intrinsics[i][j], 0);
  }
}

static void wrong_share(hl_sphere s, const char *part)
{
  hl_ctx ctx = {0};
  assert_int_equal(hl_sphere_check(&ctx, &s), HL_ERR_FORMAT);
  assert_says(ctx.msg, part);
}

static void test_check_refuses_a_wrong_camera_share(void **state)
{
  (void)state;
  hl_sphere s = following();
  assert_int_equal(hl_sphere_check(NULL, &s), HL_OK);
  s.n_intrinsics = 3;
  wrong_share(s, "by_intrinsics has 3 columns; 4 to 12 are needed");
  s.n_intrinsics = 13;
  wrong_share(s, "by_intrinsics has 13 columns");
  s = following();
  s.by_intrinsics[2][8] = NAN;
  wrong_share(s, "by_intrinsics[2][8] = nan");
  s = following();
  s.has_covariance = false;
  wrong_share(s, "covariance is missing beside by_intrinsics");
  s = following();
  s.held_covariance_m2[2][2] = -1e-12;
  wrong_share(s, "covariance_camera_held is no part of covariance");
  s = following();
  s.held_covariance_m2[1][1] = 2.1e-11; /* more than the whole */
  wrong_share(s, "covariance_camera_held is no part of covariance");
}

static void refused(void **state, const char *text, const char *part)
{
  hl_ctx ctx = {0};
  hl_sphere s = {.radius_m = -7};
  assert_int_equal(read_text(state, text, &ctx, &s), HL_ERR_FORMAT);
  assert_says(ctx.msg, "sphere.json: ");
  assert_says(ctx.msg, part);
  assert_near(s.radius_m, -7, 0);
}

static void test_read_refuses(void **state)
{
  refused(state, HEAD "\"center_m\":[0,0,-0.3],\"radius_m\":0.025}",
          "center_m = (0, 0, -0.3): the ball is not wholly in front of the camera");
  refused(state, HEAD "\"center_m\":[0,0,0.02],\"radius_m\":0.025}", "z > radius_m = 0.025");
  refused(state, HEAD "\"center_m\":[0,0],\"radius_m\":0.025}", "an array of 3 numbers is needed");
  refused(state, HEAD "\"center_m\":[0,0,1e9],\"radius_m\":0.025}", "center_m[2] = 1e+09 m");
  refused(state, HEAD "\"center_m\":[0,0,1],\"radius_m\":0}", "radius_m = 0; a number in");
  refused(state, HEAD "\"center_m\":[0,0,1],\"radius_m\":-1}", "radius_m = -1");
  refused(state, HEAD "\"center_m\":[0,0,1]}", "radius_m is missing");
  refused(state, HEAD "\"center_m\":[0,0,1],\"radius_m\":NaN}", "NaN is not JSON");
  refused(state,
          HEAD "\"center_m\":[0,0,1],\"radius_m\":0.1,\"covariance\":[[1,0,0],[0,-1,0],[0,0,1]]}",
          "covariance is no covariance");
  refused(state, HEAD "\"center_m\":[0,0,1],\"radius_m\":0.1,\"covariance\":[[1,0],[0,1]]}",
          "3 rows of 3 numbers");
#define WHOLE                                                                                      \
  HEAD "\"center_m\":[0,0,1],\"radius_m\":0.1,\"covariance\":[[1e-6,0,0],[0,1e-6,0],[0,0,1e-6]],"
#define HELD "\"covariance_camera_held\":[[1e-7,0,0],[0,1e-7,0],[0,0,1e-7]]"
  refused(state, WHOLE HELD "}", "by_intrinsics");
  refused(state, WHOLE "\"by_intrinsics\":[[0,0,0,0],[0,0,0,0],[0,0,0,0]]}",
          "covariance_camera_held");
  refused(state, WHOLE HELD ",\"by_intrinsics\":[[0,0,0,0],[0,0,0,0,0],[0,0,0,0]]}",
          "by_intrinsics[1]");
  refused(state, WHOLE HELD ",\"by_intrinsics\":[[0,0,0],[0,0,0],[0,0,0]]}", "by_intrinsics[0]");
  refused(state, WHOLE HELD ",\"by_intrinsics\":7}", "by_intrinsics");
  refused(state, "{\"format\":\"halflight-camera\",\"version\":1}",
          "format = 'halflight-camera'; 'halflight-sphere' is needed");
}

static void test_check_refuses_what_is_no_number(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  const hl_sphere none = {.center_m = {0, NAN, 1}, .radius_m = 0.1};
  assert_int_equal(hl_sphere_check(&ctx, &none), HL_ERR_FORMAT);
  assert_says(ctx.msg, "center_m[1] = nan m");
  const hl_sphere radius = {.center_m = {0, 0, 1}, .radius_m = NAN};
  assert_int_equal(hl_sphere_check(&ctx, &radius), HL_ERR_FORMAT);
  assert_says(ctx.msg, "radius_m = nan m");
}

/* Lists on one line, a final newline, null for what is not finite. */
static void test_text(void **state)
{
  (void)state;
  const hl_sphere s = {.center_m = {0.5, -0.25, 2}, .radius_m = 0.125};
  const hl_sphere_fit fit = {
      .center_px = {1, 2}, .radius_px = 3, .rms_px = NAN, .arc = 0.5, .n_points = 77};
  char *text = NULL;
  assert_int_equal(hl_sphere_json(NULL, &s, &fit, &text), HL_OK);
  assert_string_equal(text, "{\n \"format\": \"halflight-sphere\",\n \"version\": 1,\n"
                            " \"center_m\": [0.5, -0.25, 2.0],\n \"radius_m\": 0.125,\n"
                            " \"fit\": {\"center_px\": [1.0, 2.0], \"radius_px\": 3.0, "
                            "\"rms_px\": null, \"arc\": 0.5, \"points\": 77}\n}\n");
  free(text);
}

static void test_write_refuses_a_wrong_sphere(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "wrong.json", path);
  const hl_sphere s = {.center_m = {0, 0, -1}, .radius_m = 0.1};
  assert_int_equal(hl_sphere_write(NULL, path, &s, NULL), HL_ERR_FORMAT);
  assert_int_not_equal(access(path, F_OK), 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_read),
      cmocka_unit_test(test_write_then_read),
      cmocka_unit_test(test_text),
      cmocka_unit_test(test_camera_share_there_and_back),
      cmocka_unit_test(test_check_refuses_a_wrong_camera_share),
      cmocka_unit_test(test_read_refuses),
      cmocka_unit_test(test_check_refuses_what_is_no_number),
      cmocka_unit_test(test_write_refuses_a_wrong_sphere),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
