/* Gauss-Newton on the direction of light. Private. */
#ifndef HL_LIGHT_REFINE_H
#define HL_LIGHT_REFINE_H

#include "light_model.h"

typedef struct hl_refined {
  hl_model_point at;
  hl_model_step step; /* where the last step was taken from */
  int iterations;
  bool converged; /* the last step was below the tolerance */
} hl_refined;

/* From out->at.s (unit), its exponent and nearness as far as the model has them, downhill to a tolerance [rad]; -1 where the model cannot be fitted at all.
 */
int hl_light_refine(const hl_light_model *model, const hl_light_data *data, int max_iterations,
                    double tolerance_rad, int threads, hl_model_work *work, hl_refined *out);

/* Breaks of the lobe's spline for light s: dense at the highlight, `least` pixels in every
 * interval. */
void hl_light_breaks(const hl_light_data *data, const double s[3], int count, int least,
                     hl_spline *spline);

#endif
