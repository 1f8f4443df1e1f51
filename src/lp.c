/*
 * `.lp` of RTI tools: the count, then a line `name x y z` a light. Their frame has x right, y up, z
 * towards the camera, so (x, -y, -z) of ours.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/export.h"
#include "halflight/vec3.h"
#include "text.h"

enum { DIGITS = 12 };

static hl_status check(hl_ctx *ctx, const char *const *names, const double *directions, int n)
{
  if (n < 1)
    return hl_fail(ctx, HL_ERR_ARG, "lights = %d; at least 1 is needed", n);
  for (int i = 0; i < n; i++) {
    if (!names[i] || names[i][0] == '\0' || strpbrk(names[i], "\r\n"))
      return hl_fail(ctx, HL_ERR_ARG, "name of light %d is empty or holds a line break", i);
    if (!(fabs(hl_norm(directions + 3 * i) - 1) <= 1e-6))
      return hl_fail(ctx, HL_ERR_ARG, "direction of light %d has length %.6g; 1 is needed", i,
                     hl_norm(directions + 3 * i));
  }
  return HL_OK;
}

hl_status hl_lp_write(hl_ctx *ctx, const char *path, const char *const *names,
                      const double *directions, int n)
{
  hl_status st = check(ctx, names, directions, n);
  if (st != HL_OK)
    return st;
  hl_text text = {0};
  hl_text_number(&text, n, 10);
  hl_text_add(&text, "\n");
  for (int i = 0; i < n; i++) {
    const double *d = directions + 3 * i;
    const double lp[3] = {d[0], 0 - d[1], 0 - d[2]};
    hl_text_add(&text, names[i]);
    for (int k = 0; k < 3; k++) {
      hl_text_add(&text, " ");
      hl_text_number(&text, lp[k], DIGITS);
    }
    hl_text_add(&text, "\n");
  }
  st = text.failed ? hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %d lights", path, n)
                   : hl_file_write(ctx, path, text.bytes, text.n);
  free(text.bytes);
  return st;
}
