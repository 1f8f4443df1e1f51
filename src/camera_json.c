/* CAMERA.json: read and checked, every refusal naming the file and the member; and written. */
#include "camera_json.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/export.h"
#include "halflight/lens_names.h"
#include "json_write.h"
#include "psd.h"

#define RMS_MAX_PX 1e6
enum { OBSERVATIONS_MAX = 1 << 30 };

static hl_status read_model(hl_json_source source, const json_t *root, hl_camera *camera)
{
  const char *name = NULL;
  const hl_status st = hl_json_string(source, root, "model", &name);
  if (st != HL_OK)
    return st;
  char known[128] = "";
  for (int i = 0; hl_lens_name(i); i++) {
    if (strcmp(name, hl_lens_name(i)) == 0) {
      camera->model = (hl_lens_model)i;
      camera->n_distortion = hl_lens_coefficients(i);
      return HL_OK;
    }
    if (i > 0)
      strncat(known, ", ", sizeof known - strlen(known) - 1);
    strncat(known, hl_lens_name(i), sizeof known - strlen(known) - 1);
  }
  return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: model = '%.40s' is none of: %s", source.path, name,
                 known);
}

static hl_status read_pinhole(hl_json_source source, const json_t *root, hl_camera *c)
{
  hl_status st = hl_json_int(source, root, "width", 2, 65536, &c->width);
  if (st == HL_OK)
    st = hl_json_int(source, root, "height", 2, 65536, &c->height);
  if (st == HL_OK)
    st = hl_json_number(source, root, "fx", c->width / 1000.0, 1e7, &c->fx);
  if (st == HL_OK)
    st = hl_json_number(source, root, "fy", c->width / 1000.0, 1e7, &c->fy);
  if (st == HL_OK)
    st = hl_json_number(source, root, "cx", -c->width, 2.0 * c->width, &c->cx);
  if (st == HL_OK)
    st = hl_json_number(source, root, "cy", -c->height, 2.0 * c->height, &c->cy);
  if (st == HL_OK)
    st = hl_json_numbers(source, root, "distortion", c->n_distortion, c->distortion);
  return st;
}

static hl_status no_covariance(hl_ctx *ctx, int n)
{
  return hl_fail(ctx, HL_ERR_FORMAT,
                 "covariance is no covariance; a symmetric %d x %d matrix without negative "
                 "eigenvalues is needed",
                 n, n);
}

static hl_status read_optional(hl_json_source source, const json_t *root, hl_camera *c)
{
  hl_status st = HL_OK;
  if (hl_json_has(root, "rms_px"))
    st = hl_json_number(source, root, "rms_px", 0, RMS_MAX_PX, &c->rms_px);
  if (st == HL_OK && hl_json_has(root, "observations"))
    st = hl_json_int(source, root, "observations", 0, OBSERVATIONS_MAX, &c->observations);
  if (st != HL_OK || !hl_json_has(root, "covariance"))
    return st;
  const int n = 4 + c->n_distortion;
  st = hl_json_matrix(source, root, "covariance", n, n, c->covariance);
  if (st != HL_OK)
    return st;
  if (!hl_psd_check(c->covariance, n)) {
    hl_ctx inner = {0};
    return hl_json_blame(source, no_covariance(&inner, n), inner.msg);
  }
  c->has_covariance = true;
  return HL_OK;
}

hl_status hl_camera_json_members(hl_json_source source, const json_t *root, hl_camera *out)
{
  hl_camera camera = {0};
  hl_status st = read_model(source, root, &camera);
  if (st == HL_OK)
    st = read_pinhole(source, root, &camera);
  if (st == HL_OK)
    st = read_optional(source, root, &camera);
  if (st != HL_OK)
    return st;
  hl_ctx inner = {0};
  st = hl_camera_check(&inner, &camera);
  if (st != HL_OK)
    return hl_json_blame(source, st, inner.msg);
  *out = camera;
  return HL_OK;
}

/* ---- written ---- */

static json_t *rows_of(const double *matrix, int n)
{
  json_t *rows = json_array();
  for (int i = 0; i < n; i++)
    if (json_array_append_new(rows, hl_json_reals(matrix + i * n, n)) != 0) {
      json_decref(rows);
      return NULL;
    }
  return rows;
}

json_t *hl_camera_json_document(const hl_camera *c)
{
  json_t *root =
      json_pack("{s:s,s:i,s:s,s:i,s:i,s:f,s:f,s:f,s:f,s:o}", "format", HL_CAMERA_JSON_FORMAT,
                "version", HL_CAMERA_JSON_VERSION, "model", hl_lens_name((int)c->model), "width",
                c->width, "height", c->height, "fx", c->fx, "fy", c->fy, "cx", c->cx, "cy", c->cy,
                "distortion", hl_json_reals(c->distortion, c->n_distortion));
  const bool good =
      root &&
      (!c->has_covariance ||
       hl_json_set(root, "covariance", rows_of(c->covariance, hl_camera_intrinsics_count(c)))) &&
      (!(c->rms_px > 0) || hl_json_set(root, "rms_px", hl_json_real(c->rms_px))) &&
      (c->observations <= 0 || hl_json_set(root, "observations", json_integer(c->observations)));
  if (good)
    return root;
  json_decref(root);
  return NULL;
}

/* What is written can be read. */
static hl_status check(hl_ctx *ctx, const hl_camera *c)
{
  const hl_status st = hl_camera_check(ctx, c);
  if (st != HL_OK)
    return st;
  const int n = hl_camera_intrinsics_count(c);
  if (c->has_covariance && !hl_psd_check(c->covariance, n))
    return no_covariance(ctx, n);
  if (!(c->rms_px >= 0 && c->rms_px <= RMS_MAX_PX))
    return hl_fail(ctx, HL_ERR_FORMAT, "rms_px = %.6g is outside [0, %g]", c->rms_px, RMS_MAX_PX);
  if (c->observations < 0 || c->observations > OBSERVATIONS_MAX)
    return hl_fail(ctx, HL_ERR_FORMAT, "observations = %d is outside [0, %d]", c->observations,
                   OBSERVATIONS_MAX);
  return HL_OK;
}

hl_status hl_camera_json(hl_ctx *ctx, const hl_camera *camera, char **out)
{
  const hl_status st = check(ctx, camera);
  return st == HL_OK ? hl_json_text(ctx, hl_camera_json_document(camera), out) : st;
}

hl_status hl_camera_write(hl_ctx *ctx, const char *path, const hl_camera *camera)
{
  char *text = NULL;
  hl_status st = hl_camera_json(ctx, camera, &text);
  if (st == HL_OK)
    st = hl_file_write(ctx, path, text, strlen(text));
  free(text);
  return st;
}
