/* Normal equations of several splines.
 *
 * Each row touches four columns of every spline, so the diagonal blocks are banded but the blocks
 * between two splines are full: with two splines of thirty columns a band would save nothing. (One
 * spline and a narrow border, as the light has, is normal_equations.c.) Channels share weights and
 * therefore the matrix; only their right-hand sides differ.
 */
#include "gram.h"

#include <string.h>

void hl_gram_clear(hl_gram *g, int n, int channels)
{
  g->n = n;
  g->channels = channels;
  memset(g->a, 0, (size_t)n * (size_t)n * sizeof *g->a);
  memset(g->yy, 0, sizeof g->yy);
  for (int c = 0; c < channels; c++)
    memset(g->b[c], 0, (size_t)n * sizeof *g->b[c]);
}

static void add_times(hl_gram *g, const hl_gram *other, double factor)
{
  const int n = g->n;
  for (int i = 0; i < n * n; i++)
    g->a[i] += factor * other->a[i];
  for (int c = 0; c < g->channels; c++) {
    for (int i = 0; i < n; i++)
      g->b[c][i] += factor * other->b[c][i];
    g->yy[c] += factor * other->yy[c];
  }
}

void hl_gram_merge(hl_gram *g, const hl_gram *more)
{
  add_times(g, more, 1);
}

void hl_gram_subtract(hl_gram *g, const hl_gram *less)
{
  add_times(g, less, -1);
}

/* Of two splines: four by four, a fixed count is what becomes vectors. */
static void add_splines(double *g, long n, const hl_runs *a, const hl_runs *b, int rows,
                        const double *w)
{
  for (int i = 0; i < rows; i++) {
    double *to = g + a->at[i] * n + b->at[i];
    double p[4], q[4]; /* copies, which no store can change */
    for (int k = 0; k < 4; k++) {
      p[k] = w[i] * a->value[i][k];
      q[k] = b->value[i][k];
    }
    for (int k = 0; k < 4; k++, to += n) {
      double sum[4];
      for (int l = 0; l < 4; l++)
        sum[l] = to[l] + p[k] * q[l];
      for (int l = 0; l < 4; l++)
        to[l] = sum[l];
    }
  }
}

void hl_gram_add(hl_gram *g, const hl_runs *a, const hl_runs *b, int rows, const double *w)
{
  const long n = g->n;
  if (a->count == 4 && b->count == 4) {
    add_splines(g->a, n, a, b, rows, w);
    return;
  }
  for (int i = 0; i < rows; i++)
    for (int k = 0; k < a->count; k++)
      for (int l = 0; l < b->count; l++)
        g->a[(a->at[i] + k) * n + b->at[i] + l] += w[i] * a->value[i][k] * b->value[i][l];
}

static void add_spline_data(double *b, const hl_runs *a, int rows, const double *w, const double *y)
{
  for (int i = 0; i < rows; i++) {
    double *to = b + a->at[i];
    const double wy = w[i] * y[i];
    double sum[4];
    for (int k = 0; k < 4; k++)
      sum[k] = to[k] + wy * a->value[i][k];
    for (int k = 0; k < 4; k++)
      to[k] = sum[k];
  }
}

void hl_gram_add_data(hl_gram *g, const hl_runs *a, int rows, const double *w,
                      const double *const y[HL_CHANNELS_MAX])
{
  for (int c = 0; c < g->channels; c++)
    if (a->count == 4)
      add_spline_data(g->b[c], a, rows, w, y[c]);
    else
      for (int i = 0; i < rows; i++)
        for (int k = 0; k < a->count; k++)
          g->b[c][a->at[i] + k] += w[i] * y[c][i] * a->value[i][k];
}

void hl_gram_add_square(hl_gram *g, int rows, const double *w,
                        const double *const y[HL_CHANNELS_MAX])
{
  for (int c = 0; c < g->channels; c++)
    for (int i = 0; i < rows; i++)
      g->yy[c] += w[i] * y[c][i] * y[c][i];
}

void hl_gram_add_constant(hl_gram *g, int column, const hl_runs *a, int rows, const double *w)
{
  for (int i = 0; i < rows; i++)
    for (int k = 0; k < a->count; k++)
      g->a[(long)(a->at[i] + k) * g->n + column] += w[i] * a->value[i][k];
}

void hl_gram_add_constant_data(hl_gram *g, int column, int rows, const double *w,
                               const double *const y[HL_CHANNELS_MAX])
{
  for (int i = 0; i < rows; i++) {
    g->a[(long)column * g->n + column] += w[i];
    for (int c = 0; c < g->channels; c++)
      g->b[c][column] += w[i] * y[c][i];
  }
}

void hl_gram_without(const hl_gram *g, int first, int count, hl_gram *out)
{
  const int n = g->n - count;
  hl_gram_clear(out, n, g->channels);
  for (int i = 0; i < n; i++) {
    const int from = i < first ? i : i + count;
    for (int j = 0; j < n; j++)
      out->a[(long)i * n + j] = g->a[(long)from * g->n + (j < first ? j : j + count)];
    for (int c = 0; c < g->channels; c++)
      out->b[c][i] = g->b[c][from];
  }
  memcpy(out->yy, g->yy, sizeof out->yy);
}

double hl_gram_cost(const hl_gram *g, int channel, const double *x)
{
  const int n = g->n;
  const double *b = g->b[channel];
  double linear = 0, square = 0;
  for (int i = 0; i < n; i++) {
    const double *row = g->a + (long)i * n;
    double sum = 0.5 * row[i] * x[i];
    for (int j = i + 1; j < n; j++)
      sum += row[j] * x[j];
    square += sum * x[i];
    linear += b[i] * x[i];
  }
  const double cost = g->yy[channel] - 2 * linear + 2 * square;
  return cost > 0 ? cost : 0;
}
