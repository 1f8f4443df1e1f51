/*
 * Lens models behind one small interface.
 *
 * A model maps a direction (x, y, 1) to the normalised image point (u, v) it is seen at;
 * pixel = (fx u + cx, fy v + cy). To add one: a row in the table of lens.c and a value of
 * hl_lens_model in the same place.
 */
#ifndef HL_LENS_H
#define HL_LENS_H

#include <stdbool.h>

#include "halflight/camera.h"

typedef struct hl_lens {
  const char *name; /* as camera files spell it */
  int n_coefficients;
  /* Image point of the direction (at[0], at[1], 1) and its derivative d(out)/d(at). */
  void (*distort)(const double *coefficients, const double at[2], double out[2],
                  double jacobian[2][2]);
  /* Derivative d(out)/d(coefficients) there. */
  void (*by_coefficients)(const double *coefficients, const double at[2],
                          double out[2][HL_DISTORTION_MAX]);
} hl_lens;

/* NULL where the model is none of the table. */
const hl_lens *hl_lens_of(hl_lens_model model);

/* The direction seen at an image point; false where there is none on the lens's own side of a
 * fold, `out` untouched. */
bool hl_lens_undistort(const hl_lens *lens, const double *coefficients, const double image[2],
                       double out[2]);

#endif
