/* Rows of the light model for a chunk of pixels. Private. */
#ifndef HL_LIGHT_ROWS_H
#define HL_LIGHT_ROWS_H

#include <math.h>

#include "light_model.h"

enum { HL_ROWS_CHUNK = 64 };

/* The geometry of the rows, and its slopes along both tangents of s and, where the light is near, by its
 * nearness. */
enum { HL_ROWS_SLOPES = 3 };
typedef struct hl_rows {
  double u[HL_ROWS_CHUNK], du[HL_ROWS_SLOPES][HL_ROWS_CHUNK];
  double lit[HL_ROWS_CHUNK], dlit[HL_ROWS_SLOPES][HL_ROWS_CHUNK]; /* a near light's times fall */
  double g[HL_ROWS_CHUNK], dg[HL_ROWS_SLOPES][HL_ROWS_CHUNK];
  double masking[HL_ROWS_CHUNK]; /* log M */
  double body[HL_ROWS_CHUNK], dbody[HL_ROWS_SLOPES][HL_ROWS_CHUNK], nv[HL_ROWS_CHUNK];
  double fall[HL_ROWS_CHUNK], dfall[HL_ROWS_SLOPES][HL_ROWS_CHUNK]; /* of a near light alone */
} hl_rows;

/* A distant light. Pixels first .. first + count - 1, count <= HL_ROWS_CHUNK; t NULL: no slopes. */
void hl_rows_geometry(const hl_light_model *model, const hl_light_data *data, int first, int count,
                      const double s[3], double exponent, const double (*t)[3], hl_rows *rows);

/* light_rows_near.c: the same of a light at a finite distance. */
void hl_rows_near(const hl_light_model *model, const hl_light_data *data, int first, int count,
                  const hl_model_point *at, bool slopes, hl_rows *rows);

static inline void hl_rows_at(const hl_light_model *model, const hl_light_data *data, int first,
                              int count, const hl_model_point *at, bool slopes, hl_rows *rows)
{
  if (model->near)
    hl_rows_near(model, data, first, count, at, slopes, rows);
  else
    hl_rows_geometry(model, data, first, count, at->s, at->exponent, slopes ? at->t : NULL, rows);
}

/* Columns that shade with the light, D, D n.v, D^2, then D (n.v)^4, D (n.v)^16: value, slope by D. */
static inline double hl_rows_shaded(const hl_light_model *model, int j, double d, double nv,
                                    double *rate)
{
  const double square = nv * nv, fourth = square * square, eighth = fourth * fourth;
  switch (j < model->body ? j : 3 + j - model->body) {
  case 0:
    *rate = 1;
    return d;
  case 1:
    *rate = nv;
    return d * nv;
  case 2:
    *rate = 2 * d;
    return d * d;
  case 3:
    *rate = fourth;
    return d * fourth;
  default:
    *rate = eighth * eighth;
    return d * *rate;
  }
}

static inline void hl_rows_border(const hl_light_model *model, const hl_rows *c, int i,
                                  double border[HL_BORDER_MAX])
{
  const int shaded = hl_model_shaded(model);
  double rate;
  for (int j = 0; j < shaded; j++)
    border[j] = hl_rows_shaded(model, j, c->body[i], c->nv[i], &rate);
  if (model->near)
    for (int j = 0; j < shaded; j++)
      border[j] *= c->fall[i];
  if (model->ambient)
    border[shaded] = 1;
}

/* Slopes of the shaded columns times x, which starts at the border. */
static inline void hl_rows_shading_slopes(const hl_light_model *model, const hl_rows *c, int i,
                                          const double *x, double *slope)
{
  const int last = hl_model_nearness(model);
  for (int j = 0; j < hl_model_shaded(model); j++) {
    double rate;
    const double bare = hl_rows_shaded(model, j, c->body[i], c->nv[i], &rate);
    if (!model->near) {
      for (int k = 0; k < 2; k++)
        slope[k] += rate * c->dbody[k][i] * x[j];
      continue;
    }
    for (int k = 0; k < HL_ROWS_SLOPES; k++)
      slope[k < 2 ? k : last] +=
          (c->fall[i] * rate * c->dbody[k][i] + c->dfall[k][i] * bare) * x[j];
  }
}

/* Value of the row times x, and its slopes by the nonlinear parameters with x held. `steepness`, where
 * not NULL, receives the length of the lobe's own slope, the shadow's edge apart. */
