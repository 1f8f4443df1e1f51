/* The light model as rows of a linear problem in its curves, given a direction of light. Private.
 */
#ifndef HL_LIGHT_MODEL_H
#define HL_LIGHT_MODEL_H

#include <stdbool.h>
#include <stdint.h>

#include "halflight/light.h"
#include "normal_equations.h"

enum {
  HL_NONLINEAR_MAX = 4, /* two tangent coordinates of s, the masking's exponent, the nearness */
  HL_SYSTEM_MAX = (HL_NONLINEAR_MAX * (HL_NONLINEAR_MAX + 1)) / 2
};
enum {
  HL_BLOCKS = 16,
  HL_BLOCKS_FROM = 2048
}; /* fixed, so that sums do not depend on the number of threads */

/* One thread goes without OpenMP, whose runtime may allocate: not even its entry is called, which is
 * why the parallel loops are functions of their own. */
#define HL_APART __attribute__((noinline))

/* The pixels in one place: structure of arrays, radiance divided by `level` of the frame. */
typedef struct hl_light_data {
  int n, channels;
  double *normal[3], *view[3];
  double *footprint;               /* change of the normal across a pixel [rad] */
  double *value[HL_CHANNELS_MAX];  /* radiance; the saturation level where clipped */
  double *weight[HL_CHANNELS_MAX]; /* 1 / variance; 0 = leave out */
  uint8_t *clipped;                /* bit c: channel c is at least `value` */
  uint8_t
      *side; /* pixels along a side of the square that a sample is the mean of; NULL: all are 1 */
  double
      *scatter[HL_CHANNELS_MAX]; /* variance of a pixel about its sample; nothing without `side` */
  int pixels;                    /* that the samples stand for, with `side` */
  double effective;              /* with `side`: see hl_light_effective */
  float *stretch; /* with `side`: as many times the weight, for others that were left out */
  double apart;   /* with `side`: cost of the pixels about their samples */
} hl_light_data;

/* Pixels that a sample is the mean of. */
static inline int hl_light_area(const hl_light_data *data, int i)
{
  return data->side ? data->side[i] * data->side[i] : 1;
}

/* Pixels whose noise is as large a share of the cost as the samples' is: fewer, where some stand for others
 * that were left out. */
static inline double hl_light_effective(const hl_light_data *data)
{
  return data->side ? data->effective : data->n;
}

/* Pixels that all samples stand for. */
static inline int hl_light_pixels(const hl_light_data *data)
{
  return data->side ? data->pixels : data->n;
}

static inline double hl_light_apart(const hl_light_data *data)
{
  return data->side ? data->apart : 0;
}

typedef struct hl_light_model {
  hl_lobe lobe;  /* plain or foreshortened */
  bool has_lobe; /* false: the border alone (a matte ball) */
  bool masking;  /* the lobe is shadowed and masked, by one exponent */
  int body;      /* 1: Lambert; 3: Lambert, n.s n.v and (n.s)^2 */
  bool ambient;
  bool backscatter;       /* a lobe about the view: D (n.v)^4 and D (n.v)^16 */
  bool near;              /* the light is at a finite distance from the ball's centre */
  double exponent_weight; /* pulls the masking's exponent to 0 */
  double body_weight[HL_CHANNELS_MAX]; /* pulls the body's further columns to 0 */
  hl_spline spline;                    /* over the chord u = |n - h| = 2 sin(angle / 2) */
} hl_light_model;

static inline int hl_model_nonlinear(const hl_light_model *model)
{
  return 2 + (model->masking ? 1 : 0) + (model->near ? 1 : 0);
}

/* Place of the nearness among the nonlinear parameters of a near model: the last. */
static inline int hl_model_nearness(const hl_light_model *model)
{
  return model->masking ? 3 : 2;
}

/* Border columns that shade with the light: the body's, then the backscatter's. */
static inline int hl_model_shaded(const hl_light_model *model)
{
  return model->body + (model->backscatter ? 2 : 0);
}

