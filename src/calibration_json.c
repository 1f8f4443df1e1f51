/*
 * CAMERA.json of a calibration: the camera, then what is known about it.
 *
 * The views' own covariances and their dependence on the intrinsics together with the camera's
 * covariance are the joint covariance of all parameters, so that a later comparison needs nothing
 * else. A pose is its rotation vector [rad], then its translation [m]; where a view says nothing
 * about its pose, it is null. A direction's distance is null.
 */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "camera_json.h"
#include "halflight/calibration.h"
#include "halflight/export.h"
#include "json_notes.h"
#include "json_write.h"

static json_t *pose_numbers(const hl_pose *pose)
{
  const double *r = pose->rotation_rad, *t = pose->translation_m;
  const double numbers[HL_POSE_SIZE] = {r[0], r[1], r[2], t[0], t[1], t[2]};
  return t[2] > 0 ? hl_json_reals(numbers, HL_POSE_SIZE) : json_null();
}

static json_t *view_object(const hl_view_pose *view, int intrinsics)
{
  json_t *o = json_object();
  const bool good = o && hl_json_set(o, "file", json_string(view->name)) &&
                    hl_json_set(o, "used", json_boolean(view->used)) &&
                    hl_json_set(o, "why", json_string(view->why)) &&
                    hl_json_set(o, "corners", json_integer(view->corners)) &&
                    hl_json_set(o, "seen", json_integer(view->seen)) &&
                    hl_json_set(o, "rms_px", hl_json_real(view->rms_px)) &&
                    hl_json_set(o, "cam_from_board", pose_numbers(&view->cam_from_board)) &&
                    (!view->used || (hl_json_set(o, "own_covariance",
                                                 hl_json_rows(view->own_covariance[0], HL_POSE_SIZE,
                                                              HL_POSE_SIZE, HL_POSE_SIZE)) &&
                                     hl_json_set(o, "by_intrinsics",
                                                 hl_json_rows(view->by_intrinsics[0], HL_POSE_SIZE,
                                                              intrinsics, HL_INTRINSICS_MAX))));
  return hl_json_kept(o, good);
}

static json_t *view_list(const hl_calibration *c)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < c->n_views && good; i++)
    good = json_array_append_new(
               list, view_object(&c->view[i], hl_camera_intrinsics_count(&c->camera))) == 0;
  return hl_json_kept(list, good);
}

/* `sd_px` is the larger half axis of the one-sigma ellipse. */
static json_t *projection_object(const hl_projection *p)
{
  const double(*v)[2] = p->covariance_px2;
  const double mean = (v[0][0] + v[1][1]) / 2;
  const double apart = hypot((v[0][0] - v[1][1]) / 2, v[0][1]);
  json_t *o = json_object();
  const bool good = o && hl_json_set(o, "pixel", hl_json_reals(p->pixel, 2)) &&
                    hl_json_set(o, "distance_m", hl_json_real(p->distance_m)) &&
                    hl_json_set(o, "covariance", hl_json_rows(v[0], 2, 2, 2)) &&
                    hl_json_set(o, "sd_px", hl_json_real(sqrt(mean + apart)));
  return hl_json_kept(o, good);
}

static json_t *projection_list(const hl_calibration *c)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < c->n_projections && good; i++)
    good = json_array_append_new(list, projection_object(&c->projection[i])) == 0;
  return hl_json_kept(list, good);
}

static bool add_calibration(json_t *d, const hl_calibration *c)
{
  char spec[HL_TARGET_SPEC_MAX];
  return hl_json_set(d, "status", json_string(c->trusted ? "ok" : "untrusted")) &&
         hl_json_set(d, "reasons", hl_json_reasons(&c->reasons)) &&
         hl_json_set(d, "used", hl_json_notes(&c->used)) &&
         hl_json_set(d, "left_out", hl_json_notes(&c->left_out)) &&
         hl_json_set(d, "target", json_string(hl_target_spec(&c->target, spec))) &&
         hl_json_set(d, "noise_px", hl_json_real(c->noise_px)) &&
         hl_json_set(d, "coverage", hl_json_real(c->coverage)) &&
         hl_json_set(d, "tilt_deg", hl_json_real(c->tilt_deg)) &&
         hl_json_set(d, "condition", hl_json_real(c->condition)) &&
         hl_json_set(d, "scatter", hl_json_real(c->scatter)) &&
         hl_json_set(d, "corners_used", json_integer(c->corners_used)) &&
         hl_json_set(d, "corners_left_out", json_integer(c->corners_left_out)) &&
         hl_json_set(d, "views", view_list(c)) &&
         hl_json_set(d, "projection_uncertainty", projection_list(c));
}

hl_status hl_calibration_json(hl_ctx *ctx, const hl_calibration *calibration, char **out)
{
  const hl_status st = hl_camera_check(ctx, &calibration->camera);
  if (st != HL_OK)
    return st;
  json_t *d = hl_camera_json_document(&calibration->camera);
  const bool good = d && (calibration->n_views == 0 || add_calibration(d, calibration));
  return hl_json_text(ctx, hl_json_kept(d, good), out);
}

hl_status hl_calibration_write(hl_ctx *ctx, const char *path, const hl_calibration *calibration)
{
  char *text = NULL;
  hl_status st = hl_calibration_json(ctx, calibration, &text);
  if (st == HL_OK)
    st = hl_file_write(ctx, path, text, strlen(text));
  free(text);
  return st;
}
