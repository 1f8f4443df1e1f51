/* Two calibrations of one camera: false alarms at their stated rate, changes found and named. */
#include "drift_scene.h"

#include "files.h"

enum { VIEWS = 12 };

typedef struct pair {
  hl_calibration reference, current;
} pair;

static pair pair_of(const drift_scene *reference, const drift_scene *current, test_random *r)
{
  pair p = {drift_calibrate(reference, r), drift_calibrate(current, r)};
  return p;
}

static void pair_free(pair *p)
{
  hl_calibration_free(&p->reference);
  hl_calibration_free(&p->current);
}

static hl_drift compared(const hl_calibration *reference, const hl_calibration *current,
                         double false_alarm)
{
  hl_drift_settings s = hl_drift_defaults();
  hl_ctx ctx = {0};
  hl_drift d;
  s.false_alarm = false_alarm;
  if (hl_drift_cameras(&ctx, reference, current, &s, &d) != HL_OK)
    fail_msg("%s", ctx.msg);
  return d;
}

static const hl_drift_cause *part_of(const hl_drift *d, const char *part)
{
  for (int i = 0; i < d->n_causes; i++)
    if (strcmp(d->cause[i].part, part) == 0)
      return &d->cause[i];
  fail_msg("no part %s", part);
  return NULL;
}

/* "focal length+rotation" */
static const char *moved_parts(const hl_drift *d, char text[120])
{
  size_t n = 0;
  text[0] = '\0';
  for (int i = 0; i < d->n_causes; i++)
    if (d->cause[i].moved)
      n += (size_t)snprintf(text + n, 120 - n, "%s%s", n > 0 ? "+" : "", d->cause[i].part);
  return text;
}

/* Share of alarms over independent pairs of calibrations of one unchanged camera. */
static int alarms(hl_lens_model model, int pairs, double rate, bool same_boards, int *with_mount)
{
  test_random r = {11 + (uint64_t)model};
  int n = 0;
  *with_mount = 0;
  for (int i = 0; i < pairs; i++) {
    const drift_scene a = drift_scene_of(model, VIEWS, (uint64_t)(2 * i + 1));
    const drift_scene b = same_boards ? a : drift_scene_of(model, VIEWS, (uint64_t)(2 * i + 2));
    pair p = pair_of(&a, &b, &r);
    const hl_drift d = compared(&p.reference, &p.current, rate);
    n += d.drifted;
    *with_mount += d.n_causes == 5;
    pair_free(&p);
  }
  return n;
}

/* Binomial(400, 0.05) has mean 20 and deviation 4.4. */
static void test_false_alarms_come_at_their_rate(void **state)
{
  (void)state;
  int with_mount;
  const int n = alarms(HL_LENS_PINHOLE, 400, 0.05, false, &with_mount);
  assert_in_range(n, 10, 32);
  assert_int_equal(with_mount, 0); /* boards in other poses never count as standing still */
}

/* The same with the mount in the comparison; the boards are taken to have stood still in all but a
 * share as large as the rate. */
static void test_false_alarms_with_the_mount(void **state)
{
  (void)state;
  int with_mount;
  const int n = alarms(HL_LENS_PINHOLE, 400, 0.05, true, &with_mount);
  assert_in_range(n, 10, 32);
  assert_in_range(with_mount, 368, 390);
}

static void test_false_alarms_of_the_other_lenses(void **state)
{
  (void)state;
  int with_mount;
  /* Binomial(200, 0.05): 10 +- 3.1 */
  assert_in_range(alarms(HL_LENS_FISHEYE, 200, 0.05, false, &with_mount), 2, 20);
  assert_in_range(alarms(HL_LENS_FISHEYE, 200, 0.05, true, &with_mount), 2, 20);
}

typedef struct change {
  double focal, centre, k1;
  hl_pose mount;
  const char *moved;
} change;

static drift_scene changed(drift_scene s, const change *c)
{
  s.camera.fx *= 1 + c->focal;
  s.camera.fy *= 1 + c->focal;
  s.camera.cx += c->centre;
  s.camera.distortion[0] += c->k1;
  drift_move_mount(&s, &c->mount);
  return s;
}

