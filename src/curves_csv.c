/* The fitted curves as a table: a row a point. */
#include <stdlib.h>

#include "halflight/export.h"
#include "text.h"

#define DEG_PER_RAD 57.295779513082320877

enum { DIGITS = 9 };

static void add_curve(hl_text *text, const hl_curve *curve)
{
  for (int i = 0; i < curve->n; i++) {
    hl_text_add(text, curve->lobe);
    hl_text_add(text, ",");
    hl_text_add(text, curve->channel);
    hl_text_add(text, ",radiance,");
    hl_text_number(text, DEG_PER_RAD * curve->angle_rad[i], DIGITS);
    hl_text_add(text, ",");
    hl_text_number(text, curve->value[i], DIGITS);
    hl_text_add(text, "\n");
  }
}

hl_status hl_curves_csv_write(hl_ctx *ctx, const char *path, const hl_light *light)
{
  hl_text text = {0};
  hl_text_add(&text, "lobe,channel,quantity,angle_deg,value\n");
  for (int i = 0; i < light->n_curves; i++)
    add_curve(&text, &light->curves[i]);
  const hl_status st = text.failed
                           ? hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for the curves", path)
                           : hl_file_write(ctx, path, text.bytes, text.n);
  free(text.bytes);
  return st;
}
