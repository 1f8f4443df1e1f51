/**
 * The paper's fits: reflectance as a sum of monotone curves along directions (Chandraker &
 * Ramamoorthi 2011, eq. 1).
 *
 *   rho_c(n) = sum_i g_i f_ic(a_i . n),          g_i in {1, 1/(n.v)}
 *   rho_c(n) = exp(sum_i f_ic(a_i . n)) prod_i g_i   in the log domain (Section 3: a product of factors)
 *
 * Channels share directions. rho is radiance (BRDF x cos) under the one light of the samples. Where the
 * light s is known a direction of the plane of s and v is a_i = (cs s + cv v)/|.|, per sample where
 * views differ. What a fit may claim is decided by the paper's propositions and by how the fitted
 * curves and directions turn out, not by the option given.
 */
#ifndef HALFLIGHT_FIT_H
#define HALFLIGHT_FIT_H

#include "halflight/samples.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { HL_TERMS_MAX = 8, HL_TERM_NAME_MAX = 32 };

/** What is fitted. */
typedef enum hl_fit_model {
  HL_FIT_RIDGE,            /* one curve along an unknown direction (Props. 1, 2) */
  HL_FIT_DICHROMATIC,      /* a linear part and one lobe (eq. 4; Props. 3, 5) */
  HL_FIT_ADDITIVE,         /* curves along known directions (5.2) */
  HL_FIT_PURSUIT,          /* curves along unknown directions (5.2, eqs. 18, 19) */
  HL_FIT_TORRANCE_SPARROW, /* the parametric baselines of the paper's comparison */
  HL_FIT_BLINN_PHONG
} hl_fit_model;

/** In which domain the terms add up. */
typedef enum hl_fit_domain { HL_DOMAIN_LINEAR, HL_DOMAIN_LOG } hl_fit_domain;
/** What draws free curves through their points. */
typedef enum hl_smoother { HL_SMOOTHER_SPLINE, HL_SMOOTHER_LOESS } hl_smoother;

/** Compute-time choices; what is known of the scene is an argument of hl_fit_samples. */
typedef struct hl_fit_settings {
  hl_lobe lobe;         /* auto keeps, term by term, the form with the smaller residual */
  hl_fit_domain domain; /* log: rho is a product of monotone factors */
  hl_smoother smoother; /* of the ridge's final curve */
  int terms;            /* of a pursuit; 0 = by cross-validation */
  int max_terms;        /* of a pursuit: fitted forward to so many, then dropped one at a time */
  int free_curves;      /* 1: curves need be neither monotone nor non-negative nor through zero */
  int starts;           /* directions that the joint refinement starts from, at most */
  int seed;             /* of the folds, and of the search's random turn */
  int folds;            /* of the cross-validation */
  int threads;          /* 0 = as many as the machine has; results do not depend on it */
} hl_fit_settings;

/** The defaults; they pass their own check. */
HL_API hl_fit_settings hl_fit_defaults(void);
/** Name, unit, bounds and text of every setting. */
HL_API const hl_field_table *hl_fit_fields(void);

/** Whether a term is the linear one. */
typedef enum hl_term_role { HL_TERM_LINEAR, HL_TERM_LOBE } hl_term_role;

/** One term of a fit. */
typedef struct hl_term {
  hl_term_role role;
  double direction[3];              /* unit, in the samples' frame, for the mean view */
  bool foreshortened;               /* g = 1/(n.v) */
  bool in_plane;                    /* direction = (cs s + cv v)/|.|, where the light is known */
  double cs, cv;                    /* whole numbers where `name` is one: h is (1,1), s is (1,0) */
  char name[HL_TERM_NAME_MAX];      /* "s", "h", "2s+v", ...; "" where there is none */
  double strength[HL_CHANNELS_MAX]; /* value of the curve at t = 1 */
  int n;                            /* points of the curve */
  double t[HL_CURVE_POINTS];        /* a.n, ascending from 0 to 1; free curves from what is shown */
  double value[HL_CHANNELS_MAX][HL_CURVE_POINTS];
  double shown[2];      /* least and largest a.n of the samples: beyond them a curve is a guess */
  double gain;          /* share of the variance that the fit loses without this term, refitted */
  double off_linear;    /* share of the curve's rms, over the samples, that no k t explains */
  double off_quadratic; /* ... that no k t + q t^2 explains */
} hl_term;

