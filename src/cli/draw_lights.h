/* A session's lights as charts. */
#ifndef HL_CLI_DRAW_LIGHTS_H
#define HL_CLI_DRAW_LIGHTS_H

#include "draw.h"

/* One figure a light, and a shade of it up to `high` where that is above. */
typedef struct hl_bars {
  const char *label; /* of the axis */
  int n;
  const double *value, *high; /* NAN where there is none; high may be NULL */
  const bool *good;
  bool logarithmic;
} hl_bars;

/* `data` is an hl_bars. HL_ERR_IO. */
hl_status hl_draw_bars(hl_ctx *ctx, hl_picture_kind kind, const char *path, const void *data);

#endif
