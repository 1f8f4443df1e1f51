/* The lights of a rig handed to the fit of its shape. What they are known to is the median of what each
 * states, one coordinate: no shape can be seen more closely. */
#include <math.h>
#include <stdlib.h>

#include "halflight/lights.h"

typedef struct rig {
  double *x, *sigma, *off; /* shape (n,3), (n), (n) */
  bool *is_off;
  int n;
} rig;

static int by_value(const void *a, const void *b)
{
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static void take(const hl_lights *lights, bool positions, rig *r)
{
  for (int i = 0; i < lights->n; i++) {
    const hl_rig_light *l = &lights->light[i];
    if (!l->found || (positions && !l->near))
      continue;
    double variance = 0;
    for (int k = 0; k < 3; k++) {
      r->x[3 * r->n + k] = positions ? l->position_m[k] : l->direction[k];
      variance += positions ? l->position_covariance_m2[k][k] / 3
                  : k < 2   ? l->covariance_rad2[k][k] / 2
                            : 0;
    }
    r->sigma[r->n++] = sqrt(fmax(variance, 0));
  }
  qsort(r->sigma, (size_t)r->n, sizeof *r->sigma, by_value);
}

static void give(const rig *r, bool positions, hl_lights *lights)
{
  for (int i = 0, k = 0; i < lights->n; i++) {
    hl_rig_light *l = &lights->light[i];
    const bool taken = l->found && (!positions || l->near);
    l->dome_off = taken ? r->off[k] : 0;
    l->off_dome = taken && r->is_off[k];
    k += taken;
  }
}

hl_status hl_lights_find_dome(hl_ctx *ctx, hl_lights *lights)
{
  const size_t n = lights->n > 0 ? (size_t)lights->n : 1;
  rig r = {.x = calloc(3 * n, sizeof *r.x),
           .sigma = calloc(n, sizeof *r.sigma),
           .off = calloc(n, sizeof *r.off),
           .is_off = calloc(n, sizeof *r.is_off)};
  int found = 0, near = 0;
  for (int i = 0; i < lights->n; i++) {
    found += lights->light[i].found;
    near += lights->light[i].found && lights->light[i].near;
  }
  const bool positions = near >= HL_DOME_LIGHTS_MIN && 2 * near >= found;
  hl_status st;
  if (!r.x || !r.sigma || !r.off || !r.is_off) {
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d lights", lights->n);
  } else {
    take(lights, positions, &r);
    st = hl_dome_fit_to(ctx, r.x, r.n, positions, r.sigma[r.n / 2 < r.n ? r.n / 2 : 0],
                        &lights->dome, r.off, r.is_off);
    if (st == HL_OK)
      give(&r, positions, lights);
  }
  free(r.x);
  free(r.sigma);
  free(r.off);
  free(r.is_off);
  return st;
}
