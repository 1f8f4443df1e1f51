/*
 * Whether the board is the one that the spec describes.
 *
 * A wrong gap between tags, or a print stretched along one side, is fitted by no camera, but nearly:
 * what is left is a fraction of a pixel up to a pixel or two, and looks like noise until it is asked.
 * So two numbers are added to the unknowns at the minimum, the spacing ratio and the stretch a,
 * x (1 + a/2), y (1 - a/2), beside the poses and fx, fy, cx, cy (the distortion held), and the step
 * that Gauss and Newton would take says what they would be and how much of the sum of squares they
 * would explain.
 */
#include <math.h>
#include <string.h>

#include "intrinsics.h"

enum { HELD_FROM = 4, SHAPES = 2 };

/* d(board)/d(shape) of a corner; a chessboard has no ratio. */
static void by_shape(const hl_target *target, const hl_sighting *s, double out[SHAPES][3])
{
  const int columns = hl_target_corner_columns(target);
  const int column = s->index % columns / 2, row = s->index / columns / 2; /* of the tag */
  const double stretch[3] = {s->board_m[0] / 2, -s->board_m[1] / 2, 0};
  const double gaps[3] = {column * target->size_m, row * target->size_m, 0};
  memcpy(out[0], stretch, sizeof stretch);
  memcpy(out[1], gaps, sizeof gaps);
}

static bool add_view(const hl_intrinsics *p, const hl_intrinsics_view *view, int shapes,
                     hl_arrow *arrow, hl_arrow_view *block)
{
  for (int c = 0; c < view->n; c++) {
    const hl_sighting *s = &view->sighting[c];
    double at[3], by_pose[3][HL_POSE_SIZE], by_board[3][3], pixel[2], by_point[2][3];
    double theta[2][HL_INTRINSICS_MAX], shape[SHAPES][3];
    if (!s->used)
      continue;
    hl_pose_apply(&view->pose, s->board_m, at, by_pose, by_board);
    if (hl_camera_project_derivatives(NULL, &p->camera, at, pixel, by_point, theta) != HL_OK)
      return false;
    by_shape(&p->corners->target, s, shape);
    for (int i = 0; i < 2; i++) {
      double row[HL_INTRINSICS_MAX], pose[HL_POSE_SIZE] = {0};
      for (int k = 0; k < HELD_FROM; k++)
        row[k] = -s->weight * theta[i][k];
      for (int k = 0; k < shapes; k++) {
        row[HELD_FROM + k] = 0;
        for (int a = 0; a < 3; a++)
          for (int b = 0; b < 3; b++)
            row[HELD_FROM + k] -= s->weight * by_point[i][a] * by_board[a][b] * shape[k][b];
      }
      for (int k = 0; k < HL_POSE_SIZE; k++)
        for (int a = 0; a < 3; a++)
          pose[k] -= s->weight * by_point[i][a] * by_pose[a][k];
      hl_arrow_add(arrow, block, row, pose, s->weight * (s->pixel[i] - pixel[i]));
    }
  }
  return true;
}

/* g' H^-1 g at the step `by`. */
static double gain_of(const hl_intrinsics *p, const hl_arrow *arrow, const double *by)
{
  double gain = 0;
  for (int k = 0; k < arrow->n; k++)
    gain -= arrow->gradient[k] * by[k];
  for (int i = 0; i < p->n_active; i++) {
    double step[HL_POSE_SIZE];
    hl_arrow_view_step(p->active[i], arrow->n, by, step);
    for (int k = 0; k < HL_POSE_SIZE; k++)
      gain -= p->active[i]->gradient[k] * step[k];
  }
  return gain;
}

bool hl_intrinsics_shape(hl_intrinsics *p, hl_board_shape *out)
{
  const hl_target *target = &p->corners->target;
  const int shapes = target->kind == HL_TARGET_APRILGRID ? 2 : 1;
  const int n = HELD_FROM + shapes;
  hl_arrow arrow;
  hl_arrow_fault fault;
  double by[HL_INTRINSICS_MAX], inverse[HL_INTRINSICS_MAX * HL_INTRINSICS_MAX];
  hl_arrow_clear(&arrow, n);
  p->n_active = 0;
  for (int i = 0; i < p->n_views; i++) {
    if (!p->view[i].used)
      continue;
    hl_arrow_view_clear(&p->block[i]);
    p->active[p->n_active++] = &p->block[i];
    if (!add_view(p, &p->view[i], shapes, &arrow, &p->block[i]))
      return false;
  }
  if (!hl_arrow_factor(&arrow, p->active, p->n_active, 0, &fault) || !(p->cost > 0))
    return false;
  hl_arrow_step(&arrow, p->active, p->n_active, by);
  hl_spd_inverse(&arrow.schur, inverse);
  *out = (hl_board_shape){.explained = gain_of(p, &arrow, by) / p->cost};
  const double variance = p->cost / hl_intrinsics_freedom(p);
  out->stretch = by[HELD_FROM];
  out->stretch_sd = sqrt(variance * inverse[HELD_FROM * n + HELD_FROM]);
  if (shapes > 1) {
    out->ratio_off = by[HELD_FROM + 1];
    out->ratio_sd = sqrt(variance * inverse[(HELD_FROM + 1) * n + HELD_FROM + 1]);
  }
  return true;
}
