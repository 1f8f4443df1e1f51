/* What one fit works on: the samples at three sizes, and what is known of the scene. Private. */
#ifndef HL_FIT_WORK_H
#define HL_FIT_WORK_H

#include "ridge_refine.h"

enum { HL_FIT_COARSE = 400, HL_FIT_MIDDLE = 2048, HL_FIT_STARTS_MAX = 16 };

typedef struct hl_fit_work {
  void *pool;
  hl_ridge_data all;    /* every sample that counts */
  hl_ridge_data middle; /* some thousands; shares arrays with `all` where that has no more */
  hl_ridge_data coarse; /* some hundreds, the brightest among them */
  hl_spline coarse_spline;
  hl_spline bank[3][HL_TERMS_MAX]; /* of fits that are compared */
  hl_ridge_fit answer;
  hl_ridge_fit product; /* log domain: the fit of one form */
  hl_spline product_bank[HL_TERMS_MAX];
  double product_misfit;
  bool kept_divided;
  double level;                /* mean of the values, the unit of data[].y in the linear domain */
  int not_seen, not_lit, dark; /* samples left out: n.v <= 0, n.s <= 0, radiance 0 */
  bool has_light;
  bool in_plane; /* directions are sought in the plane of light and view, which span one */
  double light[3];
  bool log_domain, free_curves;
  bool divided; /* log domain: y is that of rho n.v */
  hl_lobe lobe;
  int starts, seed, folds, threads;
  hl_refine_work refine;
  hl_gram whole;
  hl_ridge_fit best[HL_TERMS_MAX + 1]; /* of each number of terms, on the coarse samples */
  hl_ridge_fit trial, rival;
  hl_ridge_fit start[HL_FIT_STARTS_MAX]; /* settled */
  int order[HL_FIT_STARTS_MAX];          /* of the starts, best first */
  int n_starts;
  double *residual; /* shape (coarse.n) */
  double *scratch;  /* shape (all.n) */
} hl_fit_work;

/* fit_gather.c: samples that count, in one place. *out is the caller's (hl_fit_work_free).
 * HL_ERR_DEGENERATE, HL_ERR_MEMORY. */
hl_status hl_fit_gather(hl_ctx *ctx, const hl_samples *samples, const double *light,
                        const hl_fit_settings *settings, int unknowns, hl_fit_work **out);
void hl_fit_work_free(hl_fit_work *work);

/* Evenly spread over [0,1), the same for the same sample wherever it stands. */
double hl_fit_lot(const hl_ridge_data *data, int i, int seed);

/* In the log domain a factor 1/(n.v) belongs to the product: y becomes log(rho n.v), or log rho. */
void hl_fit_divide(hl_fit_work *work, bool divided);

/* fit_search.c: directions of one more ridge worth trying, best first, by how much of a residual a
 * curve of steps explains along them (eq. 19). Returns how many, at most `most`. */
typedef struct hl_fit_start {
  double a[3];
  bool foreshortened;
  double gain; /* share of the residual's square */
} hl_fit_start;
int hl_fit_forward(hl_fit_work *work, const hl_ridge_fit *model, hl_fit_start *out, int most);

/* fit_terms.c: a sum of no ridges yet. */
void hl_fit_begin(const hl_fit_work *work, hl_ridge_fit *fit);
/* One more term, linear where there is no spline; the axis' kind says what of it is sought. */
void hl_fit_append(hl_ridge_fit *fit, const hl_spline *spline, bool foreshortened,
                   const hl_axis *axis);
void hl_fit_drop(hl_ridge_fit *fit, int term);
/* Towards a: sought in the plane where work->in_plane, else anywhere. */
hl_axis hl_fit_axis(const hl_fit_work *work, const double a[3]);
hl_axis hl_fit_in_plane(double cs, double cv);
hl_axis hl_fit_named(double cs, double cv);

/* fit_starts.c: settle work->trial on the coarse samples and put it among the starts. */
void hl_fit_add_start(hl_fit_work *work);
/* Whether a lobe of this form may be used. */
bool hl_fit_may(const hl_fit_work *work, bool foreshortened);
void hl_fit_refine_coarse(hl_fit_work *work, int iterations, hl_ridge_fit *fit);
/* Lights to begin with: i of n from straight ahead to beyond the rim ... */
void hl_fit_light_of(const hl_fit_work *work, int i, int n, double out[3]);
/* ... the normal of the brightest sample, or the view mirrored at it. */
void hl_fit_brightest_light(const hl_fit_work *work, bool mirrored, double out[3]);

