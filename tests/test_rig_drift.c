/* Sessions of a rig against each other: what moved is named, nothing else is, and false alarms are as
 * rare as stated. */
#include <stdlib.h>

#include "halflight/rig_drift.h"
#include "rig_scene.h"

static const double degree = 0.017453292519943295;

/* One calibration for both unless `two`. */
static hl_rig_drift compared(const rig_scene *before, const rig_scene *after, bool two,
                             uint64_t seed, double rate)
{
  test_random r = {(seed + 1) * 0x9E3779B97F4A7C15u};
  double k[9], l[9];
  hl_ctx ctx = {0};
  hl_rig_drift d;
  rig_draw_camera(before, &r, k);
  rig_draw_camera(before, &r, l);
  hl_lights a = rig_draw(before, k, &r), b = rig_draw(after, two ? l : k, &r);
  const hl_rig_drift_settings settings = {.false_alarm = rate};
  const hl_status st = hl_drift_rig(&ctx, &a, &b, &settings, &d);
  if (st != HL_OK)
    fail_msg("%s", ctx.msg);
  for (int i = 0; i < d.n_causes; i++)
    d.cause[i].name = "";
  hl_lights_free(&a);
  hl_lights_free(&b);
  return d;
}

/* `expected`: bit i of [part] says that place i of that part moved; mount and sphere are place 0. */
static void check_moved(const hl_rig_drift *d, const unsigned expected[HL_RIG_PARTS])
{
  for (int i = 0; i < d->n_causes; i++) {
    const hl_rig_cause *c = &d->cause[i];
    const bool should = expected[c->part] >> (c->reference > 0 ? c->reference : 0) & 1;
    if (c->moved != should)
      fail_msg("%s, place %d: moved %d, figure %g, threshold %g", c->what, c->reference, c->moved,
               c->figure, c->threshold);
  }
}

static const hl_rig_cause *cause(const hl_rig_drift *d, hl_rig_part part, int place)
{
  for (int i = 0; i < d->n_causes; i++)
    if (d->cause[i].part == part && d->cause[i].reference == place)
      return &d->cause[i];
  fail_msg("part %d of place %d was not tested", part, place);
  return NULL;
}

static void test_names_what_moved(void **state)
{
  (void)state;
  const rig_scene before = rig_scene_new();
  rig_scene after = before;
  rig_turn_by(after.direction[4], degree, 0);
  rig_turn_by(after.direction[13], 0, -degree);
  after.intensity[19] *= 0.9;
  after.center_m[0] += 0.0012;
  after.center_m[1] -= 0.0008;
  const unsigned expected[HL_RIG_PARTS] = {
      [HL_RIG_DIRECTION] = 1u << 4 | 1u << 13, [HL_RIG_INTENSITY] = 1u << 19, [HL_RIG_SPHERE] = 1};
  for (uint64_t seed = 0; seed < 20; seed++) {
    hl_rig_drift d = compared(&before, &after, false, seed, 0.001);
    assert_true(d.drifted);
    check_moved(&d, expected);
    assert_near(cause(&d, HL_RIG_DIRECTION, 4)->figure, 1, 0.15);
    assert_near(cause(&d, HL_RIG_DIRECTION, 13)->figure, 1, 0.15);
    assert_near(cause(&d, HL_RIG_INTENSITY, 19)->change[0], 0.9, 0.03);
    assert_near(cause(&d, HL_RIG_SPHERE, 0)->change[0], 0.0012, 4e-4);
    hl_rig_drift_free(&d);
  }
}

/* A camera that turned moves every light, and the ball with them: one cause. */
static void test_turned_camera_is_mount(void **state)
{
  (void)state;
  const rig_scene before = rig_scene_new();
  rig_scene after = before;
  const double w[3] = {0.02, -0.015, 0.03};
  for (int i = 0; i < RIG_LIGHTS; i++) {
    double turn[3];
    hl_cross(w, before.direction[i], turn);
    hl_add_scaled(before.direction[i], 1, turn, after.direction[i]);
    hl_unit(after.direction[i], after.direction[i]);
  }
  double carried[3];
  hl_cross(w, before.center_m, carried);
  hl_add_scaled(before.center_m, 1, carried, after.center_m);
  rig_turn_by(after.direction[7], 2 * degree, 0);
  const unsigned expected[HL_RIG_PARTS] = {[HL_RIG_MOUNT] = 1, [HL_RIG_DIRECTION] = 1u << 7};
  for (uint64_t seed = 0; seed < 10; seed++) {
    hl_rig_drift d = compared(&before, &after, false, seed, 0.001);
    check_moved(&d, expected);
    assert_near(cause(&d, HL_RIG_MOUNT, -1)->figure, hl_norm(w) / degree, 0.5);
    hl_rig_drift_free(&d);
  }
}