static inline int hl_model_border(const hl_light_model *model)
{
  return hl_model_shaded(model) + (model->ambient ? 1 : 0);
}

/* A clipped sample's row, kept for the rounds of censoring. */
typedef struct hl_clipped_row {
  double band[4], border[HL_BORDER_MAX];
  double weight, value;
  double now, change; /* prediction, and what a full step adds to it */
  int first, channel;
  bool active; /* the model falls short of the saturation level: the datum counts */
} hl_clipped_row;

/* Everything known at one direction. */
typedef struct hl_model_point {
  double s[3], t[2][3];                      /* direction and its tangents */
  double x[HL_CHANNELS_MAX][HL_COLUMNS_MAX]; /* curves */
  hl_normal_factor factor[HL_CHANNELS_MAX];
  double exponent; /* of the masking */
  double nearness; /* the ball's radius over the light's distance from its centre; 0 = distant */
  double cost;     /* r' W r */
} hl_model_point;

typedef struct hl_model_work {
  hl_normal block[HL_BLOCKS][HL_CHANNELS_MAX];
  double cross[HL_BLOCKS][HL_CHANNELS_MAX][HL_COLUMNS_MAX][HL_NONLINEAR_MAX]; /* X' W D */
  double inner[HL_BLOCKS][HL_SYSTEM_MAX + HL_NONLINEAR_MAX + 1]; /* D' W D, D' W r, r' W r */
  hl_smoothing smoothing[HL_CHANNELS_MAX];
  int censor_rounds;   /* how often to choose who pulls, at most; 0 = enough */
  bool keep_smoothing; /* use the last fit's; false settles it anew */
  int n_clipped[HL_BLOCKS];
  hl_clipped_row *clipped; /* shape (channels * n): block b owns its pixels' share */
  hl_model_point trial;
} hl_model_work;

/* Best curves at s; -1 where they cannot be had. Cost O(pixels). */
int hl_model_fit(const hl_light_model *model, const hl_light_data *data, const double s[3],
                 double exponent, int threads, hl_model_work *work, hl_model_point *out);
/* The same for a light at a finite distance; hl_model_fit is the one at nearness 0. */
int hl_model_fit_near(const hl_light_model *model, const hl_light_data *data, const double s[3],
                      double exponent, double nearness, int threads, hl_model_work *work,
                      hl_model_point *out);

/* The normal equations a channel at the point, clipped samples that pull there included. */
void hl_model_normal(const hl_light_model *model, const hl_light_data *data, int threads,
                     hl_model_work *work, const hl_model_point *at,
                     hl_normal normal[HL_CHANNELS_MAX]);

/* Gauss-Newton system of the nonlinear parameters with the curves profiled out (Kaufman). */
typedef struct hl_model_step {
  double gradient[HL_NONLINEAR_MAX];                  /* D' W r */
  double hessian[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX]; /* D' P D */
  double cost;
  double solved[HL_CHANNELS_MAX][HL_NONLINEAR_MAX][HL_COLUMNS_MAX]; /* A^-1 X' W D */
} hl_model_step;
void hl_model_differentiate(const hl_light_model *model, const hl_light_data *data,
                            const hl_model_point *at, int threads, hl_model_work *work,
                            hl_model_step *out);

/* Per pixel: what the model predicts, and its slopes with the curves held and profiled out. */
typedef struct hl_model_pixel {
  double value;
  double steepness; /* of the lobe alone, the shadow's edge apart */
  double slope[HL_NONLINEAR_MAX];
  double profiled[HL_NONLINEAR_MAX]; /* D - X A^-1 X'W D */
} hl_model_pixel;

/* `solved` is A^-1 X'W D a channel, from hl_model_differentiate; NULL leaves `profiled` at `slope`.
 */
void hl_model_predict(const hl_light_model *model, const hl_light_data *data,
                      const hl_model_point *at, double (*solved)[HL_NONLINEAR_MAX][HL_COLUMNS_MAX],
                      int first, int count, int channel, hl_model_pixel *out);

#endif
