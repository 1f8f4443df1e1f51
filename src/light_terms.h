/* Terms that a frame may need beside its shape of reflectance. Private. */
#ifndef HL_LIGHT_TERMS_H
#define HL_LIGHT_TERMS_H

#include "light_work.h"

/* Tries each on the kept variant, one after another, and keeps what saves its stated share of the cost,
 * or what settings->with names; out->on and out->term say which. The shape is chosen anew whenever one is
 * kept. */
void hl_light_try_terms(struct hl_light_work *work, const hl_surface *surface,
                        const hl_light_settings *settings, const double start[2][3],
                        hl_light_settled *out);

/* HL_ERR_ARG where `with` and `without` contradict or name what there is not. */
hl_status hl_light_check_terms(hl_ctx *ctx, const hl_light_settings *settings);

#endif
