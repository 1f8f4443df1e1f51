/* Corners of one view: derivatives against differences, the pose from nothing, what is refused. */
#include "../calib/sightings.h"
#include "corner_scene.h"
#include "halflight/vec3.h"

enum { CORNERS_MAX = 144 };

/* One view of the standard board, its true pose, and corners with noise. */
typedef struct one_view {
  hl_target target;
  hl_camera camera;
  hl_pose pose;
  int n;
  hl_sighting sighting[CORNERS_MAX];
} one_view;

static one_view view_of(hl_lens_model model, uint64_t seed, double noise)
{
  one_view v = {.target = board_target(), .camera = board_camera(model)};
  const board_hold hold = board_held(&v.camera);
  hl_corners set = board_views(&v.camera, &v.target, 1, seed, &hold, &v.pose);
  hl_corners noisy = board_noisy(&set, noise, seed);
  v.n = hl_sightings_of(&v.target, &noisy.view[0], v.sighting);
  assert_int_equal(v.n, set.view[0].seen);
  hl_corners_free(&set);
  hl_corners_free(&noisy);
  return v;
}

static double *unknown_of(hl_pose *pose, int k)
{
  return k < 3 ? &pose->rotation_rad[k] : &pose->translation_m[k - 3];
}

static double half_cost(const one_view *v, const hl_camera *camera, const hl_pose *pose)
{
  return hl_sightings_cost(camera, pose, v->sighting, v->n) / 2;
}

/* analytic: the gradient of half the sum of squares, by every intrinsic and the pose, at a place
 * that is not the minimum; weights and a corner left out included */
static void test_gradient(void **state)
{
  (void)state;
  for (int model = 0; model < 3; model++) {
    one_view v = view_of((hl_lens_model)model, 3, 0.5);
    hl_arrow arrow;
    hl_arrow_view rows;
    double theta[HL_INTRINSICS_MAX];
    for (int i = 0; i < v.n; i++)
      v.sighting[i].weight = 1.0 / (1 + i % 3);
    v.sighting[7].used = false;
    v.pose.translation_m[2] *= 1.01;
    v.pose.rotation_rad[1] += 0.01;
    const int n = hl_camera_intrinsics_count(&v.camera);
    hl_arrow_clear(&arrow, n);
    hl_arrow_view_clear(&rows);
    assert_true(hl_sightings_rows(&v.camera, &v.pose, v.sighting, v.n, &arrow, &rows));
    hl_camera_intrinsics(&v.camera, theta);
    for (int k = 0; k < n; k++) {
      const double step = k < 4 ? 1e-3 : 1e-6;
      double moved[HL_INTRINSICS_MAX], cost[2];
      for (int side = 0; side < 2; side++) {
        hl_camera camera = v.camera;
        memcpy(moved, theta, sizeof moved);
        moved[k] += side ? step : -step;
        hl_camera_set_intrinsics(&camera, moved);
        cost[side] = half_cost(&v, &camera, &v.pose);
      }
      assert_near((cost[1] - cost[0]) / (2 * step) / arrow.gradient[k], 1, 1e-5);
      assert_near(rows.own_gradient[k], arrow.gradient[k], 0);
    }
    for (int k = 0; k < HL_POSE_SIZE; k++) {
      const double step = 1e-6;
      double cost[2];
      for (int side = 0; side < 2; side++) {
        hl_pose pose = v.pose;
        *unknown_of(&pose, k) += side ? step : -step;
        cost[side] = half_cost(&v, &v.camera, &pose);
      }
      assert_near((cost[1] - cost[0]) / (2 * step) / rows.gradient[k], 1, 1e-5);
    }
  }
}

/* With the intrinsics held the pose's block is the same. */
static void test_held_intrinsics(void **state)
{
  (void)state;
  const one_view v = view_of(HL_LENS_PINHOLE, 4, 0.5);
  hl_arrow arrow;
  hl_arrow_view rows, alone;
  hl_arrow_clear(&arrow, hl_camera_intrinsics_count(&v.camera));
  hl_arrow_view_clear(&rows);
  hl_arrow_view_clear(&alone);
  assert_true(hl_sightings_rows(&v.camera, &v.pose, v.sighting, v.n, &arrow, &rows));
  assert_true(hl_sightings_rows(&v.camera, &v.pose, v.sighting, v.n, NULL, &alone));
  assert_memory_equal(rows.b, alone.b, sizeof rows.b);
  assert_memory_equal(rows.gradient, alone.gradient, sizeof rows.gradient);
}

static void test_behind(void **state)
{
  (void)state;
  one_view v = view_of(HL_LENS_PINHOLE, 5, 0);
  hl_arrow_view rows;
  double r[2];
  v.pose.translation_m[2] = -0.4;
  hl_arrow_view_clear(&rows);
  assert_false(hl_sighting_residual(&v.camera, &v.pose, &v.sighting[0], r));
  assert_true(isinf(hl_sightings_cost(&v.camera, &v.pose, v.sighting, v.n)));
  assert_false(hl_sightings_rows(&v.camera, &v.pose, v.sighting, v.n, NULL, &rows));
}

