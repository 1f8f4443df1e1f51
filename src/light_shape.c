/* The shape of the reflectance: no lobe, a plain or a foreshortened one, with or without bends.
 *
 * Every shape is refined from the same start, under nearly even weights (hl_light_final_noise) that let
 * the highlight speak, where the direction is; a richer one is kept only where it saves a stated share
 * of the cost.
 */
#include <math.h>
#include <string.h>

#include "light_work.h"

enum { LEAST_PIXELS = 6, ITERATIONS = 12 };
const hl_light_noise hl_light_final_noise = {0.008, 0.02};
static const double tolerance_rad = 1e-6, compare_tolerance_rad = 2e-5;
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
hl_status hl_light_refine_variant(struct hl_light_work *work, const hl_light_settings *settings,
                                  const double s[3], int rounds, hl_light_variant *variant)
{
  memcpy(work->refined.at.s, s, sizeof work->refined.at.s);
  work->refined.at.exponent = variant->exponent;
  work->refined.at.nearness = variant->nearness;
  for (int round = 0; round < rounds; round++) {
    if (variant->model.has_lobe)
      hl_light_breaks(&work->all, work->refined.at.s, settings->intervals, LEAST_PIXELS,
                      &variant->model.spline);
    if (hl_light_refine(&variant->model, &work->all, ITERATIONS,
                        rounds > 1 ? tolerance_rad : compare_tolerance_rad, settings->threads,
                        &work->model, &work->refined) != 0)
      return HL_ERR_DEGENERATE;
    if (!variant->model.has_lobe)
      break;
  }
  memcpy(variant->s, work->refined.at.s, sizeof variant->s);
  variant->exponent = work->refined.at.exponent;
  variant->nearness = work->refined.at.nearness;
  variant->cost = work->refined.at.cost;
  variant->converged = work->refined.converged;
  return HL_OK;
}

static void set_variant(hl_light_settled *out, hl_variant which, hl_lobe lobe, bool bent)
{
  hl_light_variant *v = &out->variant[which];
  memset(v, 0, sizeof *v);
  v->model.lobe = lobe;
  v->model.has_lobe = lobe != HL_LOBE_AUTO;
  v->model.masking = bent;
  v->model.body = bent ? 3 : 1;
  hl_light_switch_on(out->on, &v->model);
  v->nearness = v->model.near ? out->nearness : 0;
  v->cost = HUGE_VAL;
}

/* Share of the cost that a richer model saves; none where what is left is beyond any camera: 0.05 % of
 * the median lit radiance. */
double hl_light_gain(const struct hl_light_work *work, double without, double with)
{
  const double least = 5e-4 / hl_light_final_noise.absolute;
  const hl_light_data *d = &work->all;
  const double left =
      without - hl_light_apart(d); /* within cells is nothing for a model to explain */
  return left > least * least * hl_light_pixels(d) * d->channels ? 1 - with / without : 0;
}

/* What noise alone would make a model with so many more columns a channel save, some times over. */
double hl_light_noise_gain(const struct hl_light_work *work, int columns)
{
  return 4.0 * columns / hl_light_effective(&work->all);
}

/* Simple or bent, of one kind of lobe. */
static hl_variant of_kind(const struct hl_light_work *work, const hl_light_settings *settings,
                          const hl_light_settled *s, hl_variant simple)
{
  const hl_variant bent = simple + (HL_VARIANT_PLAIN_BENT - HL_VARIANT_PLAIN);
  if (settings->with & 1U << HL_LIGHT_BENDS && isfinite(s->variant[bent].cost))
    return bent;
  const double saved = hl_light_gain(work, s->variant[simple].cost, s->variant[bent].cost);
  return saved > least_shape_gain + hl_light_noise_gain(work, 3) ? bent : simple;
}

static bool fits_clearly_better(const hl_light_settled *s, hl_variant plain,
                                hl_variant foreshortened, double floor)
{
  const double left = s->variant[plain].cost - floor;
  const double others = s->variant[foreshortened].cost - floor;
  return !isfinite(others) || (isfinite(left) && left < plain_handicap * others);
}

/* Plain where, beyond the noise, it leaves clearly less than foreshortened does; then the fewest terms
 * that the others do not beat by a stated gain. */
