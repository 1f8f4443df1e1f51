/* A sum of ridges over all samples: normal equations of the curves, and slopes by the directions.
 *
 * Samples are summed in blocks whose number depends on the samples alone, and the blocks in order, so
 * that the bits do not depend on how many threads share them.
 */
#include "ridges.h"

#include <string.h>

#include "ridge_rows.h"

int hl_ridge_blocks(const hl_ridge_data *data)
{
  const int wanted = data->n / HL_BLOCK_SAMPLES;
  return wanted < 1 ? 1 : wanted > HL_FIT_BLOCKS ? HL_FIT_BLOCKS : wanted;
}

int hl_ridge_block_first(const hl_ridge_data *data, int blocks, int b)
{
  return (int)((long)data->n * b / blocks);
}

double hl_ridge_square(const hl_ridge_data *d)
{
  double sum = 0;
  for (int c = 0; c < d->channels; c++) {
    double w = 0, wy = 0, wyy = 0;
    for (int i = 0; i < d->n; i++) {
      w += d->w[i];
      wy += d->w[i] * d->y[c][i];
      wyy += d->w[i] * d->y[c][i] * d->y[c][i];
    }
    sum += wyy - wy * wy / w;
  }
  return sum;
}

static int run_of(const hl_ridge_pass *p, int term)
{
  return p->ridges->linear[term] ? 1 : 4;
}

/* ---- normal equations ---- */

static void gram_block(const hl_ridge_pass *p, int from, int to, hl_gram *g)
{
  const hl_ridge_data *d = p->data;
  const int n = p->ridges->n;
  hl_ridge_rows rows;
  hl_gram_clear(g, p->columns, d->channels);
  for (int first = from; first < to; first += HL_RIDGE_CHUNK) {
    const int count = to - first < HL_RIDGE_CHUNK ? to - first : HL_RIDGE_CHUNK;
    const double *w = d->w + first;
    const double *y[HL_CHANNELS_MAX];
    for (int c = 0; c < d->channels; c++)
      y[c] = d->y[c] + first;
    hl_ridge_rows_at(p, first, count, false, &rows);
    for (int j = 0; j < n; j++) {
      const hl_runs a = {run_of(p, j), rows.term[j].at, rows.term[j].value};
      for (int k = j; k < n; k++) {
        const hl_runs b = {run_of(p, k), rows.term[k].at, rows.term[k].value};
        hl_gram_add(g, &a, &b, count, w);
      }
      hl_gram_add_data(g, &a, count, w, y);
      if (p->ridges->has_constant)
        hl_gram_add_constant(g, p->columns - 1, &a, count, w);
    }
    if (p->ridges->has_constant)
      hl_gram_add_constant_data(g, p->columns - 1, count, w, y);
    hl_gram_add_square(g, count, w, y);
  }
}

/* One thread goes without OpenMP, whose runtime may allocate: not even its entry is called, which is
 * why the parallel loops are functions of their own. */
#define HL_APART __attribute__((noinline))

static void gram_of_block(const hl_ridge_pass *p, int blocks, int b, hl_ridge_work *work)
{
  gram_block(p, hl_ridge_block_first(p->data, blocks, b),
             hl_ridge_block_first(p->data, blocks, b + 1), &work->block[b]);
}

static HL_APART void gram_parallel(const hl_ridge_pass *p, int blocks, int threads,
                                   hl_ridge_work *work)
{
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (int b = 0; b < blocks; b++)
    gram_of_block(p, blocks, b, work);
  (void)threads;
}

void hl_ridges_gram(const hl_ridges *ridges, const hl_axes *axes, const hl_ridge_data *data,
                    int threads, hl_ridge_work *work, hl_gram *out)
{
  hl_ridge_pass p;
  const int blocks = hl_ridge_blocks(data);
  hl_ridge_pass_begin(ridges, axes, data, &p);
  if (blocks == 1) {
    gram_block(&p, 0, data->n, out);
    return;
  }
  if (threads > 1)
    gram_parallel(&p, blocks, threads, work);
  else
    for (int b = 0; b < blocks; b++)
      gram_of_block(&p, blocks, b, work);
  hl_gram_clear(out, p.columns, data->channels);
  for (int b = 0; b < blocks; b++)
    hl_gram_merge(out, &work->block[b]);
}

/* ---- slopes ---- */

/* D of a chunk and channel: slopes by each parameter with the curves held. */
static void chunk_slopes(const hl_ridge_pass *p, const hl_ridge_rows *rows, const double *x,
                         double d[HL_AXES_MAX][HL_RIDGE_CHUNK])
{
  for (int j = 0; j < p->ridges->n; j++) {
    const hl_ridge_term_rows *r = &rows->term[j];
    const hl_axis_frame *f = &p->frame[j];
    for (int i = 0; i < rows->count && f->count > 0; i++) {
      const double *c = x + r->at[i], *b = r->rate[i];
      const double rate = p->ridges->linear[j]
                              ? b[0] * c[0]
                              : (b[0] * c[0] + b[1] * c[1]) + (b[2] * c[2] + b[3] * c[3]);
      for (int k = 0; k < f->count; k++)
        d[f->first + k][i] += rate * r->dt[k][i];
    }
  }
}

