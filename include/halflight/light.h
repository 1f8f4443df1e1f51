/**
 * The light: its direction, how sure that is, and the reflectance that explains the frame.
 *
 * Model, per channel c with one direction s for all (Chandraker & Ramamoorthi 2011, eq. 4, with the
 * half-vector per pixel, a foreshortened lobe and a body that shares s):
 *
 *   I_c(p) = k_c D + g(n,v) f_c(angle(n, h(p))) [+ body's bends] [+ e_c],
 *   D = max(0, n.s),   h = (s+v)/|s+v|,   g in {1, 1/(n.v)} [x (G(n.s) G(n.v))^a]
 *
 * Terms in brackets enter only where the frame needs them; src/light_rows.c has them in full.
 */
#ifndef HALFLIGHT_LIGHT_H
#define HALFLIGHT_LIGHT_H

#include "halflight/surface.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What the uncertainty of a direction comes from. */
typedef enum hl_light_part {
  HL_PART_NOISE,  /* of the pixels */
  HL_PART_MODEL,  /* what the model does not describe */
  HL_PART_POSE,   /* of the ball, the camera held */
  HL_PART_CAMERA, /* its intrinsics, the ball's pose moving along where it was found through them */
  HL_PARTS
} hl_light_part;

enum { HL_CHANNELS_MAX = 3, HL_CURVE_POINTS = 121, HL_NOTES_MAX = 20, HL_NOTE_TEXT_MAX = 160 };

/** The form of the specular lobe. */
typedef enum hl_lobe { HL_LOBE_AUTO, HL_LOBE_PLAIN, HL_LOBE_FORESHORTENED } hl_lobe;

/** Terms that a scene may need; each is tried, and kept only where the frame demands it. */
typedef enum hl_light_term {
  HL_LIGHT_AMBIENT,      /* a constant e_c */
  HL_LIGHT_NEAR,         /* the light at a finite distance: s(p) and fall-off */
  HL_LIGHT_BACKSCATTER,  /* a second lobe about the view */
  HL_LIGHT_COLORED_LOBE, /* channels with lobes of their own shape, not one shape in one colour */
  HL_LIGHT_OUTLIERS,     /* pixels that no term explains are left out */
  HL_LIGHT_RESPONSE, /* a bend of the recorded response against linear: never tried, see `with` */
  HL_LIGHT_BENDS,    /* masking exponent and a body that bends away from Lambert's */
  HL_LIGHT_TERMS
} hl_light_term;

/** Name on the command line and in files: "ambient", "near", ...; NULL outside the list. */
HL_API const char *hl_light_term_name(hl_light_term term);

/** How to estimate. */
typedef struct hl_light_settings {
  hl_lobe lobe;     /* auto keeps the one with the smaller residual */
  unsigned with;    /* bit t: term t is kept whatever it saves; HL_ERR_ARG for the response, which
                            one frame cannot tell from the free curves of lobe and body */
  unsigned without; /* bit t: term t is never tried; both is HL_ERR_ARG */
  int pixels;       /* at most so many samples are worked on, pixels and means of blocks of them
                         where shading is straight; 0 = all pixels */
  double budget_ms; /* best answer within this time, as far as can be; 0 = no limit, and no clock is
                         looked at */
  int threads;      /* 0 = as many as the machine has; results do not depend on it */
  double model_error;    /* of the model, relative to the radiance: its weights while searching */
  double outlier_sigmas; /* pixels off by so many deviations are left out; 0 = never */
  double widest_deg;     /* largest angle from the view searched */
  int intervals;         /* of the lobe's spline, at most; fewer are faster and bend less */
} hl_light_settings;

/** The defaults; they pass their own check. */
HL_API hl_light_settings hl_light_defaults(void);
/** Name, unit, bounds and text of every setting. */
HL_API const hl_field_table *hl_light_fields(void);

/** One line of `used`, `left_out` or `reasons`. */
typedef struct hl_note {
  char what[40];
  char why[HL_NOTE_TEXT_MAX];
} hl_note;

/** Lines of `used`, `left_out` or `reasons`. */
typedef struct hl_notes {
  int n;
  hl_note note[HL_NOTES_MAX];
} hl_notes;

/** Notes that are kept in numbers: as many as there are, on the heap; zeroed it is empty. */
typedef struct hl_note_list {
  int n;
  hl_note *note;
} hl_note_list;

/** A fitted curve: radiance (BRDF x cos x light), in the frame's linear units, against an angle. */
typedef struct hl_curve {
  const char *lobe;    /* "diffuse" or "specular", static */
  const char *channel; /* "r", "g", "b" or "grey", static */
  int n;
  double angle_rad[HL_CURVE_POINTS]; /* diffuse: angle(n,s); specular: angle(n,h) */
  double value[HL_CURVE_POINTS];     /* monotone, non-negative; specular: before g(n,v), diffuse: at
                                        the mean n.v of the pixels, `mean_cos_view` */
} hl_curve;

