/*
 * Two cameras of different lens models.
 *
 * They have no intrinsics in common, so the projection difference d is the evidence, with N, B and W as
 * in drift_projection.c and F the part of N that no motion explains. F has far fewer columns than d has
 * rows: most differences cannot come from what the covariances state. What neither F nor B explains,
 * rho^2 = min |d - F w - B x|^2, is the two models' own difference. It is not noise, but a sign of how
 * large a difference of that kind is, so it is taken to be as large in each direction that F does
 * explain, and at least `least_px` a node:
 *
 *   T = d' (F F' + rho^2 I)^-1 d - 1 = min over w of |w|^2 + |d - F w - B x|^2 / rho^2, less 1,
 *
 * chi-squared with sum l_k / (l_k + rho^2) degrees of freedom, l_k the eigenvalues of F F': those
 * directions count that the stated uncertainty really has.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "drift_projection.h"
#include "significance.h"
#include "triangle.h"

static const double least_px = 1e-3; /* a node: no lens model is better than that */

/* The trace of (R'R)^-1: the sum of squares of R^-1. */
static double trace_of_inverse(const hl_triangle *t)
{
  double sum = 0;
  for (int c = 0; c < t->n; c++) {
    double y[HL_TRIANGLE_MAX] = {0};
    for (int i = c; i >= 0; i--) {
      y[i] = i == c;
      for (int k = i + 1; k <= c; k++)
        y[i] -= t->r[i][k] * y[k];
      y[i] /= t->r[i][i];
      sum += y[i] * y[i];
    }
  }
  return sum;
}

/* What the nodes say about the causes, the motion free and first. */
static int gather(const hl_drift_fit *f, hl_triangle *out)
{
  int seen = 0;
  hl_triangle_clear(out, f->n_motion + f->n_causes);
  for (int k = 0; k < f->n_nodes; k++) {
    const hl_drift_node *n = &f->node[k];
    seen += n->seen;
    for (int i = 0; n->seen && i < 2; i++) {
      double row[HL_TRIANGLE_MAX] = {0};
      memcpy(row, n->by_motion[i], (size_t)f->n_motion * sizeof *row);
      memcpy(row + f->n_motion, n->by_cause[i], (size_t)f->n_causes * sizeof *row);
      hl_triangle_add(out, row, n->difference[i]);
    }
  }
  return seen;
}

/* T and its degrees of freedom. */
static double misfit(const hl_drift_fit *f, double *dof)
{
  hl_triangle all, causes;
  const int first = f->n_motion, n = f->n_causes;
  const int seen = gather(f, &all);
  const double floor_px2 = least_px * least_px * seen;
  const double rho = sqrt(fmax(all.rest, floor_px2));
  hl_triangle_clear(&causes, n);
  for (int i = 0; i < n; i++) {
    double row[HL_TRIANGLE_MAX] = {0};
    for (int k = 0; k < n; k++)
      row[k] = all.r[first + i][first + k] / rho;
    hl_triangle_add(&causes, row, all.z[first + i] / rho);
  }
  for (int i = 0; i < n; i++) {
    double row[HL_TRIANGLE_MAX] = {0};
    row[i] = 1;
    hl_triangle_add(&causes, row, 0);
  }
  *dof = n - trace_of_inverse(&causes);
  return causes.rest;
}

hl_status hl_drift_unlike(hl_ctx *ctx, const hl_drift_side *reference, const hl_drift_side *current,
                          hl_drift *out)
{
  hl_drift_fit f = {0};
  const hl_status st = hl_drift_fit_open(ctx, reference, current, 0, &f);
  if (st != HL_OK)
    return st;
  double dof, sum = 0;
  int seen = 0;
  const double t = misfit(&f, &dof);
  const double noise_dof = fmin(reference->noise_dof, current->noise_dof);
  for (int k = 0; k < f.n_nodes; k++) {
    const hl_drift_node *n = &f.node[k];
    seen += n->seen;
    for (int i = 0; n->seen && i < 2; i++)
      sum += n->difference[i] * n->difference[i];
  }
  out->significance = hl_significance(t, dof, noise_dof);
  out->drifted = out->significance < out->false_alarm;
  out->n_causes = 1;
  hl_drift_cause *cause = &out->cause[0];
  *cause = (hl_drift_cause){.what = "intrinsics",
                            .part = "projection",
                            .unit = "px",
                            .figure = sqrt(sum / seen),
                            .significance = out->significance,
                            .moved = out->drifted};
  const double limit = hl_significance_limit(out->false_alarm, dof, noise_dof);
  cause->threshold = t > 0 ? cause->figure * sqrt(limit / t) : NAN;
  free(f.node);
  return HL_OK;
}