/* How often of ten the change is found and called by its name, and nothing else. */
static void assert_named(const change *c, bool same_boards, int least)
{
  test_random r = {101};
  int named = 0, found = 0;
  for (int i = 0; i < 10; i++) {
    const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 20, 500 + (uint64_t)i);
    const drift_scene b =
        changed(same_boards ? a : drift_scene_of(HL_LENS_PINHOLE, 20, 600 + (uint64_t)i), c);
    pair p = pair_of(&a, &b, &r);
    const hl_drift d = compared(&p.reference, &p.current, 0.01);
    char text[120];
    found += d.drifted;
    named += strcmp(moved_parts(&d, text), c->moved) == 0;
    if (strcmp(text, c->moved) != 0)
      print_message("%s called %s\n", c->moved, text);
    pair_free(&p);
  }
  assert_int_equal(found, 10);
  if (named < least)
    fail_msg("%s named in %d of 10", c->moved, named);
}

static void test_changes_of_the_intrinsics_are_named(void **state)
{
  (void)state;
  static const change changes[] = {
      {.focal = 0.005, .moved = "focal length"},
      {.centre = 3, .moved = "centre"},
      {.k1 = 0.01, .moved = "distortion"},
      {.focal = 0.005, .k1 = 0.01, .moved = "focal length+distortion"},
  };
  for (int i = 0; i < 4; i++)
    assert_named(&changes[i], false, 9);
}

/* Where boards stood still, each change is told from a mount that moved. */
static void test_changes_of_the_mount_are_named(void **state)
{
  (void)state;
  const double rad = 0.15 / 57.295779513082320877; /* 0.15 deg, 0.6 mm */
  const hl_pose knock = {{0.6 * rad, 0.8 * rad, 0}, {0.0004, 0, 0.000447}};
  const hl_pose turn = {{0, rad, 0}, {0}}, shift = {{0}, {0.0004, 0, 0.000447}};
  const change changes[] = {
      {.mount = knock, .moved = "rotation+translation"},
      {.mount = turn, .moved = "rotation"},
      {.mount = shift, .moved = "translation"},
      {.focal = 0.004, .mount = knock, .moved = "focal length+rotation+translation"},
      {.centre = 3, .moved = "centre"},
  };
  for (int i = 0; i < 5; i++)
    assert_named(&changes[i], true, 9);
}

/* A mount that moved between hand-held boards is nothing one can know. */
static void test_hand_held_boards_say_nothing_of_the_mount(void **state)
{
  (void)state;
  test_random r = {7};
  const change c = {.mount = {{0.01, 0.02, 0}, {0.01, 0, 0}}};
  const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 20, 1);
  const drift_scene b = changed(drift_scene_of(HL_LENS_PINHOLE, 20, 2), &c);
  pair p = pair_of(&a, &b, &r);
  const hl_drift d = compared(&p.reference, &p.current, 0.01);
  assert_int_equal(d.n_causes, 3);
  assert_false(d.drifted);
  assert_int_equal(d.notes.n, 1);
  assert_string_equal(d.notes.note[0].what, "mount");
  assert_says(d.notes.note[0].why, "did not stand still");
  pair_free(&p);
}

/* One board among those that stood still was moved: the boards cannot be taken for still. */
static void test_one_board_that_was_moved_is_seen(void **state)
{
  (void)state;
  test_random r = {8};
  const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 20, 1);
  drift_scene b = a;
  b.board[4].translation_m[1] += 0.001;
  pair p = pair_of(&a, &b, &r);
  const hl_drift d = compared(&p.reference, &p.current, 0.01);
  assert_int_equal(d.n_causes, 3);
  assert_says(d.notes.note[0].why, "did not stand still");
  pair_free(&p);
}

static void test_what_is_said_of_views_without_partners(void **state)
{
  (void)state;
  test_random r = {9};
  const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 8, 1);
  pair p = pair_of(&a, &a, &r);
  for (int i = 1; i < 8; i++)
    snprintf(p.current.view[i].name, sizeof p.current.view[i].name, "other%d.png", i);
  hl_drift d = compared(&p.reference, &p.current, 0.01);
  assert_int_equal(d.n_causes, 3);
  assert_says(d.notes.note[0].why, "one board of the same name cannot tell whether it stood still");
  snprintf(p.current.view[0].name, sizeof p.current.view[0].name, "other0.png");
  d = compared(&p.reference, &p.current, 0.01);
  assert_says(d.notes.note[0].why, "no view of the one has the name of a view of the other");
  p.current.n_views = 0;
  d = compared(&p.reference, &p.current, 0.01);
  assert_says(d.notes.note[0].why, "a camera states no board poses");
  pair_free(&p);
}

