/* Lens models: closed forms, other programs' numbers, derivatives, the inverse, and where there is
 * none. */
#include <string.h>

#include "../calib/lens.h"
#include "halflight/lens_names.h"
#include "near.h"

/* Lenses as they are built, each one to one up to `reach` = tan of the angle to the axis. */
typedef struct specimen {
  hl_lens_model model;
  double reach;
  double k[HL_DISTORTION_MAX];
} specimen;

static const specimen lenses[] = {
    {HL_LENS_PINHOLE, 0.9, {0, 0, 0, 0, 0}},
    {HL_LENS_PINHOLE, 0.7, {-0.25, 0.08, 0.001, -0.0008, 0}},
    {HL_LENS_PINHOLE, 0.7, {0.12, -0.03, 0, 0, 0.01}},
    {HL_LENS_PINHOLE, 0.7, {-0.1, 0.02, 0.02, 0.015, -0.002}},
    {HL_LENS_RATIONAL, 1.2, {0.4, -0.1, 0.001, 0.002, 0.03, 0.35, -0.06, 0.02}},
    {HL_LENS_RATIONAL, 1.2, {2.1, 0.9, -0.0005, 0.0008, 0.03, 2.4, 1.5, 0.2}}, /* a barrel */
    {HL_LENS_FISHEYE, 5.671, {0, 0, 0, 0}},                                    /* tan 80 deg */
    {HL_LENS_FISHEYE, 5.671, {0.05, -0.02, 0.006, -0.001}},
    {HL_LENS_FISHEYE, 5.671, {-0.04, 0.01, -0.008, 0.002}},
};

enum { N_LENSES = sizeof lenses / sizeof lenses[0] };

/* A direction within the lens's reach. */
static void somewhere(const specimen *s, test_random *r, double at[2])
{
  const double radius = s->reach * random_uniform(r), azimuth = random_between(r, -4, 4);
  at[0] = radius * cos(azimuth);
  at[1] = radius * sin(azimuth);
}

static void image_of(const specimen *s, const double at[2], double out[2])
{
  double ignored[2][2];
  hl_lens_of(s->model)->distort(s->k, at, out, ignored);
}

static bool direction_of(const specimen *s, double u, double v, double out[2])
{
  return hl_lens_undistort(hl_lens_of(s->model), s->k, (const double[2]){u, v}, out);
}

static void test_table_knows_its_models(void **state)
{
  (void)state;
  static const struct {
    hl_lens_model model;
    const char *name;
    int n;
  } known[] = {{HL_LENS_PINHOLE, "pinhole", 5},
               {HL_LENS_RATIONAL, "rational", 8},
               {HL_LENS_FISHEYE, "fisheye", 4}};
  for (int i = 0; i < 3; i++) {
    const hl_lens *lens = hl_lens_of(known[i].model);
    assert_non_null(lens);
    assert_string_equal(lens->name, known[i].name);
    assert_int_equal(lens->n_coefficients, known[i].n);
    assert_string_equal(hl_lens_name((int)known[i].model), known[i].name);
    assert_int_equal(hl_lens_coefficients((int)known[i].model), known[i].n);
    assert_true(known[i].n <= HL_DISTORTION_MAX);
  }
  assert_null(hl_lens_of((hl_lens_model)3));
  assert_null(hl_lens_of((hl_lens_model)77));
  assert_null(hl_lens_name(3));
  assert_null(hl_lens_name(77));
  assert_null(hl_lens_name(-1));
  assert_int_equal(hl_lens_coefficients(77), 0);
}

/* Analytic: on the x axis u = x (1 + k1 x^2 + k2 x^4 + k3 x^6) + 3 p2 x^2, v = p1 x^2. */
static void test_pinhole_on_an_axis(void **state)
{
  (void)state;
  const specimen s = {HL_LENS_PINHOLE, 1, {0.1, 0.2, 0.03, 0.04, 0.5}};
  double out[2];
  image_of(&s, (const double[2]){0.5, 0}, out);
  assert_near(out[0], 0.5 * (1 + 0.1 * 0.25 + 0.2 * 0.0625 + 0.5 * 0.015625) + 3 * 0.04 * 0.25,
              1e-15);
  assert_near(out[1], 0.03 * 0.25, 1e-15);
}

