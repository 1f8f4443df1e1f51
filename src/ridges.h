/* A sum of ridges: terms, their axes, and the samples they are fitted to. Private.
 *
 *   rho_c(p) = sum_i g_i(p) f_ic(t_i(p)),   t_i(p) = n_p . w_i(p) / |w_i(p)|
 *
 * An axis is w = a (free, fixed) or w(p) = cs s + cv v_p (in the plane of light and view). Curves are
 * cubic splines over the chord u = |n - w/|w|| = sqrt(2 - 2t), whose breaks are dense at the
 * highlight; a linear term is k t.
 */
#ifndef HL_RIDGES_H
#define HL_RIDGES_H

#include <stdbool.h>

#include "gram.h"
#include "halflight/fit.h"
#include "spline.h"

enum {
  HL_AXES_MAX = 2 * HL_TERMS_MAX, /* nonlinear parameters */
  HL_FIT_BLOCKS = 16,             /* of samples, so that sums do not depend on the threads */
  HL_BLOCK_SAMPLES = 1024         /* at least so many a block */
};

/* The samples as structure of arrays, values divided by their mean. */
typedef struct hl_ridge_data {
  int n, channels;
  double *normal[3];
  double *view[3]; /* NULL: mean_view for all */
  double *nv;      /* n.v */
  double *y[HL_CHANNELS_MAX];
  double *w; /* weight, the same for all channels */
  double mean_view[3];
} hl_ridge_data;

typedef enum hl_axis_kind {
  HL_AXIS_FIXED, /* w = a */
  HL_AXIS_FREE,  /* w = a, two parameters */
  HL_AXIS_NAMED, /* w = cs s + cv v */
  HL_AXIS_PLANE  /* w = cs s + cv v with cs = cos psi, cv = sin psi, one parameter */
} hl_axis_kind;

typedef struct hl_axis {
  hl_axis_kind kind;
  double a[3]; /* unit; of the others the direction at the mean view */
  double cs, cv;
} hl_axis;

/* All directions; `seeks_light`: s itself has two parameters, before those of the axes. */
typedef struct hl_axes {
  int n;
  bool seeks_light;
  double light[3];
  hl_axis axis[HL_TERMS_MAX];
} hl_axes;

/* What the terms are, whatever their directions. */
typedef struct hl_ridges {
  int n;
  bool linear[HL_TERMS_MAX];
  bool foreshortened[HL_TERMS_MAX];
  bool free_curves;                      /* neither monotone nor non-negative nor through zero */
  bool has_constant;                     /* one more column: the scale in the log domain */
  const hl_spline *spline[HL_TERMS_MAX]; /* held below its domain; borrowed */
  double smooth[HL_TERMS_MAX];           /* lambda, relative to the columns' own weight */
} hl_ridges;

static inline int hl_ridges_first(const hl_ridges *r, int term)
{
  int first = 0;
  for (int i = 0; i < term; i++)
    first += r->linear[i] ? 1 : r->spline[i]->n;
  return first;
}

static inline int hl_ridges_columns(const hl_ridges *r)
{
  return hl_ridges_first(r, r->n) + (r->has_constant ? 1 : 0);
}

int hl_axes_parameters(const hl_axes *axes);

/* Set each axis' `a` from the light and the mean view. */
void hl_axes_settle(hl_axes *axes, const double mean_view[3]);

/* out = axes moved by delta in their tangents. */
void hl_axes_move(const hl_axes *axes, const double *delta, const double mean_view[3],
                  hl_axes *out);

int hl_ridge_blocks(const hl_ridge_data *data);
/* First sample of a block. */
int hl_ridge_block_first(const hl_ridge_data *data, int blocks, int b);

/* Weighted square of the data about their mean, all channels. */
double hl_ridge_square(const hl_ridge_data *data);

/* Sums of each block of samples. */
typedef struct hl_ridge_work {
  hl_gram block[HL_FIT_BLOCKS];
  double cross[HL_FIT_BLOCKS][HL_CHANNELS_MAX][HL_AXES_MAX][HL_GRAM_MAX];
  double inner[HL_FIT_BLOCKS][HL_AXES_MAX][HL_AXES_MAX];
  double gradient[HL_FIT_BLOCKS][HL_AXES_MAX];
  double cost[HL_FIT_BLOCKS];
} hl_ridge_work;

/* Normal equations of the curves at these axes. O(n). */
void hl_ridges_gram(const hl_ridges *ridges, const hl_axes *axes, const hl_ridge_data *data,
                    int threads, hl_ridge_work *work, hl_gram *out);

/* What a step of the axes would do, with the curves x held. */
typedef struct hl_ridge_slopes {
  int q;
  double gradient[HL_AXES_MAX];                            /* D' W r */
  double inner[HL_AXES_MAX][HL_AXES_MAX];                  /* D' W D */
  double cross[HL_CHANNELS_MAX][HL_AXES_MAX][HL_GRAM_MAX]; /* D' W X */
  double cost;                                             /* r' W r */
} hl_ridge_slopes;
void hl_ridges_slopes(const hl_ridges *ridges, const hl_axes *axes, const hl_ridge_data *data,
                      const double (*x)[HL_GRAM_MAX], int threads, hl_ridge_work *work,
                      hl_ridge_slopes *out);

#endif
