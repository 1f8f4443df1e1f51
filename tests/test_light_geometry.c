/* What the light inherits from an uncertain ball and camera: against finite differences, turned about the
 * axis, and nothing where nothing is uncertain. */
#include "light_data.h"

/* ---- the response against estimates of a changed geometry */

/* A ball seen through a lens of nine intrinsics. */
static lit_scene distorted(void)
{
  lit_scene s = lit_glossy();
  s.camera.n_distortion = 5;
  const double distortion[5] = {-0.2, 0.05, 0.001, -0.001, 0};
  memcpy(s.camera.distortion, distortion, sizeof distortion);
  s.noise = 0.002;
  s.across = 3;
  return s;
}

static hl_light_settings settings_of(const lit_scene *s)
{
  hl_light_settings out = hl_light_defaults();
  out.lobe = s->lobe == LIT_FORESHORTENED ? HL_LOBE_FORESHORTENED : HL_LOBE_PLAIN;
  return out;
}

/* The direction on another camera or ball, in the tangents of `from`. */
static void direction_of(hl_light_work *work, const lit_scene *s, const hl_frame *frame,
                         const double t[2][3], double out[2])
{
  const hl_light_settings settings = settings_of(s);
  hl_surface surface = lit_surface(s);
  hl_light light;
  assert_int_equal(hl_light_estimate(NULL, work, frame, &surface, &settings, &light), HL_OK);
  for (int u = 0; u < 2; u++)
    out[u] = hl_dot(t[u], light.direction);
  hl_surface_free(&surface);
}

/* The estimate's own response, from its kept variant. */
static void response_of(hl_light_work *work, const lit_scene *s, const hl_frame *frame,
                        hl_light_response *out, double t[2][3])
{
  const hl_light_settings settings = settings_of(s);
  hl_surface surface = lit_surface(s);
  hl_light_settled settled;
  hl_light_spread spread;
  double start[2][3];
  surface.camera.has_covariance = true;
  assert_int_equal(hl_light_gather(NULL, work, frame, &surface, 0), HL_OK);
  memcpy(start[0], s->light, sizeof start[0]);
  memcpy(start[1], s->light, sizeof start[1]);
  assert_int_equal(
      hl_light_settle(NULL, work, &surface, &settings, (const double(*)[3])start, &settled), HL_OK);
  const hl_light_model *model = &settled.variant[settled.kept].model;
  hl_light_uncertainty(work, &surface, model, &settled, 1, &spread);
  hl_light_respond(work, model, &surface, &spread, 1, out);
  memcpy(t, work->best.at.t, sizeof work->best.at.t);
  hl_light_response threads;
  hl_light_respond(work, model, &surface, &spread, 3, &threads);
  assert_memory_equal(&threads, out, sizeof threads);
  hl_surface_free(&surface);
}

/* Central difference of the direction by the ball's centre (k < 3) or an intrinsic, in tangents t. */
static void difference(hl_light_work *work, const lit_scene *s, const hl_frame *frame, int k,
                       double h, const double t[2][3], double out[2])
{
  double side[2][2];
  for (int i = 0; i < 2; i++) {
    lit_scene moved = *s;
    double theta[HL_INTRINSICS_MAX];
    hl_camera_intrinsics(&s->camera, theta);
    if (k < 3)
      moved.ball.center_m[k] += i == 0 ? -h : h;
    else
      theta[k - 3] += i == 0 ? -h : h;
    hl_camera_set_intrinsics(&moved.camera, theta);
    direction_of(work, &moved, frame, t, side[i]);
  }
  for (int u = 0; u < 2; u++)
    out[u] = (side[1][u] - side[0][u]) / (2 * h);
}

/* Steps of some hundredths of a pixel, so that the same terms are kept. */
static void responds(const lit_scene *s, double tolerance)
{
  static const double step[12] = {4e-6, 4e-6, 4e-5, 0.2,  0.2,  0.03,
                                  0.03, 2e-3, 0.05, 5e-4, 5e-4, 1};
  test_random random = {9};
  hl_surface surface = lit_surface(s);
  hl_frame frame = lit_frame(s, &surface, &random);
  hl_light_work *work = NULL;
  assert_int_equal(hl_light_work_new(NULL, LIT_SIDE * LIT_SIDE, s->channels, &work), HL_OK);
  hl_light_response r;
  double t[2][3];
  response_of(work, s, &frame, &r, t);
  for (int k = 0; k < 3 + hl_camera_intrinsics_count(&s->camera); k++) {
    double want[2];
    difference(work, s, &frame, k, step[k], (const double(*)[3])t, want);
    const double size = hypot(want[0], want[1]);
    for (int u = 0; u < 2; u++) {
      const double got = k < 3 ? r.by_center[u][k] : r.by_intrinsics[u][k - 3];
      if (!is_near(got, want[u], tolerance * size))
        print_error("lobe %d, change %d\n", s->lobe, k);
      assert_near(got, want[u], tolerance * size);
    }
  }
  hl_light_work_free(work);
  lit_frame_free(&frame);
  hl_surface_free(&surface);
}

