/* A printed target seen by a camera, 6 x 6 samples a pixel: truth for the corners. */
#ifndef HL_TEST_BOARD_SCENE_H
#define HL_TEST_BOARD_SCENE_H

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/camera.h"
#include "halflight/frame.h"
#include "halflight/pose.h"
#include "halflight/target.h"
#include "near.h"

enum { BOARD_SAMPLES = 6, BOARD_TAGS = 64 };

typedef struct board_scene {
  hl_target target;
  hl_camera camera;
  hl_pose cam_from_board;
  int border_bits;   /* of the tags */
  bool isolated;     /* no black squares between the tags */
  bool top_left_ids; /* instead of Kalibr's */
  bool mirrored;     /* the board's x runs to the left, as in a mirror */
  bool white_first;  /* of a chessboard: its first square is white */
  int turned;        /* the tags are printed turned by so many quarters clockwise */
  double black, white, around;
  double slope;   /* change of the light across the frame, of its mean */
  double blur_px; /* standard deviation, beside the pixel's own */
  double noise;   /* standard deviation */
  unsigned seed;
  bool cells[BOARD_TAGS][HL_TARGET_TAG_CELLS][HL_TARGET_TAG_CELLS]; /* by column and row */
} board_scene;

static inline int board_tag_id(const board_scene *s, int column, int row)
{
  return s->top_left_ids ? row * s->target.columns + column
                         : hl_target_tag_id(&s->target, column, row);
}

/* A board before a plain pinhole camera of 640 x 480 pixels; board_place says where, board_print
 * prints its tags. */
static inline board_scene board_scene_of(const char *spec)
{
  board_scene s = {.border_bits = 2, .black = 0.03, .white = 0.8, .around = 0.3, .seed = 1};
  if (hl_target_parse(NULL, spec, &s.target) != HL_OK)
    abort();
  s.camera = (hl_camera){.width = 640,
                         .height = 480,
                         .fx = 800,
                         .fy = 800,
                         .cx = 319.5,
                         .cy = 239.5,
                         .n_distortion = 5};
  return s;
}

/* Looks at the board's middle from so far that it fills `share` of the frame, turned by a rotation
 * vector. */
static inline void board_place(board_scene *s, double share, double rx, double ry, double rz)
{
  double last[3];
  double turned[3];
  hl_target_corner(&s->target, hl_target_corners(&s->target) - 1, last);
  const double w = s->camera.fx * last[0] / (share * s->camera.width);
  const double h = s->camera.fy * last[1] / (share * s->camera.height);
  s->cam_from_board = (hl_pose){{rx, ry, rz}, {0, 0, 0}};
  const double middle[3] = {last[0] / 2, last[1] / 2, 0};
  hl_pose_apply(&s->cam_from_board, middle, turned, NULL, NULL);
  for (int i = 0; i < 3; i++)
    s->cam_from_board.translation_m[i] = (i == 2 ? fmax(w, h) : 0) - turned[i];
}

/* False where this build has no AprilTag. */
static inline bool board_print(board_scene *s)
{
  for (int row = 0; row < s->target.rows; row++)
    for (int column = 0; column < s->target.columns; column++) {
      bool upright[HL_TARGET_TAG_CELLS][HL_TARGET_TAG_CELLS];
      bool(*out)[HL_TARGET_TAG_CELLS] = s->cells[row * s->target.columns + column];
      const int last = HL_TARGET_TAG_CELLS - 1;
      if (hl_target_tag_cells(NULL, board_tag_id(s, column, row), upright) != HL_OK)
        return false;
      for (int y = 0; y <= last; y++)
        for (int x = 0; x <= last; x++)
          out[y][x] = s->turned == 0   ? upright[y][x]
                      : s->turned == 1 ? upright[last - x][y]
                      : s->turned == 2 ? upright[last - y][last - x]
                                       : upright[x][last - y];
    }
  return true;
}

