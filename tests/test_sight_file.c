/* A sight from LIGHT.json and SPHERE.json is that of the light and the ball themselves. */
#include "files.h"
#include "halflight/export.h"
#include "halflight/position.h"
#include "halflight/vec3.h"

static hl_sphere ball(void)
{
  hl_sphere s = {.center_m = {0.1, -0.05, 0.6}, .radius_m = 0.02, .has_covariance = true};
  for (int k = 0; k < 3; k++)
    s.covariance_m2[k][k] = 1e-8 * (k + 1);
  return s;
}

static hl_light some_light(void)
{
  hl_light l = {.found = true,
                .trusted = true,
                .direction = {0.6, 0, -0.8},
                .tangent_basis = {{0, 1, 0}, {0.8, 0, 0.6}},
                .by_center = {{3, 1, -2}, {0.5, 7, 4}},
                .channels = 1,
                .lobe = HL_LOBE_PLAIN,
                .color = {1, 1, 1}};
  const hl_sphere s = ball();
  l.part_stated[HL_PART_POSE] = true;
  for (int a = 0; a < 2; a++)
    for (int b = 0; b < 2; b++) {
      for (int k = 0; k < 3; k++)
        l.part_rad2[HL_PART_POSE][a][b] +=
            l.by_center[a][k] * s.covariance_m2[k][k] * l.by_center[b][k];
      l.covariance_rad2[a][b] = l.part_rad2[HL_PART_POSE][a][b] + (a == b ? 1e-6 : 2e-7);
    }
  return l;
}

static void put_pair(void **state, const hl_light *light, const hl_sphere *sphere,
                     char light_path[TEST_PATH_MAX], char sphere_path[TEST_PATH_MAX])
{
  path_in(state, "light.json", light_path);
  path_in(state, "sphere.json", sphere_path);
  assert_int_equal(hl_light_json_write(NULL, light_path, light, NULL), HL_OK);
  assert_int_equal(hl_sphere_write(NULL, sphere_path, sphere, NULL), HL_OK);
}

static void same(const hl_sight *a, const hl_sight *b)
{
  for (int k = 0; k < 3; k++) {
    assert_near(a->origin_m[k], b->origin_m[k], 1e-15);
    assert_near(a->direction[k], b->direction[k], 0);
    for (int l = 0; l < 3; l++)
      assert_near(a->origin_covariance_m2[k][l], b->origin_covariance_m2[k][l], 0);
    for (int t = 0; t < 2; t++) {
      assert_near(a->by_origin[t][k], b->by_origin[t][k], 0);
      assert_near(a->own_rad2[t][k % 2], b->own_rad2[t][k % 2], 1e-16);
    }
  }
}

static void test_file_and_memory_agree(void **state)
{
  char light_path[TEST_PATH_MAX], sphere_path[TEST_PATH_MAX];
  for (int near = 0; near < 2; near++) {
    hl_light light = some_light();
    const hl_sphere sphere = ball();
    hl_sight read, made;
    light.near = near;
    light.position_m[2] = -1;
    put_pair(state, &light, &sphere, light_path, sphere_path);
    assert_int_equal(hl_sight_read(NULL, light_path, sphere_path, &read), HL_OK);
    assert_int_equal(hl_sight_of_light(NULL, &light, &sphere, &made), HL_OK);
    same(&read, &made);
    assert_near(read.own_rad2[0][0], 1e-6, 1e-16); /* the pose's share is taken out */
    assert_near(read.own_rad2[0][1], 2e-7, 1e-16);
    assert_near(read.by_origin[1][1], 7, 0);
    assert_false(read.doubted);
    light.trusted = false;
    put_pair(state, &light, &sphere, light_path, sphere_path);
    assert_int_equal(hl_sight_read(NULL, light_path, sphere_path, &read), HL_OK);
    assert_true(read.doubted);
  }
}

/* A near light's sight starts at the centre, a distant one's at the highlight: on the ball, where the
 * mirror law holds. */