/** What theory says of a fit: may another explain the same? */
typedef enum hl_identifiability { HL_UNIQUE, HL_AMBIGUOUS, HL_NOT_GUARANTEED } hl_identifiability;

/** What one frame said about its light. */
typedef struct hl_light {
  bool trusted;     /* false: reasons say why; the numbers are the best that could be had */
  bool found;       /* false: no direction at all, nothing below but reasons is meaningful */
  hl_notes reasons; /* why it is not to be trusted, in words a person can act on */

  double direction[3];        /* unit, surface to light, camera frame */
  double tangent_basis[2][3]; /* unit, orthogonal to direction */
  double covariance_rad2[2][2];
  double ellipse_95_rad[2];   /* half axes, major first */
  bool part_stated[HL_PARTS]; /* false: nothing is known of this part, and it counts as none */
  double part_rad2[HL_PARTS][2][2]; /* covariance_rad2 is their sum */
  double part_95_rad[HL_PARTS][2];  /* half axes of the ellipse of each part alone */
  double bound_rad2[2][2]; /* semiparametric Cramer-Rao bound: least covariance that any estimator
                              reaches whose curves are free, from the pixels' noise alone */
  double efficiency;       /* of the stated noise part: size of the bound over it, 0..1 */
  double by_center[2][3];  /* how the direction follows the ball's centre [rad/m]; 0: no ball */
  double by_intrinsics[2][HL_INTRINSICS_MAX]; /* how it follows the intrinsics, the centre held */
  bool near;            /* the light's distance shows; else position_m is nothing */
  double position_m[3]; /* camera frame */
  double position_covariance_m2[3][3];
  double color[3]; /* relative radiance, largest 1 */

  hl_lobe lobe;                   /* the one kept; HL_LOBE_AUTO where there is no lobe */
  double half_angle_direction[3]; /* h for the mean view */
  double diffuse_strength[3];     /* k_c */
  double lobe_strength[3];        /* f_c at angle 0, as far as the frame shows it */
  double masking_exponent;        /* a of g(n,v); 0 where the frame does not need it */
  double mean_cos_view;           /* of the pixels used */
  double mean_view[3];            /* of the pixels used, unit */
  double diffuse_view_slope[3];   /* b_c of the body's bend b_c D (n.v - mean_cos_view) */
  double ambient[3];              /* e_c, 0 where the frame does not need it */
  double backscatter[3]
                    [2]; /* a_c, b_c of the lobe about the view, D (a_c (n.v)^4 + b_c (n.v)^16) */
  double evidence_highlight; /* share of the information on s that the lobe brought, 0..1 */

  int channels;
  int n_curves;
  hl_curve curves[2 * HL_CHANNELS_MAX];

  int n_pixels;   /* samples used */
  int n_clipped;  /* pixels with a clipped channel */
  int n_outliers; /* pixels left out */
  int iterations;
  double rms;            /* of the residual, in the frame's units */
  double relative_error; /* mean |fit - data| / mean data over the lit pixels */
  double condition;      /* of the information matrix of s */

  hl_identifiability verdict;
  const char *proposition; /* static */
  const char *stays_free;  /* static */

  hl_notes used;
  hl_notes left_out;
} hl_light;

/** Everything that has the size of the ball; one a thread. */
typedef struct hl_light_work hl_light_work;

/**
 * @return HL_OK; HL_ERR_ARG; HL_ERR_MEMORY. The caller frees `out` with hl_light_work_free.
 */
HL_API hl_status hl_light_work_new(hl_ctx *ctx, int max_pixels, int channels, hl_light_work **out);
/** Release a workspace; NULL is accepted. */
HL_API void hl_light_work_free(hl_light_work *work);

/**
 * Estimate the light from one frame of a surface of known geometry.
 *
 * What is uncertain about the surface's camera and its ball enters the light's covariance: the camera's
 * as far as surface->camera states one, the pose's as far as surface->ball does.
 *
 * @param settings NULL means hl_light_defaults()
 * @param out      written on HL_OK and on HL_ERR_DEGENERATE (found = false, reasons filled)
 * @return HL_OK, also where the answer is not to be trusted (out->trusted says);
 *         HL_ERR_ARG (sizes that do not belong together, settings);
 *         HL_ERR_DEGENERATE (black, constant or fully clipped: no direction at all)
 * Allocates nothing. Deterministic for any number of threads, unless budget_ms is set.
 */
HL_API hl_status hl_light_estimate(hl_ctx *ctx, hl_light_work *work, const hl_frame *frame,
                                   const hl_surface *surface, const hl_light_settings *settings,
                                   hl_light *out);

/** Predicted and measured mean radiance and whether it was used (1) or left out (0), of each surface pixel of
 * the last estimate; borrowed from work until its next use, shape (surface->n). Any pointer may be
 * NULL. */
HL_API void hl_light_fitted(const hl_light_work *work, const float **predicted,
                            const float **measured, const float **weight);

#ifdef __cplusplus
}
#endif
#endif
