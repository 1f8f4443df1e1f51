/* A light's position from sights: truth is a point that they all look at. */
#include "files.h"
#include "halflight/position.h"
#include "term_scene.h"

enum { DRAWS = 400, SIGHTS = 4 };

static const double truth[3] = {0.3, -0.4, 0.2};

/* Balls in front of a camera, a few decimetres apart. */
static const double places[SIGHTS][3] = {
    {-0.2, 0, 0.6}, {0.25, 0.05, 0.7}, {0, 0.2, 0.5}, {0.1, -0.15, 0.9}};

/* Looking at `at`, its direction known to `sigma`, more along one tangent than the other. */
static hl_sight sight_of(const double from[3], const double at[3], double sigma)
{
  hl_sight g = {.own_rad2 = {{sigma * sigma, 0}, {0, 4 * sigma * sigma}}};
  memcpy(g.origin_m, from, sizeof g.origin_m);
  hl_add_scaled(at, -1, from, g.direction);
  hl_unit(g.direction, g.direction);
  hl_tangent_basis(g.direction, g.tangent_basis[0], g.tangent_basis[1]);
  return g;
}

static void four(hl_sight out[SIGHTS], const double at[3], double sigma)
{
  for (int i = 0; i < SIGHTS; i++)
    out[i] = sight_of(places[i], at, sigma);
}

/* Turn a direction by these angles along its tangents; the basis stays one of the new direction. */
static void turn(hl_sight *g, double a, double b)
{
  const double angle = hypot(a, b);
  double axis[3], across[3];
  for (int k = 0; k < 3; k++)
    across[k] = angle > 0 ? (a * g->tangent_basis[0][k] + b * g->tangent_basis[1][k]) / angle : 0;
  for (int k = 0; k < 3; k++)
    axis[k] = cos(angle) * g->direction[k] + sin(angle) * across[k];
  memcpy(g->direction, axis, sizeof axis);
  for (int t = 0; t < 2; t++) {
    hl_add_scaled(g->tangent_basis[t], -hl_dot(g->tangent_basis[t], axis), axis,
                  g->tangent_basis[t]);
    if (t == 1)
      hl_add_scaled(g->tangent_basis[1], -hl_dot(g->tangent_basis[1], g->tangent_basis[0]),
                    g->tangent_basis[0], g->tangent_basis[1]);
    hl_unit(g->tangent_basis[t], g->tangent_basis[t]);
  }
}

static hl_position position_of(const hl_sight *sights, int n)
{
  hl_ctx ctx = {0};
  hl_position out;
  if (hl_position_of_sights(&ctx, sights, n, &out) != HL_OK) {
    print_error("%s\n", ctx.msg);
    fail();
  }
  return out;
}

static void test_exact_sights_meet_exactly(void **state)
{
  (void)state;
  hl_sight sights[SIGHTS];
  four(sights, truth, 1e-4);
  for (int n = 2; n <= SIGHTS; n++) {
    const hl_position p = position_of(sights, n);
    assert_true(p.trusted && p.found);
    assert_int_equal(p.dof, 2 * n - 3);
    for (int k = 0; k < 3; k++)
      assert_near(p.position_m[k], truth[k], 1e-9);
    assert_near(p.chi_squared, 0, 1e-9);
    assert_true(p.distance_95_m[0] < p.distance_m && p.distance_m < p.distance_95_m[1]);
    assert_true(p.least_distance_m > p.distance_95_m[0] && p.least_distance_m < p.distance_m);
  }
}

static void test_a_doubted_sight_places_nothing_to_trust(void **state)
{
  (void)state;
  hl_sight sights[SIGHTS];
  four(sights, truth, 1e-4);
  sights[2].doubted = true;
  const hl_position p = position_of(sights, SIGHTS);
  assert_true(p.found && !p.trusted);
  assert_int_equal(p.reasons.n, 1);
  assert_says(p.reasons.note[0].why, "number 3");
  turn(&sights[2], 0.1, 0.1); /* left out, it harms nobody */
  const hl_position q = position_of(sights, SIGHTS);
  assert_false(q.sight[2].used);
  assert_true(q.found && q.trusted);
}

