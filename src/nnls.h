/* Least squares with non-negative unknowns, from normal equations. Private. */
#ifndef HL_NNLS_H
#define HL_NNLS_H

#include <stdbool.h>

enum { HL_NNLS_MAX = 64, HL_NNLS_LARGEST = 200 };

/* min x'Ax - 2 b'x over x >= 0; A symmetric positive semi-definite, row-major n x n, n <=
 * HL_NNLS_MAX. Returns 0; -1 where it did not settle (x is then feasible all the same). Allocates
 * nothing. */
int hl_nnls(const double *a, const double *b, int n, double *x);

/* The same from a start, n <= HL_NNLS_LARGEST. In: x >= 0, and is_free for the unknowns believed
 * positive; `signs`, where not NULL, says which unknowns have no bound (they are always free). Out:
 * both as they turned out. work: n * n doubles, on success the factor of the free unknowns' part of A
 * (cholesky.h, stride n, in their order). */
int hl_nnls_from(const double *a, const double *b, int n, const bool *signs, bool *is_free,
                 double *x, double *work);

#endif
