/*
 * Cameras in the YAML of OpenCV's FileStorage, as its calibration sample names the members:
 *
 *   image_width, image_height              pixels
 *   camera_matrix            3 x 3         [fx 0 cx; 0 fy cy; 0 0 1]
 *   distortion_coefficients  1 x n, n x 1  k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 .. s4 [tx ty]]]]
 *   fisheye_model            0 or 1        1: distortion_coefficients are cv::fisheye's k1 k2 k3 k4
 *   avg_reprojection_error   pixels        root mean square distance; optional
 *
 * Four coefficients are a fisheye's only together with `fisheye_model: 1` (what OpenCV's
 * camera_calibration sample writes) or ROS' `distortion_model: equidistant`; else they are a pinhole's
 * with k3 = 0. ROS' camera_info files have the same members and are read too.
 *
 * OpenCV writes `%YAML:1.0` and tags matrices `!!opencv-matrix`, neither of which PyYAML's safe_load
 * takes; its reader asks for neither, so `%YAML 1.1` and plain mappings are what both read.
 *
 * Pixels: OpenCV puts (0,0) into the centre of the top-left pixel (cornerSubPix and remap sample there,
 * and calibrateCamera starts from a centre of ((w - 1)/2, (h - 1)/2)), as we do.
 */
#include <string.h>

#include "camera_formats.h"

enum { COEFFICIENTS_MAX = 14, PATH_MAX_CHARS = 512 };

bool hl_camera_opencv_is(const json_t *root)
{
  return hl_json_has(root, "camera_matrix") || hl_json_has(root, "distortion_coefficients");
}

/* Numbers of a matrix, row by row; *n of them, at most `most`. */
static hl_status read_matrix(hl_json_source source, const json_t *root, const char *name, int most,
                             int *rows, int *columns, double *out)
{
  char path[PATH_MAX_CHARS];
  const json_t *matrix = json_object_get(root, name);
  if (!json_is_object(matrix))
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: %s is %s; a matrix of rows, cols and data is needed", source.path, name,
                   matrix ? "no mapping" : "missing");
  snprintf(path, sizeof path, "%s: %s", source.path, name);
  const hl_json_source inside = {source.ctx, path};
  hl_status st = hl_json_int(inside, matrix, "rows", 1, most, rows);
  if (st == HL_OK)
    st = hl_json_int(inside, matrix, "cols", 1, most, columns);
  if (st == HL_OK && *rows * *columns > most)
    st = hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %d x %d values; at most %d are needed", path,
                 *rows, *columns, most);
  if (st == HL_OK)
    st = hl_json_numbers(inside, matrix, "data", *rows * *columns, out);
  return st;
}

static hl_status read_camera_matrix(hl_json_source source, const json_t *root, hl_camera *c)
{
  int rows = 0, columns = 0;
  double m[9];
  const hl_status st = read_matrix(source, root, "camera_matrix", 9, &rows, &columns, m);
  if (st != HL_OK)
    return st;
  if (rows != 3 || columns != 3)
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: camera_matrix is %d x %d; 3 x 3 is needed",
                   source.path, rows, columns);
  static const int at[5] = {1, 3, 6, 7, 8};
  static const double due[5] = {0, 0, 0, 0, 1};
  for (int i = 0; i < 5; i++)
    if (!(m[at[i]] == due[i]))
      return hl_fail(source.ctx, HL_ERR_FORMAT,
                     "%s: camera_matrix: data[%d] = %.6g; %g is needed: [fx 0 cx; 0 fy cy; 0 0 1]",
                     source.path, at[i], m[at[i]], due[i]);
  hl_camera_formats_set_core(c, (const double[4]){m[0], m[4], m[2], m[5]});
  return HL_OK;
}

/* What the file says of its lens; false where it says nothing. */
static hl_status read_lens(hl_json_source source, const json_t *root, bool *fisheye)
{
  static const char *const models[] = {"plumb_bob", "rational_polynomial", "equidistant",
                                       "fisheye"};
  int flag = 0;
  *fisheye = false;
  const json_t *stated = json_object_get(root, "fisheye_model");
  if (json_is_boolean(stated))
    *fisheye = json_is_true(stated);
  else if (hl_json_has(root, "fisheye_model")) {
    const hl_status st = hl_json_int(source, root, "fisheye_model", 0, 1, &flag);
    if (st != HL_OK)
      return st;
    *fisheye = flag == 1;
  }
  if (!hl_json_has(root, "distortion_model"))
    return HL_OK;
  const char *name = NULL;
  const hl_status st = hl_json_string(source, root, "distortion_model", &name);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < 4; i++)
    if (strcmp(name, models[i]) == 0) {
      *fisheye = *fisheye || i >= 2;
      return HL_OK;
    }
  return hl_fail(source.ctx, HL_ERR_FORMAT,
                 "%s: distortion_model = '%.40s' is none of: plumb_bob, rational_polynomial, "
                 "equidistant, fisheye",
                 source.path, name);
}

