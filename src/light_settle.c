/* Which terms the frame needs, and the direction with them.
 *
 * What is left after a fit is model error more than noise, so the weights decide much. From the
 * basin that relative weights found, nearly even ones (final_noise) let the highlight speak, where
 * the direction is. Under them every variant of the model is refined from the same start, and a
 * further term is kept only where it saves least_gain of the cost; the others are listed with what
 * they would have saved.
 */
#include <math.h>
#include <string.h>

#include "halflight/vec3.h"
#include "light_work.h"

enum { BREAKS = 40, LEAST_PIXELS = 6, ROUNDS = 2, ITERATIONS = 12, PASSES = 6, AREA_ROUNDS = 2 };
static const hl_light_noise final_noise = {0.008, 0.02};
static const double tolerance_rad = 1e-6, compare_tolerance_rad = 2e-5;
static const double least_gain = 0.005;
static const double least_shape_gain =
    0.02; /* of a lobe, and of the bends: they have more freedom */
/* Measured and path-traced lobes alike are foreshortened; the plain kind must fit clearly better.
 */
static const double plain_handicap = 0.7, noise_margin = 0.01;
/* The bends are held near zero, or they would follow a misfit of a few tenths of a percent with
 * coefficients that no material has and carry the direction off by half a degree. In units of the
 * final noise: a misfit of sqrt(bent_error) of it over the whole ball is worth a body coefficient
 * of 1 (the median lit radiance) or an exponent of exponent_spread. Settled on 25 measured
 * materials under four lights and 15 path-traced frames. */
static const double bent_error = 0.001, exponent_spread = 0.4;
/* Without a shadow to show it, an ambient light must save more. */
static const double least_unseen_gain = 0.4;
static const double least_dark = 0.002, same_start_rad = 0.02;
/* A residual is no outlier while it is explained by model error, or by where in the pixel a steep
 * highlight lies: relative part, and share of the prediction's change across the pixel. */
static const double outlier_relative = 0.05, outlier_absolute = 0.02, outlier_slope = 0.5;
static const double least_deviation2 = 0.1;

/* Each round follows with the breaks; to compare variants one is enough. */
static hl_status refine_variant(struct hl_light_work *work, const hl_light_settings *settings,
                                const double s[3], int rounds, hl_light_variant *variant)
{
  memcpy(work->refined.at.s, s, sizeof work->refined.at.s);
  work->refined.at.exponent = variant->exponent;
  for (int round = 0; round < rounds; round++) {
    if (variant->model.has_lobe)
      hl_light_breaks(&work->all, work->refined.at.s, BREAKS, LEAST_PIXELS, &variant->model.spline);
    if (hl_light_refine(&variant->model, &work->all, ITERATIONS,
                        rounds > 1 ? tolerance_rad : compare_tolerance_rad, settings->threads,
                        &work->model, &work->refined) != 0)
      return HL_ERR_DEGENERATE;
    if (!variant->model.has_lobe)
      break;
  }
  memcpy(variant->s, work->refined.at.s, sizeof variant->s);
  variant->exponent = work->refined.at.exponent;
  variant->cost = work->refined.at.cost;
  variant->converged = work->refined.converged;
  return HL_OK;
}

static void set_variant(hl_light_settled *out, hl_variant which, hl_lobe lobe, bool bent,
                        bool ambient)
{
  hl_light_variant *v = &out->variant[which];
  memset(v, 0, sizeof *v);
  v->model.lobe = lobe;
  v->model.has_lobe = lobe != HL_LOBE_AUTO;
  v->model.masking = bent;
  v->model.body = bent ? 3 : 1;
  v->model.ambient = ambient;
  v->cost = HUGE_VAL;
}

/* Share of the cost that a richer model saves; none where what is left is beyond any camera: 0.05 % of
 * the median lit radiance. */
static double gain(const struct hl_light_work *work, double without, double with)
{
  const double least = 5e-4 / final_noise.absolute;
  return without > least * least * work->all.n * work->all.channels ? 1 - with / without : 0;
}

/* What noise alone would make a model with so many more columns a channel save, some times over. */
static double noise_gain(const struct hl_light_work *work, int columns)
{
  return 4.0 * columns / work->all.n;
}

