/* Cholesky's factor of a small dense matrix, upper triangle, row by row. Private. */
#ifndef HL_CHOLESKY_H
#define HL_CHOLESKY_H

/* In place: U'U = A for the n x n upper triangle at u, rows `stride` apart. A pivot below
 * floor * (its diagonal) + tiny is raised to that, so that a singular matrix still has an answer;
 * returns how many were. */
int hl_cholesky(double *u, int n, int stride, double floor);

/* In place: U' x = b, whose square is b'A^-1 b. */
void hl_cholesky_forward(const double *u, int n, int stride, double *x);

/* In place: A x = b. */
void hl_cholesky_solve(const double *u, int n, int stride, double *x);

#endif
