/* Shapes of rigs: exact, perturbed with one light off, without a light, and lights without order. */
#include <string.h>

#include "files.h"
#include "halflight/dome.h"
#include "halflight/vec3.h"

#define DEG 57.295779513082320877

enum { MOST = 80 };

typedef struct rig {
  double x[MOST][3];
  int n;
} rig;

/* Lights at an angle from an axis, evenly about it. */
static void add_ring(rig *rig_, const double axis[3], double half_angle_rad, int n, double phase)
{
  double e[2][3];
  hl_tangent_basis(axis, e[0], e[1]);
  for (int i = 0; i < n; i++) {
    double *x = rig_->x[rig_->n++];
    const double t = phase + 2 * 3.14159265358979323846 * i / n;
    for (int k = 0; k < 3; k++)
      x[k] = cos(half_angle_rad) * axis[k] +
             sin(half_angle_rad) * (cos(t) * e[0][k] + sin(t) * e[1][k]);
  }
}

static void shake(rig *rig_, double sigma_rad, test_random *r)
{
  for (int i = 0; i < rig_->n; i++) {
    for (int k = 0; k < 3; k++)
      rig_->x[i][k] += sigma_rad * random_normal(r);
    hl_unit(rig_->x[i], rig_->x[i]);
  }
}

/* A cols x rows grid of 0.2 m by 0.15 m, 1.1 m in front of the ball and oblique to the view. */
static rig grid_of(int cols, int rows, bool positions)
{
  rig g = {.n = 0};
  const double corner[3] = {-0.5, -0.35, -1.1}, u[3] = {0.2, 0, 0.02}, v[3] = {0.0, 0.15, 0.03};
  for (int i = 0; i < cols * rows; i++) {
    double *x = g.x[g.n++];
    hl_add_scaled(corner, i % cols, u, x);
    hl_add_scaled(x, i / cols, v, x);
    if (!positions)
      hl_unit(x, x);
  }
  return g;
}

static void take_out(rig *rig_, int at)
{
  rig_->n--;
  for (int i = at; i < rig_->n; i++)
    memcpy(rig_->x[i], rig_->x[i + 1], sizeof rig_->x[i]);
}

static hl_dome fit_to(const rig *r, bool positions, double sigma, double off[MOST],
                      bool is_off[MOST])
{
  hl_dome d;
  hl_ctx ctx = {0};
  if (hl_dome_fit_to(&ctx, r->x[0], r->n, positions, sigma, &d, off, is_off) != HL_OK)
    fail_msg("%s", ctx.msg);
  return d;
}

static const double tilted[3] = {0.36, -0.48, -0.8};

static void test_exact_ring(void **state)
{
  (void)state;
  rig r = {.n = 0};
  double off[MOST];
  bool is_off[MOST];
  add_ring(&r, tilted, 40 / DEG, 16, 0.1);
  const hl_dome d = fit_to(&r, false, 0, off, is_off);
  const hl_dome_fit *f = &d.fit[HL_DOME_RINGS];
  assert_int_equal(d.shape, HL_DOME_RINGS);
  assert_int_equal(f->n_rings, 1);
  assert_int_equal(f->n_on, 16);
  assert_true(hl_angle(f->axis, tilted) < 1e-7);
  assert_near(f->half_angle_rad[0], 40 / DEG, 1e-7);
  assert_true(f->rms < 1e-7);
  assert_false(d.fit[HL_DOME_SPHERE].fitted);
}

static void test_perturbed_ring_names_one(void **state)
{
  (void)state;
  rig r = {.n = 0};
  test_random random = {5};
  double off[MOST];
  bool is_off[MOST];
  add_ring(&r, tilted, 55 / DEG, 24, 0);
  shake(&r, 0.2 / DEG, &random);
  double out[3];
  hl_add_scaled(r.x[7], 4 / DEG, tilted, out); /* towards the axis */
  hl_unit(out, r.x[7]);
  const double truly = 55 / DEG - hl_angle(tilted, r.x[7]);
  const hl_dome d = fit_to(&r, false, 0, off, is_off);
  assert_int_equal(d.shape, HL_DOME_RINGS);
  assert_near(d.fit[HL_DOME_RINGS].rms, 0.2 / DEG, 0.08 / DEG);
  for (int i = 0; i < r.n; i++)
    assert_int_equal(is_off[i], i == 7);
  assert_near(off[7], truly, 0.2 / DEG);
}

