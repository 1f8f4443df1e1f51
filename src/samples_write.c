/* SAMPLES.csv, written. */
#include <stdlib.h>

#include "halflight/export.h"
#include "halflight/samples.h"
#include "text.h"

enum { DIGITS = 9 };

static void add_numbers(hl_text *text, const double *number, int n, bool first)
{
  for (int i = 0; i < n; i++) {
    if (!first || i > 0)
      hl_text_add(text, ",");
    hl_text_number(text, number[i], DIGITS);
  }
}

hl_status hl_samples_write(hl_ctx *ctx, const char *path, const hl_samples *samples)
{
  hl_text text = {0};
  hl_text_add(&text, samples->channels == 1 ? "nx,ny,nz,value" : "nx,ny,nz,r,g,b");
  hl_text_add(&text, samples->view ? ",vx,vy,vz\n" : "\n");
  for (int i = 0; i < samples->n; i++) {
    add_numbers(&text, samples->normal + 3 * (size_t)i, 3, true);
    for (int c = 0; c < samples->channels; c++)
      add_numbers(&text, samples->value[c] + i, 1, false);
    if (samples->view)
      add_numbers(&text, samples->view + 3 * (size_t)i, 3, false);
    hl_text_add(&text, "\n");
  }
  const hl_status st =
      text.failed ? hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %d samples", path, samples->n)
                  : hl_file_write(ctx, path, text.bytes, text.n);
  free(text.bytes);
  return st;
}