/* Sessions lie in folders of their own; a name that a session has twice means nothing. */
static void test_names_are_compared_without_their_folders(void **state)
{
  (void)state;
  test_random r = {10};
  const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 8, 1);
  pair p = pair_of(&a, &a, &r);
  for (int i = 0; i < 8; i++) {
    snprintf(p.reference.view[i].name, sizeof p.reference.view[i].name, "before/view%d.png", i);
    snprintf(p.current.view[i].name, sizeof p.current.view[i].name, "today/left/view%d.png", i);
  }
  assert_int_equal(compared(&p.reference, &p.current, 0.01).n_causes, 5);
  for (int i = 0; i < 8; i++)
    snprintf(p.current.view[i].name, sizeof p.current.view[i].name, "%d/view%d.png", i, i / 2);
  assert_int_equal(compared(&p.reference, &p.current, 0.01).n_causes, 3);
  pair_free(&p);
}

static void test_a_camera_is_the_same_as_itself(void **state)
{
  (void)state;
  test_random r = {12};
  const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 8, 3);
  hl_calibration c = drift_calibrate(&a, &r);
  const hl_drift d = compared(&c, &c, 0.01);
  assert_false(d.drifted);
  assert_near(d.significance, 1, 1e-12);
  assert_near(d.max_px, 0, 1e-9);
  for (int i = 0; i < d.n_causes; i++) {
    assert_near(d.cause[i].figure, 0, 1e-9);
    assert_true(d.cause[i].threshold > 0);
  }
  hl_calibration_free(&c);
}

/* The other way round everything has the other sign and the same size. */
static void test_swap(void **state)
{
  (void)state;
  test_random r = {13};
  const change c = {.focal = 0.001, .mount = {{0.0005, 0, 0}, {0}}};
  const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 12, 3);
  const drift_scene b = changed(a, &c);
  pair p = pair_of(&a, &b, &r);
  const hl_drift there = compared(&p.reference, &p.current, 0.01);
  const hl_drift back = compared(&p.current, &p.reference, 0.01);
  assert_true(there.drifted);
  for (int i = 0; i < 5; i++) {
    assert_int_equal(there.cause[i].moved, back.cause[i].moved);
    assert_near(back.cause[i].figure / back.cause[i].threshold,
                there.cause[i].figure / there.cause[i].threshold,
                0.05 * there.cause[i].figure / there.cause[i].threshold + 0.01);
    for (int k = 0; k < there.cause[i].n; k++)
      assert_near(back.cause[i].change[k], -there.cause[i].change[k],
                  0.05 * there.cause[i].sigma[k]);
  }
  pair_free(&p);
}

/* In other units of length: the same, but for the translation's own figures. */
static void test_units_do_not_matter(void **state)
{
  (void)state;
  test_random r = {14};
  const change c = {.mount = {{0.0003, 0, 0}, {0.0001, 0, 0}}};
  const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 12, 3);
  const drift_scene b = changed(a, &c);
  pair p = pair_of(&a, &b, &r);
  const hl_drift metres = compared(&p.reference, &p.current, 0.01);
  const double k = 1000;
  for (int side = 0; side < 2; side++) {
    hl_calibration *s = side ? &p.current : &p.reference;
    for (int v = 0; v < s->n_views; v++)
      for (int i = 0; i < 3; i++) {
        s->view[v].cam_from_board.translation_m[i] *= k;
        for (int j = 0; j < HL_POSE_SIZE; j++) {
          s->view[v].own_covariance[3 + i][j] *= k;
          s->view[v].own_covariance[j][3 + i] *= k;
        }
        for (int j = 0; j < 9; j++)
          s->view[v].by_intrinsics[3 + i][j] *= k;
      }
  }
  const hl_drift millimetres = compared(&p.reference, &p.current, 0.01);
  assert_near(log(millimetres.significance), log(metres.significance),
              1e-6 * fabs(log(metres.significance)));
  for (int i = 0; i < 5; i++) {
    const double unit = i == 4 ? k : 1;
    assert_near(millimetres.cause[i].figure, unit * metres.cause[i].figure,
                1e-6 * unit * metres.cause[i].figure);
    assert_near(millimetres.cause[i].threshold, unit * metres.cause[i].threshold,
                1e-5 * unit * metres.cause[i].threshold);
  }
  pair_free(&p);
}

