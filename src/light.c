/* The light from one frame: gather, search, settle, state the uncertainty, draw the curves.
 *
 * Each step is a file: light_gather.c, light_pixels.c, light_search.c, light_settle.c, light_finish.c, light_uncertainty.c,
 * light_curves.c, light_notes.c; the model is light_model.c, its solver light_refine.c.
 */
#include "halflight/light.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/notes.h"
#include "halflight/vec3.h"
#include "light_budget.h"
#include "light_terms.h"

#ifdef _OPENMP
#include <omp.h>
#endif

enum { LARGEST_SURFACE = 1 << 28 };
static const double chi2_95 = 5.9914645471079817; /* 2 degrees of freedom */

hl_light_settings hl_light_defaults(void)
{
  const hl_light_settings s = {.lobe = HL_LOBE_AUTO,
                               .threads = 1,
                               .model_error = 0.02,
                               .outlier_sigmas = 8,
                               .widest_deg = 150,
                               .intervals = 40};
  return s;
}

const hl_field_table *hl_light_fields(void)
{
  static const char *const lobes[] = {"auto", "plain", "foreshortened", NULL};
  static const hl_field fields[] = {
      {"lobe", HL_FIELD_CHOICE, offsetof(hl_light_settings, lobe), 0, 2, "",
       "form of the specular lobe; auto keeps the one with the smaller residual", lobes},
      {"pixels", HL_FIELD_INT, offsetof(hl_light_settings, pixels), 0, LARGEST_SURFACE, "",
       "work on at most so many samples, means of blocks where shading is straight; 0 for all",
       NULL},
      {"budget_ms", HL_FIELD_DOUBLE, offsetof(hl_light_settings, budget_ms), 0, 1e6, "ms",
       "best answer within this time, as far as can be; 0 for no limit", NULL},
      {"threads", HL_FIELD_INT, offsetof(hl_light_settings, threads), 0, 256, "",
       "threads to use, 0 for as many as the machine has; the result does not depend on it", NULL},
      {"model_error", HL_FIELD_DOUBLE, offsetof(hl_light_settings, model_error), 1e-4, 0.5, "",
       "error of the model relative to the radiance, while searching", NULL},
      {"outlier_sigmas", HL_FIELD_DOUBLE, offsetof(hl_light_settings, outlier_sigmas), 0, 1e6, "",
       "leave out pixels that differ by so many deviations; 0 never does", NULL},
      {"widest_deg", HL_FIELD_DOUBLE, offsetof(hl_light_settings, widest_deg), 10, 180, "deg",
       "largest angle of the light from the view that is searched", NULL},
      {"intervals", HL_FIELD_INT, offsetof(hl_light_settings, intervals), 4, 45, "",
       "intervals of the lobe's curve, at most; those with few samples are merged", NULL},
  };
  static const hl_field_table table = {"light settings", fields,
                                       (int)(sizeof fields / sizeof *fields)};
  return &table;
}

/* Carves arrays off one block; with a NULL base it only adds up their sizes. */
typedef struct arena {
  char *base;
  size_t used;
} arena;

static void *carve(arena *a, size_t count, size_t size)
{
  void *at = a->base ? a->base + a->used : NULL;
  a->used += (count * size + 63) / 64 * 64;
  return at;
}

static void carve_data(arena *a, hl_light_data *d, size_t n, int channels, bool cells)
{
  for (int k = 0; k < 3; k++) {
    d->normal[k] = carve(a, n, sizeof(double));
    d->view[k] = carve(a, n, sizeof(double));
  }
  d->footprint = carve(a, n, sizeof(double));
  d->clipped = carve(a, n, 1);
  d->side = cells ? carve(a, n, 1) : NULL;
  d->stretch = cells ? carve(a, n, sizeof *d->stretch) : NULL;
  for (int c = 0; c < channels; c++) {
    d->value[c] = carve(a, n, sizeof(double));
    d->weight[c] = carve(a, n, sizeof(double));
    d->scatter[c] = cells ? carve(a, n, sizeof(double)) : NULL;
  }
}

