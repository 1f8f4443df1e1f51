/* Normal equations in the shape of an arrow: intrinsics, one pose a view, nothing between views. */
#ifndef HL_ARROW_H
#define HL_ARROW_H

#include "halflight/camera.h"
#include "halflight/pose.h"
#include "spd.h"

/* What one view's corners say. */
typedef struct hl_arrow_view {
  double b[HL_POSE_SIZE * HL_POSE_SIZE];     /* pose by pose */
  double e[HL_INTRINSICS_MAX][HL_POSE_SIZE]; /* intrinsics by pose */
  double gradient[HL_POSE_SIZE];             /* of half the sum of squares, by the pose */
  double own_gradient[HL_INTRINSICS_MAX];    /* this view's part of that by the intrinsics */
  hl_spd factor;                             /* of b */
  double w[HL_INTRINSICS_MAX][HL_POSE_SIZE]; /* E B^-1, so that G = -w' */
} hl_arrow_view;

typedef struct hl_arrow {
  int n;                                           /* intrinsics */
  double a[HL_INTRINSICS_MAX * HL_INTRINSICS_MAX]; /* packed n x n, lower triangle */
  double gradient[HL_INTRINSICS_MAX];
  double s[HL_INTRINSICS_MAX * HL_INTRINSICS_MAX]; /* Schur complement, packed n x n */
  hl_spd schur;                                    /* its factor */
} hl_arrow;

void hl_arrow_clear(hl_arrow *arrow, int n);
void hl_arrow_view_clear(hl_arrow_view *view);

/* One weighted row of the Jacobian with its weighted residual. Without an arrow (NULL) the
 * intrinsics are held, and by_intrinsics is not looked at. */
void hl_arrow_add(hl_arrow *arrow, hl_arrow_view *view, const double *by_intrinsics,
                  const double by_pose[HL_POSE_SIZE], double residual);

/* Where a factor fails. */
typedef struct hl_arrow_fault {
  int view;    /* index in `views`; -1: the intrinsics themselves */
  int unknown; /* of the pose, or of the intrinsics */
} hl_arrow_fault;

/* Factors of the views' blocks, the Schur complement and its factor; false where one is singular. */
bool hl_arrow_factor(hl_arrow *arrow, hl_arrow_view *const *views, int n_views, double damping,
                     hl_arrow_fault *fault);

/* Gauss-Newton's step of the intrinsics, and that of a view's pose beside it. */
void hl_arrow_step(const hl_arrow *arrow, hl_arrow_view *const *views, int n_views,
                   double out[HL_INTRINSICS_MAX]);
void hl_arrow_view_step(const hl_arrow_view *view, int n, const double *by_intrinsics,
                        double out[HL_POSE_SIZE]);

/* How a view pulls the intrinsics once its pose has followed: w g_pose - g_intrinsics, its share of
 * the right-hand side of S d(theta) = pull. */
void hl_arrow_view_pull(const hl_arrow_view *view, int n, double out[HL_INTRINSICS_MAX]);

#endif
