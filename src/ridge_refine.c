/* Joint refinement of all directions: variable projection.
 *
 * For given directions the curves follow (ridge_curves.c), so the cost is a function of the directions
 * alone. Its gradient is -2 D'W r, also where curves are held at their bounds, and its Gauss-Newton
 * matrix D'WD - (X'WD)'A^-1(X'WD) over the unknowns that are free (Golub and Pereyra 1973, Kaufman
 * 1975). Steps are damped after Levenberg and Marquardt:
 *   (H + mu diag H) delta = D'W r.
 */
#include "ridge_refine.h"

#include <math.h>
#include <string.h>

#include "cholesky.h"

enum { TRIALS = 8 };
static const double longest_step_rad = 0.3;
static const double negligible = 1e-4;
static const double rounding = 1e-13; /* of the data's square: what a cost from sums may be off */

void hl_ridge_settle(const hl_ridge_data *data, bool smooth, int threads, hl_refine_work *work,
                     hl_ridge_fit *fit)
{
  hl_roughness roughness;
  hl_ridges_gram(&fit->ridges, &fit->axes, data, threads, &work->ridge, &work->gram);
  if (smooth)
    hl_curves_smooth(&fit->ridges, &work->gram, data->n, &work->curves, &fit->curves);
  hl_roughness_from(&fit->ridges, &work->gram, &roughness);
  hl_curves_solve(&fit->ridges, &work->gram, &roughness, &work->curves, &fit->curves);
}

/* Longest change of one parameter. */
static double length_of(const double *delta, int q)
{
  double most = 0;
  for (int k = 0; k < q; k++)
    most = fmax(most, fabs(delta[k]));
  return most;
}

static void damped_step(const hl_ridge_fit *fit, const double *gradient, int q, double mu,
                        double *delta)
{
  double u[HL_AXES_MAX * HL_AXES_MAX], trace = 0;
  for (int k = 0; k < q; k++)
    trace += fabs(fit->hessian[k][k]) / q;
  for (int k = 0; k < q; k++) {
    for (int l = k; l < q; l++)
      u[k * q + l] = fit->hessian[k][l];
    u[k * q + k] += mu * fabs(fit->hessian[k][k]) + 1e-12 * trace + 1e-300;
    delta[k] = gradient[k];
  }
  hl_cholesky(u, q, q, 1e-10);
  hl_cholesky_solve(u, q, q, delta);
  const double length = length_of(delta, q);
  for (int k = 0; k < q && length > longest_step_rad; k++)
    delta[k] *= longest_step_rad / length;
}

/* A step that lowers the cost by a hundred-thousandth: what is left then is the next step's, smaller
 * still. */
static bool is_negligible(const hl_ridge_fit *fit, const hl_ridge_slopes *s, const double *delta)
{
  double sum = 0;
  for (int k = 0; k < s->q; k++)
    for (int l = 0; l < s->q; l++)
      sum += delta[k] * fit->hessian[k][l] * delta[l];
  return sum < negligible * s->cost;
}

void hl_ridge_refine(const hl_ridge_data *data, int max_iterations, double tolerance_rad,
                     int threads, hl_refine_work *work, hl_ridge_fit *fit)
{
  hl_roughness roughness;
  const int q = hl_axes_parameters(&fit->axes);
  double mu = 1e-4;
  hl_ridges_gram(&fit->ridges, &fit->axes, data, threads, &work->ridge, &work->gram);
  hl_roughness_from(&fit->ridges, &work->gram, &roughness);
  hl_curves_solve(&fit->ridges, &work->gram, &roughness, &work->curves, &fit->curves);
  double scale = 0;
  for (int c = 0; c < data->channels; c++)
    scale += work->gram.yy[c];
  fit->iterations = 0;
  fit->converged = q == 0;
  while (fit->iterations < max_iterations && !fit->converged) {
    double delta[HL_AXES_MAX];
    bool lower = false;
    fit->iterations++;
    hl_ridges_slopes(&fit->ridges, &fit->axes, data, fit->curves.x, threads, &work->ridge,
                     &work->slopes);
    hl_curves_profile(&fit->ridges, &fit->curves, &work->curves, data->channels, &work->slopes,
                      fit->hessian);
    for (int trial = 0; trial < TRIALS && !lower; trial++) {
      hl_axes moved;
      damped_step(fit, work->slopes.gradient, q, mu, delta);
      hl_axes_move(&fit->axes, delta, data->mean_view, &moved);
      work->trial = fit->curves;
      hl_ridges_gram(&fit->ridges, &moved, data, threads, &work->ridge, &work->gram);
      hl_curves_solve(&fit->ridges, &work->gram, &roughness, &work->curves, &work->trial);
      lower = work->trial.cost <= fit->curves.cost + rounding * scale;
      fit->converged =
          length_of(delta, q) < tolerance_rad || is_negligible(fit, &work->slopes, delta);
      if (lower) {
        fit->axes = moved;
        fit->curves = work->trial;
        mu = fmax(1e-9, 0.1 * mu);
      } else {
        if (fit->converged)
          break;
        mu = 10 * fmax(mu, 1e-4);
      }
    }
    if (!lower)
      break;
  }
  fit->misfit = fit->curves.misfit;
}
