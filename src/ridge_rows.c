/* Rows of a sum of ridges.
 *
 *   t = n.a,  a = w/|w|,  u = |n - a|,  du = -dt/u,  dt = n.da
 *   da = tau                                    free, tau a tangent of a
 *   da = (I - aa')(cs tau)/|w|                  named, tau a tangent of the light sought
 *   da = (I - aa')(cos psi v - sin psi s)/|w|   in the plane
 */
#include "ridge_rows.h"

#include <math.h>
#include <string.h>

#include "halflight/vec3.h"

static const double root2 = 1.41421356237309504880;

/* ---- axes ---- */

static int own_parameters(const hl_axes *axes, int i)
{
  switch (axes->axis[i].kind) {
  case HL_AXIS_FREE:
    return 2;
  case HL_AXIS_PLANE:
    return 1;
  case HL_AXIS_FIXED:
  case HL_AXIS_NAMED:
    break;
  }
  return 0;
}

/* How many parameters a term has, the light's for a named one; *first its first. */
static int parameters_of(const hl_axes *axes, int i, int *first)
{
  *first = axes->seeks_light ? 2 : 0;
  if (axes->axis[i].kind == HL_AXIS_NAMED) {
    *first = 0;
    return axes->seeks_light ? 2 : 0;
  }
  for (int k = 0; k < i; k++)
    *first += own_parameters(axes, k);
  return own_parameters(axes, i);
}

int hl_axes_parameters(const hl_axes *axes)
{
  int n = axes->seeks_light ? 2 : 0;
  for (int i = 0; i < axes->n; i++)
    n += own_parameters(axes, i);
  return n;
}

static bool is_fixed_in_space(const hl_axis *axis)
{
  return axis->kind == HL_AXIS_FIXED || axis->kind == HL_AXIS_FREE;
}

void hl_axes_settle(hl_axes *axes, const double mean_view[3])
{
  for (int i = 0; i < axes->n; i++) {
    hl_axis *axis = &axes->axis[i];
    for (int k = 0; k < 3 && !is_fixed_in_space(axis); k++)
      axis->a[k] = axis->cs * axes->light[k] + axis->cv * mean_view[k];
    hl_unit(axis->a, axis->a);
  }
}

static void turn(const double a[3], const double delta[2], double out[3])
{
  double u[3], w[3];
  hl_tangent_basis(a, u, w);
  for (int k = 0; k < 3; k++)
    out[k] = a[k] + delta[0] * u[k] + delta[1] * w[k];
  hl_unit(out, out);
}

void hl_axes_move(const hl_axes *axes, const double *delta, const double mean_view[3], hl_axes *out)
{
  *out = *axes;
  if (axes->seeks_light)
    turn(axes->light, delta, out->light);
  for (int i = 0; i < axes->n; i++) {
    hl_axis *axis = &out->axis[i];
    int first = 0;
    (void)parameters_of(axes, i, &first);
    if (axis->kind == HL_AXIS_FREE) {
      turn(axes->axis[i].a, delta + first, axis->a);
    } else if (axis->kind == HL_AXIS_PLANE) {
      const double psi = atan2(axis->cv, axis->cs) + delta[first];
      axis->cs = cos(psi);
      axis->cv = sin(psi);
    }
  }
  hl_axes_settle(out, mean_view);
}

/* (I - aa') d / length */
static void project_off(const double a[3], double length, double d[3])
{
  const double along = hl_dot(a, d);
  for (int k = 0; k < 3; k++)
    d[k] = (d[k] - along * a[k]) / length;
}

static void frame_at(const hl_axes *axes, int i, const double view[3], hl_axis_frame *f)
{
  const hl_axis *axis = &axes->axis[i];
  double w[3];
  f->count = parameters_of(axes, i, &f->first);
  if (is_fixed_in_space(axis)) {
    memcpy(f->a, axis->a, sizeof f->a);
    if (f->count > 0)
      hl_tangent_basis(axis->a, f->da[0], f->da[1]);
    return;
  }
  for (int k = 0; k < 3; k++)
    w[k] = axis->cs * axes->light[k] + axis->cv * view[k];
  const double length = hl_norm(w) + 1e-300;
  hl_unit(w, f->a);
  if (axis->kind == HL_AXIS_PLANE) {
    for (int k = 0; k < 3; k++)
      f->da[0][k] = axis->cs * view[k] - axis->cv * axes->light[k];
    project_off(f->a, length, f->da[0]);
  } else if (f->count > 0) {
    hl_tangent_basis(axes->light, f->da[0], f->da[1]);
    for (int j = 0; j < 2; j++) {
      for (int k = 0; k < 3; k++)
        f->da[j][k] *= axis->cs;
      project_off(f->a, length, f->da[j]);
    }
  }
}

void hl_ridge_pass_begin(const hl_ridges *ridges, const hl_axes *axes, const hl_ridge_data *data,
                         hl_ridge_pass *out)
{
  out->ridges = ridges;
  out->axes = axes;
  out->data = data;
  out->columns = hl_ridges_columns(ridges);
  out->widest = ridges->free_curves ? 3 : root2;
  for (int i = 0; i < ridges->n; i++) {
    out->first[i] = hl_ridges_first(ridges, i);
    frame_at(axes, i, data->mean_view, &out->frame[i]);
  }
}

/* ---- rows ---- */