static void carve_samples(arena *a, hl_light_samples *s, size_t n, int channels, bool cells)
{
  carve_data(a, &s->all, n, channels, cells);
  s->grey = s->all;
  s->grey.value[0] = carve(a, n, sizeof(double));
  s->grey.weight[0] = carve(a, n, sizeof(double));
  s->grey.clipped = carve(a, n, 1);
  s->grey.scatter[0] = cells ? carve(a, n, sizeof(double)) : NULL;
  s->index = carve(a, n, sizeof *s->index);
  s->outlier = carve(a, n, 1);
  for (int c = 0; c < channels; c++)
    s->area[c] = carve(a, n, sizeof(double));
}

static void carve_work(arena *a, hl_light_work *w)
{
  const size_t n = (size_t)w->max_pixels;
  carve_samples(a, &w->aside, n, w->channels, false);
  hl_light_exchange(w); /* the pixels; beside them, the cells */
  carve_samples(a, &w->aside, n, w->channels, true);
  w->on_cells = false;
  carve_data(a, &w->coarse, HL_COARSE_MAX, 1, true);
  w->place = carve(a, 2 * n, sizeof *w->place);
  w->bend = carve(a, n, sizeof *w->bend);
  w->mean = carve(a, n, sizeof *w->mean);
  w->owner = carve(a, n, sizeof *w->owner);
  const size_t rows = n > HL_COARSE_MAX ? n : HL_COARSE_MAX;
  w->model.clipped = carve(a, rows * (size_t)w->channels, sizeof *w->model.clipped);
  w->ranked = carve(a, 2 * n, sizeof *w->ranked);
  w->fit = carve(a, n, sizeof *w->fit);
  w->score = carve(a, n, sizeof *w->score);
  w->noise = carve(a, n, sizeof *w->noise);
  w->predicted = carve(a, n, sizeof(float));
  w->measured = carve(a, n, sizeof(float));
  w->weight = carve(a, n, sizeof(float));
}

hl_status hl_light_work_new(hl_ctx *ctx, int max_pixels, int channels, hl_light_work **out)
{
  if (max_pixels < 1 || max_pixels > LARGEST_SURFACE)
    return hl_fail(ctx, HL_ERR_ARG, "max_pixels = %d is outside [1, %d]", max_pixels,
                   LARGEST_SURFACE);
  if (channels != 1 && channels != HL_CHANNELS_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "channels = %d is neither 1 nor 3", channels);
  hl_light_work *w = calloc(1, sizeof *w);
  if (!w)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a light workspace");
  w->max_pixels = max_pixels;
  w->channels = channels;
  arena a = {NULL, 0};
  carve_work(&a, w);
  a.base = w->pool = malloc(a.used);
  if (!w->pool) {
    free(w);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a light workspace of %d pixels", max_pixels);
  }
  a.used = 0;
  carve_work(&a, w);
  memset(w->predicted, 0, (size_t)max_pixels * sizeof *w->predicted);
  memset(w->measured, 0, (size_t)max_pixels * sizeof *w->measured);
  memset(w->weight, 0, (size_t)max_pixels * sizeof *w->weight);
  *out = w;
  return HL_OK;
}

void hl_light_work_free(hl_light_work *work)
{
  if (!work)
    return;
  free(work->pool);
  free(work);
}

static int threads_of(const hl_light_settings *settings)
{
#ifdef _OPENMP
  return settings->threads > 0 ? settings->threads : omp_get_max_threads();
#else
  (void)settings;
  return 1;
#endif
}

/* Half axes of the 95 % ellipse, major first. */
static void set_ellipse(double (*covariance)[2], double out[2])
{
  const double a = covariance[0][0], b = covariance[0][1], c = covariance[1][1];
  const double half = 0.5 * (a + c);
  const double root = sqrt(fmax(0, 0.25 * (a - c) * (a - c) + b * b));
  out[0] = sqrt(chi2_95 * fmax(0, half + root));
  out[1] = sqrt(chi2_95 * fmax(0, half - root));
}

/* The covariance from its parts. */
static void add_parts(hl_light *out)
{
  for (int part = 0; part < HL_PARTS; part++) {
    for (int u = 0; u < 2; u++)
      for (int v = 0; v < 2; v++)
        out->covariance_rad2[u][v] += out->part_rad2[part][u][v];
    set_ellipse(out->part_rad2[part], out->part_95_rad[part]);
  }
  set_ellipse(out->covariance_rad2, out->ellipse_95_rad);
}

