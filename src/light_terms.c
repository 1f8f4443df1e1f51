/* The terms a frame may need, one after another.
 *
 * A term is tried on the kept variant K, and of those that may be kept the one that saves most is. First it is only predicted what it would save: with the term
 * switched on at K's own direction, one solution for the curves and one Gauss-Newton step of all
 * nonlinear parameters together would leave
 *
 *   cost' = cost(K's s, term on) - g' H^-1 g,
 *
 * the score test of Rao 1948 with the curves profiled out. Where that is short of half the share asked
 * for, the term is left out with this figure, at the price of one iteration; else it is refined and
 * judged by the share that it saves of K's misfit, its cost beyond that of the pixels' noise. A term kept before is dropped again when a later one has made it needless.
 */
#include "light_terms.h"

#include <math.h>
#include <string.h>

#include "cholesky.h"
#include "halflight/vec3.h"

static const double same_start_rad = 0.02;
/* Without a shadow to show it, an ambient light must save more. */
static const double least_dark = 0.002, least_unseen_ambient = 0.4;
/* A step is a rough guess of what a refinement saves. */
static const double screening_share = 0.5;
/* Of the cost, what a term tried first must save for its share of the misfit to mean anything; and how far
 * the noise is trusted. */
static const double least_visible = 0.01, noise_share = 0.99;
/* A light farther than this many radii of the ball is distant: its rays part by 1 / 50 rad. */
static const double least_nearness = 0.01;

typedef struct term {
  const char *name;
  void (*on)(hl_light_model *model); /* NULL: not of the model that is refined here */
  double least; /* share of the cost that it must save; of those tried first, of the misfit */
  int columns;  /* further unknowns a channel */
} term;

static void ambient_on(hl_light_model *model)
{
  model->ambient = true;
}

static void near_on(hl_light_model *model)
{
  model->near = true;
}

static void backscatter_on(hl_light_model *model)
{
  model->backscatter = true;
}

static const term terms[HL_LIGHT_TERMS] = {
    [HL_LIGHT_AMBIENT] = {"ambient", ambient_on, 0.005, 1},
    [HL_LIGHT_NEAR] = {"near", near_on, 0.5, 1},
    [HL_LIGHT_BACKSCATTER] = {"backscatter", backscatter_on, 0.5, 2},
    [HL_LIGHT_COLORED_LOBE] = {"colored-lobe", NULL, 0, 0},
    [HL_LIGHT_OUTLIERS] = {"outliers", NULL, 0, 0},
    [HL_LIGHT_RESPONSE] = {"response", NULL, 0, 0},
    [HL_LIGHT_BENDS] = {"bends", NULL, 0, 0},
};
/* Those that are predicted first; the ambient light has a trial of its own. */
static const hl_light_term tried[] = {HL_LIGHT_NEAR, HL_LIGHT_BACKSCATTER};
enum { TRIED = sizeof tried / sizeof *tried };

const char *hl_light_term_name(hl_light_term which)
{
  return (unsigned)which < HL_LIGHT_TERMS ? terms[which].name : NULL;
}

hl_status hl_light_check_terms(hl_ctx *ctx, const hl_light_settings *settings)
{
  const unsigned unknown = (settings->with | settings->without) >> HL_LIGHT_TERMS;
  if (unknown)
    return hl_fail(ctx, HL_ERR_ARG,
                   "with = %#x and without = %#x: only the %d lowest bits are terms",
                   settings->with, settings->without, HL_LIGHT_TERMS);
  for (int i = 0; i < HL_LIGHT_TERMS; i++)
    if (settings->with & settings->without & 1U << i)
      return hl_fail(ctx, HL_ERR_ARG, "%s is asked for both with and without; one of the two",
                     terms[i].name);
  if (settings->with >> HL_LIGHT_RESPONSE & 1)
    return hl_fail(
        ctx, HL_ERR_ARG,
        "with response: one frame cannot tell a bend of the response from the free curves "
        "of lobe and body; calibrate the camera's response and give linear values");
  return HL_OK;
}

void hl_light_switch_on(unsigned on, hl_light_model *model)
{
  for (int i = 0; i < HL_LIGHT_TERMS; i++)
    if (on >> i & 1 && terms[i].on)
      terms[i].on(model);
}

static double dark_share(const hl_light_data *d, const double s[3])
{
  int dark = 0, all = 0;
  for (int i = 0; i < d->n; i++) {
    const double ns = d->normal[0][i] * s[0] + d->normal[1][i] * s[1] + d->normal[2][i] * s[2];
    dark += ns < -d->footprint[i] ? hl_light_area(d, i) : 0;
    all += hl_light_area(d, i);
  }
  return all > 0 ? (double)dark / all : 0;
}

