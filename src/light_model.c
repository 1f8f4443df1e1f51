/* The light model fitted to all pixels at one direction of light, and its derivative by it.
 *
 * For given s the model is linear in its curves x (rows: light_rows.c), so they are solved for and
 * the cost is a function of s (and of the masking's exponent and the light's nearness) alone: variable projection,
 *
 *   cost(s) = min_x (y - X(s)x)'W(y - X(s)x) + x'Rx.
 *
 * With D = d(X x) at fixed x, its gradient is -2 D'W r and its Gauss-Newton matrix, after Kaufman,
 * D'WD - (X'WD)'(X'WX + R)^-1 (X'WD). Golub and Pereyra 1973; Kaufman 1975.
 *
 * Pixels are summed in HL_BLOCKS fixed blocks, and the blocks in order, so that the bits do not
 * depend on how many threads share them.
 */
#include "light_model.h"

#include <string.h>

#include "halflight/vec3.h"
#include "light_censor.h"
#include "light_rows.h"

static void accumulate_block(const hl_light_model *model, const hl_light_data *data,
                             const hl_model_point *at, hl_model_work *work, int b)
{
  const int m = hl_model_border(model);
  const int n = model->has_lobe ? model->spline.n : 0;
  const int end = hl_block_first(data->n, b + 1);
  hl_clipped_row *row = hl_clipped_rows(data, work, b);
  int rows = 0;
  hl_rows c;
  for (int k = 0; k < data->channels; k++)
    hl_normal_clear(&work->block[b][k], n, m);
  for (int first = hl_block_first(data->n, b); first < end; first += HL_ROWS_CHUNK) {
    const int count = end - first < HL_ROWS_CHUNK ? end - first : HL_ROWS_CHUNK;
    hl_rows_at(model, data, first, count, at, false, &c);
    for (int i = 0; i < count; i++) {
      double band[4] = {0}, border[HL_BORDER_MAX] = {0};
      int column = 0;
      const int p = first + i;
      if (c.lit[i] <= 0 && !model->ambient) {
        for (int k = 0; k < data->channels; k++) /* clipped in shadow: cannot be explained, costs */
          work->block[b][k].yy += data->weight[k][p] * data->value[k][p] * data->value[k][p];
        continue;
      }
      if (n > 0) {
        column = hl_spline_values(&model->spline, c.u[i], band);
        for (int k = 0; k < 4; k++)
          band[k] *= c.lit[i] * c.g[i];
      }
      hl_rows_border(model, &c, i, border);
      for (int k = 0; k < data->channels; k++) {
        const double weight = data->weight[k][p];
        if (data->clipped[p] >> k & 1) {
          hl_clipped_row *r = &row[rows++];
          memcpy(r->band, band, sizeof band);
          memcpy(r->border, border, sizeof border);
          r->weight = weight;
          r->value = data->value[k][p];
          r->first = column;
          r->channel = k;
          r->active = true;
        } else if (weight > 0) {
          hl_normal_add(&work->block[b][k], column, band, border, weight, data->value[k][p]);
        }
      }
    }
  }
  work->n_clipped[b] = rows;
}

static HL_APART void accumulate_parallel(const hl_light_model *model, const hl_light_data *data,
                                         const hl_model_point *at, int threads, hl_model_work *work)
{
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (int b = 0; b < hl_blocks(data->n); b++)
    accumulate_block(model, data, at, work, b);
  (void)threads;
}

static void accumulate(const hl_light_model *model, const hl_light_data *data,
                       const hl_model_point *at, int threads, hl_model_work *work)
{
  if (threads > 1)
    accumulate_parallel(model, data, at, threads, work);
  else
    for (int b = 0; b < hl_blocks(data->n); b++)
      accumulate_block(model, data, at, work, b);
}

void hl_model_normal(const hl_light_model *model, const hl_light_data *data, int threads,
                     hl_model_work *work, const hl_model_point *at,
                     hl_normal normal[HL_CHANNELS_MAX])
{
  accumulate(model, data, at, threads, work);
  for (int c = 0; c < data->channels; c++)
    hl_censor_normal(model, data, c, at->x[c], work, &normal[c]);
}

int hl_model_fit(const hl_light_model *model, const hl_light_data *data, const double s[3],
                 double exponent, int threads, hl_model_work *work, hl_model_point *out)
{
  return hl_model_fit_near(model, data, s, exponent, 0, threads, work, out);
}

