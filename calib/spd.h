/* Small symmetric positive definite matrices, packed n x n, row by row. */
#ifndef HL_SPD_H
#define HL_SPD_H

#include <stdbool.h>

enum { HL_SPD_MAX = 12 };

/* Cholesky factor of the matrix scaled to a unit diagonal. */
typedef struct hl_spd {
  int n;
  double scale[HL_SPD_MAX]; /* A = D^-1 L L' D^-1, D the diagonal of these */
  double l[HL_SPD_MAX * HL_SPD_MAX];
} hl_spd;

/* False where the matrix is not positive definite to rounding; *weakest (may be NULL) is then the
 * row at which that shows. Every diagonal element is first enlarged by `damping` of itself. */
bool hl_spd_factor(const double *matrix, int n, double damping, hl_spd *out, int *weakest);

/* x = A^-1 b; may be b. */
void hl_spd_solve(const hl_spd *factor, const double *b, double *x);

/* Symmetric to the last bit. */
void hl_spd_inverse(const hl_spd *factor, double *out);

/* Condition number of the scaled matrix in the 1-norm; *weakest (may be NULL) is the row that the
 * others come closest to explaining, its share left to itself (1 - R^2) in *own (may be NULL). */
double hl_spd_condition(const double *matrix, const hl_spd *factor, int *weakest, double *own);

#endif
