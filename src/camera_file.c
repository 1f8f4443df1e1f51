/*
 * Camera files, told apart by what they hold, not by their names:
 *
 *   {"..."            JSON, CAMERA.json
 *   {'...', {#        a Python dictionary, mrcal's .cameramodel; so is {"lensmodel"
 *   anything else     YAML: OpenCV's with camera_matrix, Kalibr's with cam0
 */
#include "camera_file.h"

#include <stdlib.h>
#include <string.h>

#include "camera_formats.h"
#include "camera_json.h"
#include "file_read.h"
#include "python_read.h"
#include "yaml_read.h"

enum { YAML_BYTES_MAX = 16 << 20 };

typedef enum language { IN_JSON, IN_YAML, IN_PYTHON } language;

static const char *after_blanks(const char *c)
{
  return c + strspn(c, " \t\r\n");
}

/* `text` ends with a zero byte. */
static language language_of(const char *text)
{
  const char *c = after_blanks(text);
  const bool commented = *c == '#';
  while (*c == '#')
    c = after_blanks(c + strcspn(c, "\n"));
  if (*c == '[')
    return IN_JSON;
  if (*c != '{')
    return IN_YAML;
  c = after_blanks(c + 1);
  static const char first[] = "\"lensmodel\"";
  if (*c == '\'' || *c == '#' || strncmp(c, first, sizeof first - 1) == 0)
    return IN_PYTHON;
  return commented ? IN_PYTHON : IN_JSON;
}

static hl_status parse(hl_json_source source, language in, char *bytes, size_t n, json_t **out)
{
  if (in == IN_PYTHON)
    return hl_python_parse(source, bytes, n, out);
  if (in == IN_JSON)
    return hl_json_parse(source, bytes, n, out);
  if (n > YAML_BYTES_MAX)
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: over %d bytes, the largest YAML accepted",
                   source.path, YAML_BYTES_MAX);
  return hl_yaml_parse(source, bytes, n, out);
}

static hl_status read_root(hl_json_source source, language in, const json_t *root, hl_camera *out)
{
  if (in == IN_PYTHON)
    return hl_camera_mrcal_members(source, root, out);
  if (in == IN_YAML && hl_camera_opencv_is(root))
    return hl_camera_opencv_members(source, root, out);
  if (in == IN_YAML && hl_camera_kalibr_is(root))
    return hl_camera_kalibr_members(source, root, out);
  if (in == IN_YAML)
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: no camera is known in it: not JSON, no camera_matrix as OpenCV's YAML has, "
                   "no cam0 as Kalibr's has, no .cameramodel of mrcal",
                   source.path);
  const hl_status st = hl_json_header(source, root, HL_CAMERA_JSON_FORMAT, HL_CAMERA_JSON_VERSION);
  return st == HL_OK ? hl_camera_json_members(source, root, out) : st;
}

hl_status hl_camera_file_read(hl_ctx *ctx, const char *path, hl_camera *out, json_t **document)
{
  const hl_json_source source = {ctx, path};
  unsigned char *bytes = NULL;
  size_t n = 0;
  json_t *root = NULL;
  hl_status st = hl_file_read(ctx, path, HL_JSON_BYTES_MAX, &bytes, &n);
  if (st != HL_OK)
    return st;
  const language in = language_of((const char *)bytes);
  st = parse(source, in, (char *)bytes, n, &root);
  free(bytes);
  if (st == HL_OK)
    st = read_root(source, in, root, out);
  const bool wanted = st == HL_OK && document && in == IN_JSON;
  if (st == HL_OK && document)
    *document = wanted ? root : NULL;
  if (!wanted)
    json_decref(root);
  return st;
}

hl_status hl_camera_read(hl_ctx *ctx, const char *path, hl_camera *out)
{
  return hl_camera_file_read(ctx, path, out, NULL);
}

/* ---- shared by the readers */

hl_status hl_camera_formats_size(hl_json_source source, const json_t *object, const char *member,
                                 hl_camera *camera)
{
  double size[2];
  const hl_status st = hl_json_numbers(source, object, member, 2, size);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < 2; i++)
    if (!(size[i] >= 2 && size[i] <= 65536 && size[i] == (int)size[i]))
      return hl_fail(source.ctx, HL_ERR_FORMAT,
                     "%s: %s[%d] = %.9g; a whole number in [2, 65536] is needed", source.path,
                     member, i, size[i]);
  camera->width = (int)size[0];
  camera->height = (int)size[1];
  return HL_OK;
}

hl_status hl_camera_formats_finish(hl_json_source source, hl_camera *camera, hl_camera *out)
{
  hl_ctx inner = {0};
  const hl_status st = hl_camera_check(&inner, camera);
  if (st != HL_OK)
    return hl_json_blame(source, st, inner.msg);
  *out = *camera;
  return HL_OK;
}

void hl_camera_formats_set_core(hl_camera *camera, const double core[4])
{
  camera->fx = core[0];
  camera->fy = core[1];
  camera->cx = core[2];
  camera->cy = core[3];
}

/* ---- written */

/* In the order of hl_camera_format. */
static const struct {
  const char *name;
  hl_status (*put)(hl_ctx *ctx, const hl_camera *camera, hl_text *out);
  unsigned keeps; /* hl_camera_part */
} formats[] = {
    {"json", NULL, HL_CAMERA_COVARIANCE | HL_CAMERA_RMS | HL_CAMERA_OBSERVATIONS},
    {"opencv", hl_camera_opencv_put, HL_CAMERA_RMS},
    {"kalibr", hl_camera_kalibr_put, 0},
    {"mrcal", hl_camera_mrcal_put, 0},
};

enum { N_FORMATS = sizeof formats / sizeof formats[0] };

const char *hl_camera_format_name(int format)
{
  return format >= 0 && format < N_FORMATS ? formats[format].name : NULL;
}

unsigned hl_camera_lost(const hl_camera *camera, hl_camera_format format)
{
  const unsigned has = (camera->has_covariance ? HL_CAMERA_COVARIANCE : 0u) |
                       (camera->rms_px > 0 ? HL_CAMERA_RMS : 0u) |
                       (camera->observations > 0 ? HL_CAMERA_OBSERVATIONS : 0u);
  return (unsigned)format < N_FORMATS ? has & ~formats[format].keeps : has;
}

hl_status hl_camera_text(hl_ctx *ctx, const hl_camera *camera, hl_camera_format format, char **out)
{
  if ((unsigned)format >= N_FORMATS)
    return hl_fail(ctx, HL_ERR_ARG, "format = %d is none of the known camera formats", (int)format);
  if (format == HL_CAMERA_JSON)
    return hl_camera_json(ctx, camera, out);
  hl_text text = {0};
  hl_status st = hl_camera_check(ctx, camera);
  if (st == HL_OK)
    st = formats[format].put(ctx, camera, &text);
  if (st == HL_OK && text.failed)
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for the text of a camera");
  if (st == HL_OK)
    *out = text.bytes;
  else
    free(text.bytes);
  return st;
}