/* fit_pursuit.c: the best sums of least .. most ridges on the coarse samples into work->best. Axes are
 * sought in the plane of light and view (work->in_plane), or anywhere. */
void hl_fit_pursue(hl_fit_work *work, int least, int most);

/* fit_finish.c: finer curves of a fit that the coarse samples gave, smoothed by cross-validation, their
 * splines in `bank` (shape HL_TERMS_MAX), its directions refined on the middle samples ... */
void hl_fit_refine_middle(hl_fit_work *work, hl_spline *bank, hl_ridge_fit *fit);
/* ... again, its splines and smoothing kept ... */
void hl_fit_refine_near(hl_fit_work *work, hl_ridge_fit *fit);
/* ... and its directions on all samples, with more breaks where the splines are all that limits it
 * (into work->bank[2]). */
void hl_fit_refine_all(hl_fit_work *work, hl_ridge_fit *fit);
/* The other form of each lobe, where it fits better, on the middle samples. */
void hl_fit_choose_forms(hl_fit_work *work, hl_ridge_fit *fit);
/* Last, the curves once more with weights from the residuals, half way from least squares to least
 * absolute deviations: what a sum of ridges leaves of a real material is not spread like noise. The
 * weights of work->all change. */
void hl_fit_reweigh(hl_fit_work *work, hl_ridge_fit *fit);

/* The better of two fits refined on the middle samples into `best` (n == 0: none yet), its splines into
 * `bank`. */
void hl_fit_keep(const hl_ridge_fit *fit, hl_spline *bank, hl_ridge_fit *best);

/* fit_prefer.c: whether `structured` fits nearly as well as `free`: its residual's square at most
 * `ratio` times the other's, or that plus the square of `share` of the data's rms. */
bool hl_fit_is_near(const hl_fit_work *work, const hl_ridge_fit *structured,
                    const hl_ridge_fit *free, double ratio, double share);
/* Directions near a named one of the plane of `light` and view become it, where that fits nearly as
 * well. */
void hl_fit_prefer_names(hl_fit_work *work, const double light[3], hl_ridge_fit *fit);
/* Two of the terms about h and s of some light (Prop. 6) become so, where that fits nearly as well;
 * the light is then fit->axes.light. */
bool hl_fit_prefer_light(hl_fit_work *work, hl_ridge_fit *fit);

/* fit_sizes.c: the best of 1 .. most ridges in work->best compared by cross-validation on the middle
 * samples. */
typedef struct hl_fit_sizes {
  int n, chosen;
  hl_fit_size size[HL_TERMS_MAX];
} hl_fit_sizes;
void hl_fit_compare_sizes(hl_fit_work *work, int most, hl_fit_sizes *out);

/* fit_errors.c: how far a fit is from a set of samples, in their own units. */
typedef struct hl_fit_errors {
  double relative;    /* mean |fit - data| / mean data */
  double unexplained; /* share of the variance, all channels together */
} hl_fit_errors;
void hl_fit_errors_of(const hl_fit_work *work, const hl_ridge_fit *fit, const hl_ridge_data *data,
                      hl_fit_errors *out);

/* fit_models.c, fit_dichromatic.c: each model's own search, on the middle samples; splines in
 * work->bank. *light_found says that fit->axes.light follows from the lobes. */
void hl_fit_search_ridge(hl_fit_work *work, hl_ridge_fit *fit);
void hl_fit_search_additive(hl_fit_work *work, int n, const double *directions, hl_ridge_fit *fit);
void hl_fit_search_pursuit(hl_fit_work *work, int terms, int max_terms, hl_fit_sizes *sizes,
                           bool *light_found, hl_ridge_fit *fit);
void hl_fit_search_dichromatic(hl_fit_work *work, bool *light_found, hl_ridge_fit *fit);

/* fit_tables.c: a fit as its user sees it. */
void hl_fit_tables(hl_fit_work *work, hl_ridge_fit *fit, bool light_found, hl_fit *out);

/* fit_loess.c: the ridge's curve smoothed by local lines instead; its errors too. */
void hl_fit_loess(hl_fit_work *work, const hl_ridge_fit *fit, hl_fit *out);

/* fit_verdict.c */
void hl_fit_judge(const hl_fit_work *work, const hl_ridge_fit *fit, hl_fit *out);

#endif
