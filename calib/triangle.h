/* Least squares fed row by row, kept as a triangle. */
#ifndef HL_TRIANGLE_H
#define HL_TRIANGLE_H

#include "halflight/camera.h"
#include "halflight/pose.h"

enum { HL_TRIANGLE_MAX = 2 * (HL_INTRINSICS_MAX + HL_POSE_SIZE) };

/* R u = z in the least-squares sense; `rest` is what no u explains. */
typedef struct hl_triangle {
  int n; /* unknowns */
  double r[HL_TRIANGLE_MAX][HL_TRIANGLE_MAX];
  double z[HL_TRIANGLE_MAX];
  double rest; /* sum of squares */
  int rows;    /* added so far */
} hl_triangle;

void hl_triangle_clear(hl_triangle *triangle, int n);

/* The equation row . u = datum with unit noise; `row`, of n numbers, is used up. */
void hl_triangle_add(hl_triangle *triangle, double *row, double datum);

#endif
