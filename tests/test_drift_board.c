/* One new view of a fixed board, against the reference. */
#include "drift_scene.h"

#include "files.h"

enum { VIEWS = 12, FIXED = 0 }; /* the board's reference frame is the calibration's first view */

/* A calibration in which one board is the fixed one. */
typedef struct fixed_scene {
  drift_scene scene;
  hl_calibration reference;
  hl_board_pose board;
} fixed_scene;

static fixed_scene fixed_scene_of(hl_lens_model model, uint64_t seed, test_random *r)
{
  fixed_scene f = {.scene = drift_scene_of(model, VIEWS, seed)};
  const double nearer = f.scene.camera.fx / 700;
  f.scene.board[FIXED] = (hl_pose){{0.35, -0.3, 0.1}, {-0.12, -0.1, 0.42 * nearer}};
  f.reference = drift_calibrate(&f.scene, r);
  const hl_view_pose *view = &f.reference.view[FIXED];
  f.board = (hl_board_pose){.target = f.scene.target,
                            .cam_from_board = view->cam_from_board,
                            .camera = f.reference.camera,
                            .has_covariance = true};
  memcpy(f.board.covariance, view->own_covariance, sizeof f.board.covariance);
  memcpy(f.board.by_intrinsics, view->by_intrinsics, sizeof f.board.by_intrinsics);
  return f;
}

/* What is seen of the fixed board now: a camera and a mount that may have moved. */
static hl_corners seen_now(const drift_scene *s, const hl_pose *moved, test_random *r)
{
  hl_corners set = hl_corners_of(&s->target);
  hl_pose pose = s->board[FIXED];
  hl_view *view;
  set.width = s->camera.width;
  set.height = s->camera.height;
  if (moved)
    hl_pose_compose(moved, &pose, &pose);
  assert_int_equal(hl_corners_add(NULL, &set, "fixed.png", &view), HL_OK);
  view->seen = drift_see(&s->camera, &s->target, &pose, view->corner);
  drift_noise(s, r, view->corner);
  return set;
}

static hl_drift compared(const fixed_scene *f, const hl_corners *corners, double false_alarm)
{
  const hl_drift_settings s = {.false_alarm = false_alarm};
  hl_ctx ctx = {0};
  hl_drift d;
  if (hl_drift_board(&ctx, &f->reference, &f->board, corners, 0, &s, &d) != HL_OK)
    fail_msg("%s", ctx.msg);
  return d;
}

static bool is_moved(const hl_drift *d, const char *part)
{
  for (int i = 0; i < d->n_causes; i++)
    if (strcmp(d->cause[i].part, part) == 0)
      return d->cause[i].moved;
  return false;
}

static bool has_note(const hl_drift *d, const char *what, const char *why)
{
  for (int i = 0; i < d->notes.n; i++)
    if (strcmp(d->notes.note[i].what, what) == 0 && strstr(d->notes.note[i].why, why))
      return true;
  return false;
}

/* Binomial(400, 0.05): 20 +- 4.4. */
static void test_false_alarms_come_at_their_rate(void **state)
{
  (void)state;
  test_random r = {31};
  int alarms = 0;
  for (int i = 0; i < 400; i++) {
    fixed_scene f = fixed_scene_of(HL_LENS_PINHOLE, (uint64_t)i + 1, &r);
    hl_corners now = seen_now(&f.scene, NULL, &r);
    const hl_drift d = compared(&f, &now, 0.05);
    assert_int_equal(d.n_causes, 5);
    alarms += d.drifted;
    hl_corners_free(&now);
    hl_calibration_free(&f.reference);
  }
  assert_in_range(alarms, 10, 32);
}

typedef struct change {
  double focal, centre, k1;
  hl_pose mount;
  const char *moved[2];
} change;

