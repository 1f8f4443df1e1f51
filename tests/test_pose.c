/* Rigid motions: closed forms, derivatives, and the ways between vector and matrix. */
#include <string.h>

#include "halflight/pose.h"
#include "halflight/vec3.h"
#include "near.h"

static const double pi = 3.14159265358979323846;

/* A unit vector of no preferred direction. */
static void some_axis(test_random *r, double axis[3])
{
  for (int i = 0; i < 3; i++)
    axis[i] = random_normal(r);
  hl_unit(axis, axis);
}

static hl_pose turned_by(const double axis[3], double angle)
{
  hl_pose p = {{angle * axis[0], angle * axis[1], angle * axis[2]}, {0.3, -0.2, 1.1}};
  return p;
}

/* From nothing over the seam of series and closed form (0.1) to nearly half a turn. */
static const double angles[] = {0,    1e-12, 1e-8, 1e-4, 0.01,          0.099999999,    0.100000001,
                                0.15, 0.5,   1.3,  2.2,  3.14159265358, 3.1415926535897};

enum { N_ANGLES = sizeof angles / sizeof angles[0] };

static void near_matrix(const double a[3][3], const double b[3][3], double limit)
{
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      assert_near(a[i][j], b[i][j], limit);
}

static void near_pose(const hl_pose *a, const hl_pose *b, double limit)
{
  for (int i = 0; i < 3; i++) {
    assert_near(a->rotation_rad[i], b->rotation_rad[i], limit);
    assert_near(a->translation_m[i], b->translation_m[i], limit);
  }
}

/* Analytic: about z, x turns towards y. */
static void test_matrix_of_a_turn_about_an_axis(void **state)
{
  (void)state;
  for (int i = 0; i < N_ANGLES; i++) {
    const double c = cos(angles[i]), s = sin(angles[i]);
    const hl_pose p = {{0, 0, angles[i]}, {0}};
    double m[3][3];
    hl_pose_matrix(&p, m);
    near_matrix((const double(*)[3])m, (const double[3][3]){{c, -s, 0}, {s, c, 0}, {0, 0, 1}},
                4e-16);
  }
}

/* Numbers of OpenCV 4.6.0 (Debian python3-opencv), cv2.Rodrigues of (0.3, -0.7, 1.1). */
static void test_matrix_agrees_with_opencv(void **state)
{
  (void)state;
  static const double known[3][3] = {
      {0.26946350302809197, -0.89022585275603228, -0.36727013439786366},
      {0.70974036526885498, 0.44135444349207031, -0.54906727194200655},
      {0.65089018616342798, -0.1127128488443101, 0.75075813632723143}};
  const hl_pose p = {{0.3, -0.7, 1.1}, {0}};
  double m[3][3];
  hl_pose_matrix(&p, m);
  near_matrix((const double(*)[3])m, known, 1e-15);
}

static void test_matrix_is_a_rotation(void **state)
{
  (void)state;
  test_random r = {3};
  for (int i = 0; i < N_ANGLES; i++)
    for (int run = 0; run < 20; run++) {
      double axis[3], m[3][3], turned[3], cross[3];
      some_axis(&r, axis);
      const hl_pose p = turned_by(axis, angles[i]);
      hl_pose_matrix(&p, m);
      for (int a = 0; a < 3; a++) {
        turned[a] = hl_dot(m[a], axis);
        for (int b = 0; b < 3; b++)
          assert_near(hl_dot(m[a], m[b]), a == b, 4e-15);
      }
      hl_cross(m[0], m[1], cross);
      assert_near(hl_dot(cross, m[2]), 1, 4e-15);
      for (int a = 0; a < 3; a++)
        assert_near(turned[a], axis[a], 4e-15);
      assert_near(m[0][0] + m[1][1] + m[2][2], 1 + 2 * cos(angles[i]), 4e-15);
    }
}

