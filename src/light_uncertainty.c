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
 * The pose enters by the same linearisation: with the ball's centre moved by dC, a pixel's point
 * and normal move by dn = (d (n.dC)/(n.d) - dC)/R, d the pixel's ray, and the direction by H^-1 g.
 */
#include <math.h>
#include <string.h>

#include "halflight/vec3.h"
#include "light_work.h"

enum { TILES_ACROSS = 64 };
static const double structured_ratio = 2.5;
static const double lit_share = 0.02; /* of level */
static const double defensible_ratio = 0.25, coarse_weight = 0.5;

/* Inverse of a symmetric positive definite n x n, n <= 3; a zero pivot is lifted to 1e-12 of its
 * own. */
static void invert(const double a[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX], int n,
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

static void add_channel(struct hl_light_work *work, const hl_light_model *model, int c, sums *s)
{
  const hl_light_data *d = &work->all;
  const int q = hl_model_nonlinear(model);
  for (int i = 0; i < d->n; i++) {
    const hl_model_pixel *f = &work->fit[i];
    const double y = d->value[c][i], w = d->weight[c][i];
    work->predicted[i] += (float)(f->value / d->channels);
    work->measured[i] += (float)(y / d->channels);
    const bool clipped = d->clipped[i] >> c & 1;
    if (!(w > 0) || (clipped && !(f->value < y)))
      continue;
    const double r = y - f->value;
    for (int u = 0; u < q; u++) {
      work->score[i][u] += w * r * f->profiled[u];
      for (int v = 0; v < q; v++)
        s->h[u][v] += w * f->profiled[u] * f->profiled[v];
    }
    s->rr += r * r;
    s->samples++;
    if (!clipped) {
      const double t = compressed(y), difference = t - compressed(f->value);
      s->mean += t;
      s->variance += t * t;
      s->residual += difference * difference;
      s->ww += 1;
    }
    if (y > lit_share) {
      s->fit_error += fabs(r);
      s->data += y;
      s->lit++;
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
  double lobe = 0, body = 0;
  hl_model_point *without = &work->model.trial;
  for (int c = 0; c < d->channels; c++) {
    hl_model_predict(model, d, &work->best.at, NULL, 0, d->n, c, work->fit);
    *without = work->best.at;
    for (int j = 0; j < model->body; j++)
      without->x[c][model->spline.n + j] = 0;
    for (int i = 0; i < d->n; i++) {
      hl_model_pixel part;
      hl_model_predict(model, d, without, NULL, i, 1, c, &part);
      for (int k = 0; k < 2; k++) {
        const double rest = work->fit[i].slope[k] - part.slope[k];
        lobe += d->weight[c][i] * part.slope[k] * part.slope[k];
        body += d->weight[c][i] * rest * rest;
      }
    }
  }
  return lobe + body > 0 ? lobe / (lobe + body) : 0;
}

/* Scores summed over square tiles of the surface's bounding box, then their outer products. */
static void tile_products(const struct hl_light_work *work, const hl_surface *surface, int q,
                          double m[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX])
{
  double tile[HL_TILES_MAX][HL_NONLINEAR_MAX] = {{0}};
  int x0 = surface->width, x1 = 0, y0 = surface->height, y1 = 0;
  for (int i = 0; i < surface->n; i++) {
    const int x = surface->pixel[i] % surface->width, y = surface->pixel[i] / surface->width;
    x0 = x < x0 ? x : x0;
    x1 = x > x1 ? x : x1;
    y0 = y < y0 ? y : y0;
    y1 = y > y1 ? y : y1;
  }
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

/* What the answer moves by between defensible models, as a covariance in the tangents: each weighs
 * the less the worse it fits, and so does the answer under relative weights, which is half a model.
 */
static void model_share(const struct hl_light_work *work, const hl_light_settled *settled,
                        double out[2][2])
{
  const hl_model_point *at = &work->best.at;
  const double cost = settled->variant[settled->kept].cost;
  double total = 1;
  for (int i = HL_VARIANT_MATTE; i <= HL_VARIANTS; i++) {
    const bool coarse = i == HL_VARIANTS;
    const double *s = coarse ? settled->coarse_s : settled->variant[i].s;
    if (!coarse && (i == (int)settled->kept || !isfinite(settled->variant[i].cost)))
      continue;
    const double weight =
        coarse ? coarse_weight
               : exp(-fmax(0, settled->variant[i].cost / cost - 1) / defensible_ratio);
    const double delta[2] = {hl_dot(s, at->t[0]), hl_dot(s, at->t[1])};
    for (int u = 0; u < 2; u++)
      for (int v = 0; v < 2; v++)
        out[u][v] += weight * delta[u] * delta[v];
    total += weight;
  }
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++)
      out[u][v] /= total;
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
  double by_pixel[2][2], by_tile[2][2];
  sums s;
  memset(&s, 0, sizeof s);
  memset(work->score, 0, n * sizeof *work->score);
  memset(work->predicted, 0, n * sizeof *work->predicted);
  memset(work->measured, 0, n * sizeof *work->measured);
  hl_model_differentiate(model, d, &work->best.at, threads, &work->model, &work->best.step);
  for (int c = 0; c < d->channels; c++) {
    hl_model_predict(model, d, &work->best.at, work->best.step.solved, 0, d->n, c, work->fit);
    add_channel(work, model, c, &s);
  }
  for (int i = 0; i < d->n; i++)
    for (int u = 0; u < q; u++)
      for (int v = 0; v < q; v++)
        white[u][v] += work->score[i][u] * work->score[i][v];
  tile_products(work, surface, q, tiles);
  memset(out, 0, sizeof *out);
  invert(s.h, q, out->inverse);
  sandwich(out->inverse, white, q, by_pixel);
  sandwich(out->inverse, tiles, q, by_tile);
  out->structure = relative_size(by_tile, by_pixel);
  const bool structured = out->structure > structured_ratio;
  memcpy(out->covariance, structured ? by_tile : by_pixel, sizeof out->covariance);
  if (structured) {
    double model_part[2][2] = {{0}};
    model_share(work, settled, model_part);
    for (int u = 0; u < 2; u++)
      for (int v = 0; v < 2; v++)
        out->covariance[u][v] += model_part[u][v];
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

/* Move every normal as a shift of the ball's centre by sign * step along axis k does. */
static void shift_ball(hl_light_data *d, int k, double step_over_radius)
{
  for (int i = 0; i < d->n; i++) {
    const double n[3] = {d->normal[0][i], d->normal[1][i], d->normal[2][i]};
    const double ray[3] = {-d->view[0][i], -d->view[1][i], -d->view[2][i]};
    const double slide = n[k] / hl_dot(n, ray);
    for (int j = 0; j < 3; j++)
      d->normal[j][i] = n[j] + step_over_radius * (ray[j] * slide - (j == k));
  }
}

void hl_light_pose_share(struct hl_light_work *work, const hl_light_model *model,
                         const hl_light_spread *spread, const hl_sphere *sphere, int threads,
                         double covariance[2][2])
{
  static const double step = 1e-3; /* of the radius: far below a pixel, far above rounding */
  hl_light_data *d = &work->all;
  double response[2][3] = {{0}}; /* tangents per metre */
  const hl_model_point *at = &work->best.at;
  const int q = hl_model_nonlinear(model);
  for (int k = 0; k < 3; k++)
    for (int sign = -1; sign <= 1; sign += 2) {
      hl_model_step *out = &work->refined.step;
      shift_ball(d, k, sign * step);
      if (hl_model_fit(model, d, at->s, at->exponent, threads, &work->model, &work->model.trial) ==
          0) {
        hl_model_differentiate(model, d, &work->model.trial, threads, &work->model, out);
        for (int u = 0; u < 2; u++)
          for (int v = 0; v < q; v++)
            response[u][k] +=
                sign * spread->inverse[u][v] * out->gradient[v] / (2 * step * sphere->radius_m);
      }
      shift_ball(d, k, -sign * step);
    }
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++) {
      covariance[u][v] = 0;
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          covariance[u][v] += response[u][i] * sphere->covariance_m2[i][j] * response[v][j];
    }
}