/* Simple or bent, of one kind of lobe. */
static hl_variant of_kind(const struct hl_light_work *work, const hl_light_settled *s,
                          hl_variant simple)
{
  const hl_variant bent = simple + (HL_VARIANT_PLAIN_BENT - HL_VARIANT_PLAIN);
  const double saved = gain(work, s->variant[simple].cost, s->variant[bent].cost);
  return saved > least_shape_gain + noise_gain(work, 3) ? bent : simple;
}

/* Plain where, beyond the noise, it leaves clearly less than foreshortened does; then the fewest terms
 * that the others do not beat by a stated gain. */
static void choose(const struct hl_light_work *work, hl_light_settled *out)
{
  const hl_variant plain = of_kind(work, out, HL_VARIANT_PLAIN);
  const hl_variant foreshortened = of_kind(work, out, HL_VARIANT_FORESHORTENED);
  /* shading bends a little too: what a model leaves bounds the noise from above */
  const double least = fmin(out->variant[plain].cost, out->variant[foreshortened].cost);
  const double floor = (1 - noise_margin) * fmin(out->noise_cost, least);
  const double plain_left = out->variant[plain].cost - floor;
  const double foreshortened_left = out->variant[foreshortened].cost - floor;
  const bool is_plain = !isfinite(foreshortened_left) ||
                        (isfinite(plain_left) && plain_left < plain_handicap * foreshortened_left);
  out->kept = is_plain ? plain : foreshortened;
  const hl_variant other = is_plain ? foreshortened : plain;
  const hl_variant simple = is_plain ? HL_VARIANT_PLAIN : HL_VARIANT_FORESHORTENED;
  const hl_variant bent = is_plain ? HL_VARIANT_PLAIN_BENT : HL_VARIANT_FORESHORTENED_BENT;
  const double cost = out->variant[out->kept].cost;
  out->bent_gain = gain(work, out->variant[simple].cost, out->variant[bent].cost);
  out->kind_ratio = cost > 0 ? out->variant[other].cost / cost : HUGE_VAL;
  out->lobe_gain = gain(work, out->variant[HL_VARIANT_MATTE].cost, cost);
  const hl_light_model *model = &out->variant[out->kept].model;
  if (!(out->lobe_gain > least_shape_gain + noise_gain(work, model->spline.n)))
    out->kept = HL_VARIANT_MATTE;
}

static void refine_all(struct hl_light_work *work, const hl_light_settings *settings,
                       const double start[2][3], bool ambient, hl_light_settled *out)
{
  set_variant(out, HL_VARIANT_MATTE, HL_LOBE_AUTO, false, ambient);
  set_variant(out, HL_VARIANT_PLAIN, HL_LOBE_PLAIN, false, ambient);
  set_variant(out, HL_VARIANT_FORESHORTENED, HL_LOBE_FORESHORTENED, false, ambient);
  set_variant(out, HL_VARIANT_PLAIN_BENT, HL_LOBE_PLAIN, true, ambient);
  set_variant(out, HL_VARIANT_FORESHORTENED_BENT, HL_LOBE_FORESHORTENED, true, ambient);
  const double weight = bent_error * work->all.n * work->all.channels;
  for (int kind = 0; kind < 2; kind++) {
    const hl_lobe lobe = kind == 0 ? HL_LOBE_PLAIN : HL_LOBE_FORESHORTENED;
    hl_light_variant *simple = &out->variant[HL_VARIANT_PLAIN + kind];
    hl_light_variant *bent = &out->variant[HL_VARIANT_PLAIN_BENT + kind];
    if (settings->lobe != HL_LOBE_AUTO && settings->lobe != lobe)
      continue;
    if (refine_variant(work, settings, start[kind], 1, simple) != HL_OK)
      continue;
    bent->model.exponent_weight = weight / (exponent_spread * exponent_spread);
    for (int c = 0; c < work->all.channels; c++)
      bent->model.body_weight[c] = weight / work->all.channels;
    refine_variant(work, settings, simple->s, 1, bent);
  }
  const hl_light_variant *simple = &out->variant[HL_VARIANT_PLAIN];
  if (!(simple->cost < out->variant[HL_VARIANT_FORESHORTENED].cost))
    simple = &out->variant[HL_VARIANT_FORESHORTENED];
  if (isfinite(simple->cost))
    refine_variant(work, settings, simple->s, 1, &out->variant[HL_VARIANT_MATTE]);
  choose(work, out);
}

