/**
 * A fitted reflectance as a BRDF, and as a MERL table that other programs read.
 *
 * A fit says radiance, R = E rho (n.s): the light's irradiance E (at normal incidence, in the frame's
 * units) is not in one photo, so the BRDF's scale is a choice: E itself, or the albedo. A MERL table
 * holds isotropic reciprocal BRDFs alone; src/brdf.c says which one stands for a fit.
 */
#ifndef HALFLIGHT_BRDF_H
#define HALFLIGHT_BRDF_H

#include "halflight/merl.h"
#include "halflight/reflectance.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How to tabulate a reflectance. */
typedef struct hl_brdf_settings {
  double irradiance; /* E, of the light that was fitted under */
  double albedo;     /* 0: by E; else that of the brightest channel, light along the normal */
} hl_brdf_settings;

/** The defaults; they pass their own check. */
HL_API hl_brdf_settings hl_brdf_defaults(void);
/** Name, unit, bounds and text of every setting. */
HL_API const hl_field_table *hl_brdf_fields(void);

/** What became of a fit. */
typedef struct hl_brdf_summary {
  double irradiance; /* E that the BRDF was divided by */
  double albedo[3];  /* share of the light along the normal that is reflected at all */
  double asymmetry;  /* the BRDF's radiance against the fit's, mean |difference| / mean, over a ball
                        under the fit's own light and view: 0 where the fit is reciprocal */
  hl_notes notes;    /* the reflectance's own, and what the table could not hold */
} hl_brdf_summary;

/**
 * The reciprocal BRDF of a reflectance for E = 1, for unit vectors; 0 where n.s <= 0 or n.v <= 0.
 * A fixed axis is taken as it stands. out: shape (3).
 */
HL_API void hl_brdf_at(const hl_reflectance *reflectance, const double n[3], const double s[3],
                       const double v[3], double out[3]);

/**
 * Fill a MERL table with a reflectance's BRDF at the cells' centres. Centres at or below the horizon
 * take the value just above it, so that tables asked for the nearest cell are whole.
 *
 * @param settings NULL means hl_brdf_defaults()
 * @param merl     the caller's, hl_merl_free
 * @param summary  may be NULL
 * @return HL_OK; HL_ERR_ARG (settings; an albedo for a black reflectance); HL_ERR_DEGENERATE (a term
 *         whose axis is not known in terms of light and view: no BRDF follows); HL_ERR_MEMORY
 * Cost: two evaluations for each of 729000 cells, under a second.
 */
HL_API hl_status hl_brdf_table(hl_ctx *ctx, const hl_reflectance *reflectance,
                               const hl_brdf_settings *settings, hl_merl *merl,
                               hl_brdf_summary *summary);

#ifdef __cplusplus
}
#endif
#endif
