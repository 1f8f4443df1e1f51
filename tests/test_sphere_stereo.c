/* The stereographic picture of a camera's rays. */
#include "../calib/sphere_stereo.h"

#include "ball_scene.h"
#include "near.h"

static void test_cones_are_circles(void **state)
{
  (void)state;
  ball_scene s = scene_of(190, 40, 35); /* off the axis of a distorting lens */
  hl_stereo g;
  assert_int_equal(hl_stereo_make(NULL, &s.camera, 600, &g), HL_OK);
  double axis[3], e1[3], e2[3], at[8][2], jac[2][2];
  hl_unit(s.ball.center_m, axis);
  hl_tangent_basis(axis, e1, e2);
  const double half = asin(s.ball.radius_m / hl_norm(s.ball.center_m));
  for (int i = 0; i < 8; i++) {
    const double a = 0.785398163 * i;
    double ray[3], p[2];
    for (int k = 0; k < 3; k++)
      ray[k] = cos(half) * axis[k] + sin(half) * (cos(a) * e1[k] + sin(a) * e2[k]);
    assert_int_equal(hl_camera_project(NULL, &s.camera, ray, p), HL_OK);
    hl_stereo_at(&g, p[0], p[1], at[i], jac);
  }
  /* opposite points of equally spaced azimuths: not the centre, but every point is as far from the
   * centre of the circle through three of them */
  const double ax = at[0][0], ay = at[0][1], bx = at[3][0] - ax, by = at[3][1] - ay;
  const double cx = at[5][0] - ax, cy = at[5][1] - ay, d = 2 * (bx * cy - by * cx);
  const double ux = (cy * (bx * bx + by * by) - by * (cx * cx + cy * cy)) / d;
  const double uy = (bx * (cx * cx + cy * cy) - cx * (bx * bx + by * by)) / d;
  const double radius = hypot(ux, uy);
  for (int i = 0; i < 8; i++) /* bilinear between nodes 30 px apart: some hundredths of a pixel */
    assert_near(hypot(at[i][0] - ax - ux, at[i][1] - ay - uy), radius, 0.06);
  hl_stereo_free(&g);
}

static void test_jacobian_matches_finite_differences(void **state)
{
  (void)state;
  ball_scene s = scene_of(120, 100, 40);
  hl_stereo g;
  assert_int_equal(hl_stereo_make(NULL, &s.camera, 600, &g), HL_OK);
  double p[2], q[2], jac[2][2], unused[2][2];
  hl_stereo_at(&g, 71.3, 45.8, p, jac);
  for (int j = 0; j < 2; j++) {
    hl_stereo_at(&g, 71.3 + (j == 0) * 1e-3, 45.8 + (j == 1) * 1e-3, q, unused);
    for (int i = 0; i < 2; i++)
      assert_near((q[i] - p[i]) / 1e-3, jac[i][j], 1e-6);
  }
  hl_stereo_free(&g);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_cones_are_circles),
      cmocka_unit_test(test_jacobian_matches_finite_differences),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