/* Analytic: the same over 1 + k4 y^2 + k5 y^4 + k6 y^6; on the y axis v gains 3 p1 y^2, u p2 y^2. */
static void test_rational_on_an_axis(void **state)
{
  (void)state;
  const specimen s = {HL_LENS_RATIONAL, 1, {0.1, 0.2, 0.03, 0.04, 0.5, 0.6, 0.7, 0.8}};
  double out[2];
  image_of(&s, (const double[2]){0, 0.5}, out);
  const double above = 1 + 0.1 * 0.25 + 0.2 * 0.0625 + 0.5 * 0.015625;
  const double below = 1 + 0.6 * 0.25 + 0.7 * 0.0625 + 0.8 * 0.015625;
  assert_near(out[1], 0.5 * above / below + 3 * 0.03 * 0.25, 1e-15);
  assert_near(out[0], 0.04 * 0.25, 1e-15);
}

/* Analytic: 60 deg are seen at t + k1 t^3 + k2 t^5 + k3 t^7 + k4 t^9, t = pi/3. */
static void test_fisheye_on_an_axis(void **state)
{
  (void)state;
  const specimen s = {HL_LENS_FISHEYE, 2, {0.1, -0.02, 0.003, -0.0004}};
  const double t = 1.0471975511965976, t2 = t * t;
  double out[2];
  image_of(&s, (const double[2]){-sqrt(3), 0}, out);
  assert_near(out[0], -t * (1 + t2 * (0.1 + t2 * (-0.02 + t2 * (0.003 - t2 * 0.0004)))), 4e-16);
  assert_near(out[1], 0, 0);
}

static void test_pinhole_without_distortion_is_the_identity(void **state)
{
  (void)state;
  const double at[2] = {0.3, -0.7};
  double out[2], j[2][2];
  hl_lens_of(HL_LENS_PINHOLE)->distort(lenses[0].k, at, out, j);
  assert_near(out[0], 0.3, 0);
  assert_near(out[1], -0.7, 0);
  assert_near(j[0][0], 1, 0);
  assert_near(j[0][1], 0, 0);
  assert_near(j[1][0], 0, 0);
  assert_near(j[1][1], 1, 0);
}

/* A rational lens whose denominator is 1 is the pinhole lens, in every derivative too. */
static void test_rational_contains_the_pinhole(void **state)
{
  (void)state;
  const double k[HL_DISTORTION_MAX] = {-0.1, 0.02, 0.02, 0.015, -0.002};
  const double at[2] = {0.4, -0.3};
  double a[2], b[2], ja[2][2], jb[2][2], ka[2][HL_DISTORTION_MAX], kb[2][HL_DISTORTION_MAX];
  const hl_lens *pinhole = hl_lens_of(HL_LENS_PINHOLE), *rational = hl_lens_of(HL_LENS_RATIONAL);
  pinhole->distort(k, at, a, ja);
  rational->distort(k, at, b, jb);
  pinhole->by_coefficients(k, at, ka);
  rational->by_coefficients(k, at, kb);
  for (int i = 0; i < 2; i++) {
    assert_near(a[i], b[i], 1e-16);
    for (int j = 0; j < 2; j++)
      assert_near(ja[i][j], jb[i][j], 1e-15);
    for (int j = 0; j < 5; j++)
      assert_near(ka[i][j], kb[i][j], 1e-16);
  }
}

/* Numbers of OpenCV 4.6.0 (Debian python3-opencv): cv2.projectPoints and cv2.fisheye.projectPoints
 * of (x, y, 1) with a unit camera matrix. */
static void test_agrees_with_opencv(void **state)
{
  (void)state;
  static const struct {
    specimen lens;
    double seen[4][2][2]; /* direction, image */
  } known[] = {
      {{HL_LENS_PINHOLE, 1, {0.12, -0.05, 0.003, -0.002, 0.01}},
       {{{0.1, -0.2}, {0.10032762500000002, -0.20070525000000003}},
        {{0.45, 0.3}, {0.46339759778906242, 0.31019923185937498}},
        {{-0.6, 0.5}, {-0.63857888600000001, 0.53296240500000003}},
        {{-0.9, -1.1}, {-1.0100636719999998, -1.223524488}}}},
      {{HL_LENS_RATIONAL, 1, {0.4, -0.1, 0.001, 0.002, 0.03, 0.35, -0.06, 0.02}},
       {{{0.1, -0.2}, {0.10033602930154496, -0.20042205860308993}},
        {{0.45, 0.3}, {0.45635995592600065, 0.30414247061733374}},
        {{-0.6, 0.5}, {-0.6069149634197526, 0.5073891361831272}},
        {{-0.9, -1.1}, {-0.90191824335196136, -1.1052622974301751}}}},
      {{HL_LENS_FISHEYE, 1, {0.05, -0.02, 0.006, -0.001}},
       {{{0.1, -0.2}, {0.098615129899715437, -0.19723025979943087}},
        {{0.45, 0.3}, {0.41711849946028007, 0.27807899964018667}},
        {{-2, 1.5}, {-0.99387104428485817, 0.74540328321364369}},
        {{3, -4.5}, {0.80933815639351137, -1.214007234590267}}}},
  };
  for (int l = 0; l < 3; l++)
    for (int i = 0; i < 4; i++) {
      double out[2];
      image_of(&known[l].lens, known[l].seen[i][0], out);
      assert_near(out[0], known[l].seen[i][1][0], 1e-15);
      assert_near(out[1], known[l].seen[i][1][1], 1e-15);
    }
}