static inline double hl_rows_predict(const hl_light_model *model, const hl_rows *c, int i,
                                     const double *x, int *at, double band[4],
                                     double border[HL_BORDER_MAX], double *slope, double *steepness)
{
  const int n = model->has_lobe ? model->spline.n : 0;
  const int m = hl_model_border(model);
  double sum = 0;
  for (int k = 0; k < hl_model_nonlinear(model); k++)
    slope[k] = 0;
  if (n > 0) {
    double rate[4], lobe = 0, lobe_rate = 0;
    *at = hl_spline_values(&model->spline, c->u[i], band);
    hl_spline_slopes(&model->spline, *at, c->u[i], rate);
    for (int k = 0; k < 4; k++) {
      lobe += band[k] * x[*at + k];
      lobe_rate += rate[k] * x[*at + k];
      band[k] *= c->lit[i] * c->g[i];
    }
    sum += c->lit[i] * c->g[i] * lobe;
    for (int k = 0; k < (model->near ? HL_ROWS_SLOPES : 2); k++)
      slope[k < 2 ? k : hl_model_nearness(model)] +=
          c->lit[i] * c->g[i] * lobe_rate * c->du[k][i] +
          (c->dlit[k][i] * c->g[i] + c->lit[i] * c->dg[k][i]) * lobe;
    if (steepness)
      *steepness = fabs(c->lit[i] * c->g[i] * lobe_rate) *
                   sqrt(c->du[0][i] * c->du[0][i] + c->du[1][i] * c->du[1][i]);
    if (model->masking)
      slope[2] = c->lit[i] * c->g[i] * lobe * c->masking[i];
  }
  hl_rows_border(model, c, i, border);
  for (int j = 0; j < m; j++)
    sum += border[j] * x[n + j];
  hl_rows_shading_slopes(model, c, i, x + n, slope);
  return sum;
}

/* What the channels of a pixel share, of a distant light. */
typedef struct hl_rows_shared {
  int column;
  double band[4], rate[4]; /* of the splines, bare */
  double lit_g;
  double along[2], across[2]; /* of a tangent: by the spline's slope, and by its value */
  double border[HL_BORDER_MAX], border_rate[HL_BORDER_MAX];
  double dbody[2], masking;
} hl_rows_shared;

static inline void hl_rows_share(const hl_light_model *model, const hl_rows *c, int i,
                                 hl_rows_shared *out)
{
  *out = (hl_rows_shared){.lit_g = c->lit[i] * c->g[i]};
  if (model->has_lobe) {
    out->column = hl_spline_values(&model->spline, c->u[i], out->band);
    hl_spline_slopes(&model->spline, out->column, c->u[i], out->rate);
    for (int k = 0; k < 2; k++) {
      out->along[k] = out->lit_g * c->du[k][i];
      out->across[k] = c->dlit[k][i] * c->g[i] + c->lit[i] * c->dg[k][i];
    }
  }
  for (int j = 0; j < hl_model_shaded(model); j++)
    out->border[j] = hl_rows_shaded(model, j, c->body[i], c->nv[i], &out->border_rate[j]);
  if (model->ambient) {
    out->border[hl_model_shaded(model)] = 1;
    out->border_rate[hl_model_shaded(model)] = 0;
  }
  out->dbody[0] = c->dbody[0][i];
  out->dbody[1] = c->dbody[1][i];
  out->masking = model->masking ? c->masking[i] : 0;
}

/* Value and slopes of one channel; as hl_rows_predict. */
static inline double hl_rows_of_channel(const hl_rows_shared *p, int n, int m, int nonlinear,
                                        const double *x, double *slope)
{
  double lobe = 0, lobe_rate = 0, body = 0, body_rate = 0;
  for (int k = 0; n > 0 && k < 4; k++) {
    lobe += p->band[k] * x[p->column + k];
    lobe_rate += p->rate[k] * x[p->column + k];
  }
  for (int j = 0; j < m; j++) {
    body += p->border[j] * x[n + j];
    body_rate += p->border_rate[j] * x[n + j];
  }
  for (int k = 0; k < 2; k++)
    slope[k] = p->dbody[k] * body_rate + p->along[k] * lobe_rate + p->across[k] * lobe;
  if (nonlinear > 2)
    slope[2] = p->lit_g * lobe * p->masking;
  return (n > 0 ? p->lit_g * lobe : 0) + body;
}

#endif
