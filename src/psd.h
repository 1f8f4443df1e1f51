/* Whether a small matrix can be a covariance. */
#ifndef HL_PSD_H
#define HL_PSD_H

#include <stdbool.h>

/* n x n, row by row, n <= HL_INTRINSICS_MAX: finite, symmetric, positive semi-definite to rounding
 * of single precision relative to the diagonal. */
bool hl_psd_check(const double *matrix, int n);

#endif