/* Deviations stated for the changes against their scatter over repeated noise. */
static void test_stated_deviations_are_the_scatter(void **state)
{
  (void)state;
  test_random r = {15};
  double sum[5] = {0};
  int count[5] = {0};
  const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 12, 3);
  for (int run = 0; run < 120; run++) {
    pair p = pair_of(&a, &a, &r);
    const hl_drift d = compared(&p.reference, &p.current, 1e-12);
    for (int i = 0; i < d.n_causes; i++)
      for (int k = 0; k < d.cause[i].n; k++) {
        sum[i] += pow(d.cause[i].change[k] / d.cause[i].sigma[k], 2);
        count[i]++;
      }
    pair_free(&p);
  }
  /* 240 and more numbers, correlated within a part: rms within 15 % */
  for (int i = 0; i < 5; i++)
    assert_near(sqrt(sum[i] / count[i]), 1, 0.15);
}

/* Views whose corners err together: the deviations follow the scatter that the calibration states. */
static void test_scatter_widens(void **state)
{
  (void)state;
  test_random r = {16};
  const change c = {.focal = 0.005};
  const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 20, 1);
  const drift_scene b = changed(drift_scene_of(HL_LENS_PINHOLE, 20, 2), &c);
  pair p = pair_of(&a, &b, &r);
  const hl_drift plain = compared(&p.reference, &p.current, 0.01);
  p.current.scatter = p.reference.scatter = 9;
  const hl_drift wide = compared(&p.reference, &p.current, 0.01);
  assert_true(wide.significance > plain.significance);
  const hl_drift_cause *before = part_of(&plain, "focal length");
  const hl_drift_cause *after = part_of(&wide, "focal length");
  assert_near(after->sigma[0], 3 * before->sigma[0], 1e-9);
  assert_string_equal(wide.notes.note[0].what, "reference");
  assert_says(wide.notes.note[0].why, "taken 3.00 times as large");
  pair_free(&p);
}

/* ---- different lens models ---- */

/* The same lens written with other terms: the rational model without its denominator. */
static hl_calibration as_rational(const hl_calibration *pinhole)
{
  hl_calibration out = *pinhole;
  out.view = NULL;
  out.n_views = 0;
  out.camera.model = HL_LENS_RATIONAL;
  out.camera.n_distortion = 8;
  memset(out.camera.covariance, 0, sizeof out.camera.covariance);
  for (int i = 0; i < 12; i++)
    for (int k = 0; k < 12; k++)
      out.camera.covariance[12 * i + k] = i < 9 && k < 9 ? pinhole->camera.covariance[9 * i + k]
                                          : i == k       ? 1e-10
                                                         : 0;
  return out;
}

static void test_other_models_are_compared_by_projection(void **state)
{
  (void)state;
  test_random r = {17};
  int alarms_seen = 0;
  for (int i = 0; i < 200; i++) {
    const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, VIEWS, (uint64_t)(2 * i + 1));
    const drift_scene b = drift_scene_of(HL_LENS_PINHOLE, VIEWS, (uint64_t)(2 * i + 2));
    pair p = pair_of(&a, &b, &r);
    const hl_calibration other = as_rational(&p.current);
    const hl_drift d = compared(&p.reference, &other, 0.05);
    assert_int_equal(d.n_causes, 1);
    assert_string_equal(d.cause[0].part, "projection");
    assert_string_equal(d.notes.note[0].what, "parts");
    assert_string_equal(d.notes.note[1].what, "mount");
    alarms_seen += d.drifted;
    pair_free(&p);
  }
  assert_in_range(alarms_seen, 2, 20); /* Binomial(200, 0.05): 10 +- 3.1 */
}

static void test_changes_are_found_between_other_models(void **state)
{
  (void)state;
  static const change changes[] = {{.focal = 0.005}, {.centre = 3}, {.k1 = 0.01}};
  test_random r = {18};
  for (int k = 0; k < 3; k++) {
    int found = 0;
    for (int i = 0; i < 10; i++) {
      const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 20, (uint64_t)(2 * i + 1));
      const drift_scene b =
          changed(drift_scene_of(HL_LENS_PINHOLE, 20, (uint64_t)(2 * i + 2)), &changes[k]);
      pair p = pair_of(&a, &b, &r);
      const hl_calibration other = as_rational(&p.current);
      const hl_drift d = compared(&p.reference, &other, 0.01);
      found += d.drifted;
      assert_true((d.cause[0].figure > d.cause[0].threshold) == d.drifted);
      pair_free(&p);
    }
    assert_in_range(found, 9, 10);
  }
}