static void test_response_of_a_plain_lobe(void **state)
{
  (void)state;
  lit_scene s = distorted();
  responds(&s, 0.05);
}

static void test_response_of_a_foreshortened_lobe(void **state)
{
  (void)state;
  lit_scene s = distorted();
  s.lobe = LIT_FORESHORTENED;
  s.width = 0.3;
  s.channels = 3;
  responds(&s, 0.1);
}

static void test_response_with_clipping(void **state)
{
  (void)state;
  lit_scene s = distorted();
  s.saturation = 0.9;
  responds(&s, 0.1);
}

static void test_response_of_a_matte_ball(void **state)
{
  (void)state;
  lit_scene s = distorted();
  s.lobe = LIT_MATTE;
  responds(&s, 0.05);
}

/* ---- symmetry, and the absence of uncertainty */

/* A quarter turn about the optical axis: right becomes down. */
static void turn_vector(const double a[3], double out[3])
{
  const double turned[3] = {-a[1], a[0], a[2]};
  memcpy(out, turned, sizeof turned);
}

static void turn_covariance(const double a[3][3], double out[3][3])
{
  static const int from[3] = {1, 0, 2};
  static const double sign[3] = {-1, 1, 1};
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++)
      out[i][k] = sign[i] * sign[k] * a[from[i]][from[k]];
}

/* Of fx, fy, cx, cy: each axis takes the other's place, the centre's row counts from the other side. */
static void turn_camera(const hl_camera *a, hl_camera *out)
{
  static const int from[4] = {1, 0, 3, 2};
  static const double sign[4] = {1, 1, -1, 1};
  *out = *a;
  out->fx = a->fy;
  out->fy = a->fx;
  out->cx = LIT_SIDE - 1 - a->cy;
  out->cy = a->cx;
  for (int i = 0; i < 4; i++)
    for (int k = 0; k < 4; k++)
      out->covariance[4 * i + k] = sign[i] * sign[k] * a->covariance[4 * from[i] + from[k]];
}

static void turn_ball(const hl_sphere *a, hl_sphere *out)
{
  static const int from[4] = {1, 0, 3, 2};
  static const double sign[4] = {1, 1, -1, 1};
  *out = *a;
  turn_vector(a->center_m, out->center_m);
  turn_covariance(a->covariance_m2, out->covariance_m2);
  turn_covariance(a->held_covariance_m2, out->held_covariance_m2);
  for (int j = 0; j < a->n_intrinsics; j++) {
    const double column[3] = {a->by_intrinsics[0][from[j]], a->by_intrinsics[1][from[j]],
                              a->by_intrinsics[2][from[j]]};
    double turned[3];
    turn_vector(column, turned);
    for (int i = 0; i < 3; i++)
      out->by_intrinsics[i][j] = sign[j] * turned[i];
  }
}

/* A ball and a camera, both uncertain, the ball following in part. */
static lit_scene uncertain(void)
{
  lit_scene s = lit_glossy();
  s.across = 3;
  s.ball.has_covariance = true;
  s.ball.n_intrinsics = 4;
  static const double held[3][3] = {{4e-12, 1e-12, 0}, {1e-12, 2e-12, 1e-12}, {0, 1e-12, 1e-9}};
  static const double by[3][4] = {
      {1e-6, 0, -3e-4, 1e-5}, {0, 2e-6, 0, -3e-4}, {2e-4, 3e-4, 1e-5, 2e-5}};
  static const double causes[4][4] = {
      {0.5, 0, 0, 0}, {0.45, 0.1, 0, 0}, {0.02, 0, 0.3, 0}, {0, 0.05, 0.1, 0.2}};
  memcpy(s.ball.held_covariance_m2, held, sizeof held);
  s.camera.has_covariance = true;
  for (int i = 0; i < 4; i++)
    for (int k = 0; k < 4; k++)
      for (int j = 0; j < 4; j++)
        s.camera.covariance[4 * i + k] += causes[i][j] * causes[k][j];
  for (int i = 0; i < 3; i++) {
    memcpy(s.ball.by_intrinsics[i], by[i], sizeof by[i]);
    for (int k = 0; k < 3; k++)
      s.ball.covariance_m2[i][k] = 4 * held[i][k];
  }
  return s;
}

/* A part as a matrix of the camera frame. */
static void in_space(const hl_light *light, int part, double out[3][3])
{
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) {
      out[i][k] = 0;
      for (int u = 0; u < 2; u++)
        for (int v = 0; v < 2; v++)
          out[i][k] += light->tangent_basis[u][i] * light->part_rad2[part][u][v] *
                       light->tangent_basis[v][k];
    }
}

