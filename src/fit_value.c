/* What a fit says at a normal, from its tables of curves. */
#include <math.h>

#include "halflight/fit.h"
#include "halflight/vec3.h"

double hl_term_value(const hl_term *term, int channel, double t)
{
  const double *x = term->t, *y = term->value[channel];
  int low = 0, high = term->n - 1;
  if (term->n < 1)
    return 0;
  if (!(t > x[low]))
    return y[low];
  if (t >= x[high])
    return y[high];
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    if (t >= x[middle])
      low = middle;
    else
      high = middle;
  }
  return y[low] + (y[high] - y[low]) * (t - x[low]) / (x[high] - x[low]);
}

double hl_term_argument(const hl_fit *fit, const hl_term *term, const double n[3],
                        const double v[3])
{
  double a[3];
  if (!(fit->has_light && term->in_plane))
    return hl_dot(term->direction, n);
  for (int k = 0; k < 3; k++)
    a[k] = term->cs * fit->light[k] + term->cv * v[k];
  hl_unit(a, a);
  return hl_dot(a, n);
}

void hl_fit_at(const hl_fit *fit, const double n[3], const double v[3], double out[HL_CHANNELS_MAX])
{
  const double nv = hl_dot(n, v);
  double sum[HL_CHANNELS_MAX] = {0}, factor = 1;
  for (int i = 0; i < fit->n_terms; i++) {
    const hl_term *term = &fit->term[i];
    const double t = hl_term_argument(fit, term, n, v);
    const double g = term->foreshortened ? 1 / nv : 1;
    factor *= g;
    for (int c = 0; c < fit->channels; c++)
      sum[c] += (fit->log_domain ? 1 : g) * hl_term_value(term, c, t);
  }
  for (int c = 0; c < fit->channels; c++)
    out[c] = fit->log_domain ? factor * exp(sum[c]) : sum[c];
}
