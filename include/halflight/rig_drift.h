/**
 * Whether a rig is still the rig it was: two replayed sessions of the same lights.
 *
 * Every light's direction and intensity, every ball's place, the camera's mount and intrinsics and
 * the exposure are tested, each against its own stated uncertainty. With K tests, each is taken at
 * the rate of false alarms over K (Bonferroni), so that the rate of the whole comparison is at most
 * the stated one whatever ties the tests together. calib/rig_drift.c has the mathematics.
 */
#ifndef HALFLIGHT_RIG_DRIFT_H
#define HALFLIGHT_RIG_DRIFT_H

#include "halflight/lights.h"
#include "halflight/settings.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What of a rig may have moved. */
typedef enum hl_rig_part {
  HL_RIG_MOUNT,      /* one rotation of all lights: the camera turned in the rig; deg */
  HL_RIG_INTRINSICS, /* rms of the focal lengths' changes; px */
  HL_RIG_SPHERE,     /* a ball's centre, after the mount's rotation where that is named; m */
  HL_RIG_DIRECTION,  /* of a light, beside the mount's rotation; deg */
  HL_RIG_INTENSITY,  /* of a light, beside what is common to all; relative */
  HL_RIG_EXPOSURE,   /* exposure times gain as recorded; relative */
  HL_RIG_PARTS
} hl_rig_part;

/** One thing that may have moved. */
typedef struct hl_rig_cause {
  hl_rig_part part;
  const char *what;       /* "mount", "intrinsics", "sphere", "light" or "exposure"; static */
  const char *name;       /* of the light, borrowed from the reference; "" for what is no light */
  int reference, current; /* place of the light, or the ball, in each; -1: not of one */
  double figure;          /* how far it moved, >= 0 */
  double threshold;       /* how far it would have to in that direction for an alarm; NaN where the
                             figure is zero */
  const char *unit;       /* of both; static */
  double significance; /* probability of such a figure where nothing moved; exposures are recorded,
                          not estimated: 0 or 1 */
  double change[3];    /* current minus reference: rotation vector [rad], centre [m], direction's
                          tangent vector in the camera frame [rad], factor of the intensity or the
                          exposure in [0], (fx, fy) [px] */
  bool moved;
} hl_rig_cause;

/** When a difference counts as a drift. */
typedef struct hl_rig_drift_settings {
  double false_alarm; /* rate of false alarms of the whole comparison */
} hl_rig_drift_settings;

/** The defaults; they pass their own check. */
HL_API hl_rig_drift_settings hl_rig_drift_defaults(void);
/** Name, unit, bounds and text of every setting. */
HL_API const hl_field_table *hl_rig_drift_fields(void);

/** Owner of `cause`; hl_rig_drift_free releases. Names are borrowed: keep the reference. */
typedef struct hl_rig_drift {
  bool drifted;
  double significance; /* the smallest one times the number of tests, at most 1 */
  double false_alarm;
  int n_matched; /* lights of both sessions that were compared */
  int n_tests;   /* K */
  int n_causes;
  hl_rig_cause *cause; /* everything that was tested, moved or not */
  hl_notes notes;      /* how lights were matched, what was not compared and why */
} hl_rig_drift;

/**
 * Compare two sessions of one rig. Lights are matched by label where all have labels of their own,
 * else by file where these are the same, else by order.
 *
 * @param settings NULL means hl_rig_drift_defaults()
 * @return HL_OK, drifted or not; HL_ERR_ARG (settings); HL_ERR_FORMAT (frames of different size,
 *         balls of different number or radius); HL_ERR_DEGENERATE (fewer than three lights that both
 *         know); HL_ERR_MEMORY
 * Cost O(lights^2) to match, O(lights) for each light named.
 */
HL_API hl_status hl_drift_rig(hl_ctx *ctx, const hl_lights *reference, const hl_lights *current,
                              const hl_rig_drift_settings *settings, hl_rig_drift *out);

/** `drift --json`'s document; *out is the caller's, release it with free(). HL_ERR_MEMORY. */
HL_API hl_status hl_rig_drift_json(hl_ctx *ctx, const hl_rig_drift *drift, char **out);

/** Release what it holds. */
HL_API void hl_rig_drift_free(hl_rig_drift *drift);

#ifdef __cplusplus
}
#endif
#endif
