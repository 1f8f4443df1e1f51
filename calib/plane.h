/* A plane seen by a camera: the homography from the plane to pixels. */
#ifndef HL_PLANE_H
#define HL_PLANE_H

#include <stdbool.h>

typedef struct hl_plane {
  double h[3][3]; /* pixel ~ h (x, y, 1) */
} hl_plane;

enum { HL_PLANE_POINTS_MIN = 4 };

/* Least squares in pixels. False for fewer than HL_PLANE_POINTS_MIN points, or points in a row.
 * Allocates nothing. */
bool hl_plane_fit(const double (*board)[2], const double (*pixel)[2], int n, hl_plane *out);

void hl_plane_at(const hl_plane *plane, const double board[2], double pixel[2]);

#endif
