/*
 * Cameras as mrcal's .cameramodel: a Python dictionary with comments (mrcal/cameramodel.py), of
 *
 *   lensmodel    LENSMODEL_PINHOLE, _OPENCV4, _OPENCV5: our pinhole; LENSMODEL_OPENCV8: our rational
 *   intrinsics   fx fy cx cy, then OpenCV's coefficients k1 k2 p1 p2 k3 k4 k5 k6, as many as the name
 *                says
 *   imagersize   width height
 *   extrinsics   the camera's place in the world, which is not ours: left unread, written as none
 *
 * Its other lenses (CAHVOR, CAHVORE, the splined ones, OPENCV12 with a thin prism) are refused by name;
 * it has none that is a Kannala-Brandt fisheye. mrcal itself writes ten digits.
 *
 * Pixels: mrcal's imager reaches from (-0.5, -0.5) to (w - 0.5, h - 0.5), its centre is ((w - 1)/2,
 * (h - 1)/2) (calibration.py, image_transforms.py), so (0,0) is the centre of the top-left pixel, as
 * here.
 */
#include <string.h>

#include "camera_formats.h"

typedef struct lensmodel {
  const char *name;
  hl_lens_model model;
  int n_distortion; /* in the file */
} lensmodel;

static const lensmodel lensmodels[] = {
    {"LENSMODEL_PINHOLE", HL_LENS_PINHOLE, 0},
    {"LENSMODEL_OPENCV4", HL_LENS_PINHOLE, 4},
    {"LENSMODEL_OPENCV5", HL_LENS_PINHOLE, 5},
    {"LENSMODEL_OPENCV8", HL_LENS_RATIONAL, 8},
};

enum { N_LENSMODELS = sizeof lensmodels / sizeof lensmodels[0] };

static hl_status find_lensmodel(hl_json_source source, const json_t *root, const lensmodel **out)
{
  const char *name = NULL;
  const hl_status st = hl_json_string(source, root, "lensmodel", &name);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < N_LENSMODELS; i++)
    if (strcmp(name, lensmodels[i].name) == 0) {
      *out = &lensmodels[i];
      return HL_OK;
    }
  return hl_fail(source.ctx, HL_ERR_FORMAT,
                 "%s: lensmodel = '%.60s' is none of: LENSMODEL_PINHOLE, LENSMODEL_OPENCV4, "
                 "LENSMODEL_OPENCV5, LENSMODEL_OPENCV8",
                 source.path, name);
}

hl_status hl_camera_mrcal_members(hl_json_source source, const json_t *root, hl_camera *out)
{
  hl_camera c = {0};
  const lensmodel *found = NULL;
  double intrinsics[HL_INTRINSICS_MAX] = {0};
  hl_status st = find_lensmodel(source, root, &found);
  if (st == HL_OK)
    st = hl_camera_formats_size(source, root, "imagersize", &c);
  if (st == HL_OK)
    st = hl_json_numbers(source, root, "intrinsics", 4 + found->n_distortion, intrinsics);
  if (st != HL_OK)
    return st;
  c.model = found->model;
  c.n_distortion = found->model == HL_LENS_PINHOLE ? 5 : 8;
  hl_camera_set_intrinsics(&c, intrinsics);
  return hl_camera_formats_finish(source, &c, out);
}

hl_status hl_camera_mrcal_put(hl_ctx *ctx, const hl_camera *c, hl_text *out)
{
  if (c->model == HL_LENS_FISHEYE)
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "mrcal has no Kannala-Brandt fisheye; pinhole and rational lenses are accepted: "
                   "json, opencv or kalibr hold this camera");
  double intrinsics[HL_INTRINSICS_MAX];
  char tail[120];
  hl_camera_intrinsics(c, intrinsics);
  hl_text_add(out, "{\n    'lensmodel':  '");
  hl_text_add(out, c->model == HL_LENS_PINHOLE ? "LENSMODEL_OPENCV5" : "LENSMODEL_OPENCV8");
  hl_text_add(out, "',\n\n    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n"
                   "    'intrinsics': [ ");
  hl_text_exact(out, intrinsics, hl_camera_intrinsics_count(c));
  snprintf(tail, sizeof tail, "    'imagersize': [ %d, %d ],\n}\n", c->width, c->height);
  hl_text_add(out, " ],\n\n    # extrinsics are rt_fromref\n"
                   "    'extrinsics': [ 0, 0, 0, 0, 0, 0 ],\n\n");
  hl_text_add(out, tail);
  return HL_OK;
}
