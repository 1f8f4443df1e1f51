/* POSE.json as it should be, and every way it should not. */
#include "files.h"
#include "halflight/drift.h"

static hl_board_pose some_pose(void)
{
  hl_board_pose p = {.target = {HL_TARGET_APRILGRID, 6, 6, 0.03, 0.3},
                     .cam_from_board = {{0.35, -0.3, 0.1}, {-0.12, -0.1, 0.42}},
                     .camera = {.model = HL_LENS_PINHOLE,
                                .width = 640,
                                .height = 480,
                                .fx = 700.1,
                                .fy = 700.2,
                                .cx = 322.3,
                                .cy = 236.8,
                                .n_distortion = 5,
                                .distortion = {-0.18, 0.06, 0.0008, -0.0005, 0.01}},
                     .has_covariance = true,
                     .corners = 131,
                     .rms_px = 0.134};
  for (int i = 0; i < HL_POSE_SIZE; i++) {
    p.covariance[i][i] = 1e-9 * (i + 1);
    for (int k = 0; k < 9; k++)
      p.by_intrinsics[i][k] = 1e-4 * (i + 1) / (k + 3.0);
  }
  p.covariance[0][4] = p.covariance[4][0] = 3e-10;
  return p;
}

static void test_round_trip(void **state)
{
  char path[TEST_PATH_MAX];
  const hl_board_pose p = some_pose();
  hl_board_pose q;
  path_in(state, "pose.json", path);
  assert_int_equal(hl_board_pose_write(NULL, path, &p), HL_OK);
  assert_int_equal(hl_board_pose_read(NULL, path, &q), HL_OK);
  assert_int_equal(q.target.kind, HL_TARGET_APRILGRID);
  assert_int_equal(q.target.columns, 6);
  assert_near(q.target.spacing_ratio, 0.3, 0);
  assert_memory_equal(&q.cam_from_board, &p.cam_from_board, sizeof p.cam_from_board);
  assert_memory_equal(q.covariance, p.covariance, sizeof p.covariance);
  assert_memory_equal(q.by_intrinsics, p.by_intrinsics, sizeof p.by_intrinsics);
  assert_near(q.camera.fx, p.camera.fx, 0);
  assert_near(q.camera.distortion[4], p.camera.distortion[4], 0);
  assert_int_equal(q.corners, 131);
  assert_near(q.rms_px, 0.134, 0);
}

#define HEAD "{\"format\":\"halflight-board-pose\",\"version\":1,"
#define TARGET "\"target\":\"chessboard:9x7:0.03\","
#define POSE "\"cam_from_board\":[0,0,0,0,0,1]"

/* What a person writes by hand. */
static void test_the_least(void **state)
{
  char path[TEST_PATH_MAX];
  hl_board_pose p;
  path_in(state, "pose.json", path);
  put_text(path, HEAD TARGET POSE "}");
  assert_int_equal(hl_board_pose_read(NULL, path, &p), HL_OK);
  assert_false(p.has_covariance);
  assert_int_equal(p.camera.width, 0);
  assert_int_equal(p.target.columns, 9);
  assert_near(p.cam_from_board.translation_m[2], 1, 0);
  hl_board_pose again;
  assert_int_equal(hl_board_pose_write(NULL, path, &p), HL_OK);
  assert_int_equal(hl_board_pose_read(NULL, path, &again), HL_OK);
  assert_false(again.has_covariance);
}

static void refused(void **state, const char *text, const char *part)
{
  char path[TEST_PATH_MAX];
  hl_ctx ctx = {0};
  static hl_board_pose out, before;
  path_in(state, "pose.json", path);
  put_text(path, text);
  memset(&out, 0x5a, sizeof out);
  before = out;
  assert_int_equal(hl_board_pose_read(&ctx, path, &out), HL_ERR_FORMAT);
  assert_says(ctx.msg, part);
  assert_says(ctx.msg, "pose.json: ");
  assert_memory_equal(&out, &before, sizeof out);
}

static void test_refusals(void **state)
{
  refused(state, "{\"format\":\"halflight-camera\",\"version\":1}", "format");
  refused(state, HEAD POSE "}", "target is missing");
  refused(state, HEAD "\"target\":\"chessboard:9:0.03\"," POSE "}", "chessboard");
  refused(state, HEAD "\"target\":\"chessboard:9x7:0.03\"}", "cam_from_board is missing");
  refused(state, HEAD TARGET "\"cam_from_board\":[0,0,0,0,1]}", "an array of 6 numbers is needed");
  refused(state, HEAD TARGET "\"cam_from_board\":[0,0,0,0,0,-1]}",
          "cam_from_board puts the board's middle at z = -1 m; it must be in front");
  refused(state, HEAD TARGET "\"cam_from_board\":[0,0,0,0,0,1e9]}", "z = 1e+09 m");
  refused(state, HEAD TARGET POSE ",\"covariance\":[1]}", "6 rows of 6 numbers");
  refused(state,
          HEAD TARGET POSE ",\"covariance\":[[-1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],"
                           "[0,0,0,1,0,0],[0,0,0,0,1,0],[0,0,0,0,0,1]]}",
          "covariance is no covariance; a symmetric 6 x 6 matrix");
  refused(state,
          HEAD TARGET POSE ",\"covariance\":[[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],"
                           "[0,0,0,1,0,0],[0,0,0,0,1,0],[0,0,0,0,0,1]],\"by_intrinsics\":[[1]]}",
          "by_intrinsics without the camera it belongs to");
  refused(state, HEAD TARGET POSE ",\"camera\":{\"model\":\"pinhol\"}}", "model = 'pinhol'");
  refused(state, HEAD TARGET POSE ",\"corners\":-1}", "corners = -1");
  refused(state, HEAD TARGET POSE ",\"rms_px\":-1}", "rms_px = -1");
}

static void test_a_missing_file_is_named(void **state)
{
  char path[TEST_PATH_MAX];
  hl_ctx ctx = {0};
  hl_board_pose p;
  path_in(state, "nowhere.json", path);
  assert_int_equal(hl_board_pose_read(&ctx, path, &p), HL_ERR_IO);
  assert_says(ctx.msg, "nowhere.json: cannot open: ");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_round_trip),
      cmocka_unit_test(test_the_least),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_a_missing_file_is_named),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