static void set_direction(const hl_light_work *work, hl_light *out)
{
  const hl_light_data *d = work->on_cells ? &work->aside.all : &work->all; /* the pixels */
  double view[3] = {0};
  memcpy(out->direction, work->best.at.s, sizeof out->direction);
  memcpy(out->tangent_basis, work->best.at.t, sizeof out->tangent_basis);
  for (int i = 0; i < d->n; i++)
    for (int k = 0; k < 3; k++)
      view[k] += d->view[k][i];
  hl_unit(view, out->mean_view);
  hl_add_scaled(out->direction, 1, out->mean_view, out->half_angle_direction);
  hl_unit(out->half_angle_direction, out->half_angle_direction);
}

double hl_light_clipped_to(const hl_light_work *work)
{
  const hl_light_data *d = &work->all;
  const double *s = work->best.at.s;
  double sum = 0, sum2 = 0;
  int n = 0;
  for (int i = 0; i < d->n; i++)
    if (d->clipped[i]) {
      const double normal[3] = {d->normal[0][i], d->normal[1][i], d->normal[2][i]};
      const double view[3] = {d->view[0][i], d->view[1][i], d->view[2][i]};
      double h[3];
      hl_add_scaled(s, 1, view, h);
      const double angle = hl_angle(normal, h);
      sum += angle;
      sum2 += angle * angle;
      n++;
    }
  if (n == 0)
    return 0;
  const double mean = sum / n;
  return mean + 2 * sqrt(fmax(0, sum2 / n - mean * mean));
}

/* A dielectric's lobe has the light's colour; a matte ball's body is the best there is. Where the
 * highlight is clipped its height is unknown in that channel, so the lobe is compared over the flank:
 * from where clipping ends to a tenth of its value there. */
static void set_color(const hl_light_work *work, hl_light *out)
{
  const char *lobe = out->lobe == HL_LOBE_AUTO ? "diffuse" : "specular";
  const double from = out->lobe == HL_LOBE_AUTO ? 0 : hl_light_clipped_to(work);
  double sum[HL_CHANNELS_MAX] = {0}, most = 0;
  int c = 0;
  for (int k = 0; k < out->n_curves; k++) {
    const hl_curve *curve = &out->curves[k];
    double top = -1;
    if (strcmp(curve->lobe, lobe) != 0)
      continue;
    for (int i = 0; i < curve->n; i++) {
      if (curve->angle_rad[i] < from)
        continue;
      top = top < 0 ? curve->value[i] : top;
      sum[c] += curve->value[i] >= 0.1 * top ? curve->value[i] : 0;
    }
    most = sum[c] > most ? sum[c] : most;
    c++;
  }
  for (int k = 0; k < 3; k++)
    out->color[k] = most > 0 ? sum[out->channels == 1 ? 0 : k] / most : 1;
}

static hl_status no_light(hl_ctx *ctx, hl_light *out)
{
  out->found = out->trusted = false;
  return hl_fail(ctx, HL_ERR_DEGENERATE, "no light: %s", out->reasons.note[0].why);
}

/* From gathered pixels to the direction; on cells where the plan says so. */
static hl_status find_direction(hl_ctx *ctx, hl_light_work *work, const hl_surface *surface,
                                hl_light_settings *own, hl_light_plan *plan,
                                hl_light_settled *settled)
{
  hl_light_candidate found[HL_CANDIDATES];
  double start[2][3];
  int passes;
  hl_light_find_blocks(work, surface);
  hl_light_plan_look(own, work->all.n, plan);
  hl_light_choose_coarse(work, plan->coarse);
  int count = hl_light_look_around(work, own, plan->directions, found, &passes);
  hl_light_plan_settle(passes, work->channels, plan, own);
  if (plan->cells < work->all.n)
    hl_light_to_cells(work, plan->cells);
  hl_light_plan_terms(&work->all, plan, own);
  work->hurried = plan->hurried;
  count = count < plan->candidates ? count : plan->candidates;
  if (!hl_light_start(work, own, found, count, start))
    return hl_fail(ctx, HL_ERR_DEGENERATE, "no direction of light explains these pixels");
  const hl_status st = hl_light_settle(ctx, work, surface, own, (const double(*)[3])start, settled);
  if (st != HL_OK || !work->on_cells || !hl_light_plan_finish(plan))
    return st;
  return hl_light_finish(ctx, work, own, settled);
}

