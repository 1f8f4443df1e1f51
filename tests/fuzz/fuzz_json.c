/* Versioned JSON documents. What was accepted must be writable, and what was written accepted. */
#include <stdlib.h>
#include <string.h>

#include "readers.h"

/* Write `value` and read it again. */
#define ROUND_TRIP(type, value, to_text, read, release)                                            \
  do {                                                                                             \
    hl_ctx inner = {0};                                                                            \
    char *text = NULL;                                                                             \
    fuzz_demand((to_text) == HL_OK, "what was read can be written", inner.msg);                    \
    type again;                                                                                    \
    memset(&again, 0, sizeof again);                                                               \
    fuzz_demand(read(&inner, fuzz_again(text, strlen(text)), &again) == HL_OK,                     \
                "what was written can be read", inner.msg);                                        \
    free(text);                                                                                    \
    release(&again);                                                                               \
  } while (0)

static void nothing(void *value)
{
  (void)value;
}

hl_status fuzz_camera(hl_ctx *ctx, const fuzz_input *input)
{
  hl_camera camera = {0};
  const hl_status st = hl_camera_read(ctx, input->path, &camera);
  if (st != HL_OK)
    return st;
  ROUND_TRIP(hl_camera, camera, hl_camera_json(&inner, &camera, &text), hl_camera_read, nothing);
  for (int format = 0; hl_camera_format_name(format); format++) {
    hl_ctx inner = {0};
    char *text = NULL;
    if (hl_camera_text(&inner, &camera, (hl_camera_format)format, &text) != HL_OK)
      continue; /* a lens that the format does not know */
    hl_camera again;
    fuzz_demand(hl_camera_read(&inner, fuzz_again(text, strlen(text)), &again) == HL_OK,
                hl_camera_format_name(format), inner.msg);
    free(text);
  }
  return HL_OK;
}

hl_status fuzz_sphere(hl_ctx *ctx, const fuzz_input *input)
{
  hl_sphere sphere = {0};
  const hl_status st = hl_sphere_read(ctx, input->path, &sphere);
  if (st == HL_OK)
    ROUND_TRIP(hl_sphere, sphere, hl_sphere_json(&inner, &sphere, NULL, &text), hl_sphere_read,
               nothing);
  return st;
}

hl_status fuzz_calibration(hl_ctx *ctx, const fuzz_input *input)
{
  hl_calibration calibration = {0};
  const hl_status st = hl_calibration_read(ctx, input->path, &calibration);
  if (st == HL_OK)
    ROUND_TRIP(hl_calibration, calibration, hl_calibration_json(&inner, &calibration, &text),
               hl_calibration_read, hl_calibration_free);
  if (st == HL_OK)
    hl_calibration_free(&calibration);
  return st;
}

hl_status fuzz_board_pose(hl_ctx *ctx, const fuzz_input *input)
{
  hl_board_pose pose = {0};
  const hl_status st = hl_board_pose_read(ctx, input->path, &pose);
  if (st == HL_OK)
    ROUND_TRIP(hl_board_pose, pose, hl_board_pose_json(&inner, &pose, &text), hl_board_pose_read,
               nothing);
  return st;
}

/* A few lights and views, some below the horizon. */
static void ask(const hl_reflectance *reflectance)
{
  static const double at[][3] = {{0, 0, 1}, {0, 0, -1}, {0.6, 0, 0.8}, {0, -0.8, -0.6}, {1, 0, 0}};
  enum { N = sizeof at / sizeof at[0] };
  for (int i = 0; i < N; i++)
    for (int j = 0; j < N; j++)
      for (int k = 0; k < N; k++) {
        double out[HL_CHANNELS_MAX];
        hl_reflectance_at(reflectance, at[i], at[j], at[k], out);
        for (int c = 0; c < HL_CHANNELS_MAX; c++)
          fuzz_demand(out[c] == out[c], "radiance is a number", "");
      }
}

hl_status fuzz_reflectance(hl_ctx *ctx, const fuzz_input *input)
{
  hl_reflectance reflectance = {0};
  const hl_status st = hl_reflectance_read(ctx, input->path, &reflectance);
  if (st == HL_OK)
    ask(&reflectance);
  return st;
}

/* The light of a file, seen on a ball that is known. */
hl_status fuzz_sight(hl_ctx *ctx, const fuzz_input *input)
{
  static const char ball[] =
      "{\"format\": \"halflight-sphere\", \"version\": 1, \"center_m\": [0, 0, "
      "0.5], \"radius_m\": 0.1, \"covariance\": [[1e-10, 0, 0], [0, 1e-10, "
      "0], [0, 0, 1e-10]]}";
  hl_sight sight[2];
  hl_position position;
  const hl_status st =
      hl_sight_read(ctx, input->path, fuzz_again(ball, sizeof ball - 1), &sight[0]);
  if (st != HL_OK)
    return st;
  sight[1] = sight[0];
  sight[1].origin_m[0] += 1;
  hl_ctx inner = {0};
  if (hl_position_of_sights(&inner, sight, 2, &position) == HL_OK)
    for (int k = 0; k < 3; k++)
      fuzz_demand(position.position_m[k] - position.position_m[k] == 0, "a finite position", "");
  return HL_OK;
}

hl_status fuzz_fit(hl_ctx *ctx, const fuzz_input *input)
{
  hl_fit fit = {0};
  hl_reflectance reflectance;
  const hl_status st = hl_fit_read(ctx, input->path, &fit);
  if (st != HL_OK)
    return st;
  ROUND_TRIP(hl_fit, fit, hl_fit_json(&inner, &fit, &text), hl_fit_read, nothing);
  hl_ctx inner = {0};
  if (hl_reflectance_of_fit(&inner, &fit, &reflectance) == HL_OK)
    ask(&reflectance);
  return HL_OK;
}

hl_status fuzz_lights(hl_ctx *ctx, const fuzz_input *input)
{
  hl_lights lights = {0};
  const hl_status st = hl_lights_read(ctx, input->path, &lights);
  if (st != HL_OK)
    return st;
  ROUND_TRIP(hl_lights, lights, hl_lights_json(&inner, &lights, &text), hl_lights_read,
             hl_lights_free);
  hl_lights_free(&lights);
  return HL_OK;
}

/* Whatever was read can be written in each format, and what an .lp holds comes back. */
hl_status fuzz_lights_import(hl_ctx *ctx, const fuzz_input *input)
{
  hl_lights lights = {0}, again = {0};
  hl_status st = hl_lights_import(ctx, input->path, &lights);
  if (st != HL_OK)
    return st;
  for (int format = 0; hl_lights_format_name(format); format++) {
    hl_ctx inner = {0};
    char *text = NULL;
    st = hl_lights_text(&inner, &lights, (hl_lights_format)format, &text);
    fuzz_demand(st == HL_OK || st == HL_ERR_ARG, "lights are written", inner.msg);
    if (st == HL_OK && format <= HL_LIGHTS_ALICEVISION) {
      st = hl_lights_import(&inner, fuzz_again(text, strlen(text)), &again);
      fuzz_demand(st == HL_OK, "what was written is read", inner.msg);
      hl_lights_free(&again);
    }
    free(text);
  }
  hl_lights_free(&lights);
  return HL_OK;
}