/* Central differences: error of second order in the step. */
static void jacobian_holds(const specimen *s, const double at[2], double step, double limit)
{
  double out[2], j[2][2];
  hl_lens_of(s->model)->distort(s->k, at, out, j);
  for (int k = 0; k < 2; k++) {
    double low[2] = {at[0], at[1]}, high[2] = {at[0], at[1]}, a[2], b[2];
    low[k] -= step;
    high[k] += step;
    image_of(s, low, a);
    image_of(s, high, b);
    assert_near(j[0][k], (b[0] - a[0]) / (2 * step), limit);
    assert_near(j[1][k], (b[1] - a[1]) / (2 * step), limit);
  }
}

static void test_jacobian_against_differences(void **state)
{
  (void)state;
  test_random r = {7};
  for (int l = 0; l < N_LENSES; l++)
    for (int i = 0; i < 50; i++) {
      double at[2];
      somewhere(&lenses[l], &r, at);
      jacobian_holds(&lenses[l], at, 1e-5, 1e-8);
    }
}

/* A fisheye changes from a series to the closed form at r = 1e-3; at the axis it is the identity,
 * and u = x + (k1 - 1/3) x^3 + ... near it. */
static void test_fisheye_near_the_axis(void **state)
{
  (void)state;
  const specimen *s = &lenses[N_LENSES - 1];
  const double axis[2] = {0, 0};
  double out[2], j[2][2];
  hl_lens_of(s->model)->distort(s->k, axis, out, j);
  assert_near(out[0], 0, 0);
  assert_near(j[0][0], 1, 0);
  assert_near(j[1][1], 1, 0);
  assert_near(j[0][1], 0, 0);
  for (int i = 0; i < 248; i++) {
    const double x = 1e-9 * pow(1.07, i); /* to 0.018 */
    const double at[2] = {0.8 * x, -0.6 * x};
    /* the differences' own error: rounding, 1e-16 x over 0.02 x, and u''' (0.01 x)^2 / 6 */
    jacobian_holds(s, at, 0.01 * x, 4e-14 + 1e-4 * x * x);
    image_of(s, at, out);
    const double t = atan(x), t2 = t * t;
    const double want = t * (1 + t2 * (s->k[0] + t2 * (s->k[1] + t2 * (s->k[2] + t2 * s->k[3]))));
    assert_near(out[0], 0.8 * want, 3e-16 * x);
    assert_near(out[1], -0.6 * want, 3e-16 * x);
  }
  const double below[2] = {0.99999999e-3, 0}, above[2] = {1.00000001e-3, 0};
  double a[2], b[2], ja[2][2], jb[2][2];
  hl_lens_of(s->model)->distort(s->k, below, a, ja);
  hl_lens_of(s->model)->distort(s->k, above, b, jb);
  assert_near(b[0] - a[0], 2e-11, 2e-16); /* the slope there is 1 - 1.1e-6 */
  assert_near(jb[0][0], ja[0][0], 1e-13); /* and changes by 2.2e-3 a unit */
  assert_near(jb[1][1], ja[1][1], 1e-13);
}

static void test_by_coefficients_against_differences(void **state)
{
  (void)state;
  const double step = 1e-5;
  test_random r = {13};
  for (int l = 0; l < N_LENSES; l++)
    for (int i = 0; i < 50; i++) {
      const specimen *s = &lenses[l];
      double at[2], by[2][HL_DISTORTION_MAX];
      somewhere(s, &r, at);
      hl_lens_of(s->model)->by_coefficients(s->k, at, by);
      for (int k = 0; k < hl_lens_of(s->model)->n_coefficients; k++) {
        specimen low = *s, high = *s;
        double a[2], b[2];
        low.k[k] -= step;
        high.k[k] += step;
        image_of(&low, at, a);
        image_of(&high, at, b);
        assert_near(by[0][k], (b[0] - a[0]) / (2 * step), 1e-8);
        assert_near(by[1][k], (b[1] - a[1]) / (2 * step), 1e-8);
      }
    }
}

