/* The paper's fits: gather, search, prefer, settle on all samples, tabulate, judge.
 *
 * Each step is a file: fit_gather.c, fit_models.c and fit_dichromatic.c (with fit_search.c,
 * fit_starts.c, fit_pursuit.c), fit_sizes.c, fit_prefer.c, fit_finish.c, fit_tables.c, fit_loess.c,
 * fit_verdict.c. The sum of ridges itself is ridges.c, its curves ridge_curves.c, its solver
 * ridge_refine.c.
 */
#include "halflight/fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit_work.h"
#include "halflight/notes.h"
#include "halflight/vec3.h"

#ifdef _OPENMP
#include <omp.h>
#endif

static const double plane_rad = 0.01; /* light and view closer than this span no plane */
static const double pi = 3.14159265358979323846;

hl_fit_settings hl_fit_defaults(void)
{
  const hl_fit_settings s = {.lobe = HL_LOBE_AUTO,
                             .domain = HL_DOMAIN_LINEAR,
                             .smoother = HL_SMOOTHER_SPLINE,
                             .terms = 0,
                             .max_terms = 5,
                             .free_curves = 0,
                             .starts = 4,
                             .seed = 1,
                             .folds = 5,
                             .threads = 1};
  return s;
}

const hl_field_table *hl_fit_fields(void)
{
  static const char *const lobes[] = {"auto", "plain", "foreshortened", NULL};
  static const char *const domains[] = {"linear", "log", NULL};
  static const char *const smoothers[] = {"spline", "loess", NULL};
  static const char *const switches[] = {"no", "yes", NULL};
  static const hl_field fields[] = {
      {"lobe", HL_FIELD_CHOICE, offsetof(hl_fit_settings, lobe), 0, 2, "",
       "form of the lobes, f(a.n) or f(a.n)/(n.v); auto keeps, lobe by lobe, the one with the "
       "smaller residual",
       lobes},
      {"domain", HL_FIELD_CHOICE, offsetof(hl_fit_settings, domain), 0, 1, "",
       "log fits a product of factors instead of a sum", domains},
      {"smoother", HL_FIELD_CHOICE, offsetof(hl_fit_settings, smoother), 0, 1, "",
       "of the ridge's final curve", smoothers},
      {"terms", HL_FIELD_INT, offsetof(hl_fit_settings, terms), 0, HL_TERMS_MAX, "",
       "terms of a pursuit, 0 to choose by cross-validation", NULL},
      {"max_terms", HL_FIELD_INT, offsetof(hl_fit_settings, max_terms), 1, HL_TERMS_MAX, "",
       "terms a pursuit is fitted forward to, before it drops the least", NULL},
      {"free_curves", HL_FIELD_CHOICE, offsetof(hl_fit_settings, free_curves), 0, 1, "",
       "curves need be neither monotone nor non-negative nor through zero", switches},
      {"starts", HL_FIELD_INT, offsetof(hl_fit_settings, starts), 1, HL_FIT_STARTS_MAX, "",
       "directions that each search begins from", NULL},
      {"seed", HL_FIELD_INT, offsetof(hl_fit_settings, seed), 0, 1e6, "",
       "of the lots that deal samples into sets", NULL},
      {"folds", HL_FIELD_INT, offsetof(hl_fit_settings, folds), 2, 20, "",
       "of the cross-validation", NULL},
      {"threads", HL_FIELD_INT, offsetof(hl_fit_settings, threads), 0, 256, "",
       "threads to use, 0 for as many as the machine has; the result does not depend on it", NULL},
  };
  static const hl_field_table table = {"fit settings", fields,
                                       (int)(sizeof fields / sizeof *fields)};
  return &table;
}

static int threads_of(const hl_fit_settings *settings)
{
#ifdef _OPENMP
  return settings->threads > 0 ? settings->threads : omp_get_max_threads();
#else
  (void)settings;
  return 1;
#endif
}

/* ---- checks ---- */

static hl_status check_vector(hl_ctx *ctx, const char *what, const double v[3])
{
  const double length = hl_norm(v);
  if (length > 0 && isfinite(length))
    return HL_OK;
  return hl_fail(ctx, HL_ERR_ARG,
                 "%s = %.4g,%.4g,%.4g is no direction; a vector of length above 0 "
                 "is needed",
                 what, v[0], v[1], v[2]);
}

