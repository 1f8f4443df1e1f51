/**
 * A fitted reflectance that can be asked for any light and view: what `relight` draws, `--scale` and
 * `--aim` edit, and `brdf` writes.
 *
 *   radiance_c(n, s, v) = sum_i g_i [ f_ic(n.a_i) + b_ic (n.a_i) (n.v - v_i) ]   where n.s, n.v > 0
 *   a_i = (cs_i s + cv_i v)/|.|,   g_i = (1 or 1/(n.v)) M(n.s, n.v)^m_i
 *
 * M is Smith's shadowing and masking (src/smith.h); b_i, with v_i the mean n.v of the fit, is how much
 * a body's shading bends with the view. Both come from LIGHT.json only and are 0 elsewhere. In the log
 * domain the bracketed sum is the logarithm of radiance, and each foreshortened term divides it by
 * n.v. LIGHT.json and FIT.json both become one of these.
 */
#ifndef HALFLIGHT_REFLECTANCE_H
#define HALFLIGHT_REFLECTANCE_H

#include "halflight/fit.h"

#ifdef __cplusplus
extern "C" {
#endif

/** One term: a curve over the cosine from its axis. */
typedef struct hl_lobe_term {
  char name[HL_TERM_NAME_MAX]; /* "diffuse", "specular", the fit's, or "term1" and on */
  double cs, cv;               /* axis (cs s + cv v)/|.|: light (1,0), half-angle (1,1) */
  bool fixed_axis;             /* the axis means nothing in s and v: `axis` stays where it is */
  double axis[3];              /* under the fit's light and view */
  bool foreshortened;          /* 1/(n.v) */
  double masking_exponent;     /* m_i; 0 = none */
  double at_cos_view;          /* v_i */
  double view_slope[HL_CHANNELS_MAX]; /* b_i */
  int n;                              /* points of the curve, at least 2 */
  double t[HL_CURVE_POINTS];          /* ascending, within [-1, 1] */
  double value[HL_CHANNELS_MAX][HL_CURVE_POINTS];
} hl_lobe_term;

/** The sum of terms that explains a frame or samples. */
typedef struct hl_reflectance {
  int channels;
  bool log_domain; /* the terms add up to log radiance */
  bool
      camera_frame; /* x right, y down, z forward (LIGHT.json); false: x right, y up, z to the viewer */
  bool has_light;           /* the fit's light is known: `light` */
  double light[3], view[3]; /* of the frame or samples it was fitted to */
  int n_terms;
  hl_lobe_term term[HL_TERMS_MAX];
  hl_notes notes; /* what is not physical or not known: fixed axes, edits */
} hl_reflectance;

/**
 * Read LIGHT.json or FIT.json, whichever the file is.
 * @return as hl_camera_read; HL_ERR_FORMAT too where the file holds no reflectance (no light found)
 */
HL_API hl_status hl_reflectance_read(hl_ctx *ctx, const char *path, hl_reflectance *out);

/**
 * The reflectance of a fit. A term whose direction is known in terms of s and v follows the light and
 * the view; any other keeps its axis, and the notes say so.
 * @return HL_OK; HL_ERR_ARG (no terms, or a curve of fewer than 2 points or not ascending)
 */
HL_API hl_status hl_reflectance_of_fit(hl_ctx *ctx, const hl_fit *fit, hl_reflectance *out);

/**
 * Radiance (BRDF x cos x light) of a unit normal under a unit light, seen along a unit view; 0 where
 * n.s <= 0 or n.v <= 0. out: shape (3), grey repeated.
 *
 * Between its points a curve is the monotone cubic of Fritsch and Butland; beyond its last point it
 * stays, below its first it falls to 0 at n.a = 0 (paper L4; in the log domain it stays).
 */
HL_API void hl_reflectance_at(const hl_reflectance *reflectance, const double n[3],
                              const double s[3], const double v[3], double out[HL_CHANNELS_MAX]);

#ifdef __cplusplus
}
#endif
#endif