/* How sure that is, and all that is drawn from it; `work` is on what it was settled on. */
static void describe(hl_light_work *work, const hl_surface *surface, const hl_light_settings *own,
                     const hl_light_settled *settled, hl_light *out)
{
  const hl_light_model *model = &settled->variant[settled->kept].model;
  hl_light_spread spread;
  out->lobe = model->has_lobe ? model->lobe : HL_LOBE_AUTO;
  set_direction(work, out);
  hl_light_uncertainty(work, surface, model, settled, own->threads, &spread);
  memcpy(out->part_rad2[HL_PART_NOISE], spread.noise, sizeof spread.noise);
  memcpy(out->part_rad2[HL_PART_MODEL], spread.model, sizeof spread.model);
  out->part_stated[HL_PART_NOISE] = out->part_stated[HL_PART_MODEL] = true;
  /* what nothing is stated of moves nothing: how the light would follow it is not worth short time */
  if (!work->glanced || surface->camera.has_covariance || surface->ball.has_covariance)
    hl_light_geometry(work, model, surface, &spread, own->threads, out);
  else
    hl_notes_add(&out->left_out, "how the light follows the pose", "not derived for want of time");
  add_parts(out);
  hl_light_position(work, model, surface, &spread, own->threads, out);
  hl_light_curves(work, model, own->threads, out);
  if (work->hurried)
    hl_notes_add(&out->left_out, "bound", "not derived for want of time");
  else
    hl_light_bound(work, model, surface, own->threads, out);
  set_color(work, out);
  out->n_clipped = work->brightness.clipped;
  out->n_outliers = settled->outliers;
  out->iterations = settled->iterations;
  out->rms = spread.rms;
  out->relative_error = spread.relative_error;
  out->condition = spread.condition;
  out->evidence_highlight = spread.highlight_share;
  out->masking_exponent = model->masking ? work->best.at.exponent : 0;
  hl_light_notes(work, settled, &spread, surface, own, out);
}

hl_status hl_light_estimate(hl_ctx *ctx, hl_light_work *work, const hl_frame *frame,
                            const hl_surface *surface, const hl_light_settings *settings,
                            hl_light *out)
{
  hl_light_settings own = settings ? *settings : hl_light_defaults();
  hl_light_settled settled = {.kept = HL_VARIANT_MATTE};
  hl_light_plan plan;
  hl_status st = hl_fields_check(ctx, hl_light_fields(), &own);
  if (st == HL_OK)
    st = hl_light_check_terms(ctx, &own);
  if (st != HL_OK)
    return st;
  own.threads = threads_of(&own);
  hl_light_plan_start(&own, surface->n, &plan);
  work->glanced = plan.gathered > 0;
  st = hl_light_gather(ctx, work, frame, surface, plan.gathered);
  if (st != HL_OK)
    return st;
  memset(out, 0, sizeof *out);
  out->channels = frame->channels;
  if (hl_light_hopeless(work, frame, out))
    return no_light(ctx, out);
  st = find_direction(ctx, work, surface, &own, &plan, &settled);
  if (st != HL_OK) {
    hl_notes_add(&out->reasons, "no fit", "%s", ctx ? ctx->msg : "no model can be fitted");
    return no_light(ctx, out);
  }
  work->kept = settled.variant[settled.kept].model;
  out->found = true;
  out->n_pixels = work->all.n;
  /* cells say as much as all pixels do, in less time */
  const bool finished = !work->on_cells && plan.cells < plan.pixels;
  if (finished)
    hl_light_exchange(work);
  describe(work, surface, &own, &settled, out);
  hl_light_plan_notes(&plan, out->n_pixels, out);
  if (finished) {
    hl_light_exchange(work);
    hl_light_predict_pixels(work, &settled.variant[settled.kept].model);
  }
  hl_light_spread_over(work, surface->n);
  if (finished) /* light_pose.c goes on from the samples with the noise's own weights */
    hl_light_exchange(work);
  hl_light_plan_end(&plan, out);
  return HL_OK;
}

void hl_light_fitted(const hl_light_work *work, const float **predicted, const float **measured,
                     const float **weight)
{
  if (predicted)
    *predicted = work->predicted;
  if (measured)
    *measured = work->measured;
  if (weight)
    *weight = work->weight;
}
