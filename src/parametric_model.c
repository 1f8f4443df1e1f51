/* Variable projection with one nonlinear unknown, mu = exp(p).
 *
 * Both models are y_c = kd_c D + ks_c exp(-mu x) with D = n.s, x = angle(n,h)^2 (Torrance-Sparrow) or
 * x = -log(n.h) (Blinn-Phong). At given mu the columns X = [D, exp(-mu x)] are linear unknowns', a 2 x 2
 * problem a channel, with neither below 0. With P the projection off the columns that are not held at
 * 0, the residual r = X k - y changes, after Kaufman (1975), by
 *
 *   dr/dp = P (ks dE/dp),   dE/dp = -mu x exp(-mu x),
 *
 * which leaves out a part within the span of X: r is orthogonal to that, so J'r is the gradient.
 */
#include "parametric_model.h"

#include <math.h>

static double mu_of(double p)
{
  return fmin(fmax(exp(p), hl_parametric_least), hl_parametric_most);
}

/* D.D, D.E, E.E and with another column z: D.z, E.z */
typedef struct products {
  double dd, de, ee, dz, ez;
} products;

static products multiply(const hl_parametric *m, const double *z)
{
  products sum = {0};
  for (int i = 0; i < m->n; i++) {
    const double d = m->body[i], e = m->lobe[i];
    sum.dd += d * d;
    sum.de += d * e;
    sum.ee += e * e;
    sum.dz += d * z[i];
    sum.ez += e * z[i];
  }
  return sum;
}

/* The parts of z along the free columns. */
static void project(const products *s, bool body, bool lobe, double *along_d, double *along_e)
{
  const double determinant = s->dd * s->ee - s->de * s->de;
  *along_d = *along_e = 0;
  if (body && lobe && determinant > 1e-14 * s->dd * s->ee) {
    *along_d = (s->ee * s->dz - s->de * s->ez) / determinant;
    *along_e = (s->dd * s->ez - s->de * s->dz) / determinant;
  } else if (lobe && s->ee > 0) {
    *along_e = s->ez / s->ee;
  } else if (body && s->dd > 0) {
    *along_d = s->dz / s->dd;
  }
}

static double residual_at(const hl_parametric *m, int c, int i)
{
  return m->kd[c] * m->body[i] + m->ks[c] * m->lobe[i] - m->value[c][i];
}

double hl_parametric_solve(hl_parametric *m, double p)
{
  const double mu = mu_of(p);
  double total = 0;
  for (int i = 0; i < m->n; i++)
    m->lobe[i] = exp(-mu * m->abscissa[i]);
  for (int c = 0; c < m->channels; c++) {
    const products s = multiply(m, m->value[c]);
    project(&s, true, true, &m->kd[c], &m->ks[c]);
    /* columns and values are not negative, so neither is a coefficient that is alone */
    if (m->kd[c] < 0)
      project(&s, false, true, &m->kd[c], &m->ks[c]);
    else if (m->ks[c] < 0)
      project(&s, true, false, &m->kd[c], &m->ks[c]);
    m->square[c] = 0;
    for (int i = 0; i < m->n; i++)
      m->square[c] += residual_at(m, c, i) * residual_at(m, c, i);
    total += m->square[c];
  }
  return total;
}

void hl_parametric_residuals(hl_parametric *m, double p, double *residual)
{
  (void)hl_parametric_solve(m, p);
  for (int c = 0; c < m->channels; c++)
    for (int i = 0; i < m->n; i++)
      residual[(size_t)c * (size_t)m->n + (size_t)i] = residual_at(m, c, i);
}

void hl_parametric_slopes(hl_parametric *m, double p, double *slope)
{
  const double mu = mu_of(p);
  const bool free_mu = exp(p) == mu;
  (void)hl_parametric_solve(m, p);
  for (int c = 0; c < m->channels; c++) {
    double *z = slope + (size_t)c * (size_t)m->n, along_d, along_e;
    for (int i = 0; i < m->n; i++) {
      const double steep = m->lobe[i] > 0 ? mu * m->abscissa[i] * m->lobe[i] : 0;
      z[i] = free_mu ? -m->ks[c] * steep : 0;
    }
    const products s = multiply(m, z);
    project(&s, m->kd[c] > 0, m->ks[c] > 0, &along_d, &along_e);
    for (int i = 0; i < m->n; i++)
      z[i] -= along_d * m->body[i] + along_e * m->lobe[i];
  }
}