/* Two sights that pass each other, equally well known: the light is nearest to both, midway. */
static void test_skew_sights_meet_midway(void **state)
{
  (void)state;
  const double one[3] = {-1, 0, 0}, two[3] = {1, 0, 0};
  const double above[3] = {0, 0.001, 1}, below[3] = {0, -0.001, 1};
  hl_sight sights[2] = {sight_of(one, above, 0.01), sight_of(two, below, 0.01)};
  for (int i = 0; i < 2; i++)
    sights[i].own_rad2[1][1] = sights[i].own_rad2[0][0];
  const hl_position p = position_of(sights, 2);
  assert_near(p.position_m[0], 0, 1e-6);
  assert_near(p.position_m[1], 0, 1e-6);
  assert_near(p.position_m[2], 1, 1e-5);
  /* each is off by 0.001 over its length, sqrt 2 */
  assert_near(p.sight[0].off_rad, 0.001 / sqrt(2), 1e-7);
  assert_near(p.chi_squared, 2 * pow(0.001 / sqrt(2) / 0.01, 2), 1e-5);
}

/* Turned, moved and scaled, the answer is too. */
static void test_follows_its_frame(void **state)
{
  (void)state;
  static const double r[3][3] = {{0.36, 0.48, -0.8}, {-0.8, 0.6, 0}, {0.48, 0.64, 0.6}};
  static const double shift[3] = {3, -2, 5};
  const double scale = 40;
  hl_sight a[SIGHTS], b[SIGHTS];
  four(a, truth, 2e-3);
  turn(&a[1], 0.001, 0.002);
  turn(&a[2], -0.002, 0.001);
  for (int i = 0; i < SIGHTS; i++) {
    for (int k = 0; k < 3; k++)
      a[i].origin_covariance_m2[k][k] = 1e-7 * (k + 1);
    b[i] = a[i];
    for (int k = 0; k < 3; k++) {
      b[i].origin_m[k] = shift[k] + scale * hl_dot(r[k], a[i].origin_m);
      b[i].direction[k] = hl_dot(r[k], a[i].direction);
      for (int t = 0; t < 2; t++)
        b[i].tangent_basis[t][k] = hl_dot(r[k], a[i].tangent_basis[t]);
      for (int l = 0; l < 3; l++) {
        b[i].origin_covariance_m2[k][l] = 0;
        for (int m = 0; m < 3; m++)
          b[i].origin_covariance_m2[k][l] +=
              scale * scale * r[k][m] * a[i].origin_covariance_m2[m][m] * r[l][m];
      }
    }
  }
  const hl_position p = position_of(a, SIGHTS), q = position_of(b, SIGHTS);
  for (int k = 0; k < 3; k++)
    assert_near(q.position_m[k], shift[k] + scale * hl_dot(r[k], p.position_m), 1e-6);
  assert_near(q.chi_squared, p.chi_squared, 1e-6);
  assert_near(q.distance_95_m[1], scale * p.distance_95_m[1], 1e-6);
  for (int k = 0; k < 3; k++) {
    double sum = 0;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        sum += scale * scale * r[k][i] * p.covariance_m2[i][j] * r[k][j];
    assert_near(q.covariance_m2[k][k], sum, 1e-6 * sum);
  }
}

/* v' C^-1 v of a 3 x 3 covariance. */
static double mahalanobis(const double c[3][3], const double v[3])
{
  double rows[3][3], x[3];
  hl_cross(c[1], c[2], rows[0]);
  hl_cross(c[2], c[0], rows[1]);
  hl_cross(c[0], c[1], rows[2]);
  const double determinant = hl_dot(c[0], rows[0]);
  for (int i = 0; i < 3; i++)
    x[i] = (rows[0][i] * v[0] + rows[1][i] * v[1] + rows[2][i] * v[2]) / determinant;
  return hl_dot(v, x);
}

