/* Sub-pixel readings of a ball's outline. */
#include "../calib/sphere_outline.h"

#include <string.h>

#include "ball_scene.h"
#include "near.h"

enum { SECTORS = 32 };

static hl_cone cone_of(const hl_sphere *ball)
{
  hl_cone c;
  hl_unit(ball->center_m, c.axis);
  hl_tangent_basis(c.axis, c.e1, c.e2);
  c.half_angle_rad = asin(ball->radius_m / hl_norm(ball->center_m));
  return c;
}

/* Reads the outline about a cone that is `inward_px` too small. */
static void read_off(const ball_scene *s, const hl_frame *f, double inward_px, bool wide,
                     hl_outline_sector out[SECTORS])
{
  const hl_outline_look look = {.reach_px = 3.5, .wide = wide};
  hl_cone c = cone_of(&s->ball);
  c.half_angle_rad -= inward_px / s->camera.fx * cos(c.half_angle_rad) * cos(c.half_angle_rad);
  hl_outline_read(f, &s->camera, &c, SECTORS, &look, out);
}

static void test_offsets_are_those_put_in(void **state)
{
  (void)state;
  static const double put[] = {0, 0.4, -0.3, 1.2};
  ball_scene s = scene_of(121.3, 98.8, 60);
  hl_frame f = scene_frame(&s);
  for (int i = 0; i < 4; i++) {
    hl_outline_sector r[SECTORS];
    read_off(&s, &f, put[i], i == 3, r);
    int seen = 0;
    double sum = 0;
    for (int k = 0; k < SECTORS; k++) {
      if (r[k].kind != HL_OUTLINE_EDGE)
        continue;
      seen++;
      sum += r[k].offset_px;
      assert_near(r[k].offset_px, put[i], fmax(5 * r[k].sigma_px, 0.08));
    }
    assert_true(seen >= 26);
    /* analytic; 0.02 px is what the lens's own scale off the axis leaves of the step put in */
    assert_near(sum / seen, put[i], 0.02);
  }
  scene_free(&f);
}

static void test_scaling_the_radiance_changes_nothing(void **state)
{
  (void)state;
  ball_scene s = scene_of(121.3, 98.8, 60);
  hl_frame f = scene_frame(&s);
  hl_outline_sector a[SECTORS], b[SECTORS];
  read_off(&s, &f, 0.2, false, a);
  for (int i = 0; i < f.width * f.height; i++)
    f.radiance[i] *= 1024;
  read_off(&s, &f, 0.2, false, b);
  for (int k = 0; k < SECTORS; k++) {
    assert_int_equal(a[k].kind, b[k].kind);
    assert_near(a[k].offset_px, b[k].offset_px, 1e-5);
  }
  scene_free(&f);
}

static void test_unusable_pixels_are_left_out(void **state)
{
  (void)state;
  ball_scene s = scene_of(121.3, 98.8, 60);
  hl_frame f = scene_frame(&s);
  hl_outline_sector r[SECTORS];
  for (int i = 0; i < f.width * f.height; i++) /* wrong values that must not be looked at */
    if (i % f.width > 120) {
      f.state[i] = i % 2 ? HL_SAMPLE_CLIPPED : HL_SAMPLE_UNUSABLE;
      f.radiance[i] = 77;
    }
  read_off(&s, &f, 0, false, r);
  int outside = 0, edges = 0;
  for (int k = 0; k < SECTORS; k++) {
    outside += r[k].kind == HL_OUTLINE_OUTSIDE;
    edges += r[k].kind == HL_OUTLINE_EDGE;
    if (r[k].kind == HL_OUTLINE_EDGE)
      assert_near(r[k].offset_px, 0, 0.1);
  }
  assert_true(outside >= 12 && edges >= 10);
  scene_free(&f);
}

static void test_nothing_to_see(void **state)
{
  (void)state;
  ball_scene s = scene_of(121.3, 98.8, 60);
  hl_frame f = scene_frame(&s);
  hl_outline_sector r[SECTORS];
  test_random random = scene_random(4);
  for (int i = 0; i < f.width * f.height; i++)
    f.radiance[i] = (float)(0.3 + 0.01 * random_normal(&random));
  read_off(&s, &f, 0, true, r);
  int edges = 0;
  for (int k = 0; k < SECTORS; k++)
    edges += r[k].kind == HL_OUTLINE_EDGE;
  assert_true(edges <= 4); /* the best of five offsets finds a step in noise now and then */
  scene_free(&f);
}

/* One pass of (1 2 1)/4 both ways has a standard deviation of sqrt(1/2) px (analytic). */
static void soften(hl_frame *f)
{
  const int w = f->width, h = f->height;
  float *t = malloc((size_t)(w * h) * sizeof *t);
  assert_non_null(t);
  memcpy(t, f->radiance, (size_t)(w * h) * sizeof *t);
  for (int y = 0; y < h; y++)
    for (int x = 1; x < w - 1; x++)
      t[y * w + x] = 0.25f * (f->radiance[y * w + x - 1] + 2 * f->radiance[y * w + x] +
                              f->radiance[y * w + x + 1]);
  for (int y = 1; y < h - 1; y++)
    for (int x = 0; x < w; x++)
      f->radiance[y * w + x] = 0.25f * (t[(y - 1) * w + x] + 2 * t[y * w + x] + t[(y + 1) * w + x]);
  free(t);
}

static void test_blur_is_found(void **state)
{
  (void)state;
  static const double blurs[] = {0, 0.3, 0.6, 0.9, 1.2};
  const hl_outline_look look = {.reach_px = 4.5};
  ball_scene s = scene_of(121.3, 98.8, 60);
  s.noise = 0;
  hl_frame f = scene_frame(&s);
  const hl_cone c = cone_of(&s.ball);
  assert_near(hl_outline_blur(&f, &s.camera, &c, SECTORS, &look, blurs, 5), 0, 0.2);
  soften(&f);
  assert_near(hl_outline_blur(&f, &s.camera, &c, SECTORS, &look, blurs, 5), 0.707, 0.12);
  scene_free(&f);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_offsets_are_those_put_in),
      cmocka_unit_test(test_scaling_the_radiance_changes_nothing),
      cmocka_unit_test(test_unusable_pixels_are_left_out),
      cmocka_unit_test(test_nothing_to_see),
      cmocka_unit_test(test_blur_is_found),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
