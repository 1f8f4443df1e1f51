/* Rows of a sum of ridges for a chunk of samples. Private. */
#ifndef HL_RIDGE_ROWS_H
#define HL_RIDGE_ROWS_H

#include "ridges.h"

enum { HL_RIDGE_CHUNK = 64 };

/* An axis and its slopes by its parameters `first` .. first + count - 1. */
typedef struct hl_axis_frame {
  double a[3], da[2][3];
  int first, count;
} hl_axis_frame;

/* What is the same for all samples of a pass over them. */
typedef struct hl_ridge_pass {
  const hl_ridges *ridges;
  const hl_axes *axes;
  const hl_ridge_data *data;
  hl_axis_frame frame[HL_TERMS_MAX]; /* at the mean view */
  int first[HL_TERMS_MAX];           /* column of each term */
  int columns;
  double widest; /* chord from which a curve is 0 */
} hl_ridge_pass;

void hl_ridge_pass_begin(const hl_ridges *ridges, const hl_axes *axes, const hl_ridge_data *data,
                         hl_ridge_pass *out);

/* One term over a chunk: the columns that are not 0 and their values, times g. */
typedef struct hl_ridge_term_rows {
  double t[HL_RIDGE_CHUNK], u[HL_RIDGE_CHUNK], g[HL_RIDGE_CHUNK];
  double dt[2][HL_RIDGE_CHUNK];
  int at[HL_RIDGE_CHUNK];          /* first column; four of a spline, one of a linear term */
  double value[HL_RIDGE_CHUNK][4]; /* g B */
  double rate[HL_RIDGE_CHUNK][4];  /* g dB/dt, only with slopes */
} hl_ridge_term_rows;

typedef struct hl_ridge_rows {
  int count;
  hl_ridge_term_rows term[HL_TERMS_MAX];
} hl_ridge_rows;

/* Samples first .. first + count - 1, count <= HL_RIDGE_CHUNK. */
void hl_ridge_rows_at(const hl_ridge_pass *pass, int first, int count, bool slopes,
                      hl_ridge_rows *rows);

/* t and u of one term alone, and its g. */
void hl_ridge_rows_chords(const hl_ridge_pass *pass, int term, int first, int count,
                          hl_ridge_term_rows *out);

/* Prediction of each sample of the chunk by the curves x of one channel. */
void hl_ridge_rows_predict(const hl_ridge_pass *pass, const hl_ridge_rows *rows, const double *x,
                           double out[HL_RIDGE_CHUNK]);

/* Value of one term's curve, before g. */
double hl_ridge_value(const hl_ridges *ridges, int term, const double *x, double t);

#endif
