/* Weighted normal equations of several splines at once, one matrix for all channels. Private. */
#ifndef HL_GRAM_H
#define HL_GRAM_H

#include "halflight/light.h"

enum { HL_GRAM_MAX = 192 };

/* A x_c = b_c, the residual's square yy_c - 2 x'b_c + x'A x. */
typedef struct hl_gram {
  int n, channels;
  double a[HL_GRAM_MAX * HL_GRAM_MAX]; /* upper triangle, n x n row by row */
  double b[HL_CHANNELS_MAX][HL_GRAM_MAX];
  double yy[HL_CHANNELS_MAX];
} hl_gram;

/* A term's part of some rows: `count` neighbouring columns from at[i], four of a spline or one. */
typedef struct hl_runs {
  int count;
  const int *at;
  const double (*value)[4];
} hl_runs;

void hl_gram_clear(hl_gram *g, int n, int channels);
void hl_gram_merge(hl_gram *g, const hl_gram *more);
void hl_gram_subtract(hl_gram *g, const hl_gram *less);

/* Rows 0 .. rows - 1 of weights w: products of two terms' parts (a == b in content: of one), b not
 * left of a; of a part with the data y[channel][row]; the data's own square. */
void hl_gram_add(hl_gram *g, const hl_runs *a, const hl_runs *b, int rows, const double *w);
void hl_gram_add_data(hl_gram *g, const hl_runs *a, int rows, const double *w,
                      const double *const y[HL_CHANNELS_MAX]);
void hl_gram_add_square(hl_gram *g, int rows, const double *w,
                        const double *const y[HL_CHANNELS_MAX]);

/* The same for a column of ones, the last. */
void hl_gram_add_constant(hl_gram *g, int column, const hl_runs *a, int rows, const double *w);
void hl_gram_add_constant_data(hl_gram *g, int column, int rows, const double *w,
                               const double *const y[HL_CHANNELS_MAX]);

/* out = g without columns first .. first + count - 1. */
void hl_gram_without(const hl_gram *g, int first, int count, hl_gram *out);

/* The residual's weighted square at x, not below 0. */
double hl_gram_cost(const hl_gram *g, int channel, const double *x);

#endif