/* A rational lens ends at the pole of its radial factor. */
static void test_pole(void **state)
{
  (void)state;
  one_view v = view_of(HL_LENS_RATIONAL, 6, 0);
  double r[2];
  assert_true(hl_sighting_residual(&v.camera, &v.pose, &v.sighting[0], r));
  v.camera.distortion[5] = -1e4;
  assert_false(hl_sighting_residual(&v.camera, &v.pose, &v.sighting[0], r));
}

static double apart(const hl_pose *a, const hl_pose *b)
{
  double most = 0;
  for (int i = 0; i < 3; i++) {
    most = fmax(most, fabs(a->rotation_rad[i] - b->rotation_rad[i]));
    most = fmax(most, fabs(a->translation_m[i] - b->translation_m[i]));
  }
  return most;
}

/* Levenberg and Marquardt's way back from a pose 10 degrees and 5 cm off. */
static void test_refine(void **state)
{
  (void)state;
  for (int model = 0; model < 3; model++) {
    const one_view v = view_of((hl_lens_model)model, 8, 0);
    hl_pose pose = v.pose;
    pose.rotation_rad[0] += 0.17;
    pose.rotation_rad[2] -= 0.1;
    pose.translation_m[2] += 0.05;
    assert_near(hl_sightings_refine(&v.camera, v.sighting, v.n, &pose), 0, 1e-16);
    assert_near(apart(&pose, &v.pose), 0, 1e-9);
  }
}

#ifdef HL_HAVE_OPENCV

static void test_pose_from_nothing(void **state)
{
  (void)state;
  for (int model = 0; model < 3; model++)
    for (uint64_t seed = 20; seed < 30; seed++) {
      const one_view v = view_of((hl_lens_model)model, seed, 0);
      hl_pose pose;
      double cost;
      assert_int_equal(hl_sightings_pose(NULL, &v.camera, v.sighting, v.n, &pose, &cost), HL_OK);
      assert_near(apart(&pose, &v.pose), 0, 1e-8);
      assert_near(cost, 0, 1e-14);
    }
}

/* Seen from afar both poses of a plane nearly fit; the better one is taken. */
static void test_two_poses(void **state)
{
  (void)state;
  one_view v = view_of(HL_LENS_PINHOLE, 9, 0);
  for (int i = 0; i < 10; i++) {
    const double angle = 0.6 * i;
    const hl_pose far_away = {{0.35 * cos(angle), 0.35 * sin(angle), 0.1}, {-0.1, -0.1, 2.5}};
    hl_corner corner[CORNERS_MAX];
    hl_view view = {.corner = corner};
    view.seen = board_see(&v.camera, &v.target, &far_away, corner);
    v.n = hl_sightings_of(&v.target, &view, v.sighting);
    hl_pose pose;
    double cost;
    assert_int_equal(hl_sightings_pose(NULL, &v.camera, v.sighting, v.n, &pose, &cost), HL_OK);
    assert_near(apart(&pose, &far_away), 0, 1e-6);
  }
}

static void test_too_few(void **state)
{
  (void)state;
  const one_view v = view_of(HL_LENS_PINHOLE, 10, 0);
  hl_ctx ctx = {0};
  hl_pose pose = {{7, 7, 7}, {7, 7, 7}};
  double cost = 7;
  assert_int_equal(hl_sightings_pose(&ctx, &v.camera, v.sighting, 3, &pose, &cost),
                   HL_ERR_DEGENERATE);
  assert_non_null(strstr(ctx.msg, "3 corners say too little"));
  assert_near(pose.rotation_rad[0] + cost, 14, 0);
}

#else

static void test_unavailable(void **state)
{
  (void)state;
  const one_view v = view_of(HL_LENS_PINHOLE, 10, 0);
  hl_ctx ctx = {0};
  hl_pose pose;
  double cost;
  assert_int_equal(hl_sightings_pose(&ctx, &v.camera, v.sighting, v.n, &pose, &cost),
                   HL_ERR_UNAVAILABLE);
  assert_non_null(strstr(ctx.msg, "-DHL_WITH_OPENCV=ON"));
}

#endif

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_gradient),
      cmocka_unit_test(test_held_intrinsics),
      cmocka_unit_test(test_behind),
      cmocka_unit_test(test_pole),
      cmocka_unit_test(test_refine),
#ifdef HL_HAVE_OPENCV
      cmocka_unit_test(test_pose_from_nothing),
      cmocka_unit_test(test_two_poses),
      cmocka_unit_test(test_too_few),
#else
      cmocka_unit_test(test_unavailable),
#endif
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
