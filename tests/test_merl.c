/* MERL tables: the angles and cells of the database's own reader, and what lies between the cells. */
#include "merl_scene.h"

#define PI 3.14159265358979323846

static const double up[3] = {0, 0, 1};

/* ---- the published reader (BRDFRead.cpp), restated: angles in, cell out */

static void turn(const double vector[3], const double axis[3], double angle, double out[3])
{
  double cross[3];
  const double along = hl_dot(vector, axis) * (1 - cos(angle));
  hl_cross(axis, vector, cross);
  for (int i = 0; i < 3; i++)
    out[i] = vector[i] * cos(angle) + axis[i] * along + cross[i] * sin(angle);
}

static void reader_angles(double theta_in, double phi_in, double theta_out, double phi_out,
                          double angles[3])
{
  static const double y[3] = {0, 1, 0};
  const double in[3] = {sin(theta_in) * cos(phi_in), sin(theta_in) * sin(phi_in), cos(theta_in)};
  const double out[3] = {sin(theta_out) * cos(phi_out), sin(theta_out) * sin(phi_out),
                         cos(theta_out)};
  double half[3], turned[3], diff[3];
  hl_add_scaled(in, 1, out, half);
  hl_unit(half, half);
  angles[0] = acos(half[2]);
  turn(in, up, -atan2(half[1], half[0]), turned);
  turn(turned, y, -angles[0], diff);
  angles[1] = acos(fmin(diff[2], 1));
  angles[2] = atan2(diff[1], diff[0]);
}

static int within(double x, int n)
{
  return x < 0 ? 0 : x < n ? (int)x : n - 1;
}

static size_t reader_cell(const double angles[3])
{
  const double degrees = angles[0] / (PI / 2) * 90;
  const double phi = angles[2] < 0 ? angles[2] + PI : angles[2];
  const int half = within(sqrt(degrees * 90), 90), diff = within(angles[1] / (PI / 2) * 90, 90);
  return (size_t)within(phi / PI * 360 / 2, 180) + (size_t)diff * 180 + (size_t)half * 180 * 90;
}

/* Not within rounding of a cell's edge. */
static bool inside_cell(const double angles[3])
{
  const double x[3] = {sqrt(angles[0] / (PI / 2)) * 90, angles[1] / (PI / 2) * 90,
                       angles[2] / PI * 180};
  for (int i = 0; i < 3; i++)
    if (fabs(x[i] - round(x[i])) < 1e-6)
      return false;
  return true;
}

static void test_nearest_is_the_published_reader(void **state)
{
  (void)state;
  hl_merl merl = {0};
  test_random r = {7};
  int compared = 0;
  assert_int_equal(hl_merl_new(NULL, &merl), HL_OK);
  for (size_t i = 0; i < 3 * (size_t)HL_MERL_CELLS; i++)
    merl.value[i] = random_uniform(&r);
  for (int k = 0; k < 20000; k++) {
    double angles[3], got[3];
    const double ti = random_between(&r, 0, 1.55), to = random_between(&r, 0, 1.55);
    const double pi_ = random_between(&r, -PI, PI), po = random_between(&r, -PI, PI);
    const double s[3] = {sin(ti) * cos(pi_), sin(ti) * sin(pi_), cos(ti)};
    const double v[3] = {sin(to) * cos(po), sin(to) * sin(po), cos(to)};
    reader_angles(ti, pi_, to, po, angles);
    if (!inside_cell(angles))
      continue;
    compared++;
    const double *cell = merl.value + reader_cell(angles);
    assert_true(hl_merl_eval(&merl, up, s, v, HL_MERL_NEAREST, got));
    /* the reader's scale factors */
    assert_near(got[0], cell[0] * (1.0 / 1500.0), 1e-15);
    assert_near(got[1], cell[90 * 90 * 180] * (1.15 / 1500.0), 1e-15);
    assert_near(got[2], cell[2 * 90 * 90 * 180] * (1.66 / 1500.0), 1e-15);
  }
  assert_true(compared > 19000);
  hl_merl_free(&merl);
}

/* ---- angles */

static void test_angles_of_directions(void **state)
{
  (void)state;
  test_random r = {3};
  for (int k = 0; k < 2000; k++) {
    const hl_merl_angles a = {random_between(&r, 1e-3, PI / 2), random_between(&r, 1e-3, PI / 2),
                              random_between(&r, 1e-3, PI - 1e-3)};
    double s[3], v[3];
    hl_merl_directions(a, s, v);
    assert_near(hl_norm(s), 1, 1e-14);
    assert_near(hl_norm(v), 1, 1e-14);
    const hl_merl_angles there = hl_merl_angles_of(up, s, v), back = hl_merl_angles_of(up, v, s);
    assert_near(there.theta_half, a.theta_half, 1e-12);
    assert_near(there.theta_diff, a.theta_diff, 1e-12);
    assert_near(there.phi_diff, a.phi_diff, 1e-10);
    /* reciprocity */
    assert_near(back.theta_half, a.theta_half, 1e-12);
    assert_near(back.theta_diff, a.theta_diff, 1e-12);
    assert_near(back.phi_diff, a.phi_diff, 1e-10);
  }
}