/* Directions and origins drawn from what is stated, also where the one follows the other: 95 % of the
 * positions lie in the stated ellipsoid (7.815 on 3 degrees), of the distances in their interval, and
 * chi-squared averages its degrees of freedom. */
static void covers(bool follows, double sigma, double origin_sigma)
{
  test_random random = {91};
  hl_sight exact[SIGHTS];
  four(exact, truth, sigma);
  int inside = 0, between = 0;
  double chi = 0;
  for (int i = 0; i < SIGHTS; i++)
    for (int k = 0; k < 3; k++) {
      exact[i].origin_covariance_m2[k][k] = origin_sigma * origin_sigma * (k == 2 ? 9 : 1);
      for (int t = 0; t < 2; t++)
        exact[i].by_origin[t][k] = follows ? 6 * exact[i].tangent_basis[t][k] : 0;
    }
  for (int draw = 0; draw < DRAWS; draw++) {
    hl_sight drawn[SIGHTS];
    memcpy(drawn, exact, sizeof drawn);
    for (int i = 0; i < SIGHTS; i++) {
      double e[3], angle[2];
      for (int k = 0; k < 3; k++) {
        e[k] = sqrt(exact[i].origin_covariance_m2[k][k]) * random_normal(&random);
        drawn[i].origin_m[k] += e[k];
      }
      for (int t = 0; t < 2; t++)
        angle[t] = sigma * (t + 1) * random_normal(&random) + hl_dot(exact[i].by_origin[t], e);
      turn(&drawn[i], angle[0], angle[1]);
    }
    const hl_position p = position_of(drawn, SIGHTS);
    double off[3], from[3];
    hl_add_scaled(p.position_m, -1, truth, off);
    hl_add_scaled(truth, -1, p.from_m, from);
    inside += mahalanobis(p.covariance_m2, off) < 7.815;
    between += hl_norm(from) > p.distance_95_m[0] && hl_norm(from) < p.distance_95_m[1];
    chi += p.chi_squared / DRAWS;
  }
  assert_true(inside > 0.92 * DRAWS && inside < 0.98 * DRAWS);
  assert_true(between > 0.92 * DRAWS && between < 0.98 * DRAWS);
  assert_near(chi, 2 * SIGHTS - 3, 0.6);
}

static void test_scatters_as_stated(void **state)
{
  (void)state;
  covers(false, 0.004, 0);
  covers(false, 0.001, 0.002);
  covers(true, 0.001, 0.002);
}

static void test_parallel_sights_say_how_far_at_least(void **state)
{
  (void)state;
  test_random random = {7};
  const double far[3] = {300, -400, -200};
  int above = 0;
  for (int draw = 0; draw < DRAWS; draw++) {
    hl_sight sights[SIGHTS];
    hl_position p;
    hl_ctx ctx = {0};
    four(sights, far, 0.002);
    for (int i = 0; i < SIGHTS; i++)
      turn(&sights[i], 0.002 * random_normal(&random), 0.004 * random_normal(&random));
    const hl_status st = hl_position_of_sights(&ctx, sights, SIGHTS, &p);
    above += p.least_distance_m < 538;
    if (st != HL_OK) {
      assert_int_equal(st, HL_ERR_DEGENERATE);
      assert_false(p.found || p.trusted);
      assert_true(p.least_distance_m > 10); /* a few decimetres over a few milliradians */
      assert_true(hl_angle(p.direction, far) < 0.02);
      assert_true(p.reasons.n > 0);
      if (isfinite(p.least_distance_m))
        assert_says(ctx.msg, "parallel within their ellipses: the light is at least");
      else
        assert_says(ctx.msg, "the sights part");
    }
  }
  /* 95 % by design, and the truth is not at infinity */
  assert_true(above > 0.92 * DRAWS);
}