int hl_model_fit_near(const hl_light_model *model, const hl_light_data *data, const double s[3],
                      double exponent, double nearness, int threads, hl_model_work *work,
                      hl_model_point *out)
{
  memmove(out->s, s, sizeof out->s);
  out->exponent = exponent;
  out->nearness = nearness;
  hl_tangent_basis(s, out->t[0], out->t[1]);
  accumulate(model, data, out, threads, work);
  out->cost = hl_light_apart(data);
  out->cost += model->masking ? model->exponent_weight * exponent * exponent : 0;
  for (int k = 0; k < data->channels; k++) {
    double cost = 0;
    if (hl_censor_solve(model, data, k, work, out, &cost) != 0)
      return -1;
    out->cost += cost;
  }
  return out->cost == out->cost ? 0 : -1;
}

/* Sums of D'WD, D'Wr and r'Wr of a block. */
typedef struct step_sums {
  double inner[HL_SYSTEM_MAX], gradient[HL_NONLINEAR_MAX], cost;
} step_sums;

/* One sample of one channel: its residual, slopes and row. `m` and `q` are constants where it counts. */
static inline void add_slopes(step_sums *sums, double (*cross)[HL_NONLINEAR_MAX], double weight,
                              double r, const double *d, const double *band, int column, int n,
                              const double *border, int m, int q)
{
  sums->cost += weight * r * r;
  for (int u = 0, at = 0; u < q; u++) {
    const double wd = weight * d[u];
    sums->gradient[u] += wd * r;
    for (int v = u; v < q; v++)
      sums->inner[at++] += wd * d[v];
    if (n > 0)
      for (int l = 0; l < 4; l++)
        cross[column + l][u] += band[l] * wd;
    for (int j = 0; j < m; j++)
      cross[n + j][u] += border[j] * wd;
  }
}

/* Pixel i of the chunk of a near light, p of the data. */
static void add_near_pixel(const hl_light_model *model, const hl_light_data *data,
                           const hl_model_point *at, const hl_rows *c, int i, int p,
                           hl_model_work *work, int b, step_sums *sums)
{
  const int n = model->has_lobe ? model->spline.n : 0;
  for (int k = 0; k < data->channels; k++) {
    double band[4] = {0}, border[HL_BORDER_MAX] = {0}, d[HL_NONLINEAR_MAX];
    int column = 0;
    if (!(data->weight[k][p] > 0))
      continue;
    const double fit = hl_rows_predict(model, c, i, at->x[k], &column, band, border, d, NULL);
    if ((data->clipped[p] >> k & 1) && !(fit < data->value[k][p]))
      continue;
    add_slopes(sums, work->cross[b][k], data->weight[k][p], data->value[k][p] - fit, d, band,
               column, n, border, hl_model_border(model), hl_model_nonlinear(model));
  }
}

/* The same of a distant light, whose channels share most. */
static inline void add_pixel(const hl_light_model *model, const hl_light_data *data,
                             const hl_model_point *at, const hl_rows *c, int i, int p, int m, int q,
                             hl_model_work *work, int b, step_sums *sums)
{
  const int n = model->has_lobe ? model->spline.n : 0;
  hl_rows_shared shared;
  double band[4];
  hl_rows_share(model, c, i, &shared);
  for (int l = 0; n > 0 && l < 4; l++)
    band[l] = shared.lit_g * shared.band[l];
  for (int k = 0; k < data->channels; k++) {
    double d[HL_NONLINEAR_MAX];
    if (!(data->weight[k][p] > 0))
      continue;
    const double fit = hl_rows_of_channel(&shared, n, m, q, at->x[k], d);
    if ((data->clipped[p] >> k & 1) && !(fit < data->value[k][p]))
      continue;
    add_slopes(sums, work->cross[b][k], data->weight[k][p], data->value[k][p] - fit, d, band,
               shared.column, n, shared.border, m, q);
  }
}

static void differentiate_chunk(const hl_light_model *model, const hl_light_data *data,
                                const hl_model_point *at, int first, int count, hl_model_work *work,
                                int b, step_sums *sums)
{
  const int m = hl_model_border(model);
  hl_rows c;
  hl_rows_at(model, data, first, count, at, true, &c);
  for (int i = 0; i < count; i++) {
    const int p = first + i;
    if (c.lit[i] <= 0 && !model->ambient)
      for (int k = 0; k < data->channels; k++)
        sums->cost += data->weight[k][p] * data->value[k][p] * data->value[k][p];
    else if (model->near)
      add_near_pixel(model, data, at, &c, i, p, work, b, sums);
    else if (model->masking)
      add_pixel(model, data, at, &c, i, p, m, 3, work, b, sums);
    else if (m == 1)
      add_pixel(model, data, at, &c, i, p, 1, 2, work, b, sums);
    else
      add_pixel(model, data, at, &c, i, p, m, 2, work, b, sums);
  }
}

