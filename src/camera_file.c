/* CAMERA.json: read and checked, every refusal naming the file and the member. */
#include <math.h>
#include <string.h>

#include "halflight/camera.h"
#include "halflight/lens_names.h"
#include "json_read.h"
#include "psd.h"

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

static hl_status read_optional(hl_json_source source, const json_t *root, hl_camera *c)
{
  hl_status st = HL_OK;
  if (hl_json_has(root, "rms_px"))
    st = hl_json_number(source, root, "rms_px", 0, 1e6, &c->rms_px);
  if (st == HL_OK && hl_json_has(root, "observations"))
    st = hl_json_int(source, root, "observations", 0, 1 << 30, &c->observations);
  if (st != HL_OK || !hl_json_has(root, "covariance"))
    return st;
  const int n = 4 + c->n_distortion;
  st = hl_json_matrix(source, root, "covariance", n, n, c->covariance);
  if (st != HL_OK)
    return st;
  if (!hl_psd_check(c->covariance, n))
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: covariance is no covariance; a symmetric %d x %d matrix without negative "
                   "eigenvalues is needed",
                   source.path, n, n);
  c->has_covariance = true;
  return HL_OK;
}

static hl_status read_members(hl_json_source source, const json_t *root, hl_camera *camera)
{
  hl_status st = read_model(source, root, camera);
  if (st == HL_OK)
    st = read_pinhole(source, root, camera);
  if (st == HL_OK)
    st = read_optional(source, root, camera);
  if (st != HL_OK)
    return st;
  hl_ctx inner = {0};
  st = hl_camera_check(&inner, camera);
  return st == HL_OK ? st : hl_json_blame(source, st, inner.msg);
}

hl_status hl_camera_read(hl_ctx *ctx, const char *path, hl_camera *out)
{
  const hl_json_source source = {ctx, path};
  json_t *root = NULL;
  hl_status st = hl_json_open(source, "halflight-camera", 1, &root);
  if (st != HL_OK)
    return st;
  hl_camera camera = {0};
  st = read_members(source, root, &camera);
  json_decref(root);
  if (st == HL_OK)
    *out = camera;
  return st;
}
