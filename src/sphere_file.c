/* SPHERE.json: read, checked, written. */
#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/export.h"
#include "halflight/sphere.h"
#include "halflight/vec3.h"
#include "json_read.h"
#include "json_write.h"
#include "psd.h"
#include "sphere_json.h"

#define FARTHEST_M 1e6
#define ROUNDING 1e-6

/* The covariance with the camera held is part of the whole one; the rest is the camera's. */
static hl_status check_camera_share(hl_ctx *ctx, const hl_sphere *s)
{
  double rest[3][3];
  if (!s->has_covariance)
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "covariance is missing beside by_intrinsics; the whole covariance is needed");
  if (!(s->n_intrinsics >= 4 && s->n_intrinsics <= HL_INTRINSICS_MAX))
    return hl_fail(ctx, HL_ERR_FORMAT, "by_intrinsics has %d columns; 4 to %d are needed",
                   s->n_intrinsics, HL_INTRINSICS_MAX);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < s->n_intrinsics; j++)
      if (!isfinite(s->by_intrinsics[i][j]))
        return hl_fail(ctx, HL_ERR_FORMAT, "by_intrinsics[%d][%d] = %g; a finite number is needed",
                       i, j, s->by_intrinsics[i][j]);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      rest[i][j] =
          (i == j ? 1 + ROUNDING : 1) * s->covariance_m2[i][j] - s->held_covariance_m2[i][j];
  if (!hl_psd_check(s->held_covariance_m2[0], 3) || !hl_psd_check(rest[0], 3))
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "covariance_camera_held is no part of covariance; a symmetric 3 x 3 matrix that "
                   "leaves no negative eigenvalues of the difference is needed");
  return HL_OK;
}

hl_status hl_sphere_check(hl_ctx *ctx, const hl_sphere *sphere)
{
  const double *c = sphere->center_m;
  for (int i = 0; i < 3; i++)
    if (!(fabs(c[i]) <= FARTHEST_M))
      return hl_fail(ctx, HL_ERR_FORMAT, "center_m[%d] = %g m is outside [%g, %g] m", i, c[i],
                     -FARTHEST_M, FARTHEST_M);
  if (!(sphere->radius_m > 0 && sphere->radius_m <= FARTHEST_M))
    return hl_fail(ctx, HL_ERR_FORMAT, "radius_m = %g m is outside (0, %g] m", sphere->radius_m,
                   FARTHEST_M);
  if (!(c[2] > sphere->radius_m))
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "center_m = (%.6g, %.6g, %.6g): the ball is not wholly in front of the camera; "
                   "z > radius_m = %.6g is needed",
                   c[0], c[1], c[2], sphere->radius_m);
  if (sphere->has_covariance && !hl_psd_check(sphere->covariance_m2[0], 3))
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "covariance is no covariance; a symmetric 3 x 3 matrix without negative "
                   "eigenvalues is needed");
  return sphere->n_intrinsics == 0 ? HL_OK : check_camera_share(ctx, sphere);
}

/* The number of columns is the number of the camera's intrinsics. */
static hl_status read_camera_share(hl_json_source source, const json_t *root, hl_sphere *s)
{
  const json_t *rows = json_object_get(root, "by_intrinsics");
  const size_t columns = json_array_size(json_array_get(rows, 0));
  const int n = columns < 4 || columns > HL_INTRINSICS_MAX ? HL_INTRINSICS_MAX : (int)columns;
  double by[3 * HL_INTRINSICS_MAX];
  hl_status st =
      hl_json_matrix(source, root, "covariance_camera_held", 3, 3, s->held_covariance_m2[0]);
  if (st == HL_OK)
    st = hl_json_matrix(source, root, "by_intrinsics", 3, n, by);
  if (st != HL_OK)
    return st;
  s->n_intrinsics = n;
  for (int i = 0; i < 3; i++)
    memcpy(s->by_intrinsics[i], by + i * n, (size_t)n * sizeof *by);
  return HL_OK;
}

