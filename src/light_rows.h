/* Rows of the light model for a chunk of pixels. Private. */
#ifndef HL_LIGHT_ROWS_H
#define HL_LIGHT_ROWS_H

#include <math.h>

#include "light_model.h"

enum { HL_ROWS_CHUNK = 64 };

/* The geometry of the rows, and its slopes along both tangents of s. */
typedef struct hl_rows {
  double u[HL_ROWS_CHUNK], du[2][HL_ROWS_CHUNK];
  double lit[HL_ROWS_CHUNK], dlit[2][HL_ROWS_CHUNK];
  double g[HL_ROWS_CHUNK], dg[2][HL_ROWS_CHUNK];
  double masking[HL_ROWS_CHUNK]; /* log M */
  double body[HL_ROWS_CHUNK], dbody[2][HL_ROWS_CHUNK], nv[HL_ROWS_CHUNK];
} hl_rows;

/* Pixels first .. first + count - 1, count <= HL_ROWS_CHUNK; t NULL: no slopes. */
void hl_rows_geometry(const hl_light_model *model, const hl_light_data *data, int first, int count,
                      const double s[3], double exponent, const double (*t)[3], hl_rows *rows);

/* Body's columns D, D n.v, D^2: value and slope by D. */
static inline double hl_rows_body(int j, double d, double nv, double *rate)
{
  switch (j) {
  case 0:
    *rate = 1;
    return d;
  case 1:
    *rate = nv;
    return d * nv;
  default:
    *rate = 2 * d;
    return d * d;
  }
}

static inline void hl_rows_border(const hl_light_model *model, double body, double nv,
                                  double border[HL_BORDER_MAX])
{
  double rate;
  int j = 0;
  for (; j < model->body; j++)
    border[j] = hl_rows_body(j, body, nv, &rate);
  if (model->ambient)
    border[j] = 1;
}

/* Value of the row times x, and its slopes along both tangents with x held. `steepness`, where not
 * NULL, receives the length of the lobe's own slope, the shadow's edge apart. */
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
    for (int k = 0; k < 2; k++)
      slope[k] += c->lit[i] * c->g[i] * lobe_rate * c->du[k][i] +
                  (c->dlit[k][i] * c->g[i] + c->lit[i] * c->dg[k][i]) * lobe;
    if (steepness)
      *steepness = fabs(c->lit[i] * c->g[i] * lobe_rate) * hypot(c->du[0][i], c->du[1][i]);
    if (model->masking)
      slope[2] = c->lit[i] * c->g[i] * lobe * c->masking[i];
  }
  hl_rows_border(model, c->body[i], c->nv[i], border);
  for (int j = 0; j < m; j++) {
    sum += border[j] * x[n + j];
    if (j < model->body) {
      double rate;
      hl_rows_body(j, c->body[i], c->nv[i], &rate);
      for (int k = 0; k < 2; k++)
        slope[k] += rate * c->dbody[k][i] * x[n + j];
    }
  }
  return sum;
}

#endif