static void test_angles_at_their_ends(void **state)
{
  (void)state;
  const hl_merl_angles all = hl_merl_angles_of(up, up, up);
  assert_near(all.theta_half, 0, 0);
  assert_near(all.theta_diff, 0, 0);
  assert_near(all.phi_diff, 0, 0);
  const double s[3] = {0.6, 0, 0.8}, v[3] = {-0.6, 0, 0.8};
  const hl_merl_angles mirrored = hl_merl_angles_of(up, s, v);
  assert_near(mirrored.theta_half, 0, 1e-15);
  assert_near(mirrored.theta_diff, atan2(0.6, 0.8), 1e-15);
  /* in the plane of n and h: s nearer to n, where phi_diff is pi, is s farther, where it is 0 */
  const double t[3] = {0.28, 0, 0.96};
  assert_near(hl_merl_angles_of(up, s, t).phi_diff, hl_merl_angles_of(up, t, s).phi_diff, 1e-15);
  assert_true(hl_merl_angles_of(up, s, t).phi_diff < PI);
}

/* Where the format says a cell is. */
static void test_centers(void **state)
{
  (void)state;
  const hl_merl_angles first = hl_merl_center(0, 0, 0), last = hl_merl_center(89, 89, 179);
  assert_near(first.theta_half, PI / 2 * 0.25 / 8100, 1e-15);
  assert_near(first.theta_diff, 0.5 * PI / 180, 1e-15);
  assert_near(first.phi_diff, 0.5 * PI / 180, 1e-15);
  assert_near(last.theta_half, PI / 2 * (89.5 / 90) * (89.5 / 90), 1e-14);
  assert_near(last.theta_diff, 89.5 * PI / 180, 1e-14);
  assert_near(last.phi_diff, 179.5 * PI / 180, 1e-14);
  assert_int_equal(hl_merl_cell(0, 0, 1), 1);
  assert_int_equal(hl_merl_cell(0, 1, 0), 180);
  assert_int_equal(hl_merl_cell(1, 0, 0), 16200);
}

/* ---- between the cells */

static void test_constant_comes_back(void **state)
{
  (void)state;
  hl_merl merl = table_of(brdf_lambert);
  test_random r = {11};
  for (int k = 0; k < 5000; k++) {
    double n[3], s[3], v[3], got[3];
    /* down to the horizon itself, where most of the cells about are below it */
    random_scene(&r, 1e-4, n, s, v);
    if (!hl_merl_eval(&merl, n, s, v, HL_MERL_SMOOTH, got))
      continue;
    assert_near(got[0], 0.3, 1e-14);
    assert_near(got[1], 0.2, 1e-14);
    assert_near(got[2], 0.1, 1e-14);
  }
  hl_merl_free(&merl);
}

static void test_centers_come_back(void **state)
{
  (void)state;
  hl_merl merl = table_of(brdf_twisted);
  for (int i = 0; i < 90; i += 7)
    for (int j = 0; j < 90; j += 11)
      for (int k = 0; k < 180; k += 13) {
        double s[3], v[3], smooth[3], nearest[3], want[3];
        const hl_merl_angles a = hl_merl_center(i, j, k);
        hl_merl_directions(a, s, v);
        if (s[2] <= 0 || v[2] <= 0)
          continue;
        brdf_twisted(up, s, v, want);
        assert_true(hl_merl_at(&merl, a, HL_MERL_SMOOTH, smooth));
        assert_true(hl_merl_at(&merl, a, HL_MERL_NEAREST, nearest));
        for (int c = 0; c < 3; c++) {
          assert_near(smooth[c], want[c], 1e-12);
          assert_near(nearest[c], want[c], 1e-14);
        }
      }
  hl_merl_free(&merl);
}

/* Reciprocal, and the same however the scene is turned, to rounding. */
static void test_invariances(void **state)
{
  (void)state;
  hl_merl merl = table_of(brdf_twisted);
  test_random r = {5};
  for (int k = 0; k < 2000; k++) {
    double n[3], s[3], v[3], axis[3], got[3], back[3], turned[3], m[3], t[3], w[3];
    random_scene(&r, 0.2, n, s, v);
    random_direction(&r, axis);
    const double angle = random_between(&r, 0, 6);
    turn(n, axis, angle, m);
    turn(s, axis, angle, t);
    turn(v, axis, angle, w);
    assert_true(hl_merl_eval(&merl, n, s, v, HL_MERL_SMOOTH, got));
    assert_true(hl_merl_eval(&merl, n, v, s, HL_MERL_SMOOTH, back));
    assert_true(hl_merl_eval(&merl, m, t, w, HL_MERL_SMOOTH, turned));
    for (int c = 0; c < 3; c++) {
      assert_near(back[c], got[c], 1e-9);
      assert_near(turned[c], got[c], 1e-9);
    }
  }
  hl_merl_free(&merl);
}