/* 1 on ink, 0 on paper, at (x,y) in units of a tag or square from the first corner. */
static inline bool board_is_black_chess(const board_scene *s, double x, double y)
{
  if (x < -1 || y < -1 || x >= s->target.columns || y >= s->target.rows)
    return false;
  return (((int)floor(x) + (int)floor(y)) % 2 == 0) != s->white_first;
}

static inline bool board_is_black_tags(const board_scene *s, double x, double y)
{
  const double gap = s->target.spacing_ratio;
  const double pitch = 1 + gap;
  const int column = (int)floor(x / pitch);
  const int row = (int)floor(y / pitch);
  const double u = x - column * pitch;
  const double v = y - row * pitch;
  const bool on_board =
      column >= -1 && row >= -1 && column < s->target.columns && row < s->target.rows;
  if (!on_board || (u >= 1 && v < 1) || (u < 1 && v >= 1))
    return false;
  if (u >= 1 && v >= 1)
    return !s->isolated;
  if (column < 0 || row < 0)
    return false;
  const int side = HL_TARGET_TAG_CELLS + 2 * s->border_bits;
  const int i = (int)floor(u * side) - s->border_bits;
  const int k = (int)floor(v * side) - s->border_bits;
  if (i < 0 || k < 0 || i >= HL_TARGET_TAG_CELLS || k >= HL_TARGET_TAG_CELLS)
    return true;
  return !s->cells[row * s->target.columns + column][k][i];
}

/* Reflectance at a place of the board's plane; paper reaches half a tag beyond the print. */
static inline double board_shade(const board_scene *s, const double at_m[2])
{
  const double x = at_m[0] / s->target.size_m;
  const double y = at_m[1] / s->target.size_m;
  const bool tags = s->target.kind == HL_TARGET_APRILGRID;
  const double pitch = tags ? 1 + s->target.spacing_ratio : 1;
  const double edge = tags ? s->target.spacing_ratio + 0.5 : 1.5;
  const double wide = s->target.columns * pitch - (tags ? s->target.spacing_ratio : 1) + edge;
  const double high = s->target.rows * pitch - (tags ? s->target.spacing_ratio : 1) + edge;
  if (x < -edge || y < -edge || x > wide || y > high)
    return s->around;
  const bool black = tags ? board_is_black_tags(s, x, y) : board_is_black_chess(s, x, y);
  return black ? s->black : s->white;
}

/* Where the ray of a pixel meets the board; false where it does not. */
static inline bool board_meet(const board_scene *s, double x, double y, double out_m[2])
{
  double ray[3];
  double r[3][3];
  const double *t = s->cam_from_board.translation_m;
  if (hl_camera_unproject(NULL, &s->camera, x, y, ray) != HL_OK)
    abort();
  hl_pose_matrix(&s->cam_from_board, r);
  double along[3] = {0, 0, 0};
  double origin[3] = {0, 0, 0};
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) {
      along[i] += r[k][i] * ray[k];
      origin[i] -= r[k][i] * t[k];
    }
  const double distance = -origin[2] / along[2];
  for (int i = 0; i < 2; i++)
    out_m[i] = origin[i] + distance * along[i];
  return distance > 0;
}

/* A corner of the print in the frame. */
static inline void board_truth(const board_scene *s, int index, double pixel[2])
{
  double at[3];
  double p[3];
  hl_target_corner(&s->target, index, at);
  hl_pose_apply(&s->cam_from_board, at, p, NULL, NULL);
  if (hl_camera_project(NULL, &s->camera, p, pixel) != HL_OK)
    abort();
  if (s->mirrored)
    pixel[0] = s->camera.width - 1 - pixel[0];
}