/* Twice the squared deviation of a sample from what model error and its place in the pixel explain. */
static double deviation2(const hl_light_data *d, const hl_model_pixel *f, int c, int i)
{
  const double r = d->value[c][i] - f->value;
  const double edge = outlier_slope * d->footprint[i] * f->steepness;
  const double relative = outlier_relative * f->value;
  return r * r / (relative * relative + edge * edge + outlier_absolute * outlier_absolute);
}

/* Mean deviation of a channel's samples, each counted with `cap` at most; model->fit is in work->fit. */
static double capped_mean(const struct hl_light_work *work, int channel, double cap)
{
  const hl_light_data *d = &work->all;
  double sum = 0;
  long used = 0;
  for (int i = 0; i < d->n; i++)
    if (!(d->clipped[i] >> channel & 1)) {
      sum += fmin(deviation2(d, &work->fit[i], channel, i), cap);
      used++;
    }
  return used > 0 ? sum / (double)used : 0;
}

/* Pixels whose residual no part of the model's stated error explains. Returns how many. */
static int mark_outliers(struct hl_light_work *work, const hl_light_model *model, double sigmas)
{
  const hl_light_data *d = &work->all;
  int marked = 0;
  memset(work->outlier, 0, (size_t)d->n);
  if (!(sigmas > 0))
    return 0;
  for (int c = 0; c < d->channels; c++) {
    hl_model_predict(model, d, &work->best.at, NULL, 0, d->n, c, work->fit);
    double mean = 1; /* one that a tenth of wild pixels hardly moves */
    for (int round = 0; round < 4; round++)
      mean = fmax(capped_mean(work, c, 9 * mean), least_deviation2);
    for (int i = 0; i < d->n; i++)
      if (!(d->clipped[i] >> c & 1) &&
          deviation2(d, &work->fit[i], c, i) > sigmas * sigmas * mean) {
        marked += !work->outlier[i];
        work->outlier[i] = 1;
      }
  }
  return marked;
}

static double dark_share(const hl_light_data *d, const double s[3])
{
  int dark = 0;
  for (int i = 0; i < d->n; i++)
    dark +=
        d->normal[0][i] * s[0] + d->normal[1][i] * s[1] + d->normal[2][i] * s[2] < -d->footprint[i];
  return d->n > 0 ? (double)dark / d->n : 0;
}

/* Whether a constant saves enough, tried from the answer without it and from the search's, which had
 * one: an ambient light can hold the answer without it on the wrong side of the ball. */
static bool needs_ambient(struct hl_light_work *work, const hl_light_settings *settings,
                          const double start[2][3], hl_light_settled *out)
{
  const hl_light_variant *base = &out->variant[out->kept];
  hl_light_variant *best = &out->variant[HL_VARIANT_AMBIENT];
  best->cost = HUGE_VAL;
  for (int from = 0; from < 2; from++) {
    hl_light_variant one = *base;
    one.model.ambient = true;
    one.cost = HUGE_VAL;
    const double *s = from == 0 ? base->s : start[base->model.lobe == HL_LOBE_FORESHORTENED];
    if (from == 1 && hl_angle(s, base->s) < same_start_rad)
      continue;
    if (refine_variant(work, settings, s, 1, &one) == HL_OK && one.cost < best->cost)
      *best = one;
  }
  if (!isfinite(best->cost))
    return false;
  out->dark_share = dark_share(&work->all, best->s);
  out->ambient_gain = gain(work, base->cost, best->cost);
  const double least = out->dark_share >= least_dark ? least_gain : least_unseen_gain;
  return out->ambient_gain > least + noise_gain(work, 1);
}

/* Cost that the pixels' noise alone leaves: second differences along the rows of the frame, in which
 * shading is straight; the few that lie across an edge or a highlight are capped. */