/* g' H^-1 g of a point's step: what a full step would save, were the cost quadratic. */
static double decrement(const hl_model_step *step, int n)
{
  double u[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX], y[HL_NONLINEAR_MAX], sum = 0;
  memcpy(u, step->hessian, sizeof u);
  memcpy(y, step->gradient, sizeof y);
  (void)hl_cholesky(u[0], n, HL_NONLINEAR_MAX, 1e-9);
  hl_cholesky_forward(u[0], n, HL_NONLINEAR_MAX, y);
  for (int i = 0; i < n; i++)
    sum += y[i] * y[i];
  return sum;
}

/* Share of the misfit, what is left beyond the noise, that a term saves; 0 where what it saves of the cost
 * is too little to tell. */
static double misfit_gain(const struct hl_light_work *work, const hl_light_settled *settled,
                          hl_light_term which, double least, double without, double with)
{
  const double saved = hl_light_gain(work, without, with);
  const double noise = noise_share * fmin(settled->noise_cost, fmin(without, with));
  if (!(saved > least + hl_light_noise_gain(work, terms[which].columns)))
    return 0;
  return (without - with) / (without - noise);
}

/* Cost that the term is predicted to leave of a variant. */
static double predicted_cost(struct hl_light_work *work, const hl_light_settings *settings,
                             hl_light_term which, const hl_light_variant *base)
{
  hl_refined *at = &work->refined;
  hl_light_model model = base->model;
  terms[which].on(&model);
  work->model.keep_smoothing = false;
  if (!isfinite(base->cost) ||
      hl_model_fit_near(&model, &work->all, base->s, base->exponent, base->nearness,
                        settings->threads, &work->model, &at->at) != 0)
    return HUGE_VAL;
  hl_model_differentiate(&model, &work->all, &at->at, settings->threads, &work->model, &at->step);
  return fmax(at->at.cost - decrement(&at->step, hl_model_nonlinear(&model)), 0);
}

/* Whether the term is worth refining: by what it is predicted to save of the kept variant or, where that
 * has bends, of the simple one: bends also follow, badly, what a missing term leaves. */
static bool is_worth_trying(struct hl_light_work *work, const hl_light_settings *settings,
                            hl_light_term which, const hl_light_settled *settled,
                            hl_term_verdict *verdict)
{
  const hl_light_variant *kept = &settled->variant[settled->kept];
  const double left = predicted_cost(work, settings, which, kept);
  verdict->gain =
      misfit_gain(work, settled, which, screening_share * least_visible, kept->cost, left);
  if (verdict->gain > screening_share * verdict->least)
    return true;
  if (kept->model.body == 1)
    return false;
  const bool plain = kept->model.lobe == HL_LOBE_PLAIN;
  const hl_light_variant *simple =
      &settled->variant[plain ? HL_VARIANT_PLAIN : HL_VARIANT_FORESHORTENED];
  const double saved =
      hl_light_gain(work, simple->cost, predicted_cost(work, settings, which, simple));
  return saved > screening_share * settled->bent_gain;
}

/* The ambient light's own trial: the kept variant with a constant, refined from its answer and from the
 * search's, which had one: it can hold the answer without it on the wrong side of the ball. */
static bool refine_ambient(struct hl_light_work *work, const hl_light_settings *settings,
                           const double start[2][3], hl_light_settled *out)
{
  const hl_light_variant *base = &out->variant[out->kept];
  hl_light_variant *best = &out->variant[HL_VARIANT_AMBIENT];
  hl_term_verdict *verdict = &out->term[HL_LIGHT_AMBIENT];
  best->cost = HUGE_VAL;
  for (int from = 0; from < 2; from++) {
    hl_light_variant one = *base;
    one.model.ambient = true;
    one.cost = HUGE_VAL;
    const double *s = from == 0 ? base->s : start[base->model.lobe == HL_LOBE_FORESHORTENED];
    if (from == 1 && hl_angle(s, base->s) < same_start_rad)
      continue;
    if (hl_light_refine_variant(work, settings, s, 1, &one) == HL_OK && one.cost < best->cost)
      *best = one;
  }
  if (!isfinite(best->cost)) {
    verdict->unfit = "cannot be fitted";
    return false;
  }
  out->dark_share = dark_share(&work->all, best->s);
  verdict->gain = hl_light_gain(work, base->cost, best->cost);
  verdict->least =
      out->dark_share >= least_dark ? terms[HL_LIGHT_AMBIENT].least : least_unseen_ambient;
  verdict->least += hl_light_noise_gain(work, 1);
  return verdict->gain > verdict->least;
}

