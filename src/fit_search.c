/* Where a further ridge should point: forward search (eqs. 18, 19).
 *
 * Each direction of a grid is judged by the share of the residual's square that a curve of steps
 * explains along it, plain or divided by n.v; the steps are as wide as the breaks of a spline, dense
 * at the highlight:
 *   gain = sum_bins (sum w g r)^2 / (sum w g^2)  over  sum w r^2
 * That is a few operations a sample and direction, so that hundreds of directions cost less than one
 * fit; what follows refines the best of them that are well apart.
 */
#include <math.h>
#include <string.h>

#include "fit_work.h"
#include "halflight/vec3.h"
#include "ridge_rows.h"

enum { GRID = 100, PLANE_GRID = 36, BINS = 16 };
static const double pi = 3.14159265358979323846;
static const double apart_rad = 0.2;

/* Data less what the model says, mean of the channels. */
static void set_residual(hl_fit_work *w, const hl_ridge_fit *model)
{
  const hl_ridge_data *d = &w->coarse;
  for (int i = 0; i < d->n; i++) {
    w->residual[i] = 0;
    for (int c = 0; c < d->channels; c++)
      w->residual[i] += d->y[c][i] / d->channels;
  }
  if (!model)
    return;
  hl_ridge_pass pass;
  hl_ridge_rows rows;
  hl_ridge_pass_begin(&model->ridges, &model->axes, d, &pass);
  for (int first = 0; first < d->n; first += HL_RIDGE_CHUNK) {
    const int count = d->n - first < HL_RIDGE_CHUNK ? d->n - first : HL_RIDGE_CHUNK;
    hl_ridge_rows_at(&pass, first, count, false, &rows);
    for (int c = 0; c < d->channels; c++) {
      double fit[HL_RIDGE_CHUNK];
      hl_ridge_rows_predict(&pass, &rows, model->curves.x[c], fit);
      for (int i = 0; i < count; i++)
        w->residual[first + i] -= fit[i] / d->channels;
    }
  }
}

static void judge(const hl_fit_work *w, const double a[3], double gain[2])
{
  const hl_ridge_data *d = &w->coarse;
  double wr[2][BINS] = {{0}}, ww[2][BINS] = {{0}};
  for (int i = 0; i < d->n; i++) {
    const double t = d->normal[0][i] * a[0] + d->normal[1][i] * a[1] + d->normal[2][i] * a[2];
    if (t <= 0)
      continue;
    const int bin = (int)(BINS * sqrt(sqrt(fmax(0, 1 - t))));
    const int at = bin < BINS ? bin : BINS - 1;
    const double weight = d->w[i], g = 1 / d->nv[i];
    wr[0][at] += weight * w->residual[i];
    ww[0][at] += weight;
    wr[1][at] += weight * g * w->residual[i];
    ww[1][at] += weight * g * g;
  }
  for (int k = 0; k < 2; k++) {
    gain[k] = 0;
    for (int b = 0; b < BINS; b++)
      if (ww[k][b] > 0)
        gain[k] += wr[k][b] * wr[k][b] / ww[k][b];
  }
}

/* Of the grid over all directions, or over the plane of light and view. */
static int grid(const hl_fit_work *w, double (*out)[3])
{
  double u[3], v[3];
  const double *axis = w->coarse.mean_view;
  if (w->in_plane) {
    for (int i = 0; i < PLANE_GRID; i++) {
      const double psi =
          pi * (0.7 * (i + 0.5) / PLANE_GRID - 0.1); /* from s + 0.3 s to v and beyond */
      for (int k = 0; k < 3; k++)
        out[i][k] = cos(psi) * w->light[k] + sin(psi) * axis[k];
      hl_unit(out[i], out[i]);
    }
    return PLANE_GRID;
  }
  hl_tangent_basis(axis, u, v);
  const double golden = pi * (1 + sqrt(5.0));
  for (int i = 0; i < GRID; i++) {
    const double z = 1 - 1.35 * (i + 0.5) / GRID;
    const double r = sqrt(fmax(0, 1 - z * z)), turn = golden * (i + 0.5);
    for (int k = 0; k < 3; k++)
      out[i][k] = r * cos(turn) * u[k] + r * sin(turn) * v[k] + z * axis[k];
  }
  return GRID;
}

int hl_fit_forward(hl_fit_work *w, const hl_ridge_fit *model, hl_fit_start *out, int most)
{
  double direction[GRID][3], gain[GRID][2], square = 0;
  bool used[GRID] = {false};
  const int n = grid(w, direction);
  int found = 0;
  set_residual(w, model);
  for (int i = 0; i < w->coarse.n; i++)
    square += w->coarse.w[i] * w->residual[i] * w->residual[i];
  for (int i = 0; i < n; i++)
    judge(w, direction[i], gain[i]);
  while (found < most) {
    int best = -1, kind = 0;
    for (int i = 0; i < n; i++)
      for (int k = 0; k < 2; k++) {
        const bool asked =
            w->lobe == HL_LOBE_AUTO || (w->lobe == HL_LOBE_FORESHORTENED) == (k == 1);
        if (!used[i] && asked && !(w->log_domain && k == 1) &&
            (best < 0 || gain[i][k] > gain[best][kind])) {
          best = i;
          kind = k;
        }
      }
    if (best < 0)
      break;
    memcpy(out[found].a, direction[best], sizeof out[found].a);
    out[found].foreshortened = kind == 1;
    out[found].gain = square > 0 ? gain[best][kind] / square : 0;
    found++;
    for (int i = 0; i < n; i++)
      used[i] = used[i] || hl_angle(direction[i], direction[best]) < apart_rad;
  }
  return found;
}