/* One axis for all samples: loops that become vectors. */
static void geometry_of_one(const hl_ridge_data *d, const hl_axis_frame *f, int first, int count,
                            bool slopes, hl_ridge_term_rows *r)
{
  const double *nx = d->normal[0] + first, *ny = d->normal[1] + first, *nz = d->normal[2] + first;
  const double ax = f->a[0], ay = f->a[1], az = f->a[2];
  for (int i = 0; i < count; i++) {
    const double x = nx[i] - ax, y = ny[i] - ay, z = nz[i] - az;
    const double square = x * x + y * y + z * z;
    r->t[i] = 1 - 0.5 * square;
    r->u[i] = sqrt(square) + 1e-12;
  }
  for (int k = 0; k < f->count && slopes; k++)
    for (int i = 0; i < count; i++)
      r->dt[k][i] = nx[i] * f->da[k][0] + ny[i] * f->da[k][1] + nz[i] * f->da[k][2];
}

/* An axis that follows each sample's view. */
static void geometry_of_views(const hl_ridge_pass *p, int term, int first, int count,
                              hl_ridge_term_rows *r)
{
  const hl_ridge_data *d = p->data;
  for (int i = 0; i < count; i++) {
    const int at = first + i;
    const double n[3] = {d->normal[0][at], d->normal[1][at], d->normal[2][at]};
    const double v[3] = {d->view[0][at], d->view[1][at], d->view[2][at]};
    double off[3];
    hl_axis_frame f = {{0}, {{0}}, 0, 0};
    frame_at(p->axes, term, v, &f);
    hl_add_scaled(n, -1, f.a, off);
    r->t[i] = 1 - 0.5 * hl_dot(off, off);
    r->u[i] = hl_norm(off) + 1e-12;
    for (int k = 0; k < f.count; k++)
      r->dt[k][i] = hl_dot(n, f.da[k]);
  }
}

static void linear_rows(int column, int count, hl_ridge_term_rows *r)
{
  for (int i = 0; i < count; i++) {
    r->at[i] = column;
    r->value[i][0] = r->g[i] * r->t[i];
    r->rate[i][0] = r->g[i];
  }
}

static void spline_rows(const hl_ridge_pass *p, int term, int count, bool slopes,
                        hl_ridge_term_rows *r)
{
  const hl_spline *spline = p->ridges->spline[term];
  const int column = p->first[term];
  for (int i = 0; i < count; i++) {
    const bool shown = r->u[i] < p->widest;
    const bool held = r->u[i] <= spline->low;
    const double g = shown ? r->g[i] : 0;
    const double u = held ? spline->low : shown ? r->u[i] : spline->high;
    double value[4], rate[4];
    const int at = hl_spline_values(spline, u, value);
    r->at[i] = column + at;
    for (int k = 0; k < 4; k++)
      r->value[i][k] = g * value[k];
    if (!slopes)
      continue;
    hl_spline_slopes(spline, at, u, rate);
    const double by_t = held ? 0 : -g / u;
    for (int k = 0; k < 4; k++)
      r->rate[i][k] = by_t * rate[k];
  }
}

static void geometry(const hl_ridge_pass *p, int term, int first, int count, bool slopes,
                     hl_ridge_term_rows *r)
{
  const hl_ridge_data *d = p->data;
  if (d->view[0] && !is_fixed_in_space(&p->axes->axis[term]))
    geometry_of_views(p, term, first, count, r);
  else
    geometry_of_one(d, &p->frame[term], first, count, slopes, r);
  for (int i = 0; i < count; i++)
    r->g[i] = p->ridges->foreshortened[term] ? 1 / d->nv[first + i] : 1;
}

void hl_ridge_rows_chords(const hl_ridge_pass *p, int term, int first, int count,
                          hl_ridge_term_rows *out)
{
  geometry(p, term, first, count, false, out);
}

void hl_ridge_rows_at(const hl_ridge_pass *p, int first, int count, bool slopes,
                      hl_ridge_rows *rows)
{
  rows->count = count;
  for (int j = 0; j < p->ridges->n; j++) {
    hl_ridge_term_rows *r = &rows->term[j];
    geometry(p, j, first, count, slopes, r);
    if (p->ridges->linear[j])
      linear_rows(p->first[j], count, r);
    else
      spline_rows(p, j, count, slopes, r);
  }
}

void hl_ridge_rows_predict(const hl_ridge_pass *p, const hl_ridge_rows *rows, const double *x,
                           double out[HL_RIDGE_CHUNK])
{
  const double constant = p->ridges->has_constant ? x[p->columns - 1] : 0;
  for (int i = 0; i < rows->count; i++)
    out[i] = constant;
  for (int j = 0; j < p->ridges->n; j++) {
    const hl_ridge_term_rows *r = &rows->term[j];
    if (p->ridges->linear[j]) {
      for (int i = 0; i < rows->count; i++)
        out[i] += r->value[i][0] * x[p->first[j]];
      continue;
    }
    for (int i = 0; i < rows->count; i++) {
      const double *c = x + r->at[i], *b = r->value[i];
      out[i] += (b[0] * c[0] + b[1] * c[1]) + (b[2] * c[2] + b[3] * c[3]);
    }
  }
}

double hl_ridge_value(const hl_ridges *ridges, int term, const double *x, double t)
{
  const double *c = x + hl_ridges_first(ridges, term);
  double u = sqrt(fmax(0, 2 - 2 * t));
  double value[4];
  if (ridges->linear[term])
    return c[0] * t;
  if (u >= (ridges->free_curves ? 3 : root2))
    return 0;
  u = fmax(u, ridges->spline[term]->low);
  const int at = hl_spline_values(ridges->spline[term], u, value);
  return (value[0] * c[at] + value[1] * c[at + 1]) + (value[2] * c[at + 2] + value[3] * c[at + 3]);
}