static void test_by_coefficients_on_the_axis(void **state)
{
  (void)state;
  for (int l = 0; l < N_LENSES; l++) {
    const hl_lens *lens = hl_lens_of(lenses[l].model);
    double by[2][HL_DISTORTION_MAX];
    lens->by_coefficients(lenses[l].k, (const double[2]){0, 0}, by);
    for (int k = 0; k < lens->n_coefficients; k++) {
      assert_near(by[0][k], 0, 0);
      assert_near(by[1][k], 0, 0);
    }
  }
}

/* Error of the direction: the image's rounding, 1e-16 of its size, over the lens's least stretch,
 * which is cos^2 = 0.03 (0.02 with distortion) for a fisheye at 80 deg. */
static void test_undistort_inverts_distort(void **state)
{
  (void)state;
  test_random r = {11};
  for (int l = 0; l < N_LENSES; l++)
    for (int i = 0; i < 400; i++) {
      const specimen *s = &lenses[l];
      double at[2], image[2], back[2];
      somewhere(s, &r, at);
      if (i % 4 == 0) { /* all the way out */
        const double grow = s->reach / hypot(at[0], at[1]);
        at[0] *= grow;
        at[1] *= grow;
      }
      image_of(s, at, image);
      assert_true(direction_of(s, image[0], image[1], back));
      const double limit = 2e-14 * (1 + at[0] * at[0] + at[1] * at[1]);
      assert_near(back[0], at[0], limit);
      assert_near(back[1], at[1], limit);
    }
}

/* A radial lens has no preferred azimuth. */
static void test_undistort_turns_with_the_image(void **state)
{
  (void)state;
  static const specimen radial[] = {
      {HL_LENS_PINHOLE, 1, {-0.2, 0.05, 0, 0, 0.01}},
      {HL_LENS_RATIONAL, 1, {2.1, 0.9, 0, 0, 0.03, 2.4, 1.5, 0.2}},
      {HL_LENS_FISHEYE, 1, {0.05, -0.02, 0.006, -0.001}},
  };
  const double c = cos(0.7), s = sin(0.7);
  for (int l = 0; l < 3; l++) {
    double along_x[2], turned[2];
    assert_true(direction_of(&radial[l], 0.4, 0, along_x));
    assert_true(direction_of(&radial[l], 0.4 * c, 0.4 * s, turned));
    assert_near(turned[0], c * along_x[0], 1e-14);
    assert_near(turned[1], s * along_x[0], 1e-14);
  }
}

static void nothing_is_seen_at(const specimen *s, double u, double v)
{
  double out[2] = {-7, -7};
  assert_false(direction_of(s, u, v, out));
  assert_near(out[0], -7, 0);
  assert_near(out[1], -7, 0);
}

/* x - x^3/3 has its maximum 2/3 at x = 1: nothing is seen beyond, and what is seen before is the
 * root on the near side (x^3 - 3x + 3u = 0; for u = 0.6 near 0.7401). */
static void test_pinhole_stays_before_the_fold(void **state)
{
  (void)state;
  const specimen s = {HL_LENS_PINHOLE, 1, {-1.0 / 3, 0, 0, 0, 0}};
  double out[2];
  assert_true(direction_of(&s, 0.6, 0, out));
  assert_near(out[0] - out[0] * out[0] * out[0] / 3, 0.6, 1e-15);
  assert_true(out[0] < 1);
  nothing_is_seen_at(&s, 0.67, 0);
  nothing_is_seen_at(&s, 50, 0);
}

/* x / (1 - x^2 / 4) grows without bound towards its pole at x = 2 and is negative beyond: every
 * image point is seen from before the pole, at x = (sqrt(1 + u^2) - 1) 2 / u. */
static void test_rational_stays_before_the_pole(void **state)
{
  (void)state;
  const specimen s = {HL_LENS_RATIONAL, 1, {0, 0, 0, 0, 0, -0.25}};
  for (int i = -3; i <= 3; i++) {
    const double u = ldexp(1, i);
    double out[2];
    assert_true(direction_of(&s, 0, -u, out));
    assert_near(out[1], -2 / u * (sqrt(1 + u * u) - 1), 3e-15);
    assert_near(out[0], 0, 0);
  }
  double out[2], j[2][2];
  hl_lens_of(s.model)->distort(s.k, (const double[2]){2, 0}, out, j); /* the pole itself */
  assert_false(j[0][0] * j[1][1] - j[0][1] * j[1][0] > 0 && j[0][0] + j[1][1] > 0);
  hl_lens_of(s.model)->distort(s.k, (const double[2]){2.5, 0}, out, j);
  assert_false(j[0][0] * j[1][1] - j[0][1] * j[1][0] > 0 && j[0][0] + j[1][1] > 0);
}

