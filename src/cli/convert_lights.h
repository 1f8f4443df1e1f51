/* convert, where the file holds lights. */
#ifndef HL_CLI_CONVERT_LIGHTS_H
#define HL_CLI_CONVERT_LIGHTS_H

#include "halflight/halflight.h"
#include "outputs.h"

/* Read the lights of `in` and write them as `format` to `out`, or print them where it is NULL. */
hl_status hl_convert_lights(hl_ctx *ctx, const char *in, hl_lights_format format, const char *out,
                            hl_outputs *outputs);

#endif