static void test_where_it_starts(void **state)
{
  (void)state;
  hl_light light = some_light();
  const hl_sphere sphere = ball();
  hl_sight g;
  light.near = true;
  assert_int_equal(hl_sight_of_light(NULL, &light, &sphere, &g), HL_OK);
  assert_memory_equal(g.origin_m, sphere.center_m, sizeof g.origin_m);
  assert_memory_equal(g.origin_covariance_m2, sphere.covariance_m2, sizeof g.origin_covariance_m2);
  light.near = false;
  assert_int_equal(hl_sight_of_light(NULL, &light, &sphere, &g), HL_OK);
  double n[3], view[3];
  hl_add_scaled(g.origin_m, -1, sphere.center_m, n);
  assert_near(hl_norm(n), sphere.radius_m, 1e-15);
  for (int k = 0; k < 3; k++)
    view[k] = -sphere.center_m[k];
  hl_unit(view, view);
  assert_near(hl_angle(n, light.direction), hl_angle(n, view), 1e-12);
  assert_near(g.origin_covariance_m2[1][1], 2e-8 + 0.01 * 0.01, 1e-15);
}

/* Beside another pose than the estimate had, the light's covariance is all its own. */
static void test_another_pose(void **state)
{
  char light_path[TEST_PATH_MAX], sphere_path[TEST_PATH_MAX];
  const hl_light light = some_light();
  hl_sphere sphere = ball();
  hl_sight g;
  for (int k = 0; k < 3; k++)
    sphere.covariance_m2[k][k] *= 1e4;
  put_pair(state, &light, &sphere, light_path, sphere_path);
  assert_int_equal(hl_sight_read(NULL, light_path, sphere_path, &g), HL_OK);
  assert_near(g.own_rad2[0][0], light.covariance_rad2[0][0], 0);
  assert_near(g.by_origin[0][0], 0, 0);
}

static void refused(void **state, const char *light, const char *sphere, const char *part)
{
  char light_path[TEST_PATH_MAX], sphere_path[TEST_PATH_MAX];
  hl_ctx ctx = {0};
  hl_sight g;
  path_in(state, "l.json", light_path);
  path_in(state, "s.json", sphere_path);
  put_text(light_path, light);
  put_text(sphere_path, sphere);
  assert_int_equal(hl_sight_read(&ctx, light_path, sphere_path, &g), HL_ERR_FORMAT);
  assert_says(ctx.msg, part);
}

#define SPHERE                                                                                     \
  "{\"format\":\"halflight-sphere\",\"version\":1,\"center_m\":[0,0,1],\"radius_m\":0.02}"
#define LIGHT(lights) "{\"format\":\"halflight-light\",\"version\":1,\"lights\":" lights "}"

static void test_refusals(void **state)
{
  refused(state, LIGHT("[]"), SPHERE, "lights holds no light");
  refused(state, LIGHT("[{}]"), SPHERE, "direction is missing");
  refused(state, LIGHT("[{\"direction\":[0,0,-1]}]"), SPHERE, "tangent_basis");
  refused(state, SPHERE, SPHERE, "format = 'halflight-sphere'");
  refused(state, LIGHT("[]"), "{}", "s.json: format is missing");
  hl_ctx ctx = {0};
  hl_sight g;
  hl_light none = some_light();
  const hl_sphere sphere = ball();
  none.found = false;
  assert_int_equal(hl_sight_of_light(&ctx, &none, &sphere, &g), HL_ERR_ARG);
  assert_says(ctx.msg, "no light was found");
  const hl_light light = some_light();
  hl_sphere behind = ball();
  behind.center_m[2] = -1;
  assert_int_equal(hl_sight_of_light(&ctx, &light, &behind, &g), HL_ERR_ARG);
  assert_says(ctx.msg, "in front of the camera");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_file_and_memory_agree),
      cmocka_unit_test(test_where_it_starts),
      cmocka_unit_test(test_another_pose),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