/* Near half a turn the vector is as good as the matrix: 1e-16 over the sine of half the angle is
 * still 1e-16. The sign of an axis at exactly half a turn is free. */
static void test_vector_to_matrix_and_back(void **state)
{
  (void)state;
  test_random r = {4};
  for (int i = 0; i < N_ANGLES; i++)
    for (int run = 0; run < 50; run++) {
      double axis[3], m[3][3];
      some_axis(&r, axis);
      if (run < 3) /* turns about the frame's own axes */
        for (int k = 0; k < 3; k++)
          axis[k] = k == run;
      const hl_pose p = turned_by(axis, angles[i]);
      hl_pose back;
      hl_pose_matrix(&p, m);
      hl_pose_from_matrix((const double(*)[3])m, p.translation_m, &back);
      near_pose(&back, &p, 4e-15);
    }
}

static void test_half_a_turn(void **state)
{
  (void)state;
  test_random r = {5};
  for (int run = 0; run < 60; run++) {
    double axis[3], m[3][3], again[3][3];
    some_axis(&r, axis);
    if (run < 3)
      for (int k = 0; k < 3; k++)
        axis[k] = k == run;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        m[i][j] = 2 * axis[i] * axis[j] - (i == j);
    const double nowhere[3] = {0};
    hl_pose p;
    hl_pose_from_matrix((const double(*)[3])m, nowhere, &p);
    assert_near(hl_norm(p.rotation_rad), pi, 4e-15);
    hl_pose_matrix(&p, again);
    near_matrix((const double(*)[3])again, (const double(*)[3])m, 1e-14);
  }
}

/* More than half a turn one way is less than half a turn the other way. */
static void test_from_matrix_takes_the_short_way(void **state)
{
  (void)state;
  const double axis[3] = {0.6, 0, -0.8};
  const hl_pose far = turned_by(axis, 4), near = turned_by(axis, 4 - 2 * pi);
  double m[3][3];
  hl_pose back;
  hl_pose_matrix(&far, m);
  hl_pose_from_matrix((const double(*)[3])m, far.translation_m, &back);
  near_pose(&back, &near, 4e-15);
}

static void test_apply_is_the_matrix_and_the_translation(void **state)
{
  (void)state;
  test_random r = {6};
  for (int i = 0; i < N_ANGLES; i++) {
    double axis[3], m[3][3], out[3], by_point[3][3];
    some_axis(&r, axis);
    const hl_pose p = turned_by(axis, angles[i]);
    const double point[3] = {0.7, -1.3, 2.1};
    hl_pose_matrix(&p, m);
    hl_pose_apply(&p, point, out, NULL, by_point);
    near_matrix((const double(*)[3])by_point, (const double(*)[3])m, 0);
    for (int k = 0; k < 3; k++)
      assert_near(out[k], hl_dot(m[k], point) + p.translation_m[k], 1e-15);
    double in_place[3] = {0.7, -1.3, 2.1};
    hl_pose_apply(&p, in_place, in_place, NULL, NULL);
    for (int k = 0; k < 3; k++)
      assert_near(in_place[k], out[k], 0);
  }
}

static void step_pose(const hl_pose *p, int k, double step, const double point[3], double out[3])
{
  hl_pose moved = *p;
  double *at = k < 3 ? &moved.rotation_rad[k] : &moved.translation_m[k - 3];
  *at += step;
  hl_pose_apply(&moved, point, out, NULL, NULL);
}

/* Central differences at every angle, those about the seam and near half a turn too; their own error
 * is 2e-16 / 2e-5 and step^2 / 6 times a third derivative of about |point|. */
