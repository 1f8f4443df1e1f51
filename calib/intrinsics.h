/* The calibration's own parts: intrinsics and one pose a view, from corners. */
#ifndef HL_INTRINSICS_H
#define HL_INTRINSICS_H

#include "arrow.h"
#include "halflight/calibration.h"
#include "sightings.h"

/* One view of the problem. */
typedef struct hl_intrinsics_view {
  const hl_view *source;
  hl_sighting *sighting; /* into the problem's own */
  int n;                 /* corners seen */
  bool used;
  hl_pose pose;
  bool has_pose;
  double cost; /* sum of squared weighted residuals of the corners used */
  char why[HL_REASON_MAX];
} hl_intrinsics_view;

/* Everything of one calibration; hl_intrinsics_free releases it. */
typedef struct hl_intrinsics {
  const hl_corners *corners;
  const hl_calibration_settings *settings;
  hl_camera camera;
  int n_views;
  hl_intrinsics_view *view;
  hl_sighting *sighting;
  int n_sightings;

  /* of the last solve */
  hl_arrow arrow;
  hl_arrow_view *block;   /* shape (n_views) */
  hl_arrow_view **active; /* blocks of the views used, in order */
  hl_pose *trial;         /* shape (n_views) */
  int n_active;
  double cost;         /* sum of squared weighted residuals */
  double prior;        /* weight of the rational model's held denominator: the noise's variance */
  double farthest;     /* q = tan^2 of the angle from the axis at the frame's corner, for it */
  double stationarity; /* distance to the minimum, in stated deviations */
  int iterations;
  bool solved_once;  /* a sum of squares was had at all */
  hl_ctx opencv;     /* what OpenCV said where it gave up */
  double opencv_off; /* how far its answer was from the minimum, in stated deviations */
} hl_intrinsics;

/* intrinsics_problem.c */
hl_status hl_intrinsics_new(hl_ctx *ctx, const hl_corners *corners,
                            const hl_calibration_settings *settings, hl_intrinsics *out);
void hl_intrinsics_free(hl_intrinsics *problem);
int hl_intrinsics_views_used(const hl_intrinsics *problem);
int hl_intrinsics_corners_used(const hl_intrinsics *problem);
void hl_intrinsics_leave_out(hl_intrinsics_view *view, const char *format, ...) HL_PRINTF(2, 3);

/* Share of the frame's cells (10 x 10) that hold a used corner, and the largest angle between two
 * boards. */
double hl_intrinsics_coverage(const hl_intrinsics *problem);
double hl_intrinsics_tilt_deg(const hl_intrinsics *problem);

/* Where a solution stands: camera, poses and what is used. */
typedef struct hl_intrinsics_state {
  hl_camera camera;
  double cost, prior, farthest, stationarity;
  hl_ctx opencv;
  double opencv_off;
  hl_intrinsics_view *view;
  hl_sighting *sighting;
} hl_intrinsics_state;

hl_status hl_intrinsics_state_new(hl_ctx *ctx, const hl_intrinsics *problem,
                                  hl_intrinsics_state *out);
void hl_intrinsics_state_free(hl_intrinsics_state *state);
void hl_intrinsics_save(const hl_intrinsics *problem, hl_intrinsics_state *state);
/* The arrow is not part of it: hl_intrinsics_linearise follows where it is needed. */
void hl_intrinsics_restore(hl_intrinsics *problem, const hl_intrinsics_state *state);

/* Degrees of freedom left, 2 N - p. */
int hl_intrinsics_freedom(const hl_intrinsics *problem);

/* intrinsics_solve.c: least squares for all that is used, from where it stands. HL_ERR_DEGENERATE
 * (a block is singular); HL_ERR_NOT_CONVERGED. */
hl_status hl_intrinsics_solve(hl_ctx *ctx, hl_intrinsics *problem);

/* The arrow at the present state, factored without damping, and the distance to the minimum. */
hl_status hl_intrinsics_linearise(hl_ctx *ctx, hl_intrinsics *problem);

/* intrinsics_start.c: from nothing to a solution for `model`. HL_ERR_DEGENERATE. */
hl_status hl_intrinsics_start(hl_ctx *ctx, hl_intrinsics *problem, hl_lens_model model);

/* intrinsics_choice.c: the model asked for, or the smallest that explains the corners; solved and
 * sifted, with what was tried in the notes. */
hl_status hl_intrinsics_choose(hl_ctx *ctx, hl_intrinsics *problem, hl_notes *used,
                               hl_notes *left_out);

/* intrinsics_shape.c: what the board would rather be, were its shape free too. */
typedef struct hl_board_shape {
  double explained;           /* of the sum of squares, by the two together */
  double stretch, stretch_sd; /* along x against y */
  double ratio_off, ratio_sd; /* of the spacing ratio; 0 for a chessboard */
} hl_board_shape;

/* At the minimum; takes the blocks of the last solve. False where it cannot be told. */
bool hl_intrinsics_shape(hl_intrinsics *problem, hl_board_shape *out);

/* intrinsics_verdict.c. Say why a solve ended so, in words about the boards; returns what is to be
 * returned. HL_ERR_DEGENERATE where a solution is that of no camera. Then what was used, left out,
 * and whether to trust it. */
hl_status hl_intrinsics_explain(hl_ctx *ctx, const hl_intrinsics *problem, hl_status status,
                                const char *msg);
hl_status hl_intrinsics_refuse(hl_ctx *ctx, const hl_intrinsics *problem);
void hl_intrinsics_judge(hl_intrinsics *problem, hl_calibration *out);

/* intrinsics_outliers.c: corners and views that stand out leave, the rest is solved again. */
hl_status hl_intrinsics_sift(hl_ctx *ctx, hl_intrinsics *problem);

#endif