static void test_the_ellipse_turns_along(void **state)
{
  (void)state;
  const lit_scene s = uncertain();
  lit_scene turned = s;
  turn_camera(&s.camera, &turned.camera);
  turn_ball(&s.ball, &turned.ball);
  turn_vector(s.light, turned.light);
  const hl_light one = lit_estimate(&s, NULL), two = lit_estimate(&turned, NULL);
  double direction[3];
  turn_vector(one.direction, direction);
  assert_near(hl_angle(direction, two.direction), 0, 1e-5);
  for (int part = HL_PART_POSE; part < HL_PARTS; part++) {
    double a[3][3], want[3][3], got[3][3];
    in_space(&one, part, a);
    turn_covariance((const double(*)[3])a, want);
    in_space(&two, part, got);
    const double trace = want[0][0] + want[1][1] + want[2][2];
    assert_true(trace > 1e-10); /* some thousandths of a degree */
    for (int i = 0; i < 3; i++)
      for (int k = 0; k < 3; k++)
        assert_near(got[i][k], want[i][k], 1e-3 * trace);
  }
}

/* The parts are of the whole: half axes of each, and their sum. */
static void test_parts_add_up(void **state)
{
  (void)state;
  const lit_scene s = uncertain();
  const hl_light light = lit_estimate(&s, NULL);
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++) {
      double sum = 0;
      for (int part = 0; part < HL_PARTS; part++)
        sum += light.part_rad2[part][u][v];
      assert_near(light.covariance_rad2[u][v], sum, 1e-12 * light.covariance_rad2[0][0]);
    }
  for (int part = 0; part < HL_PARTS; part++) {
    const double(*c)[2] = light.part_rad2[part], *axes = light.part_95_rad[part];
    assert_true(light.part_stated[part]);
    /* chi-square, 2 degrees, 95 % */
    assert_near(axes[0] * axes[0] + axes[1] * axes[1], 5.991464547107982 * (c[0][0] + c[1][1]),
                1e-12 * axes[0] * axes[0]);
    assert_true(axes[0] >= axes[1] && light.ellipse_95_rad[0] >= axes[0]);
  }
}

/* A covariance of zeros changes not a bit. */
static void test_zero_covariance(void **state)
{
  (void)state;
  lit_scene s = lit_glossy();
  s.saturation = 0.8;
  s.across = 3;
  const hl_light exact = lit_estimate(&s, NULL);
  assert_false(exact.part_stated[HL_PART_POSE] || exact.part_stated[HL_PART_CAMERA]);
  s.camera.has_covariance = s.ball.has_covariance = true;
  const hl_light zero = lit_estimate(&s, NULL);
  assert_true(zero.part_stated[HL_PART_POSE] && zero.part_stated[HL_PART_CAMERA]);
  assert_memory_equal(zero.direction, exact.direction, sizeof exact.direction);
  assert_memory_equal(zero.covariance_rad2, exact.covariance_rad2, sizeof exact.covariance_rad2);
  assert_memory_equal(zero.part_rad2, exact.part_rad2, sizeof exact.part_rad2);
  assert_memory_equal(zero.ellipse_95_rad, exact.ellipse_95_rad, sizeof exact.ellipse_95_rad);
}

/* A normal map: the camera moves the views alone, so less than it moves a ball. */
static void test_a_map_is_moved_by_the_camera_alone(void **state)
{
  (void)state;
  lit_scene s = uncertain();
  s.ball.n_intrinsics = 0;
  hl_surface surface = lit_surface(&s);
  hl_frame frame = lit_frame(&s, &surface, NULL);
  hl_light ball, map;
  assert_int_equal(lit_status(&frame, &surface, NULL, NULL, &ball), HL_OK);
  surface.is_ball = false;
  assert_int_equal(lit_status(&frame, &surface, NULL, NULL, &map), HL_OK);
  assert_false(map.part_stated[HL_PART_POSE]);
  assert_true(map.part_stated[HL_PART_CAMERA]);
  assert_true(map.part_95_rad[HL_PART_CAMERA][0] > 0);
  assert_true(map.part_95_rad[HL_PART_CAMERA][0] < 0.5 * ball.part_95_rad[HL_PART_CAMERA][0]);
  lit_frame_free(&frame);
  hl_surface_free(&surface);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_response_of_a_plain_lobe),
      cmocka_unit_test(test_response_of_a_foreshortened_lobe),
      cmocka_unit_test(test_response_with_clipping),
      cmocka_unit_test(test_response_of_a_matte_ball),
      cmocka_unit_test(test_the_ellipse_turns_along),
      cmocka_unit_test(test_parts_add_up),
      cmocka_unit_test(test_zero_covariance),
      cmocka_unit_test(test_a_map_is_moved_by_the_camera_alone),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
