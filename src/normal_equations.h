/* Weighted normal equations of a spline (a band) plus a few further columns (a border). */
#ifndef HL_NORMAL_EQUATIONS_H
#define HL_NORMAL_EQUATIONS_H

#include "spline.h"

/* Most models have a border of HL_BORDER_USUAL columns or fewer, and pay for no more. */
enum { HL_BORDER_USUAL = 4, HL_BORDER_MAX = 6, HL_COLUMNS_MAX = HL_SPLINE_MAX + HL_BORDER_MAX };

typedef struct hl_normal {
  int n, m;                      /* band and border columns */
  double band[HL_SPLINE_MAX][4]; /* band[i][k] = A(i, i + k) */
  double border[HL_SPLINE_MAX][HL_BORDER_MAX];
  double corner[HL_BORDER_MAX][HL_BORDER_MAX]; /* upper triangle */
  double rhs[HL_COLUMNS_MAX];                  /* band first, then border */
  double yy;                                   /* sum of w y^2 */
  unsigned dropped;                            /* bit j: border column j is left out */
} hl_normal;

/* Cholesky factor in the same shape: L = [Lb 0; C Lc]. */
typedef struct hl_normal_factor {
  int n, m;
  double band[HL_SPLINE_MAX][4]; /* band[i][k] = Lb(i + k, i) */
  double border[HL_SPLINE_MAX][HL_BORDER_MAX];
  double corner[HL_BORDER_MAX][HL_BORDER_MAX]; /* lower triangle */
  unsigned dropped;
} hl_normal_factor;

void hl_normal_clear(hl_normal *a, int n, int m);
void hl_normal_merge(hl_normal *a, const hl_normal *b);

/* hl_normal_add with a border of `width` columns, a constant where it is called. */
static inline void hl_normal_add_wide(hl_normal *a, int first, const double band[4],
                                      const double *border, int width, double weight, double y)
{
  const double wy = weight * y;
  double wb[4];
  for (int k = 0; k < 4; k++) {
    wb[k] = weight * band[k];
    a->rhs[first + k] += band[k] * wy;
  }
  for (int k = 0; k < 4; k++)
    for (int l = k; l < 4; l++)
      a->band[first + k][l - k] += wb[k] * band[l];
  /* a fixed count is what the compiler can make vectors of */
  for (int k = 0; k < 4; k++)
    for (int j = 0; j < width; j++)
      a->border[first + k][j] += wb[k] * border[j];
  for (int i = 0; i < width; i++) {
    const double wi = weight * border[i];
    a->rhs[a->n + i] += border[i] * wy;
    for (int j = 0; j < width; j++)
      a->corner[i][j] += wi * border[j];
  }
  a->yy += wy * y;
}

/* One row: four band values from column `first`, the border's (0 beyond m), weight and datum. */
static inline void hl_normal_add(hl_normal *a, int first, const double band[4],
                                 const double border[HL_BORDER_MAX], double weight, double y)
{
  if (a->m <= 1)
    hl_normal_add_wide(a, first, band, border, 1, weight, y);
  else if (a->m <= 2)
    hl_normal_add_wide(a, first, band, border, 2, weight, y);
  else if (a->m <= HL_BORDER_USUAL)
    hl_normal_add_wide(a, first, band, border, HL_BORDER_USUAL, weight, y);
  else
    hl_normal_add_wide(a, first, band, border, HL_BORDER_MAX, weight, y);
}

/* What holds together what no pixel determines: weights of the second differences of the band's
 * coefficients, and of the coefficients themselves. */
typedef struct hl_smoothing {
  double bend[HL_SPLINE_MAX];
  double ridge;
} hl_smoothing;

/* `smooth` is relative to the least of the three columns' own weight, so that a highlight of a few
 * pixels stays sharp, `ridge` to the mean, so that an empty interval is carried on from its
 * neighbours. Settled once a refinement: were it to follow the direction, the cost's slope would
 * miss it. */
void hl_smoothing_from(const hl_normal *a, double smooth, double ridge, hl_smoothing *out);
void hl_normal_regularise(hl_normal *a, const hl_smoothing *smoothing);

/* Leave border column j out: its coefficient becomes 0. */
void hl_normal_drop(hl_normal *a, int j);

/* 0 on success, -1 where the matrix is not positive definite. O(n (3 + m)^2), allocates nothing. */
int hl_normal_factorise(const hl_normal *a, hl_normal_factor *factor);
void hl_normal_solve(const hl_normal_factor *factor, const double *rhs, double *x);

/* out = A x */
void hl_normal_times(const hl_normal *a, const double *x, double *out);

/* The full symmetric matrix, row-major (n + m)^2. */
void hl_normal_dense(const hl_normal *a, double *out);

#endif
