/* Where searches begin: fits settled on the coarse samples, kept in the order of their costs. */
#include <math.h>

#include "fit_work.h"
#include "halflight/vec3.h"

static const double tolerance_rad = 1e-3;
static const double pi = 3.14159265358979323846;

bool hl_fit_may(const hl_fit_work *w, bool foreshortened)
{
  if (w->log_domain) /* there the factor belongs to the product, not to a term */
    return !foreshortened;
  return w->lobe == HL_LOBE_AUTO || (w->lobe == HL_LOBE_FORESHORTENED) == foreshortened;
}

void hl_fit_refine_coarse(hl_fit_work *w, int iterations, hl_ridge_fit *fit)
{
  hl_axes_settle(&fit->axes, w->all.mean_view);
  hl_ridge_refine(&w->coarse, iterations, tolerance_rad, 1, &w->refine, fit);
}

static double start_cost(const hl_fit_work *w, int place)
{
  return w->start[w->order[place]].curves.cost;
}

void hl_fit_add_start(hl_fit_work *w)
{
  hl_axes_settle(&w->trial.axes, w->all.mean_view);
  hl_ridge_settle(&w->coarse, false, 1, &w->refine, &w->trial);
  const double cost = w->trial.curves.cost;
  int place = w->n_starts;
  if (place < HL_FIT_STARTS_MAX)
    w->order[place] = w->n_starts++;
  else if (!(cost < start_cost(w, --place))) /* else the worst gives way */
    return;
  const int slot = w->order[place];
  for (; place > 0 && cost < start_cost(w, place - 1); place--)
    w->order[place] = w->order[place - 1];
  w->order[place] = slot;
  w->start[slot] = w->trial;
}

void hl_fit_light_of(const hl_fit_work *w, int i, int n, double out[3])
{
  double u[3], v[3];
  const double *axis = w->all.mean_view;
  const double z = 1 - 1.3 * (i + 0.5) / n, r = sqrt(fmax(0, 1 - z * z));
  const double turn = pi * (1 + sqrt(5.0)) * (i + 0.5);
  hl_tangent_basis(axis, u, v);
  for (int k = 0; k < 3; k++)
    out[k] = r * cos(turn) * u[k] + r * sin(turn) * v[k] + z * axis[k];
}

void hl_fit_brightest_light(const hl_fit_work *w, bool mirrored, double out[3])
{
  const hl_ridge_data *d = &w->coarse;
  double most = -HUGE_VAL;
  for (int i = 0; i < d->n; i++) {
    double sum = 0;
    for (int c = 0; c < d->channels; c++)
      sum += d->y[c][i];
    if (!(sum > most))
      continue;
    most = sum;
    for (int k = 0; k < 3; k++)
      out[k] = d->normal[k][i];
  }
  const double nv = hl_dot(out, d->mean_view);
  for (int k = 0; k < 3 && mirrored; k++)
    out[k] = 2 * nv * out[k] - d->mean_view[k];
}