/* Mean and largest error of radiance, of its mean, over random scenes. */
static void errors(test_brdf brdf, hl_merl_lookup lookup, double least, double *mean, double *most)
{
  hl_merl merl = table_of(brdf);
  test_random r = {23};
  double sum = 0, difference = 0;
  *most = 0;
  for (int k = 0; k < 20000; k++) {
    double n[3], s[3], v[3], got[3], want[3];
    random_scene(&r, least, n, s, v);
    brdf(n, s, v, want);
    assert_true(hl_merl_eval(&merl, n, s, v, lookup, got));
    for (int c = 0; c < 3; c++) {
      const double d = fabs(got[c] - want[c]) * hl_dot(n, s);
      sum += want[c] * hl_dot(n, s);
      difference += d;
      *most = fmax(*most, d);
    }
  }
  *mean = difference / sum;
  *most /= sum / 60000;
  hl_merl_free(&merl);
}

/* The signs of all three angles, and how near a smooth BRDF comes back: ours, rounded up. */
static void test_a_twisted_brdf(void **state)
{
  (void)state;
  double mean, most;
  errors(brdf_twisted, HL_MERL_SMOOTH, 0.05, &mean, &most);
  assert_true(mean < 2e-4);
  assert_true(most < 0.01);
  errors(brdf_twisted, HL_MERL_NEAREST, 0.05, &mean, &most);
  assert_true(mean > 1e-3 && mean < 1e-2);
}

/* A lobe that grows as 1/((n.s)(n.v)): the weighting is for it. Ours, rounded up. */
static void test_a_lobe_at_grazing_angles(void **state)
{
  (void)state;
  double smooth, nearest, most;
  errors(brdf_ggx, HL_MERL_SMOOTH, 0.05, &smooth, &most);
  assert_true(smooth < 7e-4);
  assert_true(most < 0.25);
  errors(brdf_ggx, HL_MERL_NEAREST, 0.05, &nearest, &most);
  assert_true(nearest > 20 * smooth);
}

static void test_below_the_horizon(void **state)
{
  (void)state;
  hl_merl merl = table_of(brdf_lambert);
  const double s[3] = {0.8, 0, -0.6};
  double got[3] = {7, 7, 7};
  assert_true(hl_merl_eval(&merl, up, s, up, HL_MERL_SMOOTH, got));
  for (int c = 0; c < 3; c++)
    assert_near(got[c], 0, 0);
  assert_true(hl_merl_eval(&merl, up, up, s, HL_MERL_NEAREST, got));
  for (int c = 0; c < 3; c++)
    assert_near(got[c], 0, 0);
  hl_merl_free(&merl);
}

/* ---- cells that were not measured */

static void test_unmeasured_cells(void **state)
{
  (void)state;
  hl_merl merl = table_of(brdf_lambert);
  const hl_merl_angles a = hl_merl_center(40, 30, 60);
  hl_merl_angles near = a;
  double got[3];
  assert_near(hl_merl_measured(&merl), 1, 0);
  /* one channel is enough to spoil a cell */
  merl.value[HL_MERL_CELLS + hl_merl_cell(40, 30, 60)] = -0.5;
  assert_true(hl_merl_measured(&merl) < 1);
  assert_true(hl_merl_measured(&merl) > 1 - 2e-6);
  for (int lookup = HL_MERL_SMOOTH; lookup <= HL_MERL_NEAREST; lookup++) {
    assert_false(hl_merl_at(&merl, a, (hl_merl_lookup)lookup, got));
    for (int c = 0; c < 3; c++)
      assert_true(isnan(got[c]));
  }
  /* half a cell on, the neighbours have half of the weight, and enough */
  near.phi_diff += 0.51 * PI / 180;
  assert_true(hl_merl_at(&merl, near, HL_MERL_SMOOTH, got));
  assert_near(got[1], 0.2, 1e-14);
  near.phi_diff -= 0.02 * PI / 180;
  assert_false(hl_merl_at(&merl, near, HL_MERL_SMOOTH, got));
  hl_merl_free(&merl);
}

static void test_a_new_table_says_nothing(void **state)
{
  (void)state;
  hl_merl merl = {0};
  double got[3];
  assert_int_equal(hl_merl_new(NULL, &merl), HL_OK);
  assert_near(hl_merl_measured(&merl), 0, 0);
  assert_false(hl_merl_eval(&merl, up, up, up, HL_MERL_SMOOTH, got));
  assert_false(hl_merl_eval(&merl, up, up, up, HL_MERL_NEAREST, got));
  hl_merl_free(&merl);
  assert_null(merl.value);
  hl_merl_free(NULL);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_nearest_is_the_published_reader),
      cmocka_unit_test(test_angles_of_directions),
      cmocka_unit_test(test_angles_at_their_ends),
      cmocka_unit_test(test_centers),
      cmocka_unit_test(test_constant_comes_back),
      cmocka_unit_test(test_centers_come_back),
      cmocka_unit_test(test_invariances),
      cmocka_unit_test(test_a_twisted_brdf),
      cmocka_unit_test(test_a_lobe_at_grazing_angles),
      cmocka_unit_test(test_below_the_horizon),
      cmocka_unit_test(test_unmeasured_cells),
      cmocka_unit_test(test_a_new_table_says_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
