/* OpenCV's calibration and plane pose through plain C; whatever it throws is a status. */
#include <string.h>

#include "halflight/bridge_opencv_calibrate.h"
#include "near.h"

#ifdef HL_HAVE_OPENCV

enum { SIDE = 7, CORNERS = SIDE * SIDE, VIEWS = 5 };

typedef struct views {
  double board[CORNERS][2], pixel[VIEWS][CORNERS][2];
  hl_opencv_view view[VIEWS];
  hl_camera camera;
  hl_pose pose[VIEWS];
} views;

static void see(views *v, hl_lens_model model)
{
  v->camera = (hl_camera){.model = model,
                          .width = 640,
                          .height = 480,
                          .fx = 400,
                          .fy = 405,
                          .cx = 310,
                          .cy = 250,
                          .n_distortion = model == HL_LENS_FISHEYE ? 4 : 5,
                          .distortion = {0.02, -0.01}};
  for (int i = 0; i < CORNERS; i++) {
    v->board[i][0] = 0.02 * (i % SIDE);
    v->board[i][1] = 0.02 * (i / SIDE);
  }
  for (int k = 0; k < VIEWS; k++) {
    v->pose[k] = (hl_pose){{0.4 * cos(k), 0.4 * sin(k), 0.1 * k}, {-0.06 + 0.02 * k, -0.05, 0.25}};
    for (int i = 0; i < CORNERS; i++) {
      const double board[3] = {v->board[i][0], v->board[i][1], 0};
      double at[3];
      hl_pose_apply(&v->pose[k], board, at, NULL, NULL);
      assert_int_equal(hl_camera_project(NULL, &v->camera, at, v->pixel[k][i]), HL_OK);
    }
    v->view[k] =
        (hl_opencv_view){CORNERS, (const double(*)[2])v->board, (const double(*)[2])v->pixel[k]};
  }
}

/* analytic, to what OpenCV's single precision and its own tolerance leave */
static void test_calibrate(void **state)
{
  (void)state;
  static const hl_lens_model models[] = {HL_LENS_PINHOLE, HL_LENS_FISHEYE};
  for (int m = 0; m < 2; m++) {
    static views v;
    see(&v, models[m]);
    hl_camera got = {
        .model = models[m], .width = 640, .height = 480, .n_distortion = v.camera.n_distortion};
    hl_pose pose[VIEWS];
    assert_int_equal(hl_opencv_calibrate(NULL, v.view, VIEWS, &got, pose), HL_OK);
    assert_near(got.fx, v.camera.fx, 0.01);
    assert_near(got.fy, v.camera.fy, 0.01);
    assert_near(got.cx, v.camera.cx, 0.01);
    assert_near(got.cy, v.camera.cy, 0.01);
    assert_near(got.distortion[0], v.camera.distortion[0], 1e-3);
    for (int k = 0; k < VIEWS; k++)
      for (int i = 0; i < 3; i++) {
        assert_near(pose[k].rotation_rad[i], v.pose[k].rotation_rad[i], 1e-3);
        assert_near(pose[k].translation_m[i], v.pose[k].translation_m[i], 1e-4);
      }
  }
}

/* Corners that are all one point. */
static void test_gives_up(void **state)
{
  (void)state;
  static const hl_lens_model models[] = {HL_LENS_PINHOLE, HL_LENS_FISHEYE};
  for (int m = 0; m < 2; m++) {
    static views v;
    hl_ctx ctx = {0};
    see(&v, models[m]);
    memset(v.board, 0, sizeof v.board);
    hl_camera got = {.model = models[m],
                     .width = 640,
                     .height = 480,
                     .fx = -7,
                     .n_distortion = v.camera.n_distortion};
    hl_pose pose[VIEWS];
    assert_int_equal(hl_opencv_calibrate(&ctx, v.view, VIEWS, &got, pose), HL_ERR_DEGENERATE);
    assert_non_null(strstr(ctx.msg, "OpenCV's calibration"));
    assert_near(got.fx, -7, 0);
  }
}

static void test_plane_poses(void **state)
{
  (void)state;
  static views v;
  double at[CORNERS][2];
  see(&v, HL_LENS_PINHOLE);
  for (int k = 0; k < VIEWS; k++) {
    hl_pose pose[2];
    int found = 0;
    for (int i = 0; i < CORNERS; i++) {
      const double board[3] = {v.board[i][0], v.board[i][1], 0};
      double point[3];
      hl_pose_apply(&v.pose[k], board, point, NULL, NULL);
      at[i][0] = point[0] / point[2];
      at[i][1] = point[1] / point[2];
    }
    assert_int_equal(hl_opencv_plane_poses(NULL, (const double(*)[2])v.board,
                                           (const double(*)[2])at, CORNERS, pose, &found),
                     HL_OK);
    assert_int_equal(found, 2);
    for (int i = 0; i < 3; i++) {
      assert_near(pose[0].rotation_rad[i], v.pose[k].rotation_rad[i], 1e-6);
      assert_near(pose[0].translation_m[i], v.pose[k].translation_m[i], 1e-6);
    }
  }
}

static void test_no_plane(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  const double zero[3][2] = {{0}};
  hl_pose pose[2];
  int found = -7;
  assert_int_equal(hl_opencv_plane_poses(&ctx, zero, zero, 3, pose, &found), HL_ERR_DEGENERATE);
  assert_int_equal(found, -7);
}

#else

static void test_none(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  assert_int_equal(hl_opencv_calibrate(&ctx, NULL, 0, NULL, NULL), HL_ERR_UNAVAILABLE);
  assert_non_null(strstr(ctx.msg, "build with -DHL_WITH_OPENCV=ON"));
  assert_int_equal(hl_opencv_plane_poses(&ctx, NULL, NULL, 0, NULL, NULL), HL_ERR_UNAVAILABLE);
}

#endif

int main(void)
{
  const struct CMUnitTest tests[] = {
#ifdef HL_HAVE_OPENCV
      cmocka_unit_test(test_calibrate),
      cmocka_unit_test(test_gives_up),
      cmocka_unit_test(test_plane_poses),
      cmocka_unit_test(test_no_plane),
#else
      cmocka_unit_test(test_none),
#endif
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
