/* How sure the direction is.
 *
 * With d_p the model's slope at a pixel after the curves have been profiled out, H = sum w d d' and
 * scores g = sum w r d, the estimate's covariance is the sandwich H^-1 M H^-1:
 *
 *   M_white = sum over pixels of g_p g_p'      noise that pixels do not share (White 1980)
 *   M_tiles = sum over tiles of g_t g_t'       residuals that neighbours share: model error
 *
 * Where the model holds, both agree within their own scatter and the white one is the better
 * number. Where the tiles say `structured_ratio` times more, the residual has structure across the
 * ball and the tiles' is taken, and to it is added what the answer moves by between defensible
 * models (plain and foreshortened, with and without the bends, relative and even weights): a bias
 * that no residual of one model shows. It lies along the plane of light and view almost entirely,
 * because a mirror image about that plane is common to all isotropic reflectance.
 *
 * Of it the noise is what second differences of the residual along the frame's rows also show, in which
 * misfit cancels; the rest is the model's.
 */
#include <math.h>
#include <string.h>

#include "halflight/vec3.h"
#include "light_work.h"

enum { TILES_ACROSS = 64 };
static const double structured_ratio = 2.5;
static const double thinned_share = 0.9;
static const double lit_share = 0.02; /* of level */
static const double defensible_ratio = 0.25, coarse_weight = 0.5;

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

/* Corner of H^-1 M H^-1 that belongs to the direction. */
static void sandwich(double h[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX],
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

/* Largest eigenvalue of a relative to b, both 2 x 2 symmetric. */
static double relative_size(double a[2][2], double b[2][2])
{
  const double det = b[0][0] * b[1][1] - b[0][1] * b[1][0];
  if (!(det > 0))
    return 1;
  const double p = (b[1][1] * a[0][0] - b[0][1] * a[1][0]) / det;
  const double q = (b[1][1] * a[0][1] - b[0][1] * a[1][1]) / det;
  const double r = (b[0][0] * a[1][0] - b[1][0] * a[0][0]) / det;
  const double s = (b[0][0] * a[1][1] - b[1][0] * a[0][1]) / det;
  const double half = 0.5 * (p + s);
  return half + sqrt(fmax(0, half * half - (p * s - q * r)));
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

/* Scores summed over square tiles of the surface's bounding box, then their outer products. */
static void tile_products(const struct hl_light_work *work, const hl_surface *surface, int q,
                          double m[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX])
{
  double tile[HL_TILES_MAX][HL_NONLINEAR_MAX] = {{0}};
  const int x0 = work->box.x0, x1 = work->box.x1, y0 = work->box.y0, y1 = work->box.y1;
  const int span = (x1 - x0 > y1 - y0 ? x1 - x0 : y1 - y0) + 1;
  /* some 24 tiles across the ball, and never more than the table holds */
  int side = span / 24 > 4 ? span / 24 : 4;
  while (span / side + 1 > TILES_ACROSS)
    side++;
  for (int p = 0; p < work->all.n; p++) {
    const int pixel = surface->pixel[work->index[p]];
    const int x = (pixel % surface->width - x0) / side, y = (pixel / surface->width - y0) / side;
    for (int u = 0; u < q; u++)
      tile[y * TILES_ACROSS + x][u] += work->score[p][u];
  }
  for (int t = 0; t < HL_TILES_MAX; t++)
    for (int u = 0; u < q; u++)
      for (int v = 0; v < q; v++)
        m[u][v] += tile[t][u] * tile[t][v];
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

/* All of it into noise and the rest; the noise is cut to what leaves the rest a covariance. */
static void split(double all[2][2], double noise[2][2], hl_light_spread *out)
{
  const double share = 1 / fmax(relative_size(noise, all), 1);
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++) {
      out->noise[u][v] = share * noise[u][v];
      out->model[u][v] = all[u][v] - share * noise[u][v];
    }
}

/* Adds what the answer moves by between defensible models, as a covariance in the tangents: each weighs
 * the less the worse it fits, and so does the answer under relative weights, which is half a model.
 */
static void model_share(const struct hl_light_work *work, const hl_light_settled *settled,
                        double ratio, bool weights, double out[2][2])
{
  const hl_model_point *at = &work->best.at;
  const double cost = settled->variant[settled->kept].cost;
  double total = 1, sum[2][2] = {{0}};
  for (int i = HL_VARIANT_MATTE; i < HL_VARIANTS + weights; i++) {
    const bool coarse = i == HL_VARIANTS;
    const double *s = coarse ? settled->coarse_s : settled->variant[i].s;
    if (!coarse && (i == (int)settled->kept || !isfinite(settled->variant[i].cost)))
      continue;
    const double weight =
        coarse ? coarse_weight : exp(-fmax(0, settled->variant[i].cost / cost - 1) / ratio);
    double moved[3];
    hl_add_scaled(s, -1, settled->compared_s, moved);
    const double delta[2] = {hl_dot(moved, at->t[0]), hl_dot(moved, at->t[1])};
    for (int u = 0; u < 2; u++)
      for (int v = 0; v < 2; v++)
        sum[u][v] += weight * delta[u] * delta[v];
    total += weight;
  }
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++)
      out[u][v] += sum[u][v] / total;
}

/* Chi-square that chance exceeds once in 1000 (Wilson and Hilferty). */
static double rare_chi2(int freedom)
{
  const double q = 2 / (9.0 * freedom);
  return freedom * pow(1 - q + 3.09 * sqrt(q), 3);
}

/* Bends that the noise alone would not ask for, yet too slight to be kept: what the answer would move by
 * with them. */
static void slight_bends(const struct hl_light_work *work, const hl_light_settled *settled,
                         double out[2][2])
{
  const hl_light_variant *kept = &settled->variant[settled->kept];
  if (!kept->model.has_lobe || kept->model.masking)
    return;
  const hl_light_variant *bent =
      &settled->variant[kept->model.lobe == HL_LOBE_PLAIN ? HL_VARIANT_PLAIN_BENT
                                                          : HL_VARIANT_FORESHORTENED_BENT];
  const int channels = work->all.channels;
  if (!isfinite(bent->cost) ||
      !(settled->bent_gain * work->all.n * channels > rare_chi2(1 + 2 * channels)))
    return;
  double moved[3];
  hl_add_scaled(bent->s, -1, settled->compared_s, moved);
  const double delta[2] = {hl_dot(moved, work->best.at.t[0]), hl_dot(moved, work->best.at.t[1])};
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++)
      out[u][v] += delta[u] * delta[v];
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
  double by_pixel[2][2], by_tile[2][2], by_noise[2][2];
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
  tile_products(work, surface, q, tiles);
  memset(out, 0, sizeof *out);
  hl_light_invert((const double(*)[HL_NONLINEAR_MAX])s.h, q, out->inverse);
  sandwich(out->inverse, white, q, by_pixel);
  sandwich(out->inverse, tiles, q, by_tile);
  out->structure = relative_size(by_tile, by_pixel);
  memcpy(out->noise, by_pixel, sizeof out->noise);
  sandwich_all(out->inverse, out->structure > structured_ratio ? tiles : white, q, out->joint);
  if (out->structure > structured_ratio) {
    sandwich(out->inverse, noise, q, by_noise);
    split(by_tile, by_noise, out);
    model_share(work, settled, defensible_ratio, true, out->model);
  } else if (hl_light_effective(d) < thinned_share * hl_light_pixels(d)) {
    /* what was left out might have told apart what noise alone leaves alike: by likelihood */
    model_share(work, settled, 2 / hl_light_effective(d), false, out->model);
  } else {
    slight_bends(work, settled, out->model);
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