static const char *unfit(const hl_surface *surface, const hl_light_settings *settings,
                         hl_light_term which)
{
  if (settings->without >> which & 1)
    return "not asked for";
  if (which == HL_LIGHT_NEAR && !(surface->ball.radius_m > 0))
    return "only a ball says where its points are";
  return NULL;
}

static void switch_to(struct hl_light_work *work, const hl_light_settings *settings, unsigned on,
                      const double start[2][3], hl_light_settled *out)
{
  out->on = on;
  if (!(on >> HL_LIGHT_NEAR & 1))
    out->nearness = 0;
  hl_light_shape(work, settings, start, out);
}

/* The whole choice of shape with the term; true where it may be kept. `trial` comes as a copy of the
 * settled state and is what it would become. */
static bool try_term(struct hl_light_work *work, const hl_surface *surface,
                     const hl_light_settings *settings, hl_light_term which,
                     const double start[2][3], const hl_light_settled *settled,
                     hl_light_settled *trial)
{
  hl_term_verdict *verdict = &trial->term[which];
  const bool forced = settings->with >> which & 1;
  const double before = settled->variant[settled->kept].cost;
  *verdict = (hl_term_verdict){.least = terms[which].least};
  verdict->unfit = unfit(surface, settings, which);
  if (verdict->unfit)
    return false;
  if (!forced && !is_worth_trying(work, settings, which, settled, verdict)) {
    verdict->screened = true;
    return false;
  }
  switch_to(work, settings, settled->on | 1U << which, start, trial);
  const hl_light_variant *kept = &trial->variant[trial->kept];
  verdict->gain = isfinite(kept->cost)
                      ? misfit_gain(work, settled, which, least_visible, before, kept->cost)
                      : 0;
  if (forced)
    return isfinite(kept->cost);
  if (which == HL_LIGHT_NEAR && verdict->gain > verdict->least &&
      !(kept->nearness > least_nearness)) {
    verdict->unfit = "it would have to be behind the ball, or farther than shows";
    return false;
  }
  return verdict->gain > verdict->least;
}

/* Drops a kept term that a later one has made needless. */
static void try_without(struct hl_light_work *work, const hl_light_settings *settings,
                        hl_light_term which, const double start[2][3], hl_light_settled *out)
{
  hl_light_settled trial = *out;
  hl_term_verdict *verdict = &out->term[which];
  switch_to(work, settings, out->on & ~(1U << which), start, &trial);
  const double with = out->variant[out->kept].cost, without = trial.variant[trial.kept].cost;
  verdict->gain = !isfinite(without) ? 1
                  : which == HL_LIGHT_AMBIENT
                      ? hl_light_gain(work, without, with)
                      : misfit_gain(work, out, which, least_visible, without, with);
  if (verdict->gain > verdict->least)
    return;
  trial.term[which] = *verdict;
  *out = trial;
}

/* Adds the one that saves most of those that may be kept; false: none. */
static bool add_best(struct hl_light_work *work, const hl_surface *surface,
                     const hl_light_settings *settings, const double start[2][3],
                     hl_light_settled *out)
{
  hl_light_settled best = *out;
  double most = -HUGE_VAL;
  int added = -1;
  for (int i = 0; i < TRIED; i++) {
    hl_light_settled trial = *out;
    if (out->on >> tried[i] & 1)
      continue;
    const bool may = try_term(work, surface, settings, tried[i], start, out, &trial);
    const double gain = trial.term[tried[i]].gain + (settings->with >> tried[i] & 1 ? 1 : 0);
    best.term[tried[i]] = out->term[tried[i]] = trial.term[tried[i]];
    if (!may || gain <= most)
      continue;
    most = gain;
    added = (int)tried[i];
    memcpy(trial.term, best.term, sizeof trial.term);
    best = trial;
  }
  if (added < 0)
    return false;
  *out = best;
  return true;
}

void hl_light_try_terms(struct hl_light_work *work, const hl_surface *surface,
                        const hl_light_settings *settings, const double start[2][3],
                        hl_light_settled *out)
{
  const unsigned ambient = 1U << HL_LIGHT_AMBIENT;
  int added = 0;
  out->term[HL_LIGHT_AMBIENT] =
      (hl_term_verdict){.unfit = unfit(surface, settings, HL_LIGHT_AMBIENT)};
  if (!out->term[HL_LIGHT_AMBIENT].unfit &&
      (refine_ambient(work, settings, start, out) || settings->with & ambient)) {
    switch_to(work, settings, out->on | ambient, start, out);
    added++;
  }
  for (int i = 0; i < TRIED && add_best(work, surface, settings, start, out); i++)
    added++;
  if (added > 1)
    for (int i = 0; i < HL_LIGHT_TERMS; i++)
      if (terms[i].on && out->on & ~settings->with & 1U << i)
        try_without(work, settings, (hl_light_term)i, start, out);
}
