/* Folders as fixtures/README.md describes them. */
#include "bench_scene.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "halflight/vec3.h"

static const double MIN_COS_VIEW = 0.1; /* estimate's */

enum { PATH_MAX_BYTES = 4096 };

static hl_status read_truth(hl_ctx *ctx, const char *path, double light[3])
{
  json_error_t error;
  json_t *root = json_load_file(path, 0, &error);
  const json_t *list = json_object_get(root, "light");
  bool good = json_array_size(list) == 3;
  for (size_t i = 0; i < 3 && good; i++) {
    good = json_is_number(json_array_get(list, i));
    light[i] = json_number_value(json_array_get(list, i));
  }
  json_decref(root);
  if (!good || !(fabs(hl_norm(light) - 1) < 1e-6))
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: no member 'light' of three numbers of length 1", path);
  return HL_OK;
}

static hl_status read_frame(hl_ctx *ctx, const char *folder, hl_frame *out)
{
  static const char *const endings[] = {"pfm", "png", "jpg", "tif", "exr"};
  char path[PATH_MAX_BYTES];
  for (int i = 0; i < 5; i++) {
    snprintf(path, sizeof path, "%s/frame.%s", folder, endings[i]);
    if (access(path, R_OK) == 0)
      return hl_frame_read(ctx, path, NULL, out);
  }
  return hl_fail(ctx, HL_ERR_IO, "%s: holds no frame.pfm, .png, .jpg, .tif or .exr", folder);
}

static hl_status derive(hl_ctx *ctx, hl_bench_scene *s)
{
  hl_status st = hl_surface_of_sphere(ctx, &s->camera, &s->sphere, MIN_COS_VIEW, &s->surface);
  if (st != HL_OK)
    return st;
  if (s->surface.width != s->frame.width || s->surface.height != s->frame.height)
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: the camera is not of the frame's size", s->name);
  st = hl_camera_project(ctx, &s->camera, s->sphere.center_m, s->circle);
  if (st != HL_OK)
    return st;
  const double d = hl_norm(s->sphere.center_m), r = s->sphere.radius_m;
  s->circle[2] = s->camera.fx * r / sqrt(d * d - r * r);
  const size_t n = (size_t)s->frame.width * (size_t)s->frame.height;
  s->grey = calloc(n, sizeof *s->grey);
  if (!s->grey)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a frame");
  for (size_t i = 0; i < n; i++)
    for (int c = 0; c < s->frame.channels; c++)
      s->grey[i] +=
          s->frame.radiance[i * (size_t)s->frame.channels + (size_t)c] / (float)s->frame.channels;
  return hl_light_work_new(ctx, s->surface.n, s->frame.channels, &s->work);
}

hl_status hl_bench_scene_open(hl_ctx *ctx, const char *folder, hl_bench_scene *out)
{
  char path[PATH_MAX_BYTES];
  *out = (hl_bench_scene){0};
  const char *slash = strrchr(folder, '/');
  snprintf(out->name, sizeof out->name, "%s", slash && slash[1] ? slash + 1 : folder);
  snprintf(path, sizeof path, "%s/camera.json", folder);
  hl_status st = hl_camera_read(ctx, path, &out->camera);
  snprintf(path, sizeof path, "%s/sphere.json", folder);
  if (st == HL_OK)
    st = hl_sphere_read(ctx, path, &out->sphere);
  snprintf(path, sizeof path, "%s/truth.json", folder);
  if (st == HL_OK)
    st = read_truth(ctx, path, out->light);
  if (st == HL_OK)
    st = read_frame(ctx, folder, &out->frame);
  return st == HL_OK ? derive(ctx, out) : st;
}

void hl_bench_scene_close(hl_bench_scene *s)
{
  hl_light_work_free(s->work);
  hl_surface_free(&s->surface);
  hl_frame_free(&s->frame);
  free(s->grey);
  *s = (hl_bench_scene){0};
}