static void test_sights_that_part(void **state)
{
  (void)state;
  const double one[3] = {-0.2, 0, 0.6}, two[3] = {0.2, 0, 0.6};
  const double left[3] = {-1.2, 0, -1}, right[3] = {1.2, 0, -1};
  const hl_sight sights[2] = {sight_of(one, left, 0.001), sight_of(two, right, 0.001)};
  hl_ctx ctx = {0};
  hl_position p;
  assert_int_equal(hl_position_of_sights(&ctx, sights, 2, &p), HL_ERR_DEGENERATE);
  assert_says(ctx.msg, "part, as if the light were behind the balls");
  assert_false(p.found);
}

static void test_one_sight_that_lies_is_named(void **state)
{
  (void)state;
  for (int bad = 0; bad < SIGHTS; bad++) {
    hl_sight sights[SIGHTS];
    four(sights, truth, 0.001);
    turn(&sights[bad], 0.05, -0.05);
    const hl_position p = position_of(sights, SIGHTS);
    assert_true(p.trusted);
    assert_int_equal(p.n_used, SIGHTS - 1);
    for (int i = 0; i < SIGHTS; i++)
      assert_int_equal(p.sight[i].used, i != bad);
    assert_near(p.sight[bad].off_rad, 0.05 * sqrt(2), 1e-4);
    assert_true(p.left_out.n == 1);
    for (int k = 0; k < 3; k++)
      assert_near(p.position_m[k], truth[k], 1e-6);
  }
}

/* Of two nobody can tell which. */
static void test_two_that_contradict_are_not_trusted(void **state)
{
  (void)state;
  hl_sight sights[2] = {sight_of(places[0], truth, 0.001), sight_of(places[1], truth, 0.001)};
  double across[3], d[3];
  hl_add_scaled(places[1], -1, places[0], d);
  hl_cross(d, sights[0].direction, across);
  hl_unit(across, across);
  turn(&sights[0], 0.05 * hl_dot(across, sights[0].tangent_basis[0]),
       0.05 * hl_dot(across, sights[0].tangent_basis[1]));
  const hl_position p = position_of(sights, 2);
  assert_false(p.trusted);
  assert_int_equal(p.n_used, 2);
  assert_true(p.probability < 0.01);
  assert_string_equal(p.reasons.note[0].what, "sights contradict each other");
}

static void refused(const hl_sight *sights, int n, hl_status due, const char *part)
{
  hl_ctx ctx = {0};
  static hl_position p;
  assert_int_equal(hl_position_of_sights(&ctx, sights, n, &p), due);
  assert_says(ctx.msg, part);
}

static void test_refusals(void **state)
{
  (void)state;
  hl_sight good[SIGHTS], bad[SIGHTS];
  four(good, truth, 0.001);
  refused(good, 1, HL_ERR_ARG, "1 sights; 2 to");
  memcpy(bad, good, sizeof bad);
  bad[1].direction[0] *= 2;
  refused(bad, SIGHTS, HL_ERR_ARG, "sight 2: direction has length");
  memcpy(bad, good, sizeof bad);
  memcpy(bad[2].tangent_basis[1], bad[2].tangent_basis[0], sizeof bad[2].tangent_basis[0]);
  refused(bad, SIGHTS, HL_ERR_ARG, "sight 3: tangent_basis");
  memcpy(bad, good, sizeof bad);
  bad[0].own_rad2[0][1] = bad[0].own_rad2[1][0] = 1;
  refused(bad, SIGHTS, HL_ERR_ARG, "sight 1: own_rad2");
  memcpy(bad, good, sizeof bad);
  bad[3].origin_covariance_m2[2][2] = NAN;
  refused(bad, SIGHTS, HL_ERR_ARG, "sight 4: own_rad2 or origin_covariance_m2");
  memcpy(bad, good, sizeof bad);
  bad[3].origin_m[2] = HUGE_VAL;
  refused(bad, SIGHTS, HL_ERR_ARG, "sight 4: origin_m");
  for (int i = 0; i < SIGHTS; i++) {
    bad[i] = good[i];
    memcpy(bad[i].origin_m, good[0].origin_m, sizeof bad[i].origin_m);
  }
  refused(bad, SIGHTS, HL_ERR_DEGENERATE, "start at one point");
}

