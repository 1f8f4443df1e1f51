/* One small value of each kind that has a file format, for tests that write and read files. */
#ifndef HL_TEST_DOCUMENTS_H
#define HL_TEST_DOCUMENTS_H

#include <string.h>

#include "halflight/halflight.h"

static inline hl_camera document_camera(void)
{
  return (hl_camera){.model = HL_LENS_PINHOLE,
                     .width = 64,
                     .height = 48,
                     .fx = 70,
                     .fy = 70,
                     .cx = 31.5,
                     .cy = 23.5,
                     .n_distortion = 5};
}

static inline hl_sphere document_sphere(void)
{
  hl_sphere s = {.center_m = {0, 0, 0.5}, .radius_m = 0.1, .has_covariance = true};
  for (int i = 0; i < 3; i++)
    s.covariance_m2[i][i] = 1e-10;
  return s;
}

static inline hl_light document_light(void)
{
  hl_light light = {.trusted = true,
                    .found = true,
                    .direction = {0, 0, -1},
                    .tangent_basis = {{1, 0, 0}, {0, -1, 0}},
                    .covariance_rad2 = {{1e-6, 0}, {0, 1e-6}},
                    .color = {1, 1, 1},
                    .lobe = HL_LOBE_FORESHORTENED,
                    .half_angle_direction = {0, 0, -1},
                    .mean_cos_view = 0.8,
                    .mean_view = {0, 0, -1},
                    .channels = 1,
                    .n_curves = 2,
                    .proposition = "Prop. 3",
                    .stays_free = "nothing"};
  for (int i = 0; i < 2; i++) {
    hl_curve *curve = &light.curves[i];
    curve->lobe = i == 0 ? "diffuse" : "specular";
    curve->channel = "grey";
    curve->n = 3;
    for (int k = 0; k < 3; k++) {
      curve->angle_rad[k] = 0.5 * k;
      curve->value[k] = 1 - 0.5 * k;
    }
  }
  return light;
}

static inline hl_fit document_fit(void)
{
  hl_fit fit = {.trusted = true,
                .model = HL_FIT_DICHROMATIC,
                .n_samples = 10,
                .channels = 1,
                .light = {0, 0, 1},
                .view = {0, 0, 1},
                .n_terms = 2,
                .condition = 1,
                .proposition = "Prop. 3",
                .stays_free = "nothing"};
  for (int i = 0; i < 2; i++) {
    hl_term *term = &fit.term[i];
    term->role = i == 0 ? HL_TERM_LINEAR : HL_TERM_LOBE;
    term->direction[2] = 1;
    term->strength[0] = 1;
    term->n = 2;
    term->t[1] = term->value[0][1] = term->shown[1] = 1;
  }
  return fit;
}

/* `view`: room for one. */
static inline hl_calibration document_calibration(hl_view_pose *view)
{
  hl_calibration calibration = {.trusted = true,
                                .camera = document_camera(),
                                .target = {HL_TARGET_CHESSBOARD, 3, 3, 0.03, 0},
                                .n_views = 1,
                                .view = view,
                                .noise_px = 0.1,
                                .coverage = 0.5,
                                .tilt_deg = 30,
                                .condition = 10,
                                .scatter = 1,
                                .corners_used = 9};
  const int n = hl_camera_intrinsics_count(&calibration.camera);
  calibration.camera.has_covariance = true;
  for (int i = 0; i < n; i++)
    calibration.camera.covariance[i * n + i] = 1e-3;
  *view = (hl_view_pose){.used = true, .seen = 9, .corners = 9};
  strcpy(view->name, "a.png");
  view->cam_from_board.translation_m[2] = 1;
  return calibration;
}

static inline hl_board_pose document_pose(void)
{
  hl_board_pose pose = {.target = {HL_TARGET_APRILGRID, 2, 2, 0.03, 0.3},
                        .cam_from_board = {{0, 0, 0}, {0, 0, 1}},
                        .camera = document_camera(),
                        .has_covariance = true};
  for (int i = 0; i < HL_POSE_SIZE; i++)
    pose.covariance[i][i] = 1e-9;
  return pose;
}

/* `light`: room for one. */
static inline hl_lights document_lights(hl_rig_light *light)
{
  static char file[] = "a.png", label[] = "one";
  *light = (hl_rig_light){.file = file,
                          .label = label,
                          .found = true,
                          .trusted = true,
                          .direction = {0, 0, -1},
                          .tangent_basis = {{1, 0, 0}, {0, -1, 0}},
                          .covariance_rad2 = {{1e-6, 0}, {0, 1e-6}},
                          .own_rad2 = {{1e-6, 0}, {0, 1e-6}},
                          .color = {1, 1, 1},
                          .intensity = {1, 1, 1},
                          .near = true,
                          .position_m = {0, 0, 1},
                          .position_covariance_m2 = {{1e-6, 0, 0}, {0, 1e-6, 0}, {0, 0, 1e-6}}};
  hl_lights lights = {
      .trusted = true, .camera = document_camera(), .n_balls = 1, .n = 1, .light = light};
  lights.ball[0] = document_sphere();
  return lights;
}

#endif