static void test_false_alarms(void **state)
{
  (void)state;
  const char *text = getenv("HL_RIG_DRAWS"); /* more, by hand */
  const int n = text ? atoi(text) : 300;
  const rig_scene rig = rig_scene_new();
  const double rate = 0.1;
  int alarms[2] = {0};
  for (int i = 0; i < 2 * n; i++) {
    hl_rig_drift d = compared(&rig, &rig, i % 2, 1000 + (uint64_t)i, rate);
    alarms[i % 2] += d.drifted;
    assert_int_equal(d.drifted, d.significance < rate);
    hl_rig_drift_free(&d);
  }
  if (text)
    printf("false alarms of %d: %d with one calibration, %d with two; stated %g\n", n, alarms[0],
           alarms[1], rate);
  for (int k = 0; k < 2; k++)
    if (fabs(alarms[k] - rate * n) > 4 * sqrt(rate * (1 - rate) * n))
      fail_msg("%d false alarms of %d", alarms[k], n);
}

static void test_exposure(void **state)
{
  (void)state;
  const rig_scene rig = rig_scene_new();
  test_random r = {5};
  const double k[9] = {0};
  hl_lights a = rig_draw(&rig, k, &r), b = rig_draw(&rig, k, &r);
  hl_rig_drift d;
  b.light[3].exposure_us *= 1.25;
  assert_int_equal(hl_drift_rig(NULL, &a, &b, NULL, &d), HL_OK);
  const hl_rig_cause *c = cause(&d, HL_RIG_EXPOSURE, -1);
  assert_true(d.drifted && c->moved);
  assert_string_equal(c->name, "04");
  assert_near(c->change[0], 1.25, 1e-12);
  hl_rig_drift_free(&d);
  hl_lights_free(&a);
  hl_lights_free(&b);
}

/* Lights are found by label in any order; what is in one session only is named. */
static void test_matching(void **state)
{
  (void)state;
  const rig_scene rig = rig_scene_new();
  test_random r = {7};
  const double k[9] = {0};
  hl_lights a = rig_draw(&rig, k, &r), b = rig_draw(&rig, k, &r);
  hl_rig_drift d;
  const hl_rig_light swap = b.light[0];
  b.light[0] = b.light[20];
  b.light[20] = swap;
  free(b.light[9].label);
  b.light[9].label = strdup("new");
  b.light[11].trusted = false;
  assert_int_equal(hl_drift_rig(NULL, &a, &b, NULL, &d), HL_OK);
  assert_false(d.drifted);
  assert_int_equal(d.n_matched, RIG_LIGHTS - 2);
  assert_string_equal(d.notes.note[0].why, "lights are matched by label");
  assert_string_equal(d.notes.note[1].why, "10 is in the reference session only");
  assert_string_equal(d.notes.note[2].why,
                      "12 is not compared: it is not to be trusted in the current session");
  assert_string_equal(d.notes.note[3].why, "new is in the current session only");
  hl_rig_drift_free(&d);
  hl_lights_free(&a);
  hl_lights_free(&b);
}

static void refused(const hl_lights *a, const hl_lights *b, double rate, hl_status status,
                    const char *message)
{
  hl_ctx ctx = {0};
  hl_rig_drift d;
  const hl_rig_drift_settings settings = {.false_alarm = rate};
  assert_int_equal(hl_drift_rig(&ctx, a, b, &settings, &d), status);
  if (!strstr(ctx.msg, message))
    fail_msg("\"%s\" instead of \"%s\"", ctx.msg, message);
}

static void test_refusals(void **state)
{
  (void)state;
  const rig_scene rig = rig_scene_new();
  test_random r = {9};
  const double k[9] = {0};
  hl_lights a = rig_draw(&rig, k, &r), b = rig_draw(&rig, k, &r);
  refused(&a, &b, 2, HL_ERR_ARG, "false_alarm");
  b.camera.width = 177;
  refused(&a, &b, 0.01, HL_ERR_FORMAT, "frames of 176 x 144 and of 177 x 144");
  b.camera.width = 176;
  b.ball[0].radius_m = 0.03;
  refused(&a, &b, 0.01, HL_ERR_FORMAT, "ball 0 has a radius of 0.025 m and of 0.03 m");
  b.ball[0].radius_m = 0.025;
  b.n_balls = 2;
  refused(&a, &b, 0.01, HL_ERR_FORMAT, "1 and 2 balls");
  b.n_balls = 1;
  memset(a.light[2].own_rad2, 0, sizeof a.light[2].own_rad2);
  memset(b.light[2].own_rad2, 0, sizeof b.light[2].own_rad2);
  refused(&a, &b, 0.01, HL_ERR_DEGENERATE, "light 03 states no uncertainty of its own");
  for (int i = 2; i < RIG_LIGHTS; i++)
    b.light[i].found = false;
  refused(&a, &b, 0.01, HL_ERR_DEGENERATE, "2 lights in common");
  hl_lights_free(&a);
  hl_lights_free(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_names_what_moved), cmocka_unit_test(test_turned_camera_is_mount),
      cmocka_unit_test(test_false_alarms),     cmocka_unit_test(test_exposure),
      cmocka_unit_test(test_matching),         cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
