/* Where on the sphere of lights to start.
 *
 * A few hundred directions out to widest_deg from the view (a light behind the rim still lights a
 * crescent), and the mirror directions s = 2(n.v)n - v of the brightest separate spots, because a
 * sharp highlight falls between the grid's directions. Each is judged by the model itself with a
 * coarse basis on some two thousand pixels: the brightest few hundred, which hold a sharp
 * highlight, and a regular choice of the rest, which hold the shadow. The best that are well apart
 * are refined, on those pixels and then on all. Weights are relative to the pixel: they find the
 * right basin also where a highlight is a thousand times brighter than the rest.
 */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "halflight/vec3.h"
#include "light_work.h"

enum {
  GRID = 360,
  SPOTS = 4,
  BRIGHTEST = 400,
  REGULAR = 1400,
  COARSE_BREAKS = 14,
  MIDDLE_BREAKS = 24,
  CENSOR_ROUNDS = 4,
  FINE_BREAKS = 40,
  LEAST_PIXELS = 6,
  ITERATIONS = 6
};
static const double pi = 3.14159265358979323846;
static const double spots_apart_rad = 0.15;
static const double candidates_apart_rad = 0.26;
static const double coarse_tolerance_rad = 1e-4;
static const double worth_refining = 2; /* times the least cost on the coarse pixels */

static void choose_coarse(struct hl_light_work *work)
{
  const hl_light_data *grey = &work->grey;
  hl_light_data *coarse = &work->coarse;
  const int brightest = grey->n < BRIGHTEST ? grey->n : BRIGHTEST;
  const int stride = grey->n / REGULAR + 1;
  coarse->n = 0;
  coarse->channels = 1;
  memset(work->outlier, 0, (size_t)grey->n);
  for (int i = 0; i < brightest; i++)
    work->outlier[work->ranked[i].index] = 1; /* a mark for this function alone */
  for (int i = 0; i < grey->n; i++)
    if (work->outlier[i] || i % stride == 0) {
      const int p = coarse->n++;
      for (int k = 0; k < 3; k++) {
        coarse->normal[k][p] = grey->normal[k][i];
        coarse->view[k][p] = grey->view[k][i];
      }
      coarse->footprint[p] = grey->footprint[i];
      coarse->value[0][p] = grey->value[0][i];
      coarse->clipped[p] = grey->clipped[i];
    }
  memset(work->outlier, 0, (size_t)grey->n);
}

static int grid_directions(const double axis[3], double widest_rad, double (*out)[3])
{
  double u[3], w[3];
  hl_tangent_basis(axis, u, w);
  const double golden = pi * (1 + sqrt(5.0));
  for (int i = 0; i < GRID; i++) {
    const double z = 1 - (i + 0.5) / GRID * (1 - cos(widest_rad));
    const double r = sqrt(fmax(0, 1 - z * z));
    for (int k = 0; k < 3; k++)
      out[i][k] =
          r * cos(golden * (i + 0.5)) * u[k] + r * sin(golden * (i + 0.5)) * w[k] + z * axis[k];
  }
  return GRID;
}

/* Mirror directions of the brightest spots; a spot is the mean normal of its brightest pixels. */
static int spot_directions(const struct hl_light_work *work, double (*out)[3])
{
  const hl_light_data *d = &work->grey;
  double spot[SPOTS][3];
  double sum[SPOTS][3] = {{0}}, view[SPOTS][3] = {{0}};
  int spots = 0;
  for (int r = 0; r < d->n && r < BRIGHTEST; r++) {
    const int i = work->ranked[r].index;
    const double n[3] = {d->normal[0][i], d->normal[1][i], d->normal[2][i]};
    const double v[3] = {d->view[0][i], d->view[1][i], d->view[2][i]};
    int k = 0;
    while (k < spots && hl_angle(n, spot[k]) > spots_apart_rad)
      k++;
    if (k == spots) {
      if (spots == SPOTS)
        continue;
      memcpy(spot[spots++], n, sizeof n);
    }
    if (work->ranked[r].key >= 0.8 * work->ranked[0].key || r == 0 || hl_norm(sum[k]) == 0) {
      hl_add_scaled(sum[k], 1, n, sum[k]);
      hl_add_scaled(view[k], 1, v, view[k]);
    }
  }
  for (int k = 0; k < spots; k++) {
    double n[3], v[3];
    hl_unit(sum[k], n);
    hl_unit(view[k], v);
    for (int j = 0; j < 3; j++)
      out[k][j] = 2 * hl_dot(n, v) * n[j] - v[j];
    hl_unit(out[k], out[k]);
  }
  return spots;
}

