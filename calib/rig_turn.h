/* The directions of two sessions against each other: one rotation of all, and what is left. */
#ifndef HL_RIG_TURN_H
#define HL_RIG_TURN_H

#include "rig_match.h"
#include "triangle.h"

/* Two equations of a light, whitened by its own noise. */
typedef struct hl_rig_rows {
  double tangent[2][3];         /* of the reference */
  double root[2][2];            /* own covariance = root root', lower */
  double change[2];             /* whitened */
  double x[2][HL_TRIANGLE_MAX]; /* whitened */
  double left[2], statistic;    /* whitened change that the fit of the others leaves; its test */
  bool moved;
} hl_rig_rows;

typedef struct hl_rig_turn {
  int n, unknowns;   /* three of the rotation first */
  hl_rig_rows *rows; /* the caller's, shape (n) */
  double rotation_rad[3], rotation_covariance[3][3];
  double statistic; /* of the rotation, chi-squared of three */
} hl_rig_turn;

/* HL_OK; HL_ERR_FORMAT (more balls than there is room for); HL_ERR_DEGENERATE. */
hl_status hl_rig_turn_equations(hl_ctx *ctx, const hl_lights *reference, const hl_lights *current,
                                const hl_rig_pair *pair, hl_rig_turn *out);

/* Finds what moved: lights whose statistic exceeds `limit`, the largest first. */
hl_status hl_rig_turn_settle(hl_ctx *ctx, double limit, hl_rig_turn *turn);

/* L with L L' = A, lower, n x n rows `stride` apart; what is not positive counts as zero. */
void hl_rig_root(const double *a, int n, int stride, double *l);

/* The two sessions were seen through one calibration, whose error they share. */
bool hl_rig_same_camera(const hl_camera *a, const hl_camera *b);

#endif
