/* Joint refinement of all directions of a sum of ridges. Private. */
#ifndef HL_RIDGE_REFINE_H
#define HL_RIDGE_REFINE_H

#include "ridge_curves.h"

typedef struct hl_ridge_fit {
  hl_ridges ridges;
  hl_axes axes;
  hl_curves curves;
  double hessian[HL_AXES_MAX][HL_AXES_MAX]; /* D' P D, in the axes' tangents */
  double misfit;                            /* r' W r where the hessian was last formed */
  int iterations;
  bool converged;
} hl_ridge_fit;

/* Everything a fit needs beside its samples; some megabytes, once. */
typedef struct hl_refine_work {
  hl_ridge_work ridge;
  hl_curves_work curves;
  hl_gram gram;
  hl_ridge_slopes slopes;
  hl_curves trial;
} hl_refine_work;

/* Curves at the fit's axes; smooths anew where `smooth`. */
void hl_ridge_settle(const hl_ridge_data *data, bool smooth, int threads, hl_refine_work *work,
                     hl_ridge_fit *fit);

/* From the fit's axes to the nearest minimum; its smoothing is kept. */
void hl_ridge_refine(const hl_ridge_data *data, int max_iterations, double tolerance_rad,
                     int threads, hl_refine_work *work, hl_ridge_fit *fit);

#endif