static double noise_cost(const struct hl_light_work *work, const hl_surface *surface)
{
  const hl_light_data *d = &work->all;
  double sum = 0;
  for (int c = 0; c < d->channels; c++) {
    double cap = HUGE_VAL, mean = 0;
    for (int round = 0; round < 6; round++) {
      double total = 0;
      long used = 0;
      for (int i = 1; i + 1 < d->n; i++) {
        if (!hl_light_in_a_row(work, surface, i))
          continue;
        const double bend = d->value[c][i - 1] - 2 * d->value[c][i] + d->value[c][i + 1];
        total += fmin(d->weight[c][i] * bend * bend / 6, cap);
        used++;
      }
      mean = used > 0 ? total / (double)used : 0;
      cap = 6 * mean;
    }
    sum += mean * d->n;
  }
  return sum;
}

static void trace_variants(hl_ctx *ctx, const hl_light_settled *out)
{
  static const char *const names[HL_VARIANTS] = {"matte",      "plain",   "foreshortened",
                                                 "plain bent", "fs bent", "ambient"};
  for (int i = 0; i < HL_VARIANTS; i++) {
    const hl_light_variant *v = &out->variant[i];
    if (isfinite(v->cost))
      hl_trace(ctx, "%s %-13s cost %.6g direction %.6f %.6f %.6f exponent %.2f%s",
               i == (int)out->kept ? "kept " : "tried", names[i], v->cost, v->s[0], v->s[1],
               v->s[2], v->exponent, v->converged ? "" : ", not converged");
  }
  hl_trace(ctx, "noise cost %.6g, outliers %d, ambient %d", out->noise_cost, out->outliers,
           out->ambient);
}

hl_status hl_light_settle(hl_ctx *ctx, struct hl_light_work *work, const hl_surface *surface,
                          const hl_light_settings *settings, const double start[2][3],
                          hl_light_settled *out)
{
  memset(out, 0, sizeof *out);
  out->variant[HL_VARIANT_AMBIENT].cost = HUGE_VAL;
  work->model.censor_rounds = 0;
  hl_light_weigh(&work->all, final_noise, NULL);
  out->noise_cost = noise_cost(work, surface);
  for (int pass = 0; pass < PASSES; pass++) {
    /* a few pixels left out do not change which terms are needed */
    if (pass == 0 || out->outliers > work->all.n / 100)
      refine_all(work, settings, start, out->ambient, out);
    if (!isfinite(out->variant[out->kept].cost))
      return hl_fail(ctx, HL_ERR_DEGENERATE, "no reflectance model can be fitted to these pixels");
    if (pass == 0 && needs_ambient(work, settings, start, out)) {
      out->ambient = true;
      refine_all(work, settings, start, true, out);
    }
    hl_light_variant *kept = &out->variant[out->kept];
    if (refine_variant(work, settings, kept->s, ROUNDS, kept) != HL_OK)
      return hl_fail(ctx, HL_ERR_DEGENERATE, "the fit was lost on repeating it");
    work->best = work->refined;
    out->iterations += work->refined.iterations;
    const int before = out->outliers;
    if (pass == PASSES - 1)
      break;
    out->outliers = mark_outliers(work, &kept->model, settings->outlier_sigmas);
    if (out->outliers <= before + before / 20)
      break;
    hl_light_weigh(&work->all, final_noise, work->outlier);
  }
  for (int round = 0; surface->is_ball && round < AREA_ROUNDS; round++) {
    hl_light_variant *kept = &out->variant[out->kept];
    hl_light_bring_to_middle(work, &kept->model, surface, settings->threads);
    if (refine_variant(work, settings, kept->s, 1, kept) != HL_OK)
      return hl_fail(ctx, HL_ERR_DEGENERATE, "the fit was lost on repeating it");
    work->best = work->refined;
    out->iterations += work->refined.iterations;
  }
  trace_variants(ctx, out);
  memcpy(out->coarse_s, start[out->variant[out->kept].model.lobe == HL_LOBE_FORESHORTENED],
         sizeof out->coarse_s);
  return HL_OK;
}
