/* The one-lobe parametric models with their linear unknowns projected out. Private. */
#ifndef HL_PARAMETRIC_MODEL_H
#define HL_PARAMETRIC_MODEL_H

#include "halflight/parametric.h"

/* Lit samples in one place; the arrays are the owner's. */
typedef struct hl_parametric {
  hl_fit_model model;
  int n, channels;
  double *body;                   /* shape (n): n.s */
  double *abscissa;               /* shape (n): angle(n,h)^2, or -log(n.h) */
  double *lobe;                   /* shape (n), scratch: f(mu) = exp(-mu abscissa) */
  double *value[HL_CHANNELS_MAX]; /* shape (n) */
  double kd[HL_CHANNELS_MAX], ks[HL_CHANNELS_MAX]; /* of the last call */
  double square[HL_CHANNELS_MAX];                  /* sum of squared residuals, of the last call */
} hl_parametric;

static const double hl_parametric_least = 1e-2, hl_parametric_most = 1e7; /* mu */

/* Best kd and ks at mu = exp(p), and the squares they leave. Returns their sum. */
double hl_parametric_solve(hl_parametric *m, double p);

/* Residuals (fit - value) at p, shape (channels * n), channel by channel. */
void hl_parametric_residuals(hl_parametric *m, double p, double *residual);

/* Their derivative by p after Kaufman: exact in the gradient of the squares. */
void hl_parametric_slopes(hl_parametric *m, double p, double *slope);

#endif