static void differentiate_block(const hl_light_model *model, const hl_light_data *data,
                                const hl_model_point *at, hl_model_work *work, int b)
{
  const int end = hl_block_first(data->n, b + 1);
  step_sums sums;
  memset(&sums, 0, sizeof sums);
  memset(work->cross[b], 0, sizeof work->cross[b]);
  for (int first = hl_block_first(data->n, b); first < end; first += HL_ROWS_CHUNK)
    differentiate_chunk(model, data, at, first,
                        end - first < HL_ROWS_CHUNK ? end - first : HL_ROWS_CHUNK, work, b, &sums);
  double *inner = work->inner[b];
  memcpy(inner, sums.inner, sizeof sums.inner);
  memcpy(inner + HL_SYSTEM_MAX, sums.gradient, sizeof sums.gradient);
  inner[HL_SYSTEM_MAX + HL_NONLINEAR_MAX] = sums.cost;
}

static HL_APART void differentiate_parallel(const hl_light_model *model, const hl_light_data *data,
                                            const hl_model_point *at, int threads,
                                            hl_model_work *work)
{
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (int b = 0; b < hl_blocks(data->n); b++)
    differentiate_block(model, data, at, work, b);
  (void)threads;
}

void hl_model_differentiate(const hl_light_model *model, const hl_light_data *data,
                            const hl_model_point *at, int threads, hl_model_work *work,
                            hl_model_step *out)
{
  const int columns = (model->has_lobe ? model->spline.n : 0) + hl_model_border(model);
  const int q = hl_model_nonlinear(model);
  if (threads > 1)
    differentiate_parallel(model, data, at, threads, work);
  else
    for (int b = 0; b < hl_blocks(data->n); b++)
      differentiate_block(model, data, at, work, b);
  memset(out, 0, sizeof *out);
  out->cost = hl_light_apart(data);
  for (int b = 0; b < hl_blocks(data->n); b++) {
    for (int u = 0, i = 0; u < q; u++) {
      out->gradient[u] += work->inner[b][HL_SYSTEM_MAX + u];
      for (int v = u; v < q; v++)
        out->hessian[u][v] += work->inner[b][i++];
    }
    out->cost += work->inner[b][HL_SYSTEM_MAX + HL_NONLINEAR_MAX];
  }
  for (int k = 0; k < data->channels; k++) {
    double c[HL_NONLINEAR_MAX][HL_COLUMNS_MAX] = {{0}}, (*solved)[HL_COLUMNS_MAX] = out->solved[k];
    for (int b = 0; b < hl_blocks(data->n); b++)
      for (int i = 0; i < columns; i++)
        for (int u = 0; u < q; u++)
          c[u][i] += work->cross[b][k][i][u];
    for (int u = 0; u < q; u++)
      hl_normal_solve(&at->factor[k], c[u], solved[u]);
    for (int i = 0; i < columns; i++)
      for (int u = 0; u < q; u++)
        for (int v = u; v < q; v++)
          out->hessian[u][v] -= c[u][i] * solved[v][i];
  }
  if (model->masking) {
    out->gradient[2] -= model->exponent_weight * at->exponent;
    out->hessian[2][2] += model->exponent_weight;
  }
  for (int u = 0; u < q; u++)
    for (int v = 0; v < u; v++)
      out->hessian[u][v] = out->hessian[v][u];
}

void hl_model_predict(const hl_light_model *model, const hl_light_data *data,
                      const hl_model_point *at, double (*solved)[HL_NONLINEAR_MAX][HL_COLUMNS_MAX],
                      int first, int count, int channel, hl_model_pixel *out)
{
  const int n = model->has_lobe ? model->spline.n : 0;
  const int m = hl_model_border(model);
  const int q = hl_model_nonlinear(model);
  hl_rows c;
  for (int from = 0; from < count; from += HL_ROWS_CHUNK) {
    const int some = count - from < HL_ROWS_CHUNK ? count - from : HL_ROWS_CHUNK;
    hl_rows_at(model, data, first + from, some, at, true, &c);
    for (int i = 0; i < some; i++) {
      hl_model_pixel *pixel = &out[from + i];
      double band[4] = {0}, border[HL_BORDER_MAX] = {0};
      int column = 0;
      memset(pixel, 0, sizeof *pixel);
      if (c.lit[i] <= 0 && !model->ambient)
        continue;
      pixel->value = hl_rows_predict(model, &c, i, at->x[channel], &column, band, border,
                                     pixel->slope, &pixel->steepness);
      for (int u = 0; u < q; u++) {
        double sum = pixel->slope[u];
        if (solved) {
          const double *x = solved[channel][u];
          for (int k = 0; n > 0 && k < 4; k++)
            sum -= band[k] * x[column + k];
          for (int j = 0; j < m; j++)
            sum -= border[j] * x[n + j];
        }
        pixel->profiled[u] = sum;
      }
    }
  }
}
