/* Where two cameras see the same points. */
#ifndef HL_DRIFT_PROJECTION_H
#define HL_DRIFT_PROJECTION_H

#include "drift_side.h"
#include "halflight/drift.h"

enum { HL_DRIFT_CAUSES = 2 * HL_INTRINSICS_MAX };

/* One point of the comparison, as the cameras see it at the present motion. */
typedef struct hl_drift_node {
  bool seen;
  double at[2], difference[2], weight;
  double point[3];                           /* reference camera */
  double by_reference[3][HL_INTRINSICS_MAX]; /* of the point */
  double by_motion[2][HL_POSE_SIZE];
  double by_cause[2][HL_DRIFT_CAUSES]; /* N, then F */
} hl_drift_node;

typedef struct hl_drift_fit {
  const hl_drift_side *reference, *current;
  double distance_m; /* 0: directions */
  int n_motion;      /* numbers of the motion that are free: 3 or 6 */
  int n_causes;
  int columns, rows, n_nodes;
  hl_drift_node *node;
  hl_pose motion;
} hl_drift_fit;

/* The nodes at the motion that best explains them; hl_drift_fit's `node` is the caller's (free).
 * HL_ERR_DEGENERATE (too few points that both see); HL_ERR_MEMORY. */
hl_status hl_drift_fit_open(hl_ctx *ctx, const hl_drift_side *reference,
                            const hl_drift_side *current, double distance_m, hl_drift_fit *out);

/* Over a grid of the frame, after the motion that best explains it: the projection difference, with
 * its stated deviations, into implied, mean_px, max_px and the nodes of `out`.
 * HL_ERR_DEGENERATE (too few points that both see); HL_ERR_MEMORY. */
hl_status hl_drift_projections(hl_ctx *ctx, const hl_drift_side *reference,
                               const hl_drift_side *current, double distance_m, hl_drift *out);

/* Cameras of different lens models: the verdict, its significance and the one cause, at
 * out->false_alarm. Same statuses. */
hl_status hl_drift_unlike(hl_ctx *ctx, const hl_drift_side *reference, const hl_drift_side *current,
                          hl_drift *out);

/* One deviation of a difference in its own direction. */
double hl_drift_deviation(const double difference[2], const double covariance[2][2]);

/* Mean over the grid of what a change of the intrinsics from `first` on does to the projections [px]:
 * the rms is the root of delta' out delta. */
void hl_drift_effect(const hl_camera *camera, int first, int n,
                     double out[HL_DISTORTION_MAX][HL_DISTORTION_MAX]);

#endif
