/* Gauss-Newton on the direction of light, the curves profiled out.
 *
 *   delta = -H^-1 g'  in the tangent plane of s,   s <- (s + T delta)/|s + T delta|
 *
 * with H = D'W(I - X A^-1 X'W)D and g' = -D'W r. A step that does not lower the cost is shortened;
 * H gains a little of its own trace where it is nearly singular (light at the view, matte ball).
 */
#include "light_refine.h"

#include <math.h>
#include <string.h>

#include "halflight/vec3.h"

enum { HALVINGS = 8 };
static const double longest_step_rad = 0.2;
static const double longest_exponent_step = 0.5, longest_nearness_step = 0.1;
/* At 1 the light would touch the ball. */
static const double largest_nearness = 0.8;

/* Cholesky of the damped system; the direction's part is limited in length. */
static void gauss_newton_step(const hl_light_model *model, const hl_model_step *q, double *delta)
{
  const int n = hl_model_nonlinear(model);
  double l[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX];
  const double damp = 1e-9 * (q->hessian[0][0] + q->hessian[1][1]) + 1e-300;
  for (int i = 0; i < n; i++) {
    delta[i] = q->gradient[i];
    for (int j = 0; j <= i; j++) {
      double sum = q->hessian[i][j] + (i == j ? damp : 0);
      for (int p = 0; p < j; p++)
        sum -= l[i][p] * l[j][p];
      if (i > j)
        l[i][j] = sum / l[j][j];
      else
        l[i][i] = sqrt(fmax(sum, 1e-14 * fabs(q->hessian[i][i]) + 1e-300));
    }
    for (int p = 0; p < i; p++)
      delta[i] -= l[i][p] * delta[p];
    delta[i] /= l[i][i];
  }
  for (int i = n - 1; i >= 0; i--) {
    for (int p = i + 1; p < n; p++)
      delta[i] -= l[p][i] * delta[p];
    delta[i] /= l[i][i];
  }
  const double length = hypot(delta[0], delta[1]);
  double k = length > longest_step_rad ? longest_step_rad / length : 1;
  if (model->masking && fabs(delta[2]) * k > longest_exponent_step)
    k = longest_exponent_step / fabs(delta[2]);
  const double nearer = model->near ? fabs(delta[hl_model_nearness(model)]) : 0;
  if (nearer * k > longest_nearness_step)
    k = longest_nearness_step / nearer;
  for (int i = 0; i < n; i++)
    delta[i] *= k;
}

/* A step of less than a hundredth of the standard deviation that the residual itself implies. */
static bool is_negligible(const hl_model_step *q, int n, const double *delta, int samples)
{
  double sum = 0;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++)
      sum += delta[i] * q->hessian[i][j] * delta[j];
  return sum < 1e-4 * q->cost / samples;
}

/* The point after the largest fraction of delta that does not raise the cost; false: there is none.
 */
static bool descend(const hl_light_model *model, const hl_light_data *data,
                    const hl_model_point *at, double *delta, double tolerance_rad, int threads,
                    hl_model_work *work, hl_model_point *trial)
{
  for (int halving = 0; halving < HALVINGS; halving++) {
    double s[3];
    hl_add_scaled(at->s, delta[0], at->t[0], s);
    hl_add_scaled(s, delta[1], at->t[1], s);
    hl_unit(s, s);
    const double exponent = model->masking ? at->exponent + delta[2] : 0;
    double nearness = model->near ? at->nearness + delta[hl_model_nearness(model)] : 0;
    nearness = nearness < largest_nearness ? nearness : largest_nearness;
    if (hl_model_fit_near(model, data, s, exponent, nearness, threads, work, trial) == 0 &&
        trial->cost <= at->cost)
      return true;
    if (hypot(delta[0], delta[1]) < tolerance_rad)
      break;
    for (int i = 0; i < hl_model_nonlinear(model); i++)
      delta[i] *= 0.5;
  }
  return false;
}

int hl_light_refine(const hl_light_model *model, const hl_light_data *data, int max_iterations,
                    double tolerance_rad, int threads, hl_model_work *work, hl_refined *out)
{
  double start[3];
  memcpy(start, out->at.s, sizeof start);
  out->iterations = 0;
  out->converged = false;
  work->keep_smoothing = false;
  if (hl_model_fit_near(model, data, start, model->masking ? out->at.exponent : 0,
                        model->near ? out->at.nearness : 0, threads, work, &out->at) != 0)
    return -1;
  work->keep_smoothing = true;
  while (out->iterations < max_iterations && !out->converged) {
    double delta[HL_NONLINEAR_MAX] = {0};
    out->iterations++;
    hl_model_differentiate(model, data, &out->at, threads, work, &out->step);
    gauss_newton_step(model, &out->step, delta);
    const bool negligible =
        is_negligible(&out->step, hl_model_nonlinear(model), delta, hl_light_pixels(data));
    const bool lower =
        descend(model, data, &out->at, delta, tolerance_rad, threads, work, &work->trial);
    out->converged = hypot(delta[0], delta[1]) < tolerance_rad || negligible;
    if (!lower)
      break;
    out->at = work->trial;
  }
  work->keep_smoothing = false;
  return 0;
}

void hl_light_breaks(const hl_light_data *data, const double s[3], int count, int least,
                     hl_spline *spline)
{
  enum { MOST = HL_SPLINE_MAX - 2 };
  int samples[MOST] = {0};
  double breaks[MOST + 1];
  const double top = sqrt(2.0);
  count = count > MOST - 1 ? MOST - 1 : count;
  for (int i = 0; i < data->n; i++) {
    double h[3], d = 0, nl = 0;
    for (int k = 0; k < 3; k++) {
      h[k] = s[k] + data->view[k][i];
      nl += s[k] * data->normal[k][i];
    }
    hl_unit(h, h);
    if (!(nl > 0))
      continue;
    for (int k = 0; k < 3; k++)
      d += (data->normal[k][i] - h[k]) * (data->normal[k][i] - h[k]);
    const double share = sqrt(sqrt(d) / top); /* breaks are quadratic in their index */
    const int j = (int)(share * count);
    samples[j < count ? j : count - 1]++;
  }
  for (int j = 0; j <= count; j++) {
    const double share = (double)j / count;
    breaks[j] = top * share * share;
  }
  hl_spline_init(spline, breaks, hl_spline_thin(breaks, samples, count, least, breaks));
}
