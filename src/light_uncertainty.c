/* How sure the direction is.
 *
 * With d_p the model's slope at a pixel after the curves have been profiled out, H = sum w d d' and
 * scores g = sum w r d, the estimate's covariance is the sandwich H^-1 M H^-1 with
 *
 *   M_white = sum over pixels of g_p g_p'      noise that pixels do not share (White 1980)
 *
 * and what light_misfit.c says of the model's share. Where that shows structure, the noise is what second
 * differences of the residual along the frame's rows also show, in which misfit cancels; the rest of
 * M_white is the model's.
 */
#include <math.h>
#include <string.h>

#include "halflight/vec3.h"
#include "light_work.h"

static const double structured_ratio = 2.5;
static const double lit_share = 0.02; /* of level */

void hl_light_invert(const double a[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX], int n,
                     double out[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX])
{
  double l[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX] = {{0}};
  for (int i = 0; i < n; i++)
    for (int j = 0; j <= i; j++) {
      double sum = a[i][j];
      for (int p = 0; p < j; p++)
        sum -= l[i][p] * l[j][p];
      l[i][j] = i == j ? sqrt(fmax(sum, 1e-12 * fabs(a[i][i]) + 1e-300)) : sum / l[j][j];
    }
  for (int c = 0; c < n; c++) {
    double y[HL_NONLINEAR_MAX];
    for (int i = 0; i < n; i++) {
      double sum = i == c;
      for (int p = 0; p < i; p++)
        sum -= l[i][p] * y[p];
      y[i] = sum / l[i][i];
    }
    for (int i = n - 1; i >= 0; i--) {
      double sum = y[i];
      for (int p = i + 1; p < n; p++)
        sum -= l[p][i] * out[p][c];
      out[i][c] = sum / l[i][i];
    }
  }
}

void hl_light_sandwich(double h[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX],
                       double m[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX], int n, double out[2][2])
{
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++) {
      out[i][j] = 0;
      for (int p = 0; p < n; p++)
        for (int q = 0; q < n; q++)
          out[i][j] += h[i][p] * m[p][q] * h[q][j];
    }
}

/* H^-1 M H^-1 of all that is fitted. */
static void sandwich_all(double h[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX],
                         double m[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX], int n,
                         double out[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX])
{
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      out[i][j] = 0;
      for (int p = 0; p < n; p++)
        for (int q = 0; q < n; q++)
          out[i][j] += h[i][p] * m[p][q] * h[q][j];
    }
}

typedef struct sums {
  double within[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX]; /* of scores: by pixels about their cells */
  double h[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX];
  double rr, ww, fit_error, data, mean, variance, residual;
  double lobe, body; /* information on s by the two parts of the slope */
  long samples, lit;
} sums;

/* What the eye would compare: a mirror-like highlight counts no more than the body it lies on. */
static double compressed(double y)
{
  return y / (1 + fabs(y));
}

/* The noise of a pixel: its residual's departure from both neighbours' in the row, of the noise's own
 * variance; without neighbours the residual itself. */
static double departure(const struct hl_light_work *work, const hl_surface *surface, int c, int i)
{
  const hl_light_data *d = &work->all;
  const double *y = d->value[c], *w = d->weight[c];
  const hl_model_pixel *f = work->fit;
  const double r = y[i] - f[i].value;
  if (i == 0 || i + 1 == d->n || !(w[i - 1] > 0 && w[i + 1] > 0) ||
      !hl_light_in_a_row(work, surface, i))
    return hl_light_area(d, i) > 1 ? copysign(sqrt(d->scatter[c][i] / hl_light_area(d, i)), r) : r;
  return (2 * r - (y[i - 1] - f[i - 1].value) - (y[i + 1] - f[i + 1].value)) / sqrt(6.0);
}

static void add_channel(struct hl_light_work *work, const hl_surface *surface,
                        const hl_light_model *model, int c, sums *s)
{
  const hl_light_data *d = &work->all;
  const int q = hl_model_nonlinear(model);
  for (int i = 0; i < d->n; i++) {
    const hl_model_pixel *f = &work->fit[i];
    const double y = d->value[c][i], w = d->weight[c][i];
    work->predicted[i] += (float)((f->value + work->area[c][i]) / d->channels);
    work->measured[i] += (float)((y + work->area[c][i]) / d->channels);
    const bool clipped = d->clipped[i] >> c & 1;
    if (!(w > 0) || (clipped && !(f->value < y)))
      continue;
    const double r = y - f->value, noise = departure(work, surface, c, i);
    const int area = hl_light_area(d, i);
    const double scatter = area > 1 ? d->scatter[c][i] : 0;
    const double apart = w * w * scatter * (area - 1) / ((double)area * area);
    for (int u = 0; u < q; u++) {
      for (int v = 0; area > 1 && v < q; v++)
        s->within[u][v] += apart * f->profiled[u] * f->profiled[v];
      work->score[i][u] += w * r * f->profiled[u];
      work->noise[i][u] += w * noise * f->profiled[u];
      for (int v = 0; v < q; v++)
        s->h[u][v] += w * f->profiled[u] * f->profiled[v];
    }
    s->rr += area * r * r + (area - 1) * scatter;
    s->samples += area;
    if (!clipped) {
      const double t = compressed(y), difference = t - compressed(f->value);
      s->mean += area * t;
      s->variance += area * t * t;
      s->residual += area * difference * difference;
      s->ww += area;
    }
    if (y > lit_share) {
      s->fit_error += area * fabs(r);
      s->data += area * y;
      s->lit += area;
    }
  }
}

