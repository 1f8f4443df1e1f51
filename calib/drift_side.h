/* One calibration, ready to be compared. */
#ifndef HL_DRIFT_SIDE_H
#define HL_DRIFT_SIDE_H

#include "halflight/calibration.h"

typedef struct hl_drift_side {
  const hl_calibration *calibration;
  int n;                                              /* intrinsics */
  double theta[HL_INTRINSICS_MAX];                    /* themselves */
  double lower[HL_INTRINSICS_MAX][HL_INTRINSICS_MAX]; /* covariance = lower lower' */
  double widened;   /* by this factor, from the views' scatter; also for the views' own */
  double noise_dof; /* residuals behind it; HUGE_VAL: not stated */
} hl_drift_side;

/* `which` is "reference" or "current". HL_ERR_DEGENERATE without a regular covariance. */
hl_status hl_drift_side_of(hl_ctx *ctx, const char *which, const hl_calibration *calibration,
                           hl_drift_side *out, hl_notes *notes);

/* Lower Cholesky factor of a symmetric positive definite matrix, packed n x n; `out` of `stride`
 * columns. False where it is singular. */
bool hl_drift_lower(const double *matrix, int n, int stride, double *out);

/* rows := lower^-1 rows: n rows of `columns` numbers, `stride` apart. */
void hl_drift_whiten(const double *lower, int lower_stride, int n, double *rows, int columns,
                     int stride);

#endif