static void test_changes_are_found_and_named(void **state)
{
  (void)state;
  static const change changes[] = {
      {.focal = 0.005, .moved = {"focal length", NULL}},
      {.centre = 3, .moved = {"centre", NULL}},
      {.mount = {{0}, {0.0004, 0, 0.00045}}, .moved = {"translation", NULL}},
      {.mount = {{0.0015, 0.0021, 0}, {0.0004, 0, 0.00045}}, .moved = {"rotation", "translation"}},
  };
  test_random r = {32};
  for (int k = 0; k < 4; k++) {
    const change *c = &changes[k];
    int found = 0, named = 0;
    for (int i = 0; i < 10; i++) {
      fixed_scene f = fixed_scene_of(HL_LENS_PINHOLE, (uint64_t)i + 1, &r);
      drift_scene now = f.scene;
      now.camera.fx *= 1 + c->focal;
      now.camera.fy *= 1 + c->focal;
      now.camera.cx += c->centre;
      hl_corners corners = seen_now(&now, &c->mount, &r);
      const hl_drift d = compared(&f, &corners, 0.01);
      int moved = 0;
      for (int p = 0; p < 5; p++)
        moved += d.cause[p].moved;
      found += d.drifted;
      named += is_moved(&d, c->moved[0]) && (!c->moved[1] || is_moved(&d, c->moved[1])) &&
               moved == 1 + (c->moved[1] != NULL);
      assert_true(has_note(&d, "mount", "a board that has moved itself looks the same") ==
                  (is_moved(&d, "rotation") || is_moved(&d, "translation")));
      hl_corners_free(&corners);
      hl_calibration_free(&f.reference);
    }
    assert_int_equal(found, 10);
    assert_in_range(named, 8, 10);
  }
}

/* One view hardly tells a turn from a centre that moved: whichever is named, the other is noted. */
static void test_what_one_view_cannot_tell_is_noted(void **state)
{
  (void)state;
  test_random r = {33};
  const hl_pose turn = {{0.0003, 0.0002, 0}, {0}};
  fixed_scene f = fixed_scene_of(HL_LENS_PINHOLE, 1, &r);
  hl_corners corners = seen_now(&f.scene, &turn, &r);
  const hl_drift d = compared(&f, &corners, 0.01);
  assert_true(d.drifted);
  assert_true(is_moved(&d, "rotation") != is_moved(&d, "centre"));
  assert_true(has_note(&d, "cause", is_moved(&d, "centre") ? "rotation" : "centre"));
  hl_corners_free(&corners);
  hl_calibration_free(&f.reference);
}

/* Far beyond where one step of a linear model would reach. */
static void test_large_motions_are_measured(void **state)
{
  (void)state;
  test_random r = {34};
  const hl_pose turn = {{0.01, 0.08, -0.02}, {0}};
  fixed_scene f = fixed_scene_of(HL_LENS_PINHOLE, 1, &r);
  hl_corners corners = seen_now(&f.scene, &turn, &r);
  const hl_drift d = compared(&f, &corners, 0.01);
  assert_true(is_moved(&d, "rotation"));
  assert_near(d.cause[3].figure, 57.29577951308232 * hl_norm(turn.rotation_rad), 0.05);
  for (int k = 0; k < 3; k++)
    assert_near(d.cause[3].change[k], turn.rotation_rad[k], 4 * d.cause[3].sigma[k] + 1e-5);
  hl_corners_free(&corners);
  hl_calibration_free(&f.reference);
}

