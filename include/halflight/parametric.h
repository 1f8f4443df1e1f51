/**
 * The parametric one-lobe models that fits are compared with (Chandraker & Ramamoorthi 2011, Sections 3
 * and 6): a body and a lobe about the half-angle h of a known light s, one width for all channels.
 *
 *   rho_c(n) = kd_c (n.s) + ks_c f(mu; n.h)   where n.s > 0
 *   f = exp(-mu angle(n,h)^2)                 simplified Torrance-Sparrow
 *   f = (n.h)^mu                              Blinn-Phong
 *
 * rho is radiance, as everywhere in a fit, and the lobe is plain, as the paper has it: it is not divided
 * by n.v.
 */
#ifndef HALFLIGHT_PARAMETRIC_H
#define HALFLIGHT_PARAMETRIC_H

#include "halflight/fit.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Fit one of them by least squares, kd and ks not negative, mu within [1e-2, 1e7]. Where samples carry
 * views, h is each sample's own.
 *
 * @param model HL_FIT_TORRANCE_SPARROW or HL_FIT_BLINN_PHONG
 * @param light towards the light, any length but 0
 * @param out   two terms, "s" (linear) and "h" (the lobe, its curve drawn from the formula); `used`
 *              says mu. Written on HL_OK
 * @return HL_OK, also where the answer is not to be trusted (out->trusted says: no lobe was found);
 *         HL_ERR_ARG (samples, model, light); HL_ERR_DEGENERATE (fewer lit samples than unknowns, or
 *         all of them black); HL_ERR_MEMORY
 * Deterministic; mu from a dozen starts by Levenberg and Marquardt (cminpack), kd and ks projected out.
 * Memory about 100 bytes a value of a sample; cost some hundred passes.
 */
HL_API hl_status hl_fit_parametric(hl_ctx *ctx, const hl_samples *samples, hl_fit_model model,
                                   const double light[3], hl_fit *out);

#ifdef __cplusplus
}
#endif
#endif
