/* POSE.json: read, checked, written. */
#include <stdlib.h>
#include <string.h>

#include "camera_json.h"
#include "halflight/drift.h"
#include "halflight/export.h"
#include "json_notes.h"
#include "json_write.h"
#include "psd.h"

static const char *const format_name = "halflight-board-pose";
enum { FORMAT_VERSION = 1 };

#define FARTHEST_M 1e6

static hl_status read_target(hl_json_source source, const json_t *root, hl_target *out)
{
  const char *spec = NULL;
  hl_ctx inner = {0};
  hl_status st = hl_json_string(source, root, "target", &spec);
  if (st != HL_OK)
    return st;
  st = hl_target_parse(&inner, spec, out);
  return st == HL_OK ? st : hl_json_blame(source, HL_ERR_FORMAT, inner.msg);
}

static hl_status check_pose(hl_json_source source, const hl_board_pose *pose)
{
  double last[3], first[3], at[3];
  hl_target_corner(&pose->target, 0, first);
  hl_target_corner(&pose->target, hl_target_corners(&pose->target) - 1, last);
  const double middle[3] = {(first[0] + last[0]) / 2, (first[1] + last[1]) / 2, 0};
  hl_pose_apply(&pose->cam_from_board, middle, at, NULL, NULL);
  if (at[2] > 0 && at[2] < FARTHEST_M)
    return HL_OK;
  return hl_fail(source.ctx, HL_ERR_FORMAT,
                 "%s: cam_from_board puts the board's middle at z = %.6g m; it must be in front of "
                 "the camera",
                 source.path, at[2]);
}

static hl_status read_covariance(hl_json_source source, const json_t *root, hl_board_pose *pose)
{
  if (!hl_json_has(root, "covariance"))
    return HL_OK;
  hl_status st =
      hl_json_matrix(source, root, "covariance", HL_POSE_SIZE, HL_POSE_SIZE, pose->covariance[0]);
  if (st == HL_OK && !hl_psd_check(pose->covariance[0], HL_POSE_SIZE))
    st = hl_fail(source.ctx, HL_ERR_FORMAT,
                 "%s: covariance is no covariance; a symmetric 6 x 6 matrix without negative "
                 "eigenvalues is needed",
                 source.path);
  pose->has_covariance = st == HL_OK;
  if (st != HL_OK || !hl_json_has(root, "by_intrinsics"))
    return st;
  if (pose->camera.width == 0)
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: by_intrinsics without the camera it belongs to; 'camera' is needed",
                   source.path);
  const int n = hl_camera_intrinsics_count(&pose->camera);
  double packed[HL_POSE_SIZE * HL_INTRINSICS_MAX];
  st = hl_json_matrix(source, root, "by_intrinsics", HL_POSE_SIZE, n, packed);
  for (int i = 0; st == HL_OK && i < HL_POSE_SIZE; i++)
    memcpy(pose->by_intrinsics[i], packed + i * n, (size_t)n * sizeof *packed);
  return st;
}

static hl_status read_members(hl_json_source source, const json_t *root, hl_board_pose *pose)
{
  double numbers[HL_POSE_SIZE];
  hl_status st = read_target(source, root, &pose->target);
  if (st == HL_OK)
    st = hl_json_numbers(source, root, "cam_from_board", HL_POSE_SIZE, numbers);
  if (st != HL_OK)
    return st;
  memcpy(pose->cam_from_board.rotation_rad, numbers, 3 * sizeof *numbers);
  memcpy(pose->cam_from_board.translation_m, numbers + 3, 3 * sizeof *numbers);
  st = check_pose(source, pose);
  if (st == HL_OK && hl_json_has(root, "camera"))
    st = hl_camera_json_members(source, json_object_get(root, "camera"), &pose->camera);
  if (st == HL_OK)
    st = read_covariance(source, root, pose);
  if (st == HL_OK && hl_json_has(root, "corners"))
    st = hl_json_int(source, root, "corners", 0, 1 << 30, &pose->corners);
  if (st == HL_OK && hl_json_has(root, "rms_px"))
    st = hl_json_number(source, root, "rms_px", 0, 1e6, &pose->rms_px);
  return st;
}

hl_status hl_board_pose_read(hl_ctx *ctx, const char *path, hl_board_pose *out)
{
  const hl_json_source source = {ctx, path};
  json_t *root = NULL;
  hl_status st = hl_json_open(source, format_name, FORMAT_VERSION, &root);
  if (st != HL_OK)
    return st;
  hl_board_pose pose = {.has_covariance = false};
  st = read_members(source, root, &pose);
  json_decref(root);
  if (st == HL_OK)
    *out = pose;
  return st;
}

static bool set_spread(json_t *root, const hl_board_pose *p)
{
  const int n = hl_camera_intrinsics_count(&p->camera);
  return hl_json_set(root, "covariance",
                     hl_json_rows(p->covariance[0], HL_POSE_SIZE, HL_POSE_SIZE, HL_POSE_SIZE)) &&
         (p->camera.width == 0 ||
          hl_json_set(root, "by_intrinsics",
                      hl_json_rows(p->by_intrinsics[0], HL_POSE_SIZE, n, HL_INTRINSICS_MAX)));
}

hl_status hl_board_pose_json(hl_ctx *ctx, const hl_board_pose *pose, char **out)
{
  char spec[HL_TARGET_SPEC_MAX];
  double numbers[HL_POSE_SIZE];
  memcpy(numbers, pose->cam_from_board.rotation_rad, 3 * sizeof *numbers);
  memcpy(numbers + 3, pose->cam_from_board.translation_m, 3 * sizeof *numbers);
  json_t *root = json_pack("{s:s,s:i,s:s,s:o}", "format", format_name, "version", FORMAT_VERSION,
                           "target", hl_target_spec(&pose->target, spec), "cam_from_board",
                           hl_json_reals(numbers, HL_POSE_SIZE));
  const bool good =
      root && (!pose->has_covariance || set_spread(root, pose)) &&
      (pose->corners <= 0 || hl_json_set(root, "corners", json_integer(pose->corners))) &&
      (!(pose->rms_px > 0) || hl_json_set(root, "rms_px", hl_json_real(pose->rms_px))) &&
      (pose->camera.width == 0 ||
       hl_json_set(root, "camera", hl_camera_json_document(&pose->camera)));
  if (!good) {
    json_decref(root);
    root = NULL;
  }
  return hl_json_text(ctx, root, out);
}

hl_status hl_board_pose_write(hl_ctx *ctx, const char *path, const hl_board_pose *pose)
{
  char *text = NULL;
  hl_status st = hl_board_pose_json(ctx, pose, &text);
  if (st == HL_OK)
    st = hl_file_write(ctx, path, text, strlen(text));
  free(text);
  return st;
}
