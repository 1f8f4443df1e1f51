/* Final curves: monotone, non-negative, through zero (paper L1 to L4), at the direction found.
 *
 * A spline whose coefficients fall from the highlight outwards falls itself, so with
 *   c_i = sum_{j >= i} d_j,  d >= 0,  c_{n-1} = 0
 * the lobe is monotone in n.h, non-negative, and zero at n.h = 0. The body grows from zero with n.s
 * for every n.v when it is a non-negative sum of
 *   D n.v,   D (1 - n.v),   D^2,   2D - D^2,
 * which between them span Lambert's D and the two bends of light_model.c. Both are non-negative
 * least squares in the normal equations that the fit has anyway.
 */
#include <math.h>
#include <string.h>

#include "light_work.h"
#include "nnls.h"

enum { BODY_CONES = 4 };
/* Body columns (D, D n.v, D^2) of each cone generator. */
static const double cone[BODY_CONES][3] = {{0, 1, 0}, {1, -1, 0}, {0, 0, 1}, {2, 0, -1}};
static const double half_pi = 1.57079632679489661923;

typedef struct constrained {
  int n, m; /* columns of the model */
  int unknowns;
  int lobes; /* of them */
  int cones;
  int retro; /* backscatter's */
} constrained;

static constrained shape_of(const hl_light_model *model)
{
  constrained s = {.n = model->has_lobe ? model->spline.n : 0, .m = hl_model_border(model)};
  s.lobes = s.n > 0 ? s.n - 1 : 0;
  s.cones = model->body > 1 ? BODY_CONES : 1;
  s.retro = model->backscatter ? 2 : 0;
  s.unknowns = s.lobes + s.cones + s.retro + (model->ambient ? 1 : 0);
  return s;
}

/* x = T d */
static void expand(const hl_light_model *model, const constrained *s, const double *d, double *x)
{
  double sum = 0;
  memset(x, 0, sizeof *x * (size_t)(s->n + s->m));
  for (int i = s->lobes - 1; i >= 0; i--)
    x[i] = sum += d[i];
  if (s->cones == 1)
    x[s->n] = d[s->lobes];
  else
    for (int g = 0; g < BODY_CONES; g++)
      for (int j = 0; j < 3; j++)
        x[s->n + j] += cone[g][j] * d[s->lobes + g];
  for (int j = 0; j < s->retro; j++)
    x[s->n + model->body + j] = d[s->lobes + s->cones + j];
  if (model->ambient)
    x[s->n + s->m - 1] = d[s->unknowns - 1];
}

/* d' = T' x */
static void contract(const hl_light_model *model, const constrained *s, const double *x, double *d)
{
  double sum = 0;
  for (int i = 0; i < s->lobes; i++)
    d[i] = sum += x[i];
  for (int g = 0; g < s->cones; g++) {
    d[s->lobes + g] = s->cones == 1 ? x[s->n] : 0;
    for (int j = 0; s->cones > 1 && j < 3; j++)
      d[s->lobes + g] += cone[g][j] * x[s->n + j];
  }
  for (int j = 0; j < s->retro; j++)
    d[s->lobes + s->cones + j] = x[s->n + model->body + j];
  if (model->ambient)
    d[s->unknowns - 1] = x[s->n + s->m - 1];
}

static void solve_constrained(const hl_light_model *model, const constrained *s, const hl_normal *a,
                              double *x)
{
  double dense[HL_COLUMNS_MAX * HL_COLUMNS_MAX] = {0}, half[HL_COLUMNS_MAX][HL_NNLS_MAX] = {{0}};
  double gram[HL_NNLS_MAX * HL_NNLS_MAX], rhs[HL_NNLS_MAX] = {0}, d[HL_NNLS_MAX] = {0};
  const int total = s->n + s->m;
  hl_normal_dense(a, dense);
  for (int i = 0; i < total; i++)
    contract(model, s, dense + (long)i * total, half[i]);
  for (int j = 0; j < s->unknowns; j++) {
    double column[HL_COLUMNS_MAX] = {0}, out[HL_NNLS_MAX] = {0};
    for (int i = 0; i < total; i++)
      column[i] = half[i][j];
    contract(model, s, column, out);
    for (int k = 0; k < s->unknowns; k++)
      gram[(long)k * s->unknowns + j] = out[k];
  }
  contract(model, s, a->rhs, rhs);
  /* unsettled it is feasible all the same, and as near as the rounds allow */
  (void)hl_nnls(gram, rhs, s->unknowns, d);
  expand(model, s, d, x);
}