static hl_status check_known(hl_ctx *ctx, hl_fit_model model, const hl_fit_known *known)
{
  hl_status st = known->light ? check_vector(ctx, "light", known->light) : HL_OK;
  if (st != HL_OK)
    return st;
  if (model != HL_FIT_ADDITIVE && known->directions)
    return hl_fail(ctx, HL_ERR_ARG, "directions are for the additive model; the others seek them");
  if (model == HL_FIT_ADDITIVE && !known->directions && !known->light)
    return hl_fail(ctx, HL_ERR_ARG,
                   "the additive model needs directions, or the light, for s and h");
  if (known->directions && (known->n_directions < 1 || known->n_directions > HL_TERMS_MAX))
    return hl_fail(ctx, HL_ERR_ARG, "directions = %d is outside [1, %d]", known->n_directions,
                   HL_TERMS_MAX);
  for (int i = 0; known->directions && i < known->n_directions && st == HL_OK; i++)
    st = check_vector(ctx, "a direction", known->directions + 3 * (size_t)i);
  return st;
}

static hl_status check(hl_ctx *ctx, const hl_samples *samples, hl_fit_model model,
                       const hl_fit_known *known, const hl_fit_settings *settings)
{
  if (model > HL_FIT_PURSUIT)
    return hl_fail(ctx, HL_ERR_ARG,
                   "model = %d is none of ridge, dichromatic, additive and pursuit", (int)model);
  hl_status st = hl_fields_check(ctx, hl_fit_fields(), settings);
  if (st == HL_OK)
    st = hl_samples_check(ctx, samples);
  if (st == HL_OK && settings->smoother == HL_SMOOTHER_LOESS && model != HL_FIT_RIDGE)
    st = hl_fail(ctx, HL_ERR_ARG, "the loess smoother is for the ridge model");
  if (st == HL_OK && settings->domain == HL_DOMAIN_LOG && model == HL_FIT_DICHROMATIC)
    st = hl_fail(ctx, HL_ERR_ARG,
                 "the dichromatic model is a sum; the log domain is for ridge, additive and "
                 "pursuit");
  return st == HL_OK ? check_known(ctx, model, known) : st;
}

/* Least number of samples that could determine the model. */
static int unknowns_of(hl_fit_model model, const hl_fit_known *known,
                       const hl_fit_settings *settings)
{
  enum { CURVE = 4, DIRECTION = 2 };
  switch (model) {
  case HL_FIT_DICHROMATIC:
    return CURVE + DIRECTION + (known->light ? 1 : 3);
  case HL_FIT_ADDITIVE:
    return CURVE * (known->directions ? known->n_directions : 2);
  case HL_FIT_PURSUIT:
    return (CURVE + DIRECTION) * (settings->terms > 0 ? settings->terms : 1);
  case HL_FIT_RIDGE:
  case HL_FIT_TORRANCE_SPARROW:
  case HL_FIT_BLINN_PHONG:
    break;
  }
  return CURVE + DIRECTION;
}

/* ---- the way of a fit ---- */

typedef struct fit_run {
  hl_fit_model model;
  const hl_fit_known *known;
  hl_fit_settings settings;
  hl_fit_sizes sizes;
  bool light_found;
} fit_run;

/* Its own search, on the middle samples. */
static void search(hl_fit_work *w, fit_run *run, hl_ridge_fit *fit)
{
  double pair[6];
  run->light_found = false;
  w->in_plane = w->has_light && hl_angle(w->light, w->all.mean_view) > plane_rad &&
                hl_angle(w->light, w->all.mean_view) < pi - plane_rad;
  switch (run->model) {
  case HL_FIT_DICHROMATIC:
    hl_fit_search_dichromatic(w, &run->light_found, fit);
    break;
  case HL_FIT_ADDITIVE:
    if (run->known->directions) {
      hl_fit_search_additive(w, run->known->n_directions, run->known->directions, fit);
      break;
    }
    memcpy(pair, w->light, sizeof w->light);
    hl_add_scaled(w->light, 1, w->all.mean_view, pair + 3);
    hl_fit_search_additive(w, w->in_plane ? 2 : 1, pair, fit);
    break;
  case HL_FIT_PURSUIT:
    hl_fit_search_pursuit(w, run->settings.terms, run->settings.max_terms, &run->sizes,
                          &run->light_found, fit);
    break;
  case HL_FIT_RIDGE:
  case HL_FIT_TORRANCE_SPARROW:
  case HL_FIT_BLINN_PHONG:
    hl_fit_search_ridge(w, fit);
    break;
  }
}

