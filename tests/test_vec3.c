/* Vectors of three. */
#include "halflight/vec3.h"
#include "near.h"

static void random_vector(test_random *r, double v[3])
{
  for (int i = 0; i < 3; i++)
    v[i] = random_normal(r);
}

static void test_by_hand(void **state)
{
  (void)state;
  const double a[3] = {1, 2, 3}, b[3] = {4, -5, 6};
  double c[3];
  assert_near(hl_dot(a, b), 12, 0);
  assert_near(hl_norm((const double[3]){3, 4, 12}), 13, 0);
  hl_cross(a, b, c);
  assert_near(c[0], 27, 0);
  assert_near(c[1], 6, 0);
  assert_near(c[2], -13, 0);
  hl_add_scaled(a, 2, b, c);
  assert_near(c[0], 9, 0);
  assert_near(c[1], -8, 0);
  assert_near(c[2], 15, 0);
}

static void test_outputs_may_alias_inputs(void **state)
{
  (void)state;
  double a[3] = {1, 2, 3};
  const double b[3] = {4, -5, 6};
  hl_cross(a, b, a);
  assert_near(a[0], 27, 0);
  assert_near(a[1], 6, 0);
  assert_near(a[2], -13, 0);
  hl_unit(a, a);
  assert_near(hl_norm(a), 1, 1e-15);
}

static void test_unit_of_nothing_is_nothing(void **state)
{
  (void)state;
  double out[3];
  hl_unit((const double[3]){0, 0, 0}, out);
  assert_near(hl_norm(out), 0, 0);
}

/* Accurate where acos is not: 1e-9 rad from 0 and from pi. */
static void test_angle_near_its_ends(void **state)
{
  (void)state;
  const double x[3] = {1, 0, 0}, near_x[3] = {1, 1e-9, 0}, minus[3] = {-1, 1e-9, 0};
  const double pi = 3.14159265358979323846;
  assert_near(hl_angle(x, near_x), 1e-9, 1e-24);
  assert_near(hl_angle(x, minus), pi - 1e-9, 1e-15);
  assert_near(hl_angle(x, (const double[3]){0, 0, 5}), pi / 2, 1e-15);
}

static void test_tangent_basis_is_right_handed(void **state)
{
  (void)state;
  test_random r = {17};
  for (int i = 0; i < 1000; i++) {
    double s[3], u[3], w[3], c[3];
    random_vector(&r, s);
    if (i < 3)
      s[0] = s[1] = s[2] = 0, s[i] = 1;
    hl_unit(s, s);
    hl_tangent_basis(s, u, w);
    hl_cross(u, w, c);
    assert_near(hl_norm(u), 1, 1e-15);
    assert_near(hl_norm(w), 1, 1e-15);
    assert_near(hl_dot(u, w), 0, 1e-15);
    assert_near(hl_dot(u, s), 0, 1e-15);
    for (int k = 0; k < 3; k++)
      assert_near(c[k], s[k], 1e-15);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_by_hand),
      cmocka_unit_test(test_outputs_may_alias_inputs),
      cmocka_unit_test(test_unit_of_nothing_is_nothing),
      cmocka_unit_test(test_angle_near_its_ends),
      cmocka_unit_test(test_tangent_basis_is_right_handed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