static double body_value(const hl_light_model *model, const double *x, double cosine,
                         double cos_view)
{
  if (model->body == 1)
    return x[0] * cosine;
  return cosine * (x[0] + x[1] * cos_view + x[2] * cosine);
}

static double lobe_value(const hl_light_model *model, const double *x, double angle_rad)
{
  double b[4], sum = 0;
  const int at = hl_spline_values(&model->spline, 2 * sin(angle_rad / 2), b);
  for (int k = 0; k < 4; k++)
    sum += b[k] * x[at + k];
  return sum > 0 ? sum : 0;
}

static double mean_cos_view(const hl_light_data *d)
{
  double sum = 0;
  for (int i = 0; i < d->n; i++)
    for (int k = 0; k < 3; k++)
      sum += d->normal[k][i] * d->view[k][i];
  return d->n > 0 ? sum / d->n : 1;
}

void hl_light_curves(struct hl_light_work *work, const hl_light_model *model, int threads,
                     hl_light *out)
{
  static const char *const colours[HL_CHANNELS_MAX] = {"r", "g", "b"};
  const constrained s = shape_of(model);
  const double cos_view = mean_cos_view(work->on_cells ? &work->aside.all : &work->all);
  const double level = work->brightness.level;
  hl_normal normal[HL_CHANNELS_MAX];
  out->n_curves = 0;
  hl_model_normal(model, &work->all, threads, &work->model, &work->best.at, normal);
  for (int c = 0; c < work->all.channels; c++) {
    double x[HL_COLUMNS_MAX];
    solve_constrained(model, &s, &normal[c], x);
    for (int lobe = 0; lobe < (model->has_lobe ? 2 : 1); lobe++) {
      hl_curve *curve = &out->curves[out->n_curves++];
      curve->lobe = lobe == 0 ? "diffuse" : "specular";
      curve->channel = work->all.channels == 1 ? "grey" : colours[c];
      curve->n = HL_CURVE_POINTS;
      for (int i = 0; i < HL_CURVE_POINTS; i++) {
        const double share = (double)i / (HL_CURVE_POINTS - 1);
        curve->angle_rad[i] = half_pi * (lobe == 0 ? share : share * share);
        const double cosine = i == HL_CURVE_POINTS - 1 ? 0 : cos(curve->angle_rad[i]);
        curve->value[i] = level * (lobe == 0 ? body_value(model, x + s.n, cosine, cos_view)
                                             : lobe_value(model, x, curve->angle_rad[i]));
      }
      curve->value[HL_CURVE_POINTS - 1] = 0;
    }
    out->diffuse_strength[c] = level * body_value(model, x + s.n, 1, cos_view);
    out->diffuse_view_slope[c] = model->body > 1 ? level * x[s.n + 1] : 0;
    out->ambient[c] = model->ambient ? level * x[s.n + s.m - 1] : 0;
    for (int j = 0; j < s.retro; j++)
      out->backscatter[c][j] = level * x[s.n + model->body + j];
    out->lobe_strength[c] = model->has_lobe ? level * lobe_value(model, x, 0) : 0;
  }
  out->mean_cos_view = cos_view;
  for (int c = work->all.channels; c < HL_CHANNELS_MAX; c++) {
    out->ambient[c] = out->ambient[0];
    memcpy(out->backscatter[c], out->backscatter[0], sizeof out->backscatter[c]);
    out->diffuse_strength[c] = out->diffuse_strength[0];
    out->diffuse_view_slope[c] = out->diffuse_view_slope[0];
    out->lobe_strength[c] = out->lobe_strength[0];
  }
}