/* In the log domain a factor 1/(n.v) belongs to the whole product: with and without it. */
static void search_forms(hl_fit_work *w, fit_run *run, hl_ridge_fit *fit)
{
  if (!w->log_domain) {
    search(w, run, fit);
    return;
  }
  fit->ridges.n = 0;
  for (int divided = 0; divided < 2; divided++) {
    if (w->lobe != HL_LOBE_AUTO && (w->lobe == HL_LOBE_FORESHORTENED) != (divided == 1))
      continue;
    hl_fit_divide(w, divided == 1);
    search(w, run, &w->product);
    const bool better = fit->ridges.n == 0 || w->product.curves.misfit < w->product_misfit;
    if (better) {
      w->product_misfit = w->product.curves.misfit;
      fit->ridges.n = 0;
      hl_fit_keep(&w->product, w->product_bank, fit);
      w->kept_divided = divided == 1;
    }
  }
  hl_fit_divide(w, w->kept_divided);
}

static void note_samples(const hl_fit_work *w, hl_fit *out)
{
  if (w->not_seen > 0)
    hl_notes_add(&out->left_out, "unseen samples", "%d of n.v <= 0", w->not_seen);
  if (w->not_lit > 0)
    hl_notes_add(&out->left_out, "attached shadow", "%d samples of n.s <= 0", w->not_lit);
  if (w->dark > 0)
    hl_notes_add(&out->left_out, "black samples",
                 w->log_domain ? "%d without a logarithm" : "%d of radiance 0: not lit", w->dark);
}

static void note_terms(const hl_fit_work *w, const fit_run *run, hl_fit *out)
{
  int divided = 0, named = 0;
  for (int i = 0; i < out->n_terms; i++) {
    divided += out->term[i].foreshortened;
    named += out->term[i].in_plane;
  }
  hl_notes_add(&out->used, out->free_curves ? "free curves" : "monotone curves",
               out->free_curves ? "smoothed by cross-validation alone"
                                : "non-negative and through zero (L1-L4)");
  if (divided > 0)
    hl_notes_add(&out->used, "foreshortened lobes", "%d of %d terms: f(a.n)/(n.v)", divided,
                 out->n_terms);
  if (named == out->n_terms && named > 0)
    hl_notes_add(&out->used, "plane of light and view",
                 "every direction follows the light, so the fit can be relit");
  else if (out->has_light)
    hl_notes_add(&out->left_out, "plane of light and view",
                 "%d of %d directions lie outside it: the fit cannot be relit there",
                 out->n_terms - named, out->n_terms);
  if (run->light_found)
    hl_notes_add(&out->used, "light from the lobes",
                 run->model == HL_FIT_DICHROMATIC ? "taken as that of which b is the half vector"
                                                  : "two directions are h and s of one light");
  if (w->all.view[0] && named < out->n_terms)
    hl_notes_add(&out->left_out, "view of every sample",
                 "directions outside the plane of light and view are the same for all samples");
}

static void fit_all(hl_fit_work *w, fit_run *run, hl_fit *out)
{
  hl_ridge_fit *fit = &w->answer;
  search_forms(w, run, fit);
  if (run->light_found)
    hl_fit_prefer_names(w, fit->axes.light, fit);
  else if (w->in_plane)
    hl_fit_prefer_names(w, w->light, fit);
  hl_fit_refine_all(w, fit);
  hl_fit_reweigh(w, fit);
  out->model = run->model;
  hl_fit_tables(w, fit, run->light_found, out);
  if (run->settings.smoother == HL_SMOOTHER_LOESS)
    hl_fit_loess(w, fit, out);
  out->n_sizes = run->sizes.n;
  memcpy(out->size, run->sizes.size, sizeof out->size);
  hl_fit_judge(w, fit, out);
  note_terms(w, run, out);
  note_samples(w, out);
}

hl_status hl_fit_samples(hl_ctx *ctx, const hl_samples *samples, hl_fit_model model,
                         const hl_fit_known *known, const hl_fit_settings *settings, hl_fit *out)
{
  const hl_fit_known nothing = {0};
  fit_run run = {.model = model,
                 .known = known ? known : &nothing,
                 .settings = settings ? *settings : hl_fit_defaults()};
  hl_fit_work *work = NULL;
  hl_status st = check(ctx, samples, model, run.known, &run.settings);
  if (st == HL_OK)
    st = hl_fit_gather(ctx, samples, run.known->light, &run.settings,
                       unknowns_of(model, run.known, &run.settings), &work);
  if (st != HL_OK)
    return st;
  work->threads = threads_of(&run.settings);
  memset(out, 0, sizeof *out);
  fit_all(work, &run, out);
  hl_fit_work_free(work);
  return HL_OK;
}
