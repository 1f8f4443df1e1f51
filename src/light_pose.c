/* What the pixels of one frame say about the ball's pose.
 *
 * The centre moves the normals (hl_surface_by_center), and with them every prediction. With the curves
 * fitted anew at a centre moved by +- e along each axis, half the difference of the residuals is the
 * derivative M with the curves profiled out (Golub & Pereyra 1973, the residual's own derivative); D is
 * that by the direction (light_model.c). With H = [D M]' W [D M] and the score g = [D M]' W r,
 * eliminating the direction's rows leaves
 *
 *   information = Hcc - Hcs Hss^-1 Hsc,   gradient = gc - Hcs Hss^-1 gs,   ds/dc = -Hss^-1 Hsc
 *
 * One frame alone knows little: a shift along the plane of light and view looks like another direction.
 * Many lights share the pose and none of their directions.
 */
#include "light_pose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cholesky.h"
#include "light_work.h"

static const double step_share = 3e-4; /* of the ball's radius */

enum { CHUNK = 64, SYSTEM = HL_NONLINEAR_MAX + 3 };

struct hl_light_pose_work {
  int max_pixels, channels;
  double *normal[3];                 /* shape (max_pixels) */
  double *moved[HL_CHANNELS_MAX][3]; /* shape (max_pixels): M */
  double *center_rate;               /* shape (max_pixels, 9) */
  double *pool;
  double scale; /* variance of a residual in units of its stated one */
  hl_model_point at, base;
};

hl_status hl_light_pose_new(hl_ctx *ctx, int max_pixels, int channels, hl_light_pose_work **out)
{
  const size_t n = (size_t)max_pixels;
  hl_light_pose_work *w = calloc(1, sizeof *w);
  double *pool = malloc((12 + 3 * (size_t)channels) * n * sizeof *pool);
  if (!w || !pool) {
    free(w);
    free(pool);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the pose of %d pixels", max_pixels);
  }
  w->pool = pool;
  w->max_pixels = max_pixels;
  w->channels = channels;
  for (int k = 0; k < 3; k++, pool += n)
    w->normal[k] = pool;
  for (int c = 0; c < channels; c++)
    for (int k = 0; k < 3; k++, pool += n)
      w->moved[c][k] = pool;
  w->center_rate = pool;
  *out = w;
  return HL_OK;
}

void hl_light_pose_free(hl_light_pose_work *work)
{
  if (!work)
    return;
  free(work->pool);
  free(work);
}

static void place(const struct hl_light_work *light, hl_light_pose_work *w, int axis, double by)
{
  const hl_light_data *d = &light->all;
  for (int i = 0; i < d->n; i++)
    for (int k = 0; k < 3; k++)
      w->normal[k][i] = d->normal[k][i] + by * w->center_rate[9 * i + 3 * k + axis];
}

/* Add `factor` times the prediction to M's column. */
static void add_prediction(const struct hl_light_work *light, hl_light_data *moved, int axis,
                           double factor, hl_light_pose_work *w)
{
  hl_model_pixel fit[CHUNK];
  for (int c = 0; c < moved->channels; c++)
    for (int first = 0; first < moved->n; first += CHUNK) {
      const int count = moved->n - first < CHUNK ? moved->n - first : CHUNK;
      hl_model_predict(&light->kept, moved, &w->at, NULL, first, count, c, fit);
      for (int i = 0; i < count; i++)
        w->moved[c][axis][first + i] += factor * fit[i].value;
    }
}

static bool differentiate(struct hl_light_work *light, double step, hl_light_pose_work *w)
{
  const hl_light_data *d = &light->all;
  hl_light_data moved = *d;
  for (int k = 0; k < 3; k++)
    moved.normal[k] = w->normal[k];
  for (int axis = 0; axis < 3; axis++) {
    for (int c = 0; c < d->channels; c++)
      memset(w->moved[c][axis], 0, (size_t)d->n * sizeof(double));
    for (int side = -1; side <= 1; side += 2) {
      place(light, w, axis, side * step);
      if (hl_model_fit(&light->kept, &moved, light->best.at.s, light->best.at.exponent, 1,
                       &light->model, &w->at) != 0)
        return false;
      add_prediction(light, &moved, axis, side / (2 * step), w);
    }
  }
  return true;
}

typedef struct sums {
  double h[SYSTEM][SYSTEM], g[SYSTEM], rr;
  long samples;
} sums;

/* D first, then M. */
static void add_channel(struct hl_light_work *light, const hl_light_pose_work *w, int c, int q,
                        sums *out)
{
  const hl_light_data *d = &light->all;
  hl_model_pixel fit[CHUNK];
  for (int first = 0; first < d->n; first += CHUNK) {
    const int count = d->n - first < CHUNK ? d->n - first : CHUNK;
    hl_model_predict(&light->kept, d, &w->base, light->best.step.solved, first, count, c, fit);
    for (int i = 0; i < count; i++) {
      const int p = first + i;
      const double weight = d->weight[c][p], r = d->value[c][p] - fit[i].value;
      double row[SYSTEM];
      if (!(weight > 0) || d->clipped[p] >> c & 1)
        continue;
      for (int u = 0; u < q; u++)
        row[u] = fit[i].profiled[u];
      for (int k = 0; k < 3; k++)
        row[q + k] = w->moved[c][k][p];
      for (int a = 0; a < q + 3; a++) {
        out->g[a] += weight * row[a] * r;
        for (int b = a; b < q + 3; b++)
          out->h[a][b] += weight * row[a] * row[b];
      }
      out->rr += weight * r * r;
      out->samples++;
    }
  }
}