static void choose(const struct hl_light_work *work, const hl_light_settings *settings,
                   hl_light_settled *out)
{
  const hl_variant plain = of_kind(work, settings, out, HL_VARIANT_PLAIN);
  const hl_variant foreshortened = of_kind(work, settings, out, HL_VARIANT_FORESHORTENED);
  /* shading bends a little too: what a model leaves bounds the noise from above */
  const double least = fmin(out->variant[plain].cost, out->variant[foreshortened].cost);
  /* beyond any camera there is no noise to speak of */
  const bool shows = hl_light_gain(work, out->variant[foreshortened].cost, 0) > 0;
  const double floor = shows ? (1 - noise_margin) * fmin(out->noise_cost, least) : 0;
  /* where the simple ones tell them apart already, bends that make up for the wrong kind do not count */
  const bool is_plain =
      fits_clearly_better(out, HL_VARIANT_PLAIN, HL_VARIANT_FORESHORTENED, floor) ||
      fits_clearly_better(out, plain, foreshortened, floor);
  out->kept = is_plain ? plain : foreshortened;
  const hl_variant other = is_plain ? foreshortened : plain;
  const hl_variant simple = is_plain ? HL_VARIANT_PLAIN : HL_VARIANT_FORESHORTENED;
  const hl_variant bent = is_plain ? HL_VARIANT_PLAIN_BENT : HL_VARIANT_FORESHORTENED_BENT;
  const double cost = out->variant[out->kept].cost;
  out->bent_gain = hl_light_gain(work, out->variant[simple].cost, out->variant[bent].cost);
  out->kind_ratio = cost > 0 ? out->variant[other].cost / cost : HUGE_VAL;
  out->lobe_gain = hl_light_gain(work, out->variant[HL_VARIANT_MATTE].cost, cost);
  const hl_light_model *model = &out->variant[out->kept].model;
  if (!(out->lobe_gain > least_shape_gain + hl_light_noise_gain(work, model->spline.n)))
    out->kept = HL_VARIANT_MATTE;
}

static void refine_bent(struct hl_light_work *work, const hl_light_settings *settings, int kind,
                        hl_light_settled *out)
{
  const double weight = bent_error * hl_light_pixels(&work->all) * work->all.channels;
  const hl_light_variant *simple = &out->variant[HL_VARIANT_PLAIN + kind];
  hl_light_variant *bent = &out->variant[HL_VARIANT_PLAIN_BENT + kind];
  if (!isfinite(simple->cost) || settings->without & 1U << HL_LIGHT_BENDS)
    return;
  bent->model.exponent_weight = weight / (exponent_spread * exponent_spread);
  for (int c = 0; c < work->all.channels; c++)
    bent->model.body_weight[c] = weight / work->all.channels;
  hl_light_refine_variant(work, settings, simple->s, 1, bent);
}

void hl_light_shape(struct hl_light_work *work, const hl_light_settings *settings,
                    const double start[2][3], hl_light_settled *out)
{
  set_variant(out, HL_VARIANT_MATTE, HL_LOBE_AUTO, false);
  set_variant(out, HL_VARIANT_PLAIN, HL_LOBE_PLAIN, false);
  set_variant(out, HL_VARIANT_FORESHORTENED, HL_LOBE_FORESHORTENED, false);
  set_variant(out, HL_VARIANT_PLAIN_BENT, HL_LOBE_PLAIN, true);
  set_variant(out, HL_VARIANT_FORESHORTENED_BENT, HL_LOBE_FORESHORTENED, true);
  for (int kind = 0; kind < 2; kind++) {
    const hl_lobe lobe = kind == 0 ? HL_LOBE_PLAIN : HL_LOBE_FORESHORTENED;
    if (settings->lobe == HL_LOBE_AUTO || settings->lobe == lobe)
      (void)hl_light_refine_variant(work, settings, start[kind], 1,
                                    &out->variant[HL_VARIANT_PLAIN + kind]);
  }
  const int better =
      out->variant[HL_VARIANT_PLAIN].cost < out->variant[HL_VARIANT_FORESHORTENED].cost ? 0 : 1;
  const hl_light_variant *simple = &out->variant[HL_VARIANT_PLAIN + better];
  for (int kind = 0; kind < 2; kind++)
    refine_bent(work, settings, kind, out);
  if (isfinite(simple->cost))
    hl_light_refine_variant(work, settings, simple->s, 1, &out->variant[HL_VARIANT_MATTE]);
  choose(work, settings, out);
  out->nearness = out->variant[out->kept].nearness;
}
