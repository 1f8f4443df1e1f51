/*
 * The sight of one ball.
 *
 * A light taken as distant has one direction s for all pixels, where a near one has s(p): the fit settles
 * for that of the pixels that say most. Of a glossy ball that is the highlight, which sits at c + R h
 * with h the bisector of light and view, and there s(p) is what the mirror law says. Of a matte ball it
 * is no single point: fall-off across the ball passes for shading. Hence the half radius of doubt.
 */
#include "sight.h"

#include <math.h>
#include <string.h>

#include "halflight/vec3.h"
#include "spd.h"

static const double unit_tolerance = 1e-6;
static const double distant_doubt = 0.5; /* radii, one deviation, each way */

hl_status hl_sight_of_light(hl_ctx *ctx, const hl_light *light, const hl_sphere *sphere,
                            hl_sight *out)
{
  if (!light->found)
    return hl_fail(ctx, HL_ERR_ARG, "no light was found; a light with a direction is needed");
  hl_ctx inner = {0};
  if (hl_sphere_check(&inner, sphere) != HL_OK)
    return hl_fail(ctx, HL_ERR_ARG, "%s", inner.msg);
  hl_sight g = {.doubted = !light->trusted};
  memcpy(g.direction, light->direction, sizeof g.direction);
  memcpy(g.tangent_basis, light->tangent_basis, sizeof g.tangent_basis);
  memcpy(g.origin_m, sphere->center_m, sizeof g.origin_m);
  memcpy(g.own_rad2, light->covariance_rad2, sizeof g.own_rad2);
  if (sphere->has_covariance)
    memcpy(g.origin_covariance_m2, sphere->covariance_m2, sizeof g.origin_covariance_m2);
  if (sphere->has_covariance && light->part_stated[HL_PART_POSE]) {
    memcpy(g.by_origin, light->by_center, sizeof g.by_origin);
    for (int k = 0; k < 2; k++)
      for (int l = 0; l < 2; l++)
        g.own_rad2[k][l] -= light->part_rad2[HL_PART_POSE][k][l];
  }
  if (!light->near) {
    double view[3], h[3];
    hl_unit(sphere->center_m, view);
    hl_add_scaled(g.direction, -1, view, h);
    hl_unit(h, h);
    hl_add_scaled(g.origin_m, sphere->radius_m, h, g.origin_m);
    for (int k = 0; k < 3; k++)
      g.origin_covariance_m2[k][k] += pow(distant_doubt * sphere->radius_m, 2);
  }
  *out = g;
  return HL_OK;
}

static bool is_covariance(const double *m, int n)
{
  double trace = 0;
  for (int i = 0; i < n; i++)
    trace += m[i * n + i];
  double lifted[9];
  hl_spd factor;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      if (!(fabs(m[i * n + j] - m[j * n + i]) <= 1e-6 * trace) || !(m[i * n + i] >= 0))
        return false;
      lifted[i * n + j] = m[i * n + j] + (i == j ? 1e-6 * trace : 0);
    }
  return trace == 0 || hl_spd_factor(lifted, n, 0, &factor, NULL);
}

hl_status hl_sights_check(hl_ctx *ctx, const hl_sight *sights, int n)
{
  if (n < 2 || n > HL_SIGHTS_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "%d sights; 2 to %d are needed", n, HL_SIGHTS_MAX);
  for (int i = 0; i < n; i++) {
    const hl_sight *g = &sights[i];
    const double(*t)[3] = g->tangent_basis;
    if (!isfinite(hl_norm(g->origin_m)))
      return hl_fail(ctx, HL_ERR_ARG, "sight %d: origin_m is not finite; metres are needed", i + 1);
    if (!(fabs(hl_norm(g->direction) - 1) <= unit_tolerance))
      return hl_fail(ctx, HL_ERR_ARG, "sight %d: direction has length %.9g; 1 is needed", i + 1,
                     hl_norm(g->direction));
    for (int k = 0; k < 2; k++)
      if (!(fabs(hl_norm(t[k]) - 1) <= unit_tolerance) ||
          !(fabs(hl_dot(t[k], g->direction)) <= unit_tolerance) ||
          !(fabs(hl_dot(t[0], t[1])) <= unit_tolerance) || !isfinite(hl_norm(g->by_origin[k])))
        return hl_fail(ctx, HL_ERR_ARG,
                       "sight %d: tangent_basis[%d] or by_origin[%d] is none; unit vectors across "
                       "direction and each other, and finite rates, are needed",
                       i + 1, k, k);
    if (!is_covariance(g->own_rad2[0], 2) || !is_covariance(g->origin_covariance_m2[0], 3))
      return hl_fail(ctx, HL_ERR_ARG,
                     "sight %d: own_rad2 or origin_covariance_m2 is no covariance; symmetric "
                     "matrices without negative eigenvalues are needed",
                     i + 1);
  }
  return HL_OK;
}
