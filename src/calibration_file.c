/*
 * A camera with its views out of a CAMERA.json; a camera alone out of any other camera file.
 *
 * Without `views` there is nothing beyond the camera. With them every member that the joint
 * covariance is made of must be there; what is only for people may be missing.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera_file.h"
#include "halflight/calibration.h"
#include "halflight/notes.h"
#include "json_read.h"
#include "psd.h"

static const double most_px = 1e6, farthest_m = 1e6;

static hl_status refuse(hl_json_source source, const char *member, const char *needed)
{
  return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s: %s is needed", source.path, member, needed);
}

/* ---- notes ---- */

/* Texts, or {"what", "why"}; what does not fit is cut. */
static hl_status read_notes(hl_json_source source, const json_t *root, const char *member,
                            hl_notes *out)
{
  const json_t *list = json_object_get(root, member);
  if (!hl_json_has(root, member))
    return HL_OK;
  if (!json_is_array(list))
    return refuse(source, member, "a list");
  for (size_t i = 0; i < json_array_size(list); i++) {
    const json_t *line = json_array_get(list, i);
    const char *what = json_string_value(json_object_get(line, "what"));
    const char *why = json_string_value(json_object_get(line, "why"));
    const char *text = json_string_value(line);
    if (!text && !(what && why))
      return refuse(source, member, "a text, or `what' and `why', in every line");
    hl_notes_add(out, text ? "" : what, "%s", text ? text : why);
  }
  return HL_OK;
}

/* ---- views ---- */

static hl_status read_pose(hl_json_source source, const json_t *object, hl_pose *out)
{
  double numbers[HL_POSE_SIZE];
  const hl_status st = hl_json_numbers(source, object, "cam_from_board", HL_POSE_SIZE, numbers);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < HL_POSE_SIZE; i++)
    if (!(fabs(numbers[i]) <= farthest_m))
      return refuse(source, "cam_from_board", "a rotation [rad] and a translation [m]");
  memcpy(out->rotation_rad, numbers, sizeof out->rotation_rad);
  memcpy(out->translation_m, numbers + 3, sizeof out->translation_m);
  return HL_OK;
}

static hl_status read_uncertainty(hl_json_source source, const json_t *object, int intrinsics,
                                  hl_view_pose *v)
{
  double by[HL_POSE_SIZE * HL_INTRINSICS_MAX];
  hl_status st = hl_json_matrix(source, object, "own_covariance", HL_POSE_SIZE, HL_POSE_SIZE,
                                v->own_covariance[0]);
  if (st == HL_OK && !hl_psd_check(v->own_covariance[0], HL_POSE_SIZE))
    st = refuse(source, "own_covariance", "a symmetric 6 x 6 matrix without negative eigenvalues");
  if (st == HL_OK)
    st = hl_json_matrix(source, object, "by_intrinsics", HL_POSE_SIZE, intrinsics, by);
  for (int i = 0; i < HL_POSE_SIZE && st == HL_OK; i++)
    memcpy(v->by_intrinsics[i], by + (ptrdiff_t)i * intrinsics, (size_t)intrinsics * sizeof by[0]);
  return st;
}

static hl_status read_view(hl_json_source source, const json_t *object, int intrinsics,
                           hl_view_pose *v)
{
  const char *file = NULL, *why = "";
  const json_t *used = json_object_get(object, "used");
  hl_status st = hl_json_string(source, object, "file", &file);
  if (st == HL_OK && !json_is_boolean(used))
    st = refuse(source, "used", "true or false");
  if (st == HL_OK && hl_json_has(object, "why"))
    st = hl_json_string(source, object, "why", &why);
  if (st == HL_OK)
    st = hl_json_int(source, object, "corners", 0, 1 << 20, &v->corners);
  if (st == HL_OK)
    st = hl_json_int(source, object, "seen", 0, 1 << 20, &v->seen);
  if (st == HL_OK)
    st = hl_json_number(source, object, "rms_px", 0, most_px, &v->rms_px);
  if (st != HL_OK)
    return st;
  v->used = json_is_true(used);
  snprintf(v->name, sizeof v->name, "%.*s", HL_VIEW_NAME_MAX - 1, file);
  snprintf(v->why, sizeof v->why, "%.*s", HL_REASON_MAX - 1, why);
  if (v->used || hl_json_has(object, "cam_from_board"))
    st = read_pose(source, object, &v->cam_from_board);
  if (st == HL_OK && v->used)
    st = read_uncertainty(source, object, intrinsics, v);
  return st;
}

