/* Where on the sphere of lights to start.
 *
 * A grid of directions out to widest_deg from the view (a light behind the rim still lights a
 * crescent), and the mirror directions s = 2(n.v)n - v of the brightest separate spots, because a
 * sharp highlight falls between the grid's directions. Each is judged by the model itself with a
 * coarse basis on some hundred cells (light_pixels.c). The best that are well apart are refined, on
 * those and then on all samples, with both kinds of lobe. Weights are relative to the pixel: they find
 * the right basin also where a highlight is a thousand times brighter than the rest.
 */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "halflight/vec3.h"
#include "light_work.h"

enum {
  GRID = 120,
  SPOTS = 4,
  BRIGHTEST = 400,
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
static const double same_rad = 1e-3;
static const double worth_refining = 2; /* times the least cost on the coarse pixels */

void hl_light_choose_coarse(struct hl_light_work *work, int most)
{
  hl_light_take_cells(work, most < HL_COARSE_MAX ? most : HL_COARSE_MAX, &work->grey, &work->coarse,
                      NULL);
}

static int grid_directions(const double axis[3], double widest_rad, int count, double (*out)[3])
{
  double u[3], w[3];
  hl_tangent_basis(axis, u, w);
  const double golden = pi * (1 + sqrt(5.0));
  for (int i = 0; i < count; i++) {
    const double z = 1 - (i + 0.5) / count * (1 - cos(widest_rad));
    const double r = sqrt(fmax(0, 1 - z * z));
    for (int k = 0; k < 3; k++)
      out[i][k] =
          r * cos(golden * (i + 0.5)) * u[k] + r * sin(golden * (i + 0.5)) * w[k] + z * axis[k];
  }
  return count;
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

static const hl_light_model searched = {.has_lobe = true, .body = 1, .ambient = true};

static hl_light_noise noise_of(const hl_light_settings *settings)
{
  return (hl_light_noise){settings->model_error, 0.2 * settings->model_error};
}

int hl_light_look_around(struct hl_light_work *work, const hl_light_settings *settings,
                         int directions, hl_light_candidate out[HL_CANDIDATES], int *passes)
{
  hl_light_model model = searched;
  double axis[3] = {0}, start[GRID + SPOTS][3];
  int count = 0;
  model.lobe = settings->lobe == HL_LOBE_PLAIN ? HL_LOBE_PLAIN : HL_LOBE_FORESHORTENED;
  work->model.censor_rounds = CENSOR_ROUNDS;
  hl_light_weigh(&work->coarse, noise_of(settings), NULL);
  for (int i = 0; i < work->coarse.n; i++)
    for (int k = 0; k < 3; k++)
      axis[k] += work->coarse.view[k][i];
  hl_unit(axis, axis);
  int starts = spot_directions(work, start);
  starts += grid_directions(axis, settings->widest_deg * pi / 180,
                            directions < GRID ? directions : GRID, start + starts);
  for (int i = 0; i < starts; i++) {
    hl_light_candidate one;
    memcpy(one.s, start[i], sizeof one.s);
    hl_light_breaks(&work->coarse, one.s, COARSE_BREAKS, LEAST_PIXELS, &model.spline);
    if (hl_model_fit(&model, &work->coarse, one.s, 0, 1, &work->model, &work->model.trial) != 0)
      continue;
    one.cost = work->model.trial.cost;
    insert_apart(out, &count, &one);
  }
  *passes = starts;
  return count;
}

/* From *s downhill on work->coarse, twice, because the breaks follow the direction. */
static double refine_coarse(struct hl_light_work *work, hl_light_model *model, double s[3])
{
  memcpy(work->refined.at.s, s, sizeof work->refined.at.s);
  for (int round = work->glanced ? 1 : 0; round < 2; round++) {
    const int breaks = round == 0 ? COARSE_BREAKS : MIDDLE_BREAKS;
    hl_light_breaks(&work->coarse, work->refined.at.s, breaks, LEAST_PIXELS, &model->spline);
    if (hl_light_refine(model, &work->coarse, ITERATIONS, coarse_tolerance_rad, 1, &work->model,
                        &work->refined) != 0)
      return HUGE_VAL;
  }
  memcpy(s, work->refined.at.s, sizeof work->refined.at.s);
  return work->refined.at.cost;
}

/* The same on all samples. */
static double refine_fine(struct hl_light_work *work, hl_light_model *model, int threads,
                          double s[3])
{
  memcpy(work->refined.at.s, s, sizeof work->refined.at.s);
  hl_light_breaks(&work->grey, s, FINE_BREAKS, LEAST_PIXELS, &model->spline);
  if (hl_light_refine(model, &work->grey, ITERATIONS, coarse_tolerance_rad, threads, &work->model,
                      &work->refined) != 0)
    return HUGE_VAL;
  memcpy(s, work->refined.at.s, sizeof work->refined.at.s);
  return work->refined.at.cost;
}

/* The best of the candidates with this kind of lobe, refined. */
static double best_of(struct hl_light_work *work, const hl_light_settings *settings,
                      hl_light_model *model, const hl_light_candidate *from, int count,
                      double best[3])
{
  hl_light_candidate one[HL_CANDIDATES];
  double least = HUGE_VAL, cost = HUGE_VAL;
  memcpy(one, from, sizeof *one * (size_t)count);
  for (int i = 0; i < count; i++) {
    one[i].cost = refine_coarse(work, model, one[i].s);
    least = fmin(least, one[i].cost);
  }
  for (int i = 0; i < count; i++) {
    bool seen = false; /* two that ran into one */
    for (int j = 0; j < i; j++)
      seen = seen || hl_angle(one[i].s, one[j].s) < same_rad;
    if (seen || !(one[i].cost <= worth_refining * least))
      continue;
    /* few samples are refined with the final weights at once */
    const double fine = work->glanced && count == 1
                            ? one[i].cost
                            : refine_fine(work, model, settings->threads, one[i].s);
    if (fine < cost) {
      cost = fine;
      memcpy(best, one[i].s, sizeof one[i].s);
    }
  }
  return cost;
}

bool hl_light_start(struct hl_light_work *work, const hl_light_settings *settings,
                    const hl_light_candidate *found, int count, double start[2][3])
{
  hl_light_model model = searched;
  double cost[2] = {HUGE_VAL, HUGE_VAL};
  hl_light_weigh(&work->grey, noise_of(settings), NULL);
  for (int kind = 0; kind < 2; kind++) {
    model.lobe = kind == 0 ? HL_LOBE_PLAIN : HL_LOBE_FORESHORTENED;
    /* from a glance both kinds start where the commoner one leads */
    const bool automatic = settings->lobe == HL_LOBE_AUTO && !(work->glanced && kind == 0);
    if (automatic || settings->lobe == model.lobe)
      cost[kind] = best_of(work, settings, &model, found, count, start[kind]);
  }
  for (int kind = 0; kind < 2; kind++)
    if (!isfinite(cost[kind]))
      memcpy(start[kind], start[1 - kind], sizeof start[kind]);
  return isfinite(cost[0]) || isfinite(cost[1]);
}