static void test_derivatives_against_differences(void **state)
{
  (void)state;
  const double step = 1e-5;
  test_random r = {7};
  for (int i = 0; i < N_ANGLES; i++)
    for (int run = 0; run < 20; run++) {
      double axis[3], out[3], a[3], b[3], by_pose[3][HL_POSE_SIZE];
      some_axis(&r, axis);
      const hl_pose p = turned_by(axis, angles[i]);
      const double point[3] = {random_normal(&r), random_normal(&r), random_normal(&r)};
      hl_pose_apply(&p, point, out, by_pose, NULL);
      for (int k = 0; k < HL_POSE_SIZE; k++) {
        step_pose(&p, k, -step, point, a);
        step_pose(&p, k, step, point, b);
        for (int m = 0; m < 3; m++)
          assert_near(by_pose[m][k], (b[m] - a[m]) / (2 * step), 2e-10);
      }
    }
}

/* Analytic: at no turn the derivative by the rotation is -[p]x. */
static void test_derivative_at_no_turn(void **state)
{
  (void)state;
  const hl_pose p = {{0}, {0}};
  double out[3], by_pose[3][HL_POSE_SIZE];
  hl_pose_apply(&p, (const double[3]){1, 2, 3}, out, by_pose, NULL);
  static const double want[3][HL_POSE_SIZE] = {
      {0, 3, -2, 1, 0, 0}, {-3, 0, 1, 0, 1, 0}, {2, -1, 0, 0, 0, 1}};
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < HL_POSE_SIZE; k++)
      assert_near(by_pose[i][k], want[i][k], 0);
}

/* A turn about the axis moves along the circle, whatever the angle: the derivative along w/|w| is
 * exactly axis x R p. The seam may not show there, nor across it. */
static void test_derivative_along_the_axis(void **state)
{
  (void)state;
  test_random r = {8};
  for (int step = 0; step < 120; step++) {
    const double angle = 1e-9 * pow(1.2, step); /* to 2.65 */
    double axis[3], out[3], turned[3], want[3], by_pose[3][HL_POSE_SIZE];
    some_axis(&r, axis);
    const hl_pose p = turned_by(axis, angle);
    const double point[3] = {0.4, 0.5, -0.9};
    hl_pose_apply(&p, point, out, by_pose, NULL);
    hl_add_scaled(out, -1, p.translation_m, turned);
    hl_cross(axis, turned, want);
    for (int i = 0; i < 3; i++)
      assert_near(hl_dot(by_pose[i], axis), want[i], 1e-15);
  }
}

static void test_compose_is_one_after_the_other(void **state)
{
  (void)state;
  test_random r = {9};
  for (int run = 0; run < 100; run++) {
    hl_pose a, b, both;
    for (int k = 0; k < 3; k++) {
      a.rotation_rad[k] = random_between(&r, -1.8, 1.8);
      b.rotation_rad[k] = random_between(&r, -1.8, 1.8);
      a.translation_m[k] = random_normal(&r);
      b.translation_m[k] = random_normal(&r);
    }
    const double point[3] = {random_normal(&r), random_normal(&r), random_normal(&r)};
    double once[3], twice[3], out[3];
    hl_pose_compose(&a, &b, &both);
    hl_pose_apply(&b, point, once, NULL, NULL);
    hl_pose_apply(&a, once, twice, NULL, NULL);
    hl_pose_apply(&both, point, out, NULL, NULL);
    for (int k = 0; k < 3; k++)
      assert_near(out[k], twice[k], 2e-14);
    assert_true(hl_norm(both.rotation_rad) <= pi + 1e-15);
    hl_pose first = a, second = b;
    hl_pose_compose(&first, &b, &first);
    hl_pose_compose(&a, &second, &second);
    near_pose(&first, &both, 0);
    near_pose(&second, &both, 0);
  }
}

static void test_inverse_undoes(void **state)
{
  (void)state;
  test_random r = {10};
  const hl_pose still = {{0}, {0}};
  for (int i = 0; i < N_ANGLES; i++)
    for (int run = 0; run < 10; run++) {
      double axis[3];
      some_axis(&r, axis);
      hl_pose p = turned_by(axis, angles[i]), back, both;
      hl_pose_inverse(&p, &back);
      hl_pose_compose(&p, &back, &both);
      near_pose(&both, &still, 2e-15);
      hl_pose_compose(&back, &p, &both);
      near_pose(&both, &still, 2e-15);
      hl_pose_inverse(&back, &back);
      near_pose(&back, &p, 2e-15);
    }
}

