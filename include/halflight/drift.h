/**
 * Whether a camera is still the camera it was.
 *
 * What two calibrations, or a calibration and one new view of a board that stands still, say is put
 * into one least-squares problem: the changes of the intrinsics and of the mount are its unknowns,
 * everything that is known with a stated uncertainty only is unknown beside them. The verdict is a
 * chi-squared test (F, where the noise itself comes from few corners) of all changes at once, at a
 * stated rate of false alarms. What moved is the smallest set of parts (focal length, centre,
 * distortion, rotation, translation) without which the rest is unremarkable.
 *
 * The projection difference is what a user sees: |q1 - q0| over the frame, after the rotation (and
 * translation, at a finite distance) that best explains it.
 */
#ifndef HALFLIGHT_DRIFT_H
#define HALFLIGHT_DRIFT_H

#include "halflight/calibration.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { HL_DRIFT_CAUSES_MAX = 5, HL_DRIFT_GRID = 25 };

/** One part that was tested, with the parts that moved free beside it and the others held. */
typedef struct hl_drift_cause {
  const char *what; /* "intrinsics" or "mount", static */
  const char *part; /* "focal length", "centre", "distortion", "projection", "rotation",
                       "translation"; static */
  double figure;    /* how far it moved, >= 0: focal length rms of fx and fy [px], centre [px],
                       distortion and projection rms over the frame, or a board's corners [px],
                       rotation [deg], translation [m] */
  double
      threshold; /* how far it would have to, in the direction in which it did, to exceed what its
                       uncertainty explains at its share of the rate of false alarms; NaN where
                       nothing tells it */
  const char *unit;    /* of both; static */
  double significance; /* probability of such a figure where it has not moved */
  bool moved;
  int n;                            /* numbers of the part; 0 for "projection" */
  double change[HL_DISTORTION_MAX]; /* current minus reference: px, coefficients, rad, m */
  double sigma[HL_DISTORTION_MAX];  /* its standard deviation */
} hl_drift_cause;

/** When a difference counts as a drift. */
typedef struct hl_drift_settings {
  double false_alarm; /* rate of false alarms of the whole comparison */
  double distance_m;  /* of the points whose projections are compared; 0 = directions */
} hl_drift_settings;

/** The defaults; they pass their own check. */
HL_API hl_drift_settings hl_drift_defaults(void);
/** Name, unit, bounds and text of every setting. */
HL_API const hl_field_table *hl_drift_fields(void);

/** What moved between two states, and how sure that is. */
typedef struct hl_drift {
  bool drifted;
  double significance; /* probability of so large a difference where nothing has changed */
  double false_alarm;  /* the rate the verdict was taken at */
  int n_causes;
  hl_drift_cause cause[HL_DRIFT_CAUSES_MAX]; /* every part that was tested, moved or not */
  hl_notes notes;                            /* what could not be compared, or told apart; why */
  hl_pose implied; /* what best explains the projections: current from reference camera */

  int width, height;      /* of the frame */
  double mean_px, max_px; /* length of the projection difference over the nodes */
  int columns, rows; /* of the grid of nodes over the frame; 0: the nodes are a board's corners */
  int n_nodes;       /* a board with more corners than fit is thinned evenly */
  double at_px[HL_DRIFT_GRID * HL_DRIFT_GRID][2];
  double difference_px[HL_DRIFT_GRID * HL_DRIFT_GRID][2]; /* current minus reference; NaN where
                                                             either sees nothing */
  double sigma_px[HL_DRIFT_GRID * HL_DRIFT_GRID]; /* one stated deviation of it, in its direction:
                                                     the 95 % region reaches 2.4477 of them */
} hl_drift;

