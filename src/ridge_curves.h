/* The curves of a sum of ridges from its normal equations: smoothed, and constrained. Private. */
#ifndef HL_RIDGE_CURVES_H
#define HL_RIDGE_CURVES_H

#include "ridges.h"

/* lambda of each term's roughness, absolute. Settled once a refinement: were it to follow the
 * directions, the cost's slope would miss it. */
typedef struct hl_roughness {
  double weight[HL_TERMS_MAX];
  double ridge;
} hl_roughness;

/* ridges->smooth relative to the mean weight of the term's columns. */
void hl_roughness_from(const hl_ridges *ridges, const hl_gram *gram, hl_roughness *out);

typedef struct hl_curves {
  double x[HL_CHANNELS_MAX][HL_GRAM_MAX];     /* of the columns */
  double d[HL_CHANNELS_MAX][HL_GRAM_MAX];     /* of the unknowns behind them */
  bool is_free[HL_CHANNELS_MAX][HL_GRAM_MAX]; /* unknowns that are not held at zero */
  double misfit;                              /* r' W r */
  double cost;                                /* and the roughness */
} hl_curves;

typedef struct hl_curves_work {
  double system[HL_GRAM_MAX * HL_GRAM_MAX]; /* of the unknowns */
  double half[HL_GRAM_MAX * HL_GRAM_MAX];
  double factor[HL_CHANNELS_MAX][HL_GRAM_MAX * HL_GRAM_MAX]; /* of the free unknowns, a channel */
} hl_curves_work;

/* Nothing known: the next solve starts from the unconstrained answer. */
void hl_curves_forget(hl_curves *curves);

/* Best curves; starts from what `curves` holds. work->factor is left for hl_curves_profile. */
void hl_curves_solve(const hl_ridges *ridges, const hl_gram *gram, const hl_roughness *roughness,
                     hl_curves_work *work, hl_curves *curves);

/* Gauss and Newton's matrix with the curves profiled out (Kaufman): inner - cross A^-1 cross'. */
void hl_curves_profile(const hl_ridges *ridges, const hl_curves *curves, const hl_curves_work *work,
                       int channels, const hl_ridge_slopes *slopes,
                       double hessian[HL_AXES_MAX][HL_AXES_MAX]);

/* Choose one lambda for all terms by generalized cross-validation over `samples` of them, start there. */
void hl_curves_smooth(hl_ridges *ridges, const hl_gram *gram, double samples, hl_curves_work *work,
                      hl_curves *curves);

/* Residual on other normal equations than those fitted to. */
double hl_curves_misfit(const hl_gram *gram, const hl_curves *curves);

#endif