/* Inside a pixel the board's place is taken as bilinear between the pixel's corners. */
static inline double board_pixel(const board_scene *s, const double corner[4][2])
{
  double sum = 0;
  for (int k = 0; k < BOARD_SAMPLES * BOARD_SAMPLES; k++) {
    const double u = (k % BOARD_SAMPLES + 0.5) / BOARD_SAMPLES;
    const double v = ((double)(k / BOARD_SAMPLES) + 0.5) / BOARD_SAMPLES;
    double at[2];
    for (int i = 0; i < 2; i++)
      at[i] = (1 - v) * ((1 - u) * corner[0][i] + u * corner[1][i]) +
              v * ((1 - u) * corner[2][i] + u * corner[3][i]);
    sum += board_shade(s, at);
  }
  return sum / (BOARD_SAMPLES * BOARD_SAMPLES);
}

static inline void board_blur_line(float *line, float *copy, int n, int stride, const double *k,
                                   int reach)
{
  for (int i = 0; i < n; i++)
    copy[i] = line[(size_t)i * (size_t)stride];
  for (int i = 0; i < n; i++) {
    double sum = 0;
    for (int j = -reach; j <= reach; j++) {
      const int at = i + j < 0 ? 0 : i + j >= n ? n - 1 : i + j;
      sum += k[j + reach] * (double)copy[at];
    }
    line[(size_t)i * (size_t)stride] = (float)sum;
  }
}

static inline void board_blur(float *p, int width, int height, double sigma)
{
  double k[129];
  double sum = 0;
  const int reach = (int)fmin(64, ceil(4 * sigma));
  float *copy = malloc((size_t)(width > height ? width : height) * sizeof *copy);
  if (!copy)
    abort();
  for (int i = -reach; i <= reach; i++)
    sum += k[i + reach] = exp(-0.5 * i * i / (sigma * sigma));
  for (int i = 0; i <= 2 * reach; i++)
    k[i] /= sum;
  for (int y = 0; y < height; y++)
    board_blur_line(p + (size_t)y * (size_t)width, copy, width, 1, k, reach);
  for (int x = 0; x < width; x++)
    board_blur_line(p + x, copy, height, width, k, reach);
  free(copy);
}

static inline hl_frame board_frame(const board_scene *s)
{
  const int w = s->camera.width;
  const int h = s->camera.height;
  const size_t n = (size_t)w * (size_t)h;
  hl_frame f = {.width = w, .height = h, .channels = 1, .bits = 32};
  double(*grid)[2] = malloc((size_t)(w + 1) * (size_t)(h + 1) * sizeof *grid);
  f.radiance = malloc(n * sizeof *f.radiance);
  f.state = calloc(n, 1);
  if (!grid || !f.radiance || !f.state)
    abort();
  for (int y = 0; y <= h; y++)
    for (int x = 0; x <= w; x++) {
      double *at = grid[(size_t)y * (size_t)(w + 1) + (size_t)x];
      const double column = s->mirrored ? w - 1 - (x - 0.5) : x - 0.5;
      if (!board_meet(s, column, y - 0.5, at))
        at[0] = at[1] = 1e9;
    }
  for (int y = 0; y < h; y++)
    for (int x = 0; x < w; x++) {
      double corner[4][2];
      const size_t at = (size_t)y * (size_t)(w + 1) + (size_t)x;
      memcpy(corner[0], grid[at], 2 * sizeof corner[0]);
      memcpy(corner[2], grid[at + (size_t)w + 1], 2 * sizeof corner[0]);
      const double light = 1 + s->slope * ((x + 0.5) / w - 0.5);
      f.radiance[(size_t)y * (size_t)w + (size_t)x] = (float)(light * board_pixel(s, corner));
    }
  free(grid);
  if (s->blur_px > 0)
    board_blur(f.radiance, w, h, s->blur_px);
  test_random random = {(s->seed + 1) * 0x9E3779B97F4A7C15u};
  for (size_t i = 0; i < n; i++)
    f.radiance[i] += (float)(s->noise * random_normal(&random));
  return f;
}

#endif