/* x / (1 + x^2) has its maximum 1/2 at x = 1: x = (1 - sqrt(1 - 4 u^2)) / 2 u. */
static void test_rational_stays_before_the_fold(void **state)
{
  (void)state;
  const specimen s = {HL_LENS_RATIONAL, 1, {0, 0, 0, 0, 0, 1}};
  double out[2];
  assert_true(direction_of(&s, 0.48, 0, out));
  assert_near(out[0], (1 - sqrt(1 - 4 * 0.48 * 0.48)) / 0.96, 1e-14);
  nothing_is_seen_at(&s, 0.51, 0);
}

/* An equidistant lens sees 90 deg at pi/2: directions just before it are found, up to where the
 * plane z = 1 holds them, and none at it or beyond. With k1 = -1/6 the image t - t^3/6 folds at
 * t = sqrt 2 (81.03 deg), at (2/3) sqrt 2 = 0.9428. */
static void test_fisheye_ends_at_a_right_angle_or_its_fold(void **state)
{
  (void)state;
  const double quarter = 1.5707963267948966;
  const specimen plain = {HL_LENS_FISHEYE, 1, {0}};
  const double angles_deg[] = {1e-7, 10, 45, 80, 89, 89.9, 89.99};
  for (int i = 0; i < 7; i++) {
    const double t = angles_deg[i] / 90 * quarter;
    double out[2];
    assert_true(direction_of(&plain, 0.6 * t, 0.8 * t, out));
    assert_near(atan(hypot(out[0], out[1])), t, 2e-13);
    assert_near(out[0] / hypot(out[0], out[1]), 0.6, 1e-14);
  }
  nothing_is_seen_at(&plain, quarter, 0);
  nothing_is_seen_at(&plain, 0, 1.6);
  nothing_is_seen_at(&plain, 3, 3);
  const specimen folding = {HL_LENS_FISHEYE, 1, {-1.0 / 6}};
  double out[2];
  assert_true(direction_of(&folding, 0, 0.94, out));
  assert_true(atan(out[1]) < sqrt(2));
  nothing_is_seen_at(&folding, 0, 0.944);
  nothing_is_seen_at(&folding, 0, 1.2);
}

static void test_undistort_refuses_what_is_no_number(void **state)
{
  (void)state;
  for (int l = 0; l < N_LENSES; l++) {
    specimen s = lenses[l];
    nothing_is_seen_at(&s, NAN, 0);
    nothing_is_seen_at(&s, INFINITY, 0);
    nothing_is_seen_at(&s, 1, -INFINITY);
    nothing_is_seen_at(&s, 1e200, 1e200);
    for (int k = 0; k < hl_lens_of(s.model)->n_coefficients; k++) {
      s = lenses[l];
      s.k[k] = NAN;
      nothing_is_seen_at(&s, 0.1, 0.2);
    }
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_table_knows_its_models),
      cmocka_unit_test(test_pinhole_on_an_axis),
      cmocka_unit_test(test_rational_on_an_axis),
      cmocka_unit_test(test_fisheye_on_an_axis),
      cmocka_unit_test(test_pinhole_without_distortion_is_the_identity),
      cmocka_unit_test(test_rational_contains_the_pinhole),
      cmocka_unit_test(test_agrees_with_opencv),
      cmocka_unit_test(test_jacobian_against_differences),
      cmocka_unit_test(test_fisheye_near_the_axis),
      cmocka_unit_test(test_by_coefficients_against_differences),
      cmocka_unit_test(test_by_coefficients_on_the_axis),
      cmocka_unit_test(test_undistort_inverts_distort),
      cmocka_unit_test(test_undistort_turns_with_the_image),
      cmocka_unit_test(test_pinhole_stays_before_the_fold),
      cmocka_unit_test(test_rational_stays_before_the_pole),
      cmocka_unit_test(test_rational_stays_before_the_fold),
      cmocka_unit_test(test_fisheye_ends_at_a_right_angle_or_its_fold),
      cmocka_unit_test(test_undistort_refuses_what_is_no_number),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