static void insert_apart(hl_light_candidate *best, int *count, const hl_light_candidate *one)
{
  for (int i = 0; i < *count; i++)
    if (hl_angle(best[i].s, one->s) < candidates_apart_rad) {
      if (one->cost >= best[i].cost)
        return;
      memmove(&best[i], &best[i + 1], sizeof *best * (size_t)(*count - i - 1));
      (*count)--;
      i--;
    }
  int at = *count;
  while (at > 0 && best[at - 1].cost > one->cost)
    at--;
  if (at >= HL_CANDIDATES)
    return;
  const int kept = *count < HL_CANDIDATES ? *count : HL_CANDIDATES - 1;
  memmove(&best[at + 1], &best[at], sizeof *best * (size_t)(kept - at));
  best[at] = *one;
  *count = kept + 1;
}

/* From work->refined.at.s downhill; -1 where the model cannot be fitted. */
static int refine(struct hl_light_work *work, const hl_light_data *data, hl_light_model *model,
                  int breaks, double tolerance_rad, int threads)
{
  hl_light_breaks(data, work->refined.at.s, breaks, LEAST_PIXELS, &model->spline);
  return hl_light_refine(model, data, ITERATIONS, tolerance_rad, threads, &work->model,
                         &work->refined);
}

int hl_light_search(struct hl_light_work *work, const hl_light_settings *settings, hl_lobe lobe,
                    hl_light_candidate out[HL_CANDIDATES])
{
  const hl_light_noise relative = {settings->model_error, 0.2 * settings->model_error};
  double axis[3] = {0}, start[GRID + SPOTS][3];
  hl_light_model model = {.lobe = lobe, .has_lobe = true, .body = 1, .ambient = true};
  choose_coarse(work);
  work->model.censor_rounds = CENSOR_ROUNDS;
  hl_light_weigh(&work->coarse, relative, NULL);
  hl_light_weigh(&work->grey, relative, NULL);
  for (int i = 0; i < work->coarse.n; i++)
    for (int k = 0; k < 3; k++)
      axis[k] += work->coarse.view[k][i];
  hl_unit(axis, axis);
  int starts = grid_directions(axis, settings->widest_deg * pi / 180, start);
  starts += spot_directions(work, start + starts);
  int count = 0;
  for (int i = 0; i < starts; i++) {
    hl_light_candidate one;
    memcpy(one.s, start[i], sizeof one.s);
    hl_light_breaks(&work->coarse, one.s, COARSE_BREAKS, LEAST_PIXELS, &model.spline);
    if (hl_model_fit(&model, &work->coarse, one.s, 0, 1, &work->model, &work->model.trial) != 0)
      continue;
    one.cost = work->model.trial.cost;
    insert_apart(out, &count, &one);
  }
  double least = HUGE_VAL;
  for (int i = 0; i < count; i++) {
    memcpy(work->refined.at.s, out[i].s, sizeof out[i].s);
    /* twice, because the breaks follow the direction */
    const bool fits =
        refine(work, &work->coarse, &model, COARSE_BREAKS, coarse_tolerance_rad, 1) == 0 &&
        refine(work, &work->coarse, &model, MIDDLE_BREAKS, coarse_tolerance_rad, 1) == 0;
    memcpy(out[i].s, work->refined.at.s, sizeof out[i].s);
    out[i].cost = fits ? work->refined.at.cost : HUGE_VAL;
    least = fmin(least, out[i].cost);
  }
  int found = 0;
  for (int i = 0; i < count; i++) {
    if (!(out[i].cost <= worth_refining * least))
      continue;
    memcpy(work->refined.at.s, out[i].s, sizeof out[i].s);
    if (refine(work, &work->grey, &model, FINE_BREAKS, coarse_tolerance_rad, settings->threads) !=
        0)
      continue;
    memcpy(out[found].s, work->refined.at.s, sizeof out[found].s);
    out[found++].cost = work->refined.at.cost;
  }
  for (int i = 1; i < found; i++)
    if (out[i].cost < out[0].cost) {
      const hl_light_candidate swap = out[0];
      out[0] = out[i];
      out[i] = swap;
    }
  return found;
}