static void test_differences_are_seen_minus_predicted(void **state)
{
  (void)state;
  test_random r = {35};
  fixed_scene f = fixed_scene_of(HL_LENS_PINHOLE, 1, &r);
  hl_corners corners = seen_now(&f.scene, NULL, &r);
  const hl_drift d = compared(&f, &corners, 0.01);
  double sum = 0, z = 0;
  int k = 0;
  for (int i = 0; i < hl_target_corners(&f.scene.target); i++) {
    const hl_corner *c = &corners.view[0].corner[i];
    double b[3], at[3], q[2];
    if (!(c->sigma > 0))
      continue;
    hl_target_corner(&f.scene.target, i, b);
    hl_pose_apply(&f.board.cam_from_board, b, at, NULL, NULL);
    assert_int_equal(hl_camera_project(NULL, &f.reference.camera, at, q), HL_OK);
    assert_near(d.at_px[k][0], q[0], 1e-9);
    assert_near(d.difference_px[k][0], c->x - q[0], 1e-9);
    assert_near(d.difference_px[k][1], c->y - q[1], 1e-9);
    sum += hypot(c->x - q[0], c->y - q[1]);
    z += pow(hypot(c->x - q[0], c->y - q[1]) / d.sigma_px[k], 2);
    k++;
  }
  assert_int_equal(d.n_nodes, k);
  assert_int_equal(d.columns, 0);
  assert_near(d.mean_px, sum / k, 1e-9);
  assert_near(z / k, 2, 0.6); /* 2 degrees of freedom a corner, 63 corners */
  hl_corners_free(&corners);
  hl_calibration_free(&f.reference);
}

static void test_larger_boards_are_thinned(void **state)
{
  (void)state;
  test_random r = {36};
  fixed_scene f = {.scene = drift_scene_of(HL_LENS_PINHOLE, VIEWS, 3)};
  f.reference = drift_calibrate(&f.scene, &r);
  f.scene.target = (hl_target){HL_TARGET_CHESSBOARD, 30, 25, 0.008, 0};
  f.scene.board[FIXED] = (hl_pose){{0.2, -0.2, 0}, {-0.1, -0.09, 0.4}};
  f.board = (hl_board_pose){.target = f.scene.target, .cam_from_board = f.scene.board[FIXED]};
  hl_corners corners = seen_now(&f.scene, NULL, &r);
  assert_int_equal(corners.view[0].seen, 750);
  const hl_drift d = compared(&f, &corners, 0.01);
  assert_int_equal(d.n_nodes, HL_DRIFT_GRID * HL_DRIFT_GRID);
  for (int k = 0; k < d.n_nodes; k++)
    assert_true(d.sigma_px[k] > 0);
  assert_true(has_note(&d, "board pose", "states no covariance; it is taken as exact"));
  hl_corners_free(&corners);
  hl_calibration_free(&f.reference);
}

/* Counted from its other end a chessboard is the same board. */
static void test_either_end_of_a_chessboard(void **state)
{
  (void)state;
  test_random r = {37};
  fixed_scene f = fixed_scene_of(HL_LENS_PINHOLE, 1, &r);
  hl_corners corners = seen_now(&f.scene, NULL, &r);
  const hl_drift straight = compared(&f, &corners, 0.01);
  const int n = hl_target_corners(&f.scene.target);
  for (int i = 0; i < n / 2; i++) {
    const hl_corner c = corners.view[0].corner[i];
    corners.view[0].corner[i] = corners.view[0].corner[n - 1 - i];
    corners.view[0].corner[n - 1 - i] = c;
  }
  const hl_drift turned = compared(&f, &corners, 0.01);
  assert_near(turned.significance, straight.significance, 1e-9);
  hl_corners_free(&corners);
  hl_calibration_free(&f.reference);
}

/* A blurred view is not a drifted camera. */
static void test_more_noise_is_noise(void **state)
{
  (void)state;
  test_random r = {38};
  int alarms = 0;
  for (int i = 0; i < 20; i++) {
    fixed_scene f = fixed_scene_of(HL_LENS_PINHOLE, (uint64_t)i + 1, &r);
    drift_scene noisy = f.scene;
    noisy.noise_px *= 4;
    hl_corners corners = seen_now(&noisy, NULL, &r);
    const hl_drift d = compared(&f, &corners, 0.01);
    alarms += d.drifted;
    assert_true(has_note(&d, "corner noise", "the view's own is used"));
    hl_corners_free(&corners);
    hl_calibration_free(&f.reference);
  }
  assert_in_range(alarms, 0, 2);
}