/* ---- drawn balls */

/* The light at `radii` ball radii from the first of two balls 5 radii apart; what a frame shows. */
static hl_sight drawn_sight(term_shader shader, int ball, double radii, unsigned without,
                            double light_m[3])
{
  term_scene t = term_ball(shader);
  double *c = t.base.ball.center_m;
  const double r = t.base.ball.radius_m;
  hl_add_scaled(c, radii * r, t.base.light, light_m);
  if (ball == 1) {
    double to[3];
    c[0] -= 4 * r; /* in a wider frame of the same camera */
    c[1] += 3 * r;
    t.base.camera.cx += 4 * r / c[2] * t.base.camera.fx;
    t.base.camera.cy -= 3 * r / c[2] * t.base.camera.fy;
    hl_add_scaled(light_m, -1, c, to);
    t.distance_radii = hl_norm(to) / r;
    hl_unit(to, t.base.light);
  } else {
    t.distance_radii = radii;
  }
  hl_light_settings settings = hl_light_defaults();
  settings.without = without;
  const hl_light light = term_estimate(&t, &settings, 13);
  hl_sight out;
  hl_ctx ctx = {0};
  assert_int_equal(hl_sight_of_light(&ctx, &light, &t.base.ball, &out), HL_OK);
  return out;
}

/* Both balls tell by themselves that the light is near: their directions are from their centres. */
static void test_two_balls_place_a_light_at_ten_radii(void **state)
{
  (void)state;
  double light[3], other[3], off[3];
  const hl_sight sights[2] = {drawn_sight(TERM_GGX, 0, 10, 0, light),
                              drawn_sight(TERM_GGX, 1, 10, 0, other)};
  const hl_position p = position_of(sights, 2);
  hl_add_scaled(p.position_m, -1, light, off);
  assert_true(p.found && p.trusted);
  assert_true(hl_norm(off) < 0.05 * 10 * 0.03);
  assert_true(mahalanobis(p.covariance_m2, off) < 16);
}

/* Taken as distant, a sight through the highlight holds the light within what it states. */
static void test_a_distant_answer_is_doubted(void **state)
{
  (void)state;
  static const double radii[] = {5, 10, 20, 50};
  for (int shader = 0; shader < 2; shader++)
    for (int i = 0; i < 4; i++) {
      double light[3], to[3];
      const hl_sight g = drawn_sight((term_shader)shader, 0, radii[i], 1U << HL_LIGHT_NEAR, light);
      hl_add_scaled(light, -1, g.origin_m, to);
      const double off_m = hl_angle(g.direction, to) * hl_norm(to);
      assert_true(off_m < 2.45 * 0.5 * 0.03); /* of two normal deviates, 95 % */
      assert_true(g.origin_covariance_m2[0][0] >= pow(0.5 * 0.03, 2));
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_exact_sights_meet_exactly),
      cmocka_unit_test(test_a_doubted_sight_places_nothing_to_trust),
      cmocka_unit_test(test_skew_sights_meet_midway),
      cmocka_unit_test(test_follows_its_frame),
      cmocka_unit_test(test_scatters_as_stated),
      cmocka_unit_test(test_parallel_sights_say_how_far_at_least),
      cmocka_unit_test(test_sights_that_part),
      cmocka_unit_test(test_one_sight_that_lies_is_named),
      cmocka_unit_test(test_two_that_contradict_are_not_trusted),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_two_balls_place_a_light_at_ten_radii),
      cmocka_unit_test(test_a_distant_answer_is_doubted),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
