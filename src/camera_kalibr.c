/*
 * Cameras in Kalibr's camchain YAML: a mapping cam0, cam1, ... of
 *
 *   camera_model       pinhole; omni, ds and eucm are other projections and refused
 *   intrinsics         fx fy cx cy
 *   distortion_model   radtan: k1 k2 p1 p2, our pinhole with k3 = 0
 *                      equidistant (equi): k1 k2 k3 k4, our fisheye
 *                      none
 *   distortion_coeffs
 *   resolution         width height
 *
 * Poses, overlaps, topics and what else a camera holds are not ours and left unread. Kalibr wants real
 * numbers spelt with a point and whole numbers without (kalibr_common/ConfigReader.py).
 *
 * Pixels: Kalibr takes its corners from cv::cornerSubPix and starts from a centre of ((w - 1)/2,
 * (h - 1)/2) (aslam_cameras, PinholeProjection), so (0,0) is the centre of the top-left pixel, as here.
 */
#include <math.h>
#include <string.h>

#include "camera_formats.h"

enum { PATH_MAX_CHARS = 512 };

static bool is_camera(const char *key)
{
  return strncmp(key, "cam", 3) == 0 && key[3] && key[3 + strspn(key + 3, "0123456789")] == '\0';
}

bool hl_camera_kalibr_is(const json_t *root)
{
  const char *key;
  json_t *value;
  json_object_foreach((json_t *)root, key, value)
  {
    if (is_camera(key))
      return true;
  }
  return false;
}

/* The chain's only camera, and what it is called. */
static hl_status find_camera(hl_json_source source, const json_t *root, const char **name,
                             const json_t **camera)
{
  const char *key;
  json_t *value;
  *name = NULL;
  json_object_foreach((json_t *)root, key, value)
  {
    if (!is_camera(key))
      continue;
    if (*name)
      return hl_fail(
          source.ctx, HL_ERR_FORMAT,
          "%s: several cameras, %.16s and %.16s; a camchain of one is needed, so copy the "
          "one that took the photo to its own file",
          source.path, *name, key);
    *name = key;
    *camera = value;
  }
  if (!json_is_object(*camera))
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %.16s is no mapping; a camera's is needed",
                   source.path, *name);
  return HL_OK;
}

static hl_status read_distortion(hl_json_source source, const json_t *camera, hl_camera *c)
{
  const char *model = NULL;
  const hl_status st = hl_json_string(source, camera, "distortion_model", &model);
  if (st != HL_OK)
    return st;
  const bool fisheye = strcmp(model, "equidistant") == 0 || strcmp(model, "equi") == 0;
  c->model = fisheye ? HL_LENS_FISHEYE : HL_LENS_PINHOLE;
  c->n_distortion = fisheye ? 4 : 5;
  if (strcmp(model, "none") == 0)
    return HL_OK;
  if (!fisheye && strcmp(model, "radtan") != 0)
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: distortion_model = '%.40s' is none of: radtan, equidistant, none",
                   source.path, model);
  return hl_json_numbers(source, camera, "distortion_coeffs", 4, c->distortion);
}

static hl_status read_camera(hl_json_source source, const json_t *camera, hl_camera *out)
{
  hl_camera c = {0};
  double core[4];
  const char *model = NULL;
  hl_status st = hl_json_string(source, camera, "camera_model", &model);
  if (st == HL_OK && strcmp(model, "pinhole") != 0)
    st = hl_fail(source.ctx, HL_ERR_FORMAT,
                 "%s: camera_model = '%.40s' is not pinhole; pinhole with radtan or equidistant "
                 "distortion is needed",
                 source.path, model);
  if (st == HL_OK)
    st = hl_camera_formats_size(source, camera, "resolution", &c);
  if (st == HL_OK)
    st = hl_json_numbers(source, camera, "intrinsics", 4, core);
  if (st == HL_OK)
    st = read_distortion(source, camera, &c);
  if (st != HL_OK)
    return st;
  hl_camera_formats_set_core(&c, core);
  return hl_camera_formats_finish(source, &c, out);
}

hl_status hl_camera_kalibr_members(hl_json_source source, const json_t *root, hl_camera *out)
{
  const char *name = NULL;
  const json_t *camera = NULL;
  char path[PATH_MAX_CHARS];
  const hl_status st = find_camera(source, root, &name, &camera);
  if (st != HL_OK)
    return st;
  snprintf(path, sizeof path, "%s: %.16s", source.path, name);
  return read_camera((hl_json_source){source.ctx, path}, camera, out);
}

static hl_status check_lens(hl_ctx *ctx, const hl_camera *c)
{
  if (c->model == HL_LENS_RATIONAL)
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "kalibr has no rational lens; its radtan is k1 k2 p1 p2 alone: json, opencv or "
                   "mrcal hold this camera");
  if (c->model == HL_LENS_PINHOLE && c->distortion[4] != 0)
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "kalibr's radtan has no k3, which is %.6g here; a pinhole with k3 = 0 is "
                   "accepted: json, opencv or mrcal hold this camera",
                   c->distortion[4]);
  return HL_OK;
}

hl_status hl_camera_kalibr_put(hl_ctx *ctx, const hl_camera *c, hl_text *out)
{
  const hl_status st = check_lens(ctx, c);
  if (st != HL_OK)
    return st;
  const double core[4] = {c->fx, c->fy, c->cx, c->cy};
  char tail[160];
  hl_text_add(out, "cam0:\n  cam_overlaps: []\n  camera_model: pinhole\n  distortion_coeffs: [");
  hl_text_exact(out, c->distortion, 4);
  hl_text_add(out, "]\n  distortion_model: ");
  hl_text_add(out, c->model == HL_LENS_FISHEYE ? "equidistant" : "radtan");
  hl_text_add(out, "\n  intrinsics: [");
  hl_text_exact(out, core, 4);
  snprintf(tail, sizeof tail, "]\n  resolution: [%d, %d]\n", c->width, c->height);
  hl_text_add(out, tail);
  return HL_OK;
}