/* k5 .. of a model that fits into a smaller one are 0. */
static hl_status read_distortion(hl_json_source source, const json_t *root, bool fisheye,
                                 hl_camera *c)
{
  int rows = 0, columns = 0;
  double k[COEFFICIENTS_MAX] = {0};
  const hl_status st =
      read_matrix(source, root, "distortion_coefficients", COEFFICIENTS_MAX, &rows, &columns, k);
  if (st != HL_OK)
    return st;
  const int n = rows * columns;
  const bool known = n == 4 || (!fisheye && (n == 5 || n == 8 || n == 12 || n == 14));
  if (!known || (rows > 1 && columns > 1))
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: distortion_coefficients is %d x %d; %s in one row or column are needed",
                   source.path, rows, columns, fisheye ? "a fisheye's 4" : "4, 5, 8, 12 or 14");
  for (int i = HL_DISTORTION_MAX; i < n; i++)
    if (!(k[i] == 0))
      return hl_fail(source.ctx, HL_ERR_FORMAT,
                     "%s: distortion_coefficients: data[%d] = %.6g is of a thin prism or a tilted "
                     "sensor; 0 is needed, since no lens model here has them",
                     source.path, i, k[i]);
  c->model = fisheye ? HL_LENS_FISHEYE : n <= 5 ? HL_LENS_PINHOLE : HL_LENS_RATIONAL;
  c->n_distortion = fisheye ? 4 : n <= 5 ? 5 : 8;
  memcpy(c->distortion, k, sizeof c->distortion);
  return HL_OK;
}

hl_status hl_camera_opencv_members(hl_json_source source, const json_t *root, hl_camera *out)
{
  hl_camera c = {0};
  bool fisheye = false;
  hl_status st = hl_json_int(source, root, "image_width", 2, 65536, &c.width);
  if (st == HL_OK)
    st = hl_json_int(source, root, "image_height", 2, 65536, &c.height);
  if (st == HL_OK)
    st = read_camera_matrix(source, root, &c);
  if (st == HL_OK)
    st = read_lens(source, root, &fisheye);
  if (st == HL_OK)
    st = read_distortion(source, root, fisheye, &c);
  if (st == HL_OK && hl_json_has(root, "avg_reprojection_error"))
    st = hl_json_number(source, root, "avg_reprojection_error", 0, 1e6, &c.rms_px);
  return st == HL_OK ? hl_camera_formats_finish(source, &c, out) : st;
}

static void put_matrix(hl_text *out, const char *name, int rows, int columns, const double *values)
{
  char head[160];
  snprintf(head, sizeof head, "%s:\n   rows: %d\n   cols: %d\n   dt: d\n   data: [ ", name, rows,
           columns);
  hl_text_add(out, head);
  for (int i = 0; i < rows * columns; i += 3) {
    const int left = rows * columns - i;
    hl_text_add(out, i > 0 ? ",\n      " : "");
    hl_text_exact(out, values + i, left < 3 ? left : 3);
  }
  hl_text_add(out, " ]\n");
}

hl_status hl_camera_opencv_put(hl_ctx *ctx, const hl_camera *c, hl_text *out)
{
  (void)ctx;
  char head[160];
  snprintf(head, sizeof head, "%%YAML 1.1\n---\nimage_width: %d\nimage_height: %d\n", c->width,
           c->height);
  hl_text_add(out, head);
  if (c->model == HL_LENS_FISHEYE)
    hl_text_add(out, "fisheye_model: 1\n");
  put_matrix(out, "camera_matrix", 3, 3,
             (const double[9]){c->fx, 0, c->cx, 0, c->fy, c->cy, 0, 0, 1});
  put_matrix(out, "distortion_coefficients", 1, c->n_distortion, c->distortion);
  if (c->rms_px > 0) {
    hl_text_add(out, "avg_reprojection_error: ");
    hl_text_exact(out, &c->rms_px, 1);
    hl_text_add(out, "\n");
  }
  return HL_OK;
}
