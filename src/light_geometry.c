/* What the light inherits from an uncertain geometry.
 *
 * A small change of the geometry that moves a pixel's prediction by m, the curves held, moves the
 * direction by
 *
 *   ds = -H^-1 sum w d m,   m = df/dn . dn + df/dv . dv,
 *
 * d the pixel's slope with the curves profiled out: what the curves can follow is orthogonal to d, so
 * their own answer need not be computed. The pixel's derivatives df are taken once, and any number of
 * changes is then a product with how its normal and view move (surface_motion.c).
 *
 *   pose     J cov(C) J'         J = ds/dC
 *   camera   K cov(theta) K'     K = ds/dtheta + J dC/dtheta
 *
 * dC/dtheta is the centre that follows the camera it was found through: a principal point that is off
 * shifts the ball that is seen too, and much of the two cancels. Cov(C) is then the outline's own. A
 * centre from elsewhere does not follow.
 */
#include <string.h>

#include "light_censor.h"
#include "light_work.h"

static const double nudge = 1e-5; /* of a unit vector: far below a curve's width, above rounding */

enum { CHUNK = 64, GEOMETRY = 6 }; /* components of normal and view */

/* A few pixels whose geometry can be moved. */
typedef struct movable {
  int first;
  double at[GEOMETRY][CHUNK];
  hl_light_data data;
} movable;

static const double *component(const hl_light_data *d, int axis)
{
  return axis < 3 ? d->normal[axis] : d->view[axis - 3];
}

static void place(const hl_light_data *d, movable *m, int axis, double by)
{
  for (int i = 0; i < m->data.n; i++)
    m->at[axis][i] = component(d, axis)[m->first + i] + by;
}

static void movable_of(const hl_light_data *d, int first, int count, movable *m)
{
  m->first = first;
  m->data = (hl_light_data){.n = count, .channels = d->channels, .footprint = d->footprint + first};
  for (int axis = 0; axis < GEOMETRY; axis++) {
    place(d, m, axis, 0);
    (axis < 3 ? m->data.normal : m->data.view)[axis % 3] = m->at[axis];
  }
}

/* Per tangent of the fit, sum over channels of w d df/dn and of w d df/dv. */
typedef double pull[HL_NONLINEAR_MAX][GEOMETRY];

static void add_channel(struct hl_light_work *work, const hl_light_model *model, int c, movable *m,
                        pull *out)
{
  const hl_light_data *d = &work->all;
  const hl_model_point *at = &work->best.at;
  const int count = m->data.n, first = m->first;
  hl_model_pixel fit[CHUNK], low[CHUNK], high[CHUNK];
  hl_model_predict(model, d, at, work->best.step.solved, first, count, c, fit);
  for (int axis = 0; axis < GEOMETRY; axis++) {
    place(d, m, axis, -nudge);
    hl_model_predict(model, &m->data, at, NULL, 0, count, c, low);
    place(d, m, axis, nudge);
    hl_model_predict(model, &m->data, at, NULL, 0, count, c, high);
    place(d, m, axis, 0);
    for (int i = 0; i < count; i++) {
      const double weight = d->weight[c][first + i];
      const bool clipped = d->clipped[first + i] >> c & 1;
      if (!(weight > 0) || (clipped && !(fit[i].value < d->value[c][first + i])))
        continue;
      const double rate = (high[i].value - low[i].value) / (2 * nudge);
      for (int u = 0; u < hl_model_nonlinear(model); u++)
        out[i][u][axis] += weight * fit[i].profiled[u] * rate;
    }
  }
}

/* sum w d m of a block for unit changes of the centre and of the intrinsics. */
typedef struct score {
  double by_center[HL_NONLINEAR_MAX][3], by_intrinsics[HL_NONLINEAR_MAX][HL_INTRINSICS_MAX];
} score;

typedef struct task {
  struct hl_light_work *work;
  const hl_light_model *model;
  const hl_surface *surface;
  bool camera; /* its share is wanted too */
  score block[HL_BLOCKS];
} task;

static void add_pixel(const task *t, int pixel, pull p, score *out)
{
  const int at = t->work->index[pixel], q = hl_model_nonlinear(t->model);
  double center[3][3], normal[3][HL_INTRINSICS_MAX], view[3][HL_INTRINSICS_MAX];
  hl_surface_by_center(t->surface, at, center);
  for (int u = 0; u < q; u++)
    for (int k = 0; k < 3; k++)
      for (int j = 0; j < 3; j++)
        out->by_center[u][j] += p[u][k] * center[k][j];
  if (!t->camera || hl_surface_by_intrinsics(NULL, t->surface, at, normal, view) != HL_OK)
    return;
  for (int u = 0; u < q; u++)
    for (int k = 0; k < 3; k++)
      for (int j = 0; j < hl_camera_intrinsics_count(&t->surface->camera); j++)
        out->by_intrinsics[u][j] += p[u][k] * normal[k][j] + p[u][3 + k] * view[k][j];
}

