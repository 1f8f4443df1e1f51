/* The least covariance that an estimator with free curves can reach on this frame.
 *
 * With the curves as nuisance parameters, D the slopes along the two tangents (and the masking's
 * exponent, where it is fitted), X the curves' rows and W = 1/variance of the pixels' own noise, the
 * semiparametric Cramer-Rao bound is the direction's corner of
 *
 *   (D' W P D)^-1,   P = I - X (X' W X)^-1 X' W      (Bickel et al. 1993, section 3.1, eq. 3.1.2)
 *
 * at the fitted point, the curves being the splines at hand. The noise of a channel is taken as
 * variance = a + b y, sensor and photons, fitted to departures of the residual from its neighbours'
 * in the row, in which misfit that changes slowly cancels. The fit's own weights are others: they
 * allow for model error. Efficiency is the bound's area over that of the stated noise alone.
 */
#include <math.h>

#include "light_work.h"

enum { ROUNDS = 4 };
static const double cap = 12;               /* of squares, in variances: a deviation of 3.5 */
static const double least_share = 0.02;     /* of the mean variance */
static const double least_variance = 1e-18; /* of the level: a frame without noise */

/* Squared departure of the residual from both neighbours', of the noise's own variance. */
static double departure2(const hl_light_data *d, const hl_model_pixel *f, int c, int i)
{
  const double *y = d->value[c];
  const double bend =
      2 * (y[i] - f[i].value) - (y[i - 1] - f[i - 1].value) - (y[i + 1] - f[i + 1].value);
  return bend * bend / 6;
}

static bool counts(const struct hl_light_work *work, const hl_surface *surface, int c, int i)
{
  const double *w = work->all.weight[c];
  return w[i - 1] > 0 && w[i] > 0 && w[i + 1] > 0 && hl_light_in_a_row(work, surface, i);
}

/* variance = max(a + b y, least) */
typedef struct noise_of_channel {
  double a, b, least;
} noise_of_channel;

static double variance_at(const noise_of_channel *noise, double y)
{
  return fmax(noise->a + noise->b * fmax(y, 0), noise->least);
}

/* Weighted least squares of the squares on (1, y), weights 1/variance^2 of the last round; where a
 * part comes out negative the other stands alone. The fit of the channel is in work->fit. */
static void noise_law(const struct hl_light_work *work, const hl_surface *surface, int c,
                      noise_of_channel *out)
{
  const hl_light_data *d = &work->all;
  double *a = &out->a, *b = &out->b;
  *a = *b = out->least = 0;
  for (int round = 0; round < ROUNDS; round++) {
    double n = 0, y1 = 0, y2 = 0, q = 0, qy = 0;
    for (int i = 1; i + 1 < d->n; i++) {
      const int area = hl_light_area(d, i);
      if (area == 1 ? !counts(work, surface, c, i) : !(d->weight[c][i] > 0))
        continue;
      const double y = fmax(work->fit[i].value, 0);
      const double variance = round == 0 ? 1 : variance_at(out, y);
      const double square = fmin(area > 1 ? d->scatter[c][i] : departure2(d, work->fit, c, i),
                                 round == 0 ? HUGE_VAL : cap * variance);
      const double w = area / (variance * variance);
      n += w;
      y1 += w * y;
      y2 += w * y * y;
      q += w * square;
      qy += w * y * square;
    }
    const double det = n * y2 - y1 * y1;
    if (round == 0 || !(det > 1e-9 * n * y2)) {
      *a = n > 0 ? q / n : 0;
      *b = 0;
      out->least = round == 0 ? fmax(least_share * *a, least_variance) : out->least;
      continue;
    }
    *a = (y2 * q - y1 * qy) / det;
    *b = (n * qy - y1 * q) / det;
    if (*b < 0) {
      *a = q / n;
      *b = 0;
    } else if (*a < 0) {
      *a = 0;
      *b = qy / y2;
    }
  }
}

static double area(double m[2][2])
{
  return sqrt(fmax(0, m[0][0] * m[1][1] - m[0][1] * m[1][0]));
}

void hl_light_noise_weights(struct hl_light_work *work, const hl_light_model *model,
                            const hl_surface *surface)
{
  hl_light_data *d = &work->all;
  for (int c = 0; c < d->channels; c++) {
    noise_of_channel noise;
    hl_model_predict(model, d, &work->best.at, NULL, 0, d->n, c, work->fit);
    noise_law(work, surface, c, &noise);
    for (int i = 0; i < d->n; i++)
      if (d->weight[c][i] > 0)
        d->weight[c][i] = hl_light_area(d, i) / variance_at(&noise, work->fit[i].value);
  }
}

void hl_light_bound(struct hl_light_work *work, const hl_light_model *model,
                    const hl_surface *surface, int threads, hl_light *out)
{
  hl_model_step step;
  double inverse[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX];
  hl_light_noise_weights(work, model, surface);
  hl_model_point *at = &work->model.trial; /* its normal equations are those of the new weights */
  if (hl_model_fit(model, &work->all, work->best.at.s, work->best.at.exponent, threads,
                   &work->model, at) != 0)
    return;
  hl_model_differentiate(model, &work->all, at, threads, &work->model, &step);
  hl_light_invert((const double(*)[HL_NONLINEAR_MAX])step.hessian, hl_model_nonlinear(model),
                  inverse);
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++)
      out->bound_rad2[u][v] = inverse[u][v];
  const double stated = area(out->part_rad2[HL_PART_NOISE]);
  out->efficiency = stated > 0 ? fmin(area(out->bound_rad2) / stated, 1) : 0;
}