static void eliminate(const sums *s, int q, hl_light_pose *out)
{
  double factor[HL_NONLINEAR_MAX * HL_NONLINEAR_MAX], solved[4][HL_NONLINEAR_MAX];
  const double scale = (double)s->samples / s->rr;
  memset(out, 0, sizeof *out);
  for (int a = 0; a < q; a++)
    for (int b = a; b < q; b++)
      factor[a * q + b] = s->h[a][b];
  hl_cholesky(factor, q, q, 1e-12);
  for (int k = 0; k < 4; k++) {
    for (int a = 0; a < q; a++)
      solved[k][a] = k < 3 ? s->h[a][q + k] : s->g[a];
    hl_cholesky_solve(factor, q, q, solved[k]);
  }
  for (int k = 0; k < 3; k++) {
    double sum = s->g[q + k];
    for (int a = 0; a < q; a++)
      sum -= s->h[a][q + k] * solved[3][a];
    out->gradient[k] = scale * sum;
    for (int u = 0; u < 2; u++)
      out->by_center[u][k] = -solved[k][u];
    for (int l = k; l < 3; l++) {
      sum = s->h[q + k][q + l];
      for (int a = 0; a < q; a++)
        sum -= s->h[a][q + k] * solved[l][a];
      out->information[k][l] = out->information[l][k] = scale * sum;
    }
  }
}

bool hl_light_pose_score(hl_light_work *light, const hl_surface *surface, hl_light_pose_work *work,
                         hl_light_pose *out)
{
  const hl_light_data *d = &light->all;
  const int q = hl_model_nonlinear(&light->kept);
  if (!surface->is_ball || d->n > work->max_pixels || d->channels > work->channels)
    return false;
  for (int i = 0; i < d->n; i++) {
    double rate[3][3];
    hl_surface_by_center(surface, light->index[i], rate);
    memcpy(work->center_rate + (size_t)9 * (size_t)i, rate, sizeof rate);
  }
  const bool kept = light->model.keep_smoothing;
  light->model.keep_smoothing = false;
  bool good = hl_model_fit(&light->kept, d, light->best.at.s, light->best.at.exponent, 1,
                           &light->model, &work->base) == 0;
  light->model.keep_smoothing = true;
  good = good && differentiate(light, step_share * surface->ball.radius_m, work);
  light->model.keep_smoothing = kept;
  if (!good)
    return false;
  sums s = {{{0}}, {0}, 0, 0};
  for (int c = 0; c < d->channels; c++)
    add_channel(light, work, c, q, &s);
  if (!(s.rr > 0) || s.samples < SYSTEM)
    return false;
  eliminate(&s, q, out);
  work->scale = s.rr / (double)s.samples;
  return true;
}

/* What to take of each column for the curve's value there. */
static void profile_row(const hl_light_model *model, double angle_rad, bool body, double cos_view,
                        double row[HL_COLUMNS_MAX])
{
  const int n = model->has_lobe ? model->spline.n : 0;
  memset(row, 0, HL_COLUMNS_MAX * sizeof *row);
  if (body) {
    const double of_body[3] = {1, cos_view, 1}; /* the light along the normal */
    memcpy(row + n, of_body, (size_t)model->body * sizeof *row);
  } else if (n > 0) {
    double band[4];
    const int at = hl_spline_values(&model->spline, 2 * sin(0.5 * angle_rad), band);
    memcpy(row + at, band, sizeof band);
  }
}

void hl_light_pose_profile(const hl_light_work *light, const hl_light_pose_work *work, int channel,
                           double mean_cos_view, const double *angle_rad, int n, double *covariance)
{
  const hl_light_model *model = &light->kept;
  const int columns = (model->has_lobe ? model->spline.n : 0) + hl_model_border(model);
  const double level = light->brightness.level;
  double row[HL_COLUMNS_MAX], other[HL_COLUMNS_MAX], solved[HL_COLUMNS_MAX];
  for (int i = 0; i < n; i++) {
    profile_row(model, angle_rad[i], i == 0, mean_cos_view, row);
    hl_normal_solve(&work->base.factor[channel], row, solved);
    for (int j = 0; j < n; j++) {
      double sum = 0;
      profile_row(model, angle_rad[j], j == 0, mean_cos_view, other);
      for (int k = 0; k < columns; k++)
        sum += other[k] * solved[k];
      covariance[i * n + j] = level * level * work->scale * sum;
    }
  }
}