static void add_block(task *t, int b)
{
  const hl_light_data *d = &t->work->all;
  const int end = hl_block_first(d->n, b + 1);
  pull pulls[CHUNK];
  movable m;
  memset(&t->block[b], 0, sizeof t->block[b]);
  for (int first = hl_block_first(d->n, b); first < end; first += CHUNK) {
    movable_of(d, first, end - first < CHUNK ? end - first : CHUNK, &m);
    memset(pulls, 0, sizeof pulls);
    for (int c = 0; c < d->channels; c++)
      add_channel(t->work, t->model, c, &m, pulls);
    for (int i = 0; i < m.data.n; i++)
      add_pixel(t, first + i, pulls[i], &t->block[b]);
  }
}

static HL_APART void add_parallel(task *t, int threads)
{
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (int b = 0; b < HL_BLOCKS; b++)
    add_block(t, b);
  (void)threads;
}

void hl_light_respond(struct hl_light_work *work, const hl_light_model *model,
                      const hl_surface *surface, const hl_light_spread *spread, int threads,
                      hl_light_response *out)
{
  task t = {work, model, surface, surface->camera.has_covariance, {{{{0}}, {{0}}}}};
  if (threads > 1)
    add_parallel(&t, threads);
  else
    for (int b = 0; b < HL_BLOCKS; b++)
      add_block(&t, b);
  memset(out, 0, sizeof *out);
  for (int b = 0; model->near && b < HL_BLOCKS; b++)
    for (int v = 0; v < hl_model_nonlinear(model); v++)
      for (int j = 0; j < 3; j++)
        out->nearness_by_center[j] -=
            spread->inverse[hl_model_nearness(model)][v] * t.block[b].by_center[v][j];
  for (int b = 0; b < HL_BLOCKS; b++)
    for (int u = 0; u < 2; u++)
      for (int v = 0; v < hl_model_nonlinear(model); v++) {
        for (int j = 0; j < 3; j++)
          out->by_center[u][j] -= spread->inverse[u][v] * t.block[b].by_center[v][j];
        for (int j = 0; j < HL_INTRINSICS_MAX; j++)
          out->by_intrinsics[u][j] -= spread->inverse[u][v] * t.block[b].by_intrinsics[v][j];
      }
}

/* J C J' for n columns; J's rows lie `stride` apart. */
static void carry(const double *j, int stride, const double *covariance, int n, double out[2][2])
{
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++) {
      out[u][v] = 0;
      for (int k = 0; k < n; k++)
        for (int l = 0; l < n; l++)
          out[u][v] += j[u * stride + k] * covariance[k * n + l] * j[v * stride + l];
    }
}

bool hl_surface_follows(const hl_surface *surface)
{
  return surface->is_ball && surface->ball.n_intrinsics > 0 &&
         surface->ball.n_intrinsics == hl_camera_intrinsics_count(&surface->camera);
}

void hl_light_geometry(struct hl_light_work *work, const hl_light_model *model,
                       const hl_surface *surface, const hl_light_spread *spread, int threads,
                       hl_light *out)
{
  const hl_camera *camera = &surface->camera;
  const hl_sphere *ball = &surface->ball;
  const bool pose = surface->is_ball && ball->has_covariance;
  const bool follows = camera->has_covariance && hl_surface_follows(surface);
  hl_light_response r;
  if (!surface->is_ball && !camera->has_covariance)
    return;
  hl_light_respond(work, model, surface, spread, threads, &r);
  memcpy(out->by_center, r.by_center, sizeof out->by_center);
  memcpy(out->by_intrinsics, r.by_intrinsics, sizeof out->by_intrinsics);
  if (pose) {
    out->part_stated[HL_PART_POSE] = true;
    carry(r.by_center[0], 3, follows ? ball->held_covariance_m2[0] : ball->covariance_m2[0], 3,
          out->part_rad2[HL_PART_POSE]);
  }
  if (!camera->has_covariance)
    return;
  const int n = hl_camera_intrinsics_count(camera);
  for (int u = 0; follows && u < 2; u++)
    for (int j = 0; j < n; j++)
      for (int k = 0; k < 3; k++)
        r.by_intrinsics[u][j] += r.by_center[u][k] * ball->by_intrinsics[k][j];
  out->part_stated[HL_PART_CAMERA] = true;
  carry(r.by_intrinsics[0], HL_INTRINSICS_MAX, camera->covariance, n,
        out->part_rad2[HL_PART_CAMERA]);
}