hl_status hl_sphere_json_members(hl_json_source source, const json_t *root, hl_sphere *s)
{
  hl_status st = hl_json_numbers(source, root, "center_m", 3, s->center_m);
  if (st == HL_OK)
    st = hl_json_number(source, root, "radius_m", 1e-9, FARTHEST_M, &s->radius_m);
  if (st != HL_OK)
    return st;
  if (hl_json_has(root, "covariance")) {
    st = hl_json_matrix(source, root, "covariance", 3, 3, s->covariance_m2[0]);
    if (st != HL_OK)
      return st;
    s->has_covariance = true;
  }
  if (hl_json_has(root, "covariance_camera_held") || hl_json_has(root, "by_intrinsics"))
    st = read_camera_share(source, root, s);
  if (st != HL_OK)
    return st;
  hl_ctx inner = {0};
  st = hl_sphere_check(&inner, s);
  return st == HL_OK ? st : hl_json_blame(source, st, inner.msg);
}

hl_status hl_sphere_read(hl_ctx *ctx, const char *path, hl_sphere *out)
{
  const hl_json_source source = {ctx, path};
  json_t *root = NULL;
  hl_status st = hl_json_open(source, "halflight-sphere", 1, &root);
  if (st != HL_OK)
    return st;
  hl_sphere sphere = {0};
  st = hl_sphere_json_members(source, root, &sphere);
  json_decref(root);
  if (st == HL_OK)
    *out = sphere;
  return st;
}

/* Three rows of n, each `stride` after the one before. */
static json_t *rows_of(const double *matrix, int n, int stride)
{
  json_t *rows = json_array();
  for (int i = 0; i < 3; i++)
    if (json_array_append_new(rows, hl_json_reals(matrix + (size_t)i * (size_t)stride, n)) != 0) {
      json_decref(rows);
      return NULL;
    }
  return rows;
}

static json_t *fit_of(const hl_sphere_fit *fit)
{
  return json_pack("{s:o,s:o,s:o,s:o,s:i}", "center_px", hl_json_reals(fit->center_px, 2),
                   "radius_px", hl_json_real(fit->radius_px), "rms_px", hl_json_real(fit->rms_px),
                   "arc", hl_json_real(fit->arc), "points", fit->n_points);
}

json_t *hl_sphere_json_document(const hl_sphere *s, const hl_sphere_fit *fit)
{
  json_t *root = json_pack("{s:s,s:i,s:o,s:f}", "format", "halflight-sphere", "version", 1,
                           "center_m", hl_json_reals(s->center_m, 3), "radius_m", s->radius_m);
  const bool good =
      root &&
      (!s->has_covariance || hl_json_set(root, "covariance", rows_of(s->covariance_m2[0], 3, 3))) &&
      (s->n_intrinsics == 0 ||
       (hl_json_set(root, "covariance_camera_held", rows_of(s->held_covariance_m2[0], 3, 3)) &&
        hl_json_set(root, "by_intrinsics",
                    rows_of(s->by_intrinsics[0], s->n_intrinsics, HL_INTRINSICS_MAX)))) &&
      (!fit || hl_json_set(root, "fit", fit_of(fit)));
  if (good)
    return root;
  json_decref(root);
  return NULL;
}

hl_status hl_sphere_json(hl_ctx *ctx, const hl_sphere *sphere, const hl_sphere_fit *fit, char **out)
{
  const hl_status st = hl_sphere_check(ctx, sphere);
  return st == HL_OK ? hl_json_text(ctx, hl_sphere_json_document(sphere, fit), out) : st;
}

hl_status hl_sphere_write(hl_ctx *ctx, const char *path, const hl_sphere *sphere,
                          const hl_sphere_fit *fit)
{
  char *text = NULL;
  hl_status st = hl_sphere_json(ctx, sphere, fit, &text);
  if (st == HL_OK)
    st = hl_file_write(ctx, path, text, strlen(text));
  free(text);
  return st;
}