static void test_rings_about_one_axis(void **state)
{
  (void)state;
  rig r = {.n = 0};
  test_random random = {6};
  double off[MOST];
  bool is_off[MOST];
  add_ring(&r, tilted, 70 / DEG, 9, 0);
  add_ring(&r, tilted, 45 / DEG, 9, 0.3);
  add_ring(&r, tilted, 20 / DEG, 6, 0.7);
  memcpy(r.x[r.n++], tilted, sizeof tilted);
  shake(&r, 0.4 / DEG, &random);
  const hl_dome d = fit_to(&r, false, 0, off, is_off);
  const hl_dome_fit *f = &d.fit[HL_DOME_RINGS];
  const double want[3] = {20, 45, 70};
  assert_int_equal(d.shape, HL_DOME_RINGS);
  assert_int_equal(f->n_rings, 3);
  assert_true(f->pole);
  assert_int_equal(f->n_off, 0);
  for (int k = 0; k < 3; k++)
    assert_near(DEG * f->half_angle_rad[k], want[k], 0.5);
  assert_true(DEG * hl_angle(f->axis, tilted) < 0.5);
}

static void test_grid_without_a_light(void **state)
{
  (void)state;
  test_random random = {7};
  double off[MOST];
  bool is_off[MOST];
  rig g = grid_of(6, 5, false);
  take_out(&g, 9);
  hl_dome d = fit_to(&g, false, 0, off, is_off);
  const hl_dome_fit *f = &d.fit[HL_DOME_GRID];
  assert_int_equal(d.shape, HL_DOME_GRID);
  assert_int_equal(f->n_on, 29);
  assert_int_equal(f->size[0] * f->size[1], 30);
  assert_true(f->rms < 1e-6);
  /* the ratio of the sides, which a direction knows */
  const double a = hl_norm(f->step[0]), b = hl_norm(f->step[1]);
  assert_near(fmax(a, b) / fmin(a, b), hl_norm((double[3]){0.2, 0, 0.02}) / hypot(0.15, 0.03),
              1e-5);
  shake(&g, 0.1 / DEG, &random);
  g.x[12][0] += 3 / DEG;
  hl_unit(g.x[12], g.x[12]);
  d = fit_to(&g, false, 0, off, is_off);
  assert_int_equal(d.shape, HL_DOME_GRID);
  assert_near(d.fit[HL_DOME_GRID].rms, 0.1 / DEG * sqrt(2), 0.05 / DEG);
  for (int i = 0; i < g.n; i++)
    assert_int_equal(is_off[i], i == 12);
  assert_true(DEG * off[12] > 2 && DEG * off[12] < 3.2);
}

