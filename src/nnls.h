/* Least squares with non-negative unknowns, from normal equations. Private. */
#ifndef HL_NNLS_H
#define HL_NNLS_H

enum { HL_NNLS_MAX = 64 };

/* min x'Ax - 2 b'x over x >= 0; A symmetric positive semi-definite, row-major n x n, n <=
 * HL_NNLS_MAX. Returns 0; -1 where it did not settle (x is then feasible all the same). Allocates
 * nothing. */
int hl_nnls(const double *a, const double *b, int n, double *x);

#endif