/* Share of the information that the lobe brings: the fit's own slopes without the body's columns.
 */
static double highlight_share(struct hl_light_work *work, const hl_light_model *model)
{
  const hl_light_data *d = &work->all;
  if (!model->has_lobe)
    return 0;
  enum { CHUNK = 64 };
  double lobe = 0, body = 0;
  hl_model_point *without = &work->model.trial;
  *without = work->best.at;
  for (int c = 0; c < d->channels; c++)
    for (int j = 0; j < model->body; j++)
      without->x[c][model->spline.n + j] = 0;
  for (int c = 0; c < d->channels; c++)
    for (int first = 0; first < d->n; first += CHUNK) {
      hl_model_pixel all[CHUNK], part[CHUNK];
      const int count = d->n - first < CHUNK ? d->n - first : CHUNK;
      hl_model_predict(model, d, &work->best.at, NULL, first, count, c, all);
      hl_model_predict(model, d, without, NULL, first, count, c, part);
      for (int i = 0; i < count; i++)
        for (int k = 0; k < 2; k++) {
          const double w = d->weight[c][first + i], rest = all[i].slope[k] - part[i].slope[k];
          lobe += w * part[i].slope[k] * part[i].slope[k];
          body += w * rest * rest;
        }
    }
  return lobe + body > 0 ? lobe / (lobe + body) : 0;
}

/* Of single pixels: a cell's score, were it shared by all of its pixels, is as many times smaller, and to
 * it comes what is within cells. */
static void pixel_products(const hl_light_data *d, double (*score)[HL_NONLINEAR_MAX], const sums *s,
                           int q, double m[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX])
{
  for (int i = 0; i < d->n; i++)
    for (int u = 0; u < q; u++)
      for (int v = 0; v < q; v++)
        m[u][v] += score[i][u] * score[i][v] / hl_light_area(d, i);
  for (int u = 0; u < q; u++)
    for (int v = 0; v < q; v++)
      m[u][v] += s->within[u][v];
}

/* The pixels' own spread into noise and the rest; the noise is cut to what leaves the rest a covariance. */
static void split(double all[2][2], double noise[2][2], hl_light_spread *out)
{
  const double share = 1 / fmax(hl_light_relative_size(noise, all), 1);
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++) {
      out->noise[u][v] = share * noise[u][v];
      out->model[u][v] += all[u][v] - share * noise[u][v];
    }
}

void hl_light_uncertainty(struct hl_light_work *work, const hl_surface *surface,
                          const hl_light_model *model, const hl_light_settled *settled, int threads,
                          hl_light_spread *out)
{
  const hl_light_data *d = &work->all;
  const int q = hl_model_nonlinear(model);
  const size_t n = (size_t)d->n;
  double white[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX] = {{0}};
  double tiles[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX] = {{0}};
  double noise[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX] = {{0}};
  double by_pixel[2][2], by_noise[2][2];
  sums s;
  memset(&s, 0, sizeof s);
  memset(work->score, 0, n * sizeof *work->score);
  memset(work->noise, 0, n * sizeof *work->noise);
  memset(work->predicted, 0, n * sizeof *work->predicted);
  memset(work->measured, 0, n * sizeof *work->measured);
  hl_model_differentiate(model, d, &work->best.at, threads, &work->model, &work->best.step);
  for (int c = 0; c < d->channels; c++) {
    hl_model_predict(model, d, &work->best.at, work->best.step.solved, 0, d->n, c, work->fit);
    add_channel(work, surface, model, c, &s);
  }
  pixel_products(d, work->score, &s, q, white);
  pixel_products(d, work->noise, &s, q, noise);
  memset(out, 0, sizeof *out);
  hl_light_invert((const double(*)[HL_NONLINEAR_MAX])s.h, q, out->inverse);
  hl_light_sandwich(out->inverse, white, q, by_pixel);
  hl_light_misfit(work, surface, settled, q, by_pixel, tiles, out);
  const bool structured = out->structure > structured_ratio;
  memcpy(out->noise, by_pixel, sizeof out->noise);
  sandwich_all(out->inverse, structured ? tiles : white, q, out->joint);
  if (structured) {
    hl_light_sandwich(out->inverse, noise, q, by_noise);
    split(by_pixel, by_noise, out);
  }
  const double half = 0.5 * (s.h[0][0] + s.h[1][1]);
  const double root = sqrt(fmax(0, half * half - s.h[0][0] * s.h[1][1] + s.h[0][1] * s.h[0][1]));
  out->condition = half - root > 0 ? (half + root) / (half - root) : HUGE_VAL;
  out->highlight_share = highlight_share(work, model);
  const double level = work->brightness.level;
  out->rms = s.samples > 0 ? level * sqrt(s.rr / (double)s.samples) : 0;
  out->relative_error = s.data > 0 ? s.fit_error / s.data : 1;
  const double variance = s.variance - s.mean * s.mean / fmax(s.ww, 1);
  out->explained = variance > 0 ? 1 - s.residual / variance : 0;
}