static void test_positions(void **state)
{
  (void)state;
  test_random random = {8};
  double off[MOST];
  bool is_off[MOST];
  const double center[3] = {0.1, 0.05, 0.6};
  rig r = {.n = 0};
  for (int i = 0; i < 30; i++) { /* on a sphere of 0.8 m to 4 mm, one 60 mm out */
    for (int k = 0; k < 3; k++)
      r.x[i][k] = random_normal(&random);
    r.x[i][2] = -fabs(r.x[i][2]);
    hl_unit(r.x[i], r.x[i]);
    hl_add_scaled(center, (i == 3 ? 0.86 : 0.8) + 0.004 * random_normal(&random), r.x[i], r.x[i]);
    r.n++;
  }
  hl_dome d = fit_to(&r, true, 0.001, off, is_off);
  assert_int_equal(d.shape, HL_DOME_SPHERE);
  assert_near(d.fit[HL_DOME_SPHERE].radius_m, 0.8, 0.01);
  assert_near(d.fit[HL_DOME_SPHERE].rms, 0.004, 0.0015);
  for (int i = 0; i < r.n; i++)
    assert_int_equal(is_off[i], i == 3);
  assert_near(off[3], 0.06, 0.015);

  rig ring = {.n = 0};
  add_ring(&ring, tilted, 1.0, 12, 0);
  d = fit_to(&ring, true, 0, off, is_off);
  assert_int_equal(d.shape, HL_DOME_RINGS);
  assert_near(d.fit[HL_DOME_RINGS].radius_m, sin(1.0), 1e-6);
  assert_near(fabs(hl_dot(d.fit[HL_DOME_RINGS].axis, tilted)), 1, 1e-9);

  rig g = grid_of(5, 4, true);
  g.x[6][2] += 0.05;
  d = fit_to(&g, true, 0.001, off, is_off);
  assert_int_equal(d.shape, HL_DOME_GRID);
  for (int i = 0; i < g.n; i++)
    assert_int_equal(is_off[i], i == 6);
  assert_near(off[6], 0.05, 0.003);
}

/* A cell between two views of one lamp is so small that its lattice does not reach the others. */
static void test_each_lamp_three_times(void **state)
{
  (void)state;
  test_random random = {9};
  rig g = {.n = 0}, once = grid_of(5, 4, true);
  double off[MOST];
  bool is_off[MOST];
  for (int i = 0; i < once.n; i++) {
    for (int k = 0; k < 3; k++)
      once.x[i][k] += 1e-3 * random_normal(&random);
    for (int view = 0; view < 3; view++, g.n++)
      for (int k = 0; k < 3; k++)
        g.x[g.n][k] = once.x[i][k] + 1e-9 * random_normal(&random);
  }
  const hl_dome d = fit_to(&g, true, 1e-3, off, is_off);
  assert_int_equal(d.shape, HL_DOME_GRID);
  assert_int_equal(d.fit[HL_DOME_GRID].n_on, g.n);
  assert_int_equal(d.fit[HL_DOME_GRID].size[0] * d.fit[HL_DOME_GRID].size[1], once.n);
}

/* Lights over a hemisphere, in a cone, and gathered about a direction. */
static void test_no_order_no_claim(void **state)
{
  (void)state;
  double off[MOST];
  bool is_off[MOST];
  test_random random = {21};
  int claims = 0;
  enum { DRAWS = 30 };
  for (int draw = 0; draw < 3 * DRAWS; draw++) {
    rig r = {.n = 8 + draw % 25};
    for (int i = 0; i < r.n; i++) {
      double *x = r.x[i];
      for (int k = 0; k < 3; k++)
        x[k] = (draw % 3 == 2 ? 0.3 : 1) * random_normal(&random);
      if (draw % 3 == 1) { /* uniform in a cone of 50 degrees */
        const double z = 1 - (1 - cos(50 / DEG)) * random_uniform(&random), s = sqrt(1 - z * z);
        const double across = hypot(x[0], x[1]);
        x[0] *= s / across;
        x[1] *= s / across;
        x[2] = -z;
      } else {
        x[2] = draw % 3 == 2 ? x[2] - 1 : -fabs(x[2]);
      }
      hl_unit(x, x);
    }
    const hl_dome d = fit_to(&r, false, 0, off, is_off);
    claims += d.shape != HL_DOME_NONE;
    for (int i = 0; i < r.n && d.shape == HL_DOME_NONE; i++)
      assert_true(off[i] == 0 && !is_off[i]);
  }
  assert_in_range(claims, 0, 1);
}

