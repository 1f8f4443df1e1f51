/* A rig of lights and its sessions, drawn from the covariances that they state. */
#ifndef HL_TEST_RIG_SCENE_H
#define HL_TEST_RIG_SCENE_H

#include <stdio.h>
#include <string.h>

#include "halflight/lights.h"
#include "halflight/pose.h"
#include "halflight/vec3.h"
#include "near.h"

enum { RIG_LIGHTS = 24 };

typedef struct rig_scene {
  double direction[RIG_LIGHTS][3], intensity[RIG_LIGHTS];
  double center_m[3];
  hl_camera camera; /* true, with the covariance that calibrations have */
} rig_scene;

static inline rig_scene rig_scene_new(void)
{
  rig_scene s = {.center_m = {0.002, -0.001, 0.44}};
  s.camera = (hl_camera){.width = 176,
                         .height = 144,
                         .fx = 880,
                         .fy = 880,
                         .cx = 88,
                         .cy = 71,
                         .n_distortion = 5,
                         .has_covariance = true};
  const double sigma[9] = {0.4, 0.4, 0.4, 0.4, 6e-3, 5e-2, 1e-4, 1e-4, 2e-2};
  for (int i = 0; i < 9; i++)
    s.camera.covariance[10 * i] = sigma[i] * sigma[i];
  for (int i = 0; i < RIG_LIGHTS; i++) {
    const double elevation = (i % 3 == 0 ? 20 : i % 3 == 1 ? 45 : 70) * 0.017453292519943295;
    const double azimuth = 0.261799 * i;
    s.direction[i][0] = cos(elevation) * cos(azimuth);
    s.direction[i][1] = cos(elevation) * sin(azimuth);
    s.direction[i][2] = -sin(elevation);
    s.intensity[i] = 1 + 0.1 * sin(1.7 * i);
  }
  return s;
}

/* Turns a direction by a vector of the tangent plane. */
static inline void rig_turn_by(double s[3], double u, double w)
{
  double a[3], b[3];
  hl_tangent_basis(s, a, b);
  hl_add_scaled(s, u, a, s);
  hl_add_scaled(s, w, b, s);
  hl_unit(s, s);
}

static inline void rig_draw_ball(const rig_scene *s, const double k[9], test_random *r,
                                 hl_sphere *ball, double error[3])
{
  const double sigma[3] = {4e-6, 4e-6, 1.5e-4};
  *ball = (hl_sphere){.radius_m = 0.025, .has_covariance = true, .n_intrinsics = 9};
  for (int i = 0; i < 3; i++) {
    error[i] = sigma[i] * random_normal(r);
    ball->held_covariance_m2[i][i] = sigma[i] * sigma[i];
  }
  ball->by_intrinsics[0][2] = ball->by_intrinsics[1][3] = -0.0005;
  ball->by_intrinsics[2][0] = ball->by_intrinsics[2][1] = 0.00025;
  for (int i = 0; i < 3; i++) {
    ball->center_m[i] = s->center_m[i] + error[i];
    for (int j = 0; j < 9; j++)
      ball->center_m[i] += ball->by_intrinsics[i][j] * k[j];
    for (int l = 0; l < 3; l++) {
      ball->covariance_m2[i][l] = ball->held_covariance_m2[i][l];
      for (int j = 0; j < 9; j++)
        ball->covariance_m2[i][l] +=
            ball->by_intrinsics[i][j] * s->camera.covariance[10 * j] * ball->by_intrinsics[l][j];
    }
  }
}

static inline void rig_draw_light(const rig_scene *s, int i, const double k[9],
                                  const double error[3], test_random *r, hl_rig_light *l)
{
  const double own[2] = {2e-4, 3e-4}, relative = 0.004;
  char text[32];
  double off[2];
  snprintf(text, sizeof text, "%02d.png", i + 1);
  l->file = strdup(text);
  snprintf(text, sizeof text, "%02d", i + 1);
  l->label = strdup(text);
  l->frame = i;
  l->found = l->trusted = true;
  memcpy(l->direction, s->direction[i], sizeof l->direction);
  hl_tangent_basis(l->direction, l->tangent_basis[0], l->tangent_basis[1]);
  for (int a = 0; a < 2; a++) {
    off[a] = own[a] * random_normal(r);
    l->own_rad2[a][a] = own[a] * own[a];
    l->by_intrinsics[a][2] = 2e-4 * (a + 1);
    for (int j = 0; j < 3; j++) {
      l->by_center[a][j] = 40 * l->tangent_basis[a][j];
      off[a] += l->by_center[a][j] * error[j];
    }
    for (int j = 0; j < 9; j++)
      off[a] += l->by_intrinsics[a][j] * k[j];
  }
  for (int j = 0; j < 3; j++)
    l->direction[j] += off[0] * l->tangent_basis[0][j] + off[1] * l->tangent_basis[1][j];
  hl_unit(l->direction, l->direction);
  hl_tangent_basis(l->direction, l->tangent_basis[0], l->tangent_basis[1]);
  l->intensity_sigma = relative;
  const double factor = s->intensity[i] * exp(relative * random_normal(r));
  for (int c = 0; c < 3; c++) {
    l->intensity[c] = factor;
    l->color[c] = 1;
  }
  l->exposure_us = 20000;
  l->gain = 1;
}

/* A session seen through a camera that is off by k. hl_lights_free releases. */
static inline hl_lights rig_draw(const rig_scene *s, const double k[9], test_random *r)
{
  double error[3], p[HL_INTRINSICS_MAX];
  hl_lights out;
  memset(&out, 0, sizeof out);
  out.trusted = true;
  out.camera = s->camera;
  hl_camera_intrinsics(&out.camera, p);
  for (int j = 0; j < 9; j++)
    p[j] += k[j];
  hl_camera_set_intrinsics(&out.camera, p);
  out.n_balls = 1;
  rig_draw_ball(s, k, r, &out.ball[0], error);
  out.n = RIG_LIGHTS;
  out.light = calloc(RIG_LIGHTS, sizeof *out.light);
  for (int i = 0; i < RIG_LIGHTS; i++)
    rig_draw_light(s, i, k, error, r, &out.light[i]);
  return out;
}

static inline void rig_draw_camera(const rig_scene *s, test_random *r, double k[9])
{
  for (int j = 0; j < 9; j++)
    k[j] = sqrt(s->camera.covariance[10 * j]) * random_normal(r);
}

#endif