static void add_cross(const hl_ridge_pass *p, const hl_ridge_rows *rows, const double *wd,
                      double *cross)
{
  for (int j = 0; j < p->ridges->n; j++) {
    const hl_ridge_term_rows *r = &rows->term[j];
    if (p->ridges->linear[j])
      for (int i = 0; i < rows->count; i++)
        cross[p->first[j]] += wd[i] * r->value[i][0];
    else
      for (int i = 0; i < rows->count; i++) {
        double *to = cross + r->at[i];
        double sum[4];
        for (int m = 0; m < 4; m++)
          sum[m] = to[m] + wd[i] * r->value[i][m];
        for (int m = 0; m < 4; m++)
          to[m] = sum[m];
      }
  }
  for (int i = 0; i < rows->count && p->ridges->has_constant; i++)
    cross[p->columns - 1] += wd[i];
}

static void slopes_block(const hl_ridge_pass *p, int q, const double (*x)[HL_GRAM_MAX], int from,
                         int to, hl_ridge_work *work, int b)
{
  const hl_ridge_data *data = p->data;
  double cost = 0;
  hl_ridge_rows rows;
  for (int c = 0; c < data->channels; c++)
    for (int k = 0; k < q; k++)
      memset(work->cross[b][c][k], 0, (size_t)p->columns * sizeof(double));
  memset(work->inner[b], 0, sizeof work->inner[b]);
  memset(work->gradient[b], 0, sizeof work->gradient[b]);
  for (int first = from; first < to; first += HL_RIDGE_CHUNK) {
    const int count = to - first < HL_RIDGE_CHUNK ? to - first : HL_RIDGE_CHUNK;
    hl_ridge_rows_at(p, first, count, true, &rows);
    for (int c = 0; c < data->channels; c++) {
      double d[HL_AXES_MAX][HL_RIDGE_CHUNK], r[HL_RIDGE_CHUNK] = {0}, wd[HL_RIDGE_CHUNK] = {0};
      memset(d, 0, (size_t)q * sizeof *d);
      hl_ridge_rows_predict(p, &rows, x[c], r);
      chunk_slopes(p, &rows, x[c], d);
      for (int i = 0; i < count; i++) {
        r[i] = data->y[c][first + i] - r[i];
        cost += data->w[first + i] * r[i] * r[i];
      }
      for (int k = 0; k < q; k++) {
        double gradient = 0;
        for (int i = 0; i < count; i++) {
          wd[i] = data->w[first + i] * d[k][i];
          gradient += wd[i] * r[i];
        }
        work->gradient[b][k] += gradient;
        for (int l = k; l < q; l++) {
          double inner = 0;
          for (int i = 0; i < count; i++)
            inner += wd[i] * d[l][i];
          work->inner[b][k][l] += inner;
        }
        add_cross(p, &rows, wd, work->cross[b][c][k]);
      }
    }
  }
  work->cost[b] = cost;
}

static void merge_slopes(const hl_ridge_work *work, int b, int channels, int columns,
                         hl_ridge_slopes *out)
{
  for (int k = 0; k < out->q; k++) {
    out->gradient[k] += work->gradient[b][k];
    for (int l = k; l < out->q; l++)
      out->inner[k][l] += work->inner[b][k][l];
    for (int c = 0; c < channels; c++)
      for (int i = 0; i < columns; i++)
        out->cross[c][k][i] += work->cross[b][c][k][i];
  }
  out->cost += work->cost[b];
}

static HL_APART void slopes_parallel(const hl_ridge_pass *p, int q, const double (*x)[HL_GRAM_MAX],
                                     int blocks, int threads, hl_ridge_work *work)
{
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (int b = 0; b < blocks; b++)
    slopes_block(p, q, x, hl_ridge_block_first(p->data, blocks, b),
                 hl_ridge_block_first(p->data, blocks, b + 1), work, b);
  (void)threads;
}

void hl_ridges_slopes(const hl_ridges *ridges, const hl_axes *axes, const hl_ridge_data *data,
                      const double (*x)[HL_GRAM_MAX], int threads, hl_ridge_work *work,
                      hl_ridge_slopes *out)
{
  hl_ridge_pass p;
  const int blocks = hl_ridge_blocks(data), q = hl_axes_parameters(axes);
  hl_ridge_pass_begin(ridges, axes, data, &p);
  if (threads > 1)
    slopes_parallel(&p, q, x, blocks, threads, work);
  else
    for (int b = 0; b < blocks; b++)
      slopes_block(&p, q, x, hl_ridge_block_first(data, blocks, b),
                   hl_ridge_block_first(data, blocks, b + 1), work, b);
  out->q = q;
  out->cost = 0;
  memset(out->gradient, 0, sizeof out->gradient);
  memset(out->inner, 0, sizeof out->inner);
  for (int c = 0; c < data->channels; c++)
    for (int k = 0; k < q; k++)
      memset(out->cross[c][k], 0, (size_t)p.columns * sizeof(double));
  for (int b = 0; b < blocks; b++)
    merge_slopes(work, b, data->channels, p.columns, out);
  for (int k = 0; k < q; k++)
    for (int l = 0; l < k; l++)
      out->inner[k][l] = out->inner[l][k];
}