/**
 * Compare two calibrations of one camera. Both need a covariance. Of one lens model, the intrinsics
 * themselves are compared, and the mount where both hold views of the same names (the files' names
 * without their folders) whose boards stood still; `notes` says where not. Of different models, the
 * projections are compared and the parts cannot be told apart.
 *
 * @param settings NULL means hl_drift_defaults()
 * @return HL_OK, drifted or not; HL_ERR_FORMAT (frames of different size); HL_ERR_DEGENERATE (no
 *         covariance, or a singular one; nothing that both see); HL_ERR_ARG (settings);
 *         HL_ERR_MEMORY
 * Cost O(views) + O(nodes), some milliseconds.
 * Source: calib/drift_parts.c, _sessions.c, _projection.c and _unlike.c have the derivations; the
 * projection difference is mrcal's (https://mrcal.secretsauce.net/differencing.html).
 */
HL_API hl_status hl_drift_cameras(hl_ctx *ctx, const hl_calibration *reference,
                                  const hl_calibration *current, const hl_drift_settings *settings,
                                  hl_drift *out);

/** Where a board that does not move is, seen from the reference camera. */
typedef struct hl_board_pose {
  hl_target target;
  hl_pose cam_from_board;
  hl_camera camera; /* the one it was fitted with, covariance left out; width 0 = not stated */
  bool has_covariance;
  double covariance[HL_POSE_SIZE][HL_POSE_SIZE];         /* the camera held */
  double by_intrinsics[HL_POSE_SIZE][HL_INTRINSICS_MAX]; /* how the pose follows the camera */
  int corners;                                           /* seen; 0 = not stated */
  double rms_px;                                         /* of the corners; 0 = not stated */
} hl_board_pose;

/**
 * Read and write POSE.json: `{"format":"halflight-board-pose","version":1,"target":SPEC,
 * "cam_from_board":[3 rad, 3 m],"covariance":[6 x 6],"by_intrinsics":[6 x intrinsics],"corners",
 * "rms_px","camera":{CAMERA.json}}`; all after cam_from_board optional in input, by_intrinsics with
 * covariance and camera only.
 * @return HL_OK; HL_ERR_IO; HL_ERR_FORMAT (also a board behind the camera); HL_ERR_MEMORY
 */
HL_API hl_status hl_board_pose_read(hl_ctx *ctx, const char *path, hl_board_pose *out);
/** POSE.json as text; *out is the caller's, release it with free(). HL_ERR_MEMORY. */
HL_API hl_status hl_board_pose_json(hl_ctx *ctx, const hl_board_pose *pose, char **out);
/** Write POSE.json, whole or not at all. HL_ERR_IO; HL_ERR_MEMORY. */
HL_API hl_status hl_board_pose_write(hl_ctx *ctx, const char *path, const hl_board_pose *pose);

/**
 * Pose of the board in one view of a calibrated camera (the reference frame of a fixed board).
 * @return HL_OK; HL_ERR_FORMAT (frame and camera of different size); HL_ERR_DEGENERATE (too few
 *         corners, no pose explains them); HL_ERR_UNAVAILABLE without OpenCV; HL_ERR_MEMORY
 */
HL_API hl_status hl_board_pose_fit(hl_ctx *ctx, const hl_calibration *camera,
                                   const hl_corners *corners, int view, hl_board_pose *out);

/**
 * One new view of a board that has not moved, against the reference. The board's pose is not fitted
 * again to judge by: it stays where the reference saw it, so that no change can hide in it.
 * @return as hl_drift_cameras; HL_ERR_FORMAT also for a pose of another target or camera;
 *         HL_ERR_DEGENERATE also for a view with too few corners
 */
HL_API hl_status hl_drift_board(hl_ctx *ctx, const hl_calibration *reference,
                                const hl_board_pose *board, const hl_corners *corners, int view,
                                const hl_drift_settings *settings, hl_drift *out);

/** `drift --json`'s document; *out is the caller's, release it with free(). HL_ERR_MEMORY. */
HL_API hl_status hl_drift_json(hl_ctx *ctx, const hl_drift *drift, char **out);

#ifdef __cplusplus
}
#endif
#endif