static void test_noise_that_is_not_stated(void **state)
{
  (void)state;
  test_random r = {39};
  fixed_scene f = fixed_scene_of(HL_LENS_PINHOLE, 1, &r);
  hl_corners corners = seen_now(&f.scene, NULL, &r);
  const hl_drift stated = compared(&f, &corners, 0.01);
  f.reference.noise_px = 0; /* from rms_px: 0.1414, over both axes */
  const hl_drift of_rms = compared(&f, &corners, 0.01);
  assert_near(of_rms.significance, stated.significance, 0.15);
  f.reference.camera.rms_px = 0;
  const hl_drift own = compared(&f, &corners, 0.01);
  assert_true(has_note(&own, "corner noise", "the camera states no rms_px"));
  assert_false(own.drifted);
  hl_corners_free(&corners);
  hl_calibration_free(&f.reference);
}

static void refused(const fixed_scene *f, const hl_corners *corners, int view, hl_status status,
                    const char *part)
{
  hl_ctx ctx = {0};
  static hl_drift out, before;
  memset(&out, 0x5a, sizeof out);
  before = out;
  assert_int_equal(hl_drift_board(&ctx, &f->reference, &f->board, corners, view, NULL, &out),
                   status);
  assert_says(ctx.msg, part);
  assert_memory_equal(&out, &before, sizeof out);
}

static void test_refusals(void **state)
{
  (void)state;
  test_random r = {40};
  fixed_scene f = fixed_scene_of(HL_LENS_PINHOLE, 1, &r);
  hl_corners corners = seen_now(&f.scene, NULL, &r);
  fixed_scene bad = f;
  bad.board.target.columns = 10;
  refused(&bad, &corners, 0, HL_ERR_FORMAT,
          "the board's pose is that of chessboard:10x7:0.03, the view shows chessboard:9x7:0.03");
  bad = f;
  bad.board.camera.fx += 1;
  refused(&bad, &corners, 0, HL_ERR_FORMAT, "fitted with another camera file");
  bad = f;
  bad.reference.camera.has_covariance = false;
  refused(&bad, &corners, 0, HL_ERR_DEGENERATE, "the reference camera states no covariance");
  bad = f;
  memset(bad.board.covariance, 0, sizeof bad.board.covariance);
  refused(&bad, &corners, 0, HL_ERR_DEGENERATE, "the board pose's covariance is singular");
  refused(&f, &corners, 1, HL_ERR_ARG, "view 1 of 1 views");
  corners.width = 1280;
  refused(&f, &corners, 0, HL_ERR_FORMAT, "fixed.png has 1280 x 480 px, the camera 640 x 480");
  corners.width = 640;
  corners.view[0].used = false;
  snprintf(corners.view[0].why, sizeof corners.view[0].why, "no corner of the board was found");
  refused(&f, &corners, 0, HL_ERR_DEGENERATE, "fixed.png: no corner of the board was found");
  corners.view[0].used = true;
  corners.view[0].seen = 0;
  for (int i = 0; i < hl_target_corners(&f.scene.target); i++)
    corners.view[0].seen += i < 11 ? 1 : 0;
  refused(&f, &corners, 0, HL_ERR_DEGENERATE, "11 corners of the board are seen; 12 are needed");
  hl_corners_free(&corners);
  hl_calibration_free(&f.reference);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_false_alarms_come_at_their_rate),
      cmocka_unit_test(test_changes_are_found_and_named),
      cmocka_unit_test(test_what_one_view_cannot_tell_is_noted),
      cmocka_unit_test(test_large_motions_are_measured),
      cmocka_unit_test(test_differences_are_seen_minus_predicted),
      cmocka_unit_test(test_larger_boards_are_thinned),
      cmocka_unit_test(test_either_end_of_a_chessboard),
      cmocka_unit_test(test_more_noise_is_noise),
      cmocka_unit_test(test_noise_that_is_not_stated),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