/* ---- refusals ---- */

static void refused(const hl_calibration *reference, const hl_calibration *current,
                    const hl_drift_settings *settings, hl_status status, const char *part)
{
  hl_ctx ctx = {0};
  static hl_drift out, before;
  memset(&out, 0x5a, sizeof out);
  before = out;
  assert_int_equal(hl_drift_cameras(&ctx, reference, current, settings, &out), status);
  assert_says(ctx.msg, part);
  assert_memory_equal(&out, &before, sizeof out);
}

static void test_refusals(void **state)
{
  (void)state;
  test_random r = {19};
  const drift_scene a = drift_scene_of(HL_LENS_PINHOLE, 8, 3);
  pair p = pair_of(&a, &a, &r);
  hl_calibration bad = p.current;
  bad.camera.has_covariance = false;
  refused(&p.reference, &bad, NULL, HL_ERR_DEGENERATE,
          "the current camera states no covariance; one that 'halflight calibrate' wrote does");
  refused(&bad, &p.reference, NULL, HL_ERR_DEGENERATE, "the reference camera states no covariance");
  bad = p.current;
  bad.camera.height = 481;
  refused(&p.reference, &bad, NULL, HL_ERR_FORMAT,
          "frame is 640 x 480 px, the current one 640 x 481");
  bad = p.current;
  for (int i = 0; i < 9; i++)
    bad.camera.covariance[9 * 8 + i] = bad.camera.covariance[9 * i + 8] = 0;
  refused(&p.reference, &bad, NULL, HL_ERR_DEGENERATE,
          "the current camera's covariance is singular at distortion[4]");
  bad = p.current;
  for (int i = 0; i < 9; i++) /* cy follows cx exactly */
    bad.camera.covariance[9 * 3 + i] = bad.camera.covariance[9 * 2 + i];
  for (int i = 0; i < 9; i++)
    bad.camera.covariance[9 * i + 3] = bad.camera.covariance[9 * i + 2];
  refused(&bad, &p.current, NULL, HL_ERR_DEGENERATE,
          "the reference camera's covariance is singular at cy");
  hl_drift_settings s = hl_drift_defaults();
  s.false_alarm = 0;
  refused(&p.reference, &p.current, &s, HL_ERR_ARG, "false_alarm = 0 is outside [1e-12, 0.5]");
  s.false_alarm = NAN;
  refused(&p.reference, &p.current, &s, HL_ERR_ARG, "false_alarm = nan");
  s = hl_drift_defaults();
  s.distance_m = -1;
  refused(&p.reference, &p.current, &s, HL_ERR_ARG, "distance_m = -1 m is outside [0, 1e+06]");
  pair_free(&p);
}

static void test_defaults_pass_their_own_check(void **state)
{
  (void)state;
  const hl_drift_settings s = hl_drift_defaults();
  assert_int_equal(hl_fields_check(NULL, hl_drift_fields(), &s), HL_OK);
  assert_near(s.false_alarm, 0.01, 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_false_alarms_come_at_their_rate),
      cmocka_unit_test(test_false_alarms_with_the_mount),
      cmocka_unit_test(test_false_alarms_of_the_other_lenses),
      cmocka_unit_test(test_changes_of_the_intrinsics_are_named),
      cmocka_unit_test(test_changes_of_the_mount_are_named),
      cmocka_unit_test(test_hand_held_boards_say_nothing_of_the_mount),
      cmocka_unit_test(test_one_board_that_was_moved_is_seen),
      cmocka_unit_test(test_what_is_said_of_views_without_partners),
      cmocka_unit_test(test_names_are_compared_without_their_folders),
      cmocka_unit_test(test_a_camera_is_the_same_as_itself),
      cmocka_unit_test(test_swap),
      cmocka_unit_test(test_units_do_not_matter),
      cmocka_unit_test(test_stated_deviations_are_the_scatter),
      cmocka_unit_test(test_scatter_widens),
      cmocka_unit_test(test_other_models_are_compared_by_projection),
      cmocka_unit_test(test_changes_are_found_between_other_models),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_defaults_pass_their_own_check),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
