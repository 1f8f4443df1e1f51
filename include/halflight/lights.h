/**
 * The lights of a rig, as a replayed session found them: one row a frame (and ball), and what all of
 * them share: camera and the balls' poses.
 *
 * A direction's covariance has two parts that behave differently when lights or sessions are compared:
 * `own_rad2` (noise and model; independent from frame to frame) and what it shares with all others of
 * the session through the ball's pose (`by_center`, with that ball's covariance) and the camera
 * (`by_intrinsics`, with the camera's covariance):
 *
 *   covariance_rad2 = own_rad2 + by_center held_covariance by_center' + by_intrinsics K by_intrinsics'
 *
 * lights.json holds exactly this struct (format "halflight-lights", version 1).
 */
#ifndef HALFLIGHT_LIGHTS_H
#define HALFLIGHT_LIGHTS_H

#include "halflight/dome.h"
#include "halflight/light.h"
#include "halflight/session.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The light of one frame of a session. */
typedef struct hl_rig_light {
  char *file, *label; /* of the frame; "" where there is no label */
  int frame;          /* place in the session, from 0 */
  int ball;   /* place in `balls`: the one it was seen on (the best one, where several were) */
  bool found; /* false: no direction; reasons say why, the rest is zero */
  bool trusted;
  hl_note_list reasons;
  double direction[3]; /* unit, from the ball to the light, camera frame */
  double tangent_basis[2][3];
  double covariance_rad2[2][2]; /* all of it */
  double ellipse_95_rad[2];
  double own_rad2[2][2];
  double by_center[2][3];                     /* [rad/m] */
  double by_intrinsics[2][HL_INTRINSICS_MAX]; /* [rad / unit of the intrinsic], the centre held */
  double color[3];                            /* relative radiance, largest 1 */
  double intensity[3];    /* relative to the session's median light, for equal exposure and gain and
                          one reflectance; r, g, b */
  double intensity_sigma; /* relative deviation of it, one for all channels; 0 = not known */
  bool near;
  double position_m[3]; /* camera frame, where near */
  double position_covariance_m2[3][3];
  double exposure_us, gain; /* as recorded; 0 = not stated */
  bool off_dome;            /* it does not belong to the shape that the lights stand on */
  double dome_off;          /* its distance from that shape, in the shape's unit; 0 without one */
} hl_rig_light;

/** Owner of its arrays and texts; hl_lights_free releases. */
typedef struct hl_lights {
  bool trusted;
  hl_notes reasons; /* of the session: moved ball or camera, bad frames */
  hl_camera camera;
  int n_balls;
  hl_sphere ball[HL_BALLS_MAX]; /* pose from all frames together */
  int n;
  hl_rig_light *light; /* in the session's order */
  hl_notes used, left_out;
  hl_dome dome; /* what the lights stand on */
} hl_lights;

/**
 * Fill lights->dome and each light's dome_off and off_dome: of positions where at least half of the
 * lights found are near, else of directions. HL_OK, also without a claim; HL_ERR_ARG (a direction that
 * is not unit); HL_ERR_MEMORY. Cost as hl_dome_fit_to.
 */
HL_API hl_status hl_lights_find_dome(hl_ctx *ctx, hl_lights *lights);

/** HL_OK; HL_ERR_IO; HL_ERR_FORMAT; HL_ERR_MEMORY. */
HL_API hl_status hl_lights_read(hl_ctx *ctx, const char *path, hl_lights *out);

/** lights.json as text; *out is the caller's, release it with free(). No times in it: it repeats. */
HL_API hl_status hl_lights_json(hl_ctx *ctx, const hl_lights *lights, char **out);
/** Write lights.json, whole or not at all. HL_ERR_IO; HL_ERR_MEMORY. */
HL_API hl_status hl_lights_write(hl_ctx *ctx, const char *path, const hl_lights *lights);

/**
 * A row a light: frame, file, label, trusted, ball, direction, its 95 % ellipse [deg], colour,
 * intensity and its deviation, position [m], exposure, gain, whether it is off the rig's shape and its
 * distance from it [deg or m]; empty where there is nothing. Decimal
 * point whatever the locale. HL_ERR_IO; HL_ERR_MEMORY.
 */
HL_API hl_status hl_lights_csv_write(hl_ctx *ctx, const char *path, const hl_lights *lights);

/** `.lp` of RTI tools, as hl_lp_write has it, of the lights that were found. HL_ERR_ARG where none
 * was; HL_ERR_IO; HL_ERR_MEMORY. */
HL_API hl_status hl_lights_lp_write(hl_ctx *ctx, const char *path, const hl_lights *lights);

/** Release what it holds and zero it; NULL is accepted. */
HL_API void hl_lights_free(hl_lights *lights);

#ifdef __cplusplus
}
#endif
#endif