static hl_status read_views(hl_json_source source, const json_t *root, hl_calibration *c)
{
  const json_t *list = json_object_get(root, "views");
  const size_t n = json_array_size(list);
  if (!json_is_array(list) || n == 0 || n > HL_VIEWS_MAX)
    return refuse(source, "views", "a list of views");
  c->view = calloc(n, sizeof *c->view);
  if (!c->view)
    return hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for %zu views", source.path, n);
  c->n_views = (int)n;
  const int intrinsics = hl_camera_intrinsics_count(&c->camera);
  for (int i = 0; i < c->n_views; i++) {
    hl_ctx inner = {0};
    const hl_json_source part = {&inner, "views"};
    const hl_status st = read_view(part, json_array_get(list, (size_t)i), intrinsics, &c->view[i]);
    if (st != HL_OK)
      return hl_fail(source.ctx, st, "%s: views[%d]%s", source.path, i,
                     inner.msg + strlen(part.path));
  }
  return HL_OK;
}

/* ---- the projection's uncertainty ---- */

static hl_status read_projections(hl_json_source source, const json_t *root, hl_calibration *c)
{
  const json_t *list = json_object_get(root, "projection_uncertainty");
  if (!hl_json_has(root, "projection_uncertainty"))
    return HL_OK;
  if (!json_is_array(list) || json_array_size(list) > HL_PROJECTIONS_MAX)
    return refuse(source, "projection_uncertainty", "a list of at most 64");
  for (size_t i = 0; i < json_array_size(list); i++) {
    const json_t *object = json_array_get(list, i);
    hl_projection p = {.distance_m = HUGE_VAL};
    hl_status st = hl_json_numbers(source, object, "pixel", 2, p.pixel);
    if (st == HL_OK && hl_json_has(object, "distance_m"))
      st = hl_json_number(source, object, "distance_m", 0, farthest_m, &p.distance_m);
    if (st == HL_OK)
      st = hl_json_matrix(source, object, "covariance", 2, 2, p.covariance_px2[0]);
    if (st != HL_OK)
      return st;
    c->projection[c->n_projections++] = p;
  }
  return HL_OK;
}

/* ---- the document ---- */

static hl_status read_figures(hl_json_source source, const json_t *root, hl_calibration *c)
{
  const struct {
    const char *member;
    double max;
    double *out;
  } figures[] = {
      {"noise_px", most_px, &c->noise_px}, {"coverage", 1, &c->coverage},
      {"tilt_deg", 180, &c->tilt_deg},     {"condition", 1e300, &c->condition},
      {"scatter", 1e300, &c->scatter},
  };
  for (size_t i = 0; i < sizeof figures / sizeof *figures; i++) {
    const hl_status st =
        hl_json_has(root, figures[i].member)
            ? hl_json_number(source, root, figures[i].member, 0, figures[i].max, figures[i].out)
            : HL_OK;
    if (st != HL_OK)
      return st;
  }
  hl_status st = HL_OK;
  if (hl_json_has(root, "corners_used"))
    st = hl_json_int(source, root, "corners_used", 0, 1 << 30, &c->corners_used);
  if (st == HL_OK && hl_json_has(root, "corners_left_out"))
    st = hl_json_int(source, root, "corners_left_out", 0, 1 << 30, &c->corners_left_out);
  return st;
}

static hl_status read_verdict(hl_json_source source, const json_t *root, hl_calibration *c)
{
  const char *status = NULL, *spec = NULL;
  hl_ctx inner = {0};
  hl_status st = hl_json_string(source, root, "status", &status);
  if (st == HL_OK)
    st = hl_json_string(source, root, "target", &spec);
  if (st != HL_OK)
    return st;
  c->trusted = strcmp(status, "ok") == 0;
  if (!c->trusted && strcmp(status, "untrusted") != 0)
    return refuse(source, "status", "'ok' or 'untrusted'");
  if (hl_target_parse(&inner, spec, &c->target) != HL_OK)
    return hl_json_blame(source, HL_ERR_FORMAT, inner.msg);
  st = read_notes(source, root, "reasons", &c->reasons);
  if (st == HL_OK)
    st = read_notes(source, root, "used", &c->used);
  if (st == HL_OK)
    st = read_notes(source, root, "left_out", &c->left_out);
  return st;
}

static hl_status read_members(hl_json_source source, const json_t *root, hl_calibration *c)
{
  hl_status st = read_verdict(source, root, c);
  if (st == HL_OK)
    st = read_figures(source, root, c);
  if (st == HL_OK)
    st = read_views(source, root, c);
  if (st == HL_OK)
    st = read_projections(source, root, c);
  return st;
}

hl_status hl_calibration_read(hl_ctx *ctx, const char *path, hl_calibration *out)
{
  hl_calibration c = {.trusted = true};
  json_t *root = NULL;
  hl_status st = hl_camera_file_read(ctx, path, &c.camera, &root);
  if (st == HL_OK && root && hl_json_has(root, "views"))
    st = read_members((hl_json_source){ctx, path}, root, &c);
  json_decref(root);
  if (st == HL_OK)
    *out = c;
  else
    hl_calibration_free(&c);
  return st;
}