static void test_rotated_and_reordered(void **state)
{
  (void)state;
  test_random random = {9};
  double off[2][MOST], q[3][3], e[2][3];
  bool is_off[2][MOST];
  rig r = {.n = 0}, s;
  add_ring(&r, tilted, 60 / DEG, 12, 0);
  add_ring(&r, tilted, 30 / DEG, 8, 0.2);
  shake(&r, 0.3 / DEG, &random);
  r.x[5][1] += 0.1;
  hl_unit(r.x[5], r.x[5]);
  hl_unit((double[3]){0.3, 0.5, 0.7}, q[2]);
  hl_tangent_basis(q[2], q[0], q[1]);
  s = r;
  for (int i = 0; i < r.n; i++)
    for (int k = 0; k < 3; k++)
      s.x[(7 * i) % r.n][k] = hl_dot(q[k], r.x[i]);
  const hl_dome a = fit_to(&r, false, 0, off[0], is_off[0]);
  const hl_dome b = fit_to(&s, false, 0, off[1], is_off[1]);
  const hl_dome_fit *f = &a.fit[HL_DOME_RINGS], *g = &b.fit[HL_DOME_RINGS];
  assert_int_equal(a.shape, HL_DOME_RINGS);
  assert_int_equal(b.shape, HL_DOME_RINGS);
  assert_int_equal(f->n_rings, 2);
  assert_near(g->rms, f->rms, 1e-9);
  assert_near(g->evidence, f->evidence, 1e-6);
  for (int k = 0; k < 3; k++)
    e[0][k] = hl_dot(q[k], f->axis);
  assert_true(hl_angle(e[0], g->axis) < 1e-8);
  for (int i = 0; i < r.n; i++) {
    assert_near(off[1][(7 * i) % r.n], off[0][i], 1e-8);
    assert_int_equal(is_off[1][(7 * i) % r.n], is_off[0][i]);
  }
}

static void test_refused_and_few(void **state)
{
  (void)state;
  double off[MOST] = {-1};
  bool is_off[MOST];
  hl_dome d = {.n = -7};
  hl_ctx ctx = {0};
  rig r = {.n = 0};
  add_ring(&r, tilted, 1, 12, 0);
  assert_int_equal(hl_dome_fit_to(&ctx, r.x[0], r.n, false, NAN, &d, off, is_off), HL_ERR_ARG);
  assert_says(ctx.msg, "sigma = nan");
  assert_int_equal(hl_dome_fit_to(&ctx, r.x[0], -1, false, 0, &d, off, is_off), HL_ERR_ARG);
  assert_says(ctx.msg, "n = -1");
  r.x[3][0] *= 2;
  assert_int_equal(hl_dome_fit_to(&ctx, r.x[0], r.n, false, 0, &d, off, is_off), HL_ERR_ARG);
  assert_says(ctx.msg, "x[3] has length");
  r.x[3][0] = NAN;
  assert_int_equal(hl_dome_fit_to(&ctx, r.x[0], r.n, true, 0, &d, off, is_off), HL_ERR_ARG);
  assert_says(ctx.msg, "x[3] is not finite");
  assert_int_equal(d.n, -7);
  assert_true(off[0] == -1);
  d = fit_to(&(rig){.n = 0}, false, 0, off, is_off);
  assert_int_equal(d.shape, HL_DOME_NONE);
  rig five = {.n = 0};
  add_ring(&five, tilted, 1, 5, 0);
  d = fit_to(&five, false, 0, off, is_off);
  assert_int_equal(d.shape, HL_DOME_NONE);
  rig one = {.n = 12}; /* all in one place */
  for (int i = 0; i < one.n; i++)
    memcpy(one.x[i], tilted, sizeof tilted);
  assert_int_equal(fit_to(&one, false, 0, off, is_off).shape, HL_DOME_NONE);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_exact_ring),
      cmocka_unit_test(test_perturbed_ring_names_one),
      cmocka_unit_test(test_rings_about_one_axis),
      cmocka_unit_test(test_grid_without_a_light),
      cmocka_unit_test(test_positions),
      cmocka_unit_test(test_each_lamp_three_times),
      cmocka_unit_test(test_no_order_no_claim),
      cmocka_unit_test(test_rotated_and_reordered),
      cmocka_unit_test(test_refused_and_few),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
