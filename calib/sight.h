/* Whether sights are sights. */
#ifndef HL_SIGHT_H
#define HL_SIGHT_H

#include "halflight/position.h"

/* HL_ERR_ARG, as hl_position_of_sights has it. */
hl_status hl_sights_check(hl_ctx *ctx, const hl_sight *sights, int n);

#endif