/* The pose moved after itself by x = (w, s), x as small as the step. */
static hl_pose moved_after(const hl_pose *p, int k, double step)
{
  hl_pose x = {{0}, {0}}, out;
  (k < 3 ? x.rotation_rad : x.translation_m)[k % 3] = step;
  hl_pose_compose(&x, p, &out);
  return out;
}

static void test_motion_undoes_a_change_of_the_numbers(void **state)
{
  (void)state;
  test_random r = {11};
  for (int run = 0; run < 30; run++) {
    double axis[3], by[HL_POSE_SIZE][HL_POSE_SIZE];
    some_axis(&r, axis);
    const hl_pose p = turned_by(axis, run < 3 ? 1e-9 : random_between(&r, 0.01, 2.5));
    hl_pose_motion(&p, by);
    for (int k = 0; k < HL_POSE_SIZE; k++) {
      /* how the numbers follow a motion is the inverse of how the motion follows the numbers */
      const double h = 1e-6;
      const hl_pose up = moved_after(&p, k, h), down = moved_after(&p, k, -h);
      double rate[HL_POSE_SIZE];
      for (int i = 0; i < 3; i++) {
        rate[i] = (up.rotation_rad[i] - down.rotation_rad[i]) / (2 * h);
        rate[3 + i] = (up.translation_m[i] - down.translation_m[i]) / (2 * h);
      }
      for (int i = 0; i < HL_POSE_SIZE; i++) {
        double sum = 0;
        for (int j = 0; j < HL_POSE_SIZE; j++)
          sum += by[i][j] * rate[j];
        assert_near(sum, i == k, 1e-8);
      }
    }
  }
}

/* pose exp(x) = exp(Ad x) pose */
static void test_adjoint_carries_a_motion_across(void **state)
{
  (void)state;
  test_random r = {12};
  for (int run = 0; run < 30; run++) {
    double axis[3], by[HL_POSE_SIZE][HL_POSE_SIZE];
    const double h = 1e-6;
    some_axis(&r, axis);
    const hl_pose p = turned_by(axis, random_between(&r, 0.01, 3));
    hl_pose_adjoint(&p, by);
    for (int k = 0; k < HL_POSE_SIZE; k++) {
      hl_pose x = {{0}, {0}}, y, before, after;
      (k < 3 ? x.rotation_rad : x.translation_m)[k % 3] = h;
      for (int i = 0; i < 3; i++) {
        y.rotation_rad[i] = by[i][k] * h;
        y.translation_m[i] = by[3 + i][k] * h;
      }
      hl_pose_compose(&p, &x, &before);
      hl_pose_compose(&y, &p, &after);
      near_pose(&before, &after, 1e-11); /* the square of the step */
    }
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_matrix_of_a_turn_about_an_axis),
      cmocka_unit_test(test_matrix_agrees_with_opencv),
      cmocka_unit_test(test_matrix_is_a_rotation),
      cmocka_unit_test(test_vector_to_matrix_and_back),
      cmocka_unit_test(test_half_a_turn),
      cmocka_unit_test(test_from_matrix_takes_the_short_way),
      cmocka_unit_test(test_apply_is_the_matrix_and_the_translation),
      cmocka_unit_test(test_derivatives_against_differences),
      cmocka_unit_test(test_derivative_at_no_turn),
      cmocka_unit_test(test_derivative_along_the_axis),
      cmocka_unit_test(test_compose_is_one_after_the_other),
      cmocka_unit_test(test_inverse_undoes),
      cmocka_unit_test(test_motion_undoes_a_change_of_the_numbers),
      cmocka_unit_test(test_adjoint_carries_a_motion_across),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