/** A row of the table that chose the number of terms. */
typedef struct hl_fit_size {
  int terms;
  double relative_error, unexplained_variance; /* of the fit to all samples */
  double cross_validated; /* unexplained share of the variance in samples left out; NaN: not done */
} hl_fit_size;

/** What a fit says: its terms, how well they explain the samples and what remains free. */
typedef struct hl_fit {
  bool trusted; /* false: reasons say why; the numbers are the best that could be had */
  hl_notes reasons, used, left_out;
  hl_fit_model model;
  bool log_domain; /* the curves add up to log rho; the scale of rho is in the first one */
  bool free_curves;
  int n_samples, channels;
  bool has_light; /* the light was given, or (Prop. 6, Prop. 3) follows from the lobes */
  bool light_given;
  double light[3], view[3]; /* unit; view is the samples' mean */
  int n_terms;
  hl_term term[HL_TERMS_MAX];
  int n_sizes;
  hl_fit_size size[HL_TERMS_MAX]; /* pursuit: what each number of terms reached */
  double relative_error;          /* mean |fit - data| / mean data, over all channels */
  double unexplained_variance;    /* share, 0..1 */
  double condition;               /* of the information on the directions; 1 where none is sought */
  double
      direction_sigma_rad; /* of the worst determined direction, by the residual; 0: none sought */
  double least_angle_rad;  /* between two terms' directions; pi where there is one term */
  double coplanarity; /* |a1 x a2 . a3|, the smallest of any three; 1 for fewer than three terms */
  hl_identifiability verdict;
  char proposition[80];
  char stays_free[HL_NOTE_TEXT_MAX];
  double estimate_ms, read_ms;
} hl_fit;

/** What is known of the scene; all of it may be absent. */
typedef struct hl_fit_known {
  const double *light;      /* shape (3): direction towards the light; NULL: not known */
  int n_directions;         /* additive: of the terms */
  const double *directions; /* shape (n_directions,3); NULL with a light: s and h */
} hl_fit_known;

/**
 * Fit a model to samples.
 *
 * @param known    vectors of any length but zero; NULL: nothing is known
 * @param settings NULL means hl_fit_defaults()
 * @param out      written on HL_OK
 * @return HL_OK, also where the answer is not to be trusted (out->trusted says);
 *         HL_ERR_ARG (samples, settings, known vectors, a model that is not one of these four);
 *         HL_ERR_DEGENERATE (fewer samples than unknowns, all on one circle, none lit, all black);
 *         HL_ERR_MEMORY
 * Memory proportional to the samples; deterministic for any number of threads; no allocation inside
 * iterations. Time grows linearly with the samples: directions are sought on a few thousand of them
 * and settled on all.
 */
HL_API hl_status hl_fit_samples(hl_ctx *ctx, const hl_samples *samples, hl_fit_model model,
                                const hl_fit_known *known, const hl_fit_settings *settings,
                                hl_fit *out);

/** Value of a term's curve at t = a.n, before g: linear between its points, held beyond them. */
HL_API double hl_term_value(const hl_term *term, int channel, double t);

/** a.n of a term for a normal and its view. */
HL_API double hl_term_argument(const hl_fit *fit, const hl_term *term, const double n[3],
                               const double v[3]);

/** What the fit says of a sample, from its terms' tables. out: shape (channels). */
HL_API void hl_fit_at(const hl_fit *fit, const double n[3], const double v[3],
                      double out[HL_CHANNELS_MAX]);

/** FIT.json (design: the command's file formats); *out is the caller's, release it with free(). */
HL_API hl_status hl_fit_json(hl_ctx *ctx, const hl_fit *fit, char **out);

/**
 * Read and check FIT.json.
 * @return HL_OK; HL_ERR_IO; HL_ERR_FORMAT (member, value and what would be accepted); HL_ERR_MEMORY
 */
HL_API hl_status hl_fit_read(hl_ctx *ctx, const char *path, hl_fit *out);

#ifdef __cplusplus
}
#endif
#endif
