/*
 * A chessboard in a frame.
 *
 * OpenCV's detectors find it; the corners are then moved to their saddles on the linear plane
 * (saddle.c), since the sector-based detector draws all of them to one side, the more the blurrier.
 * Rendered boards of 9 x 6, squares of 40 px, noise 0.5 % of white; bias along x and y, and root mean
 * square of the distance, in px:
 *
 *   blur   sector-based detector    saddles
 *   0.7    -0.012 -0.013  0.042     0.000 0.001  0.023
 *   2      -0.031 -0.033  0.077    -0.001 0.001  0.019
 *   4      -0.129 -0.125  0.242    -0.002 0.002  0.043
 *
 * Which corner is the first? The detectors may begin at any. With i to the right and j down, as seen
 * from the front, and the first square (up left of the first corner) black:
 *   - rows are put in the order in which x to y turns as in the frame, from right to down;
 *   - of the two ways round (four on a square board) those whose first square is black stay;
 *   - if two are left, which look alike in every way, the one whose x points more to the right.
 * With an odd number of columns plus rows one is left, whatever way the board is held. A mirror
 * image is a chessboard as well, the same one where a side has an even number of corners or both
 * have as many. Only with two different odd sides does it show, by a white first square.
 */
#include "chessboard.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "frame_blur.h"
#include "halflight/bridge_opencv_corners.h"
#include "saddle.h"

/* contrast beyond the last line, of the board's */
static const double goes_on = 0.5;
/* alternating part of a corner's contrast, of which boards have 0.65 and more, and the share of the
 * corners that may have less */
static const double coherent = 0.5;
static const double wrong_most = 0.05;
/* of a square: the outer ones are often cut off there */
static const double quarter = 0.5;

typedef struct board {
  int columns, rows;
  double (*at)[2]; /* shape (rows, columns) */
} board;

static double *point(const board *b, int column, int row)
{
  return b->at[row * b->columns + column];
}

/* Way from a corner to the next, taken over both neighbours where there are two. */
static void way(const board *b, int column, int row, int right, int down, double out[2])
{
  const int steps = right ? b->columns : b->rows;
  const int here = right ? column : row;
  const int before = here > 0;
  const int after = here < steps - 1;
  const double *p = point(b, column - before * right, row - before * down);
  const double *q = point(b, column + after * right, row + after * down);
  for (int axis = 0; axis < 2; axis++)
    out[axis] = (q[axis] - p[axis]) / (before + after);
}

static hl_cross cross_at(const board *b, int column, int row)
{
  hl_cross cross;
  memcpy(cross.at, point(b, column, row), sizeof cross.at);
  way(b, column, row, 1, 0, cross.across);
  way(b, column, row, 0, 1, cross.down);
  return cross;
}

/* How much lighter the up left and down right quarters are than the others. */
static double slant(const hl_grey *grey, const hl_cross *cross)
{
  double q[4];
  hl_cross_quarters(grey, cross, q);
  return (q[0] + q[2] - q[1] - q[3]) / 2;
}

/* The same from the two quarters on one side alone. */
static double slant_of_side(const hl_grey *grey, const hl_cross *cross, bool right, bool at_end)
{
  double q[4];
  hl_cross_quarters(grey, cross, q);
  if (right)
    return at_end ? q[2] - q[1] : q[0] - q[3];
  return at_end ? q[2] - q[3] : q[0] - q[1];
}

/* As if at the first corner; its sign says that the first square is white. */
static double first_slant(const board *b, const hl_grey *grey)
{
  double sum = 0;
  for (int row = 0; row < b->rows; row++)
    for (int column = 0; column < b->columns; column++) {
      const hl_cross cross = cross_at(b, column, row);
      sum += ((column + row) % 2 == 0 ? 1 : -1) * slant(grey, &cross);
    }
  return sum / (b->columns * b->rows);
}

/* Do the corners alternate as a board's do? The detector now and then strings together corners that
 * are not neighbours; at several of those the quarters do not. */
static bool is_coherent(const board *b, const hl_grey *grey)
{
  const int n = b->columns * b->rows;
  const double first = first_slant(b, grey) > 0 ? 1 : -1;
  int wrong = 0;
  for (int i = 0; i < n; i++) {
    const int column = i % b->columns;
    const int row = i / b->columns;
    const hl_cross cross = cross_at(b, column, row);
    double q[4];
    hl_cross_quarters(grey, &cross, q);
    const double lightest = fmax(fmax(q[0], q[1]), fmax(q[2], q[3]));
    const double darkest = fmin(fmin(q[0], q[1]), fmin(q[2], q[3]));
    const double alternating = ((column + row) % 2 == 0 ? first : -first) * slant(grey, &cross);
    wrong += !(alternating > coherent * (lightest - darkest));
  }
  return wrong <= wrong_most * n;
}

/* ---------------------------------------------------------------- which corner is the first */

/* Does y turn out of x to the left, as in a mirror? */
static bool is_left_handed(const board *b)
{
  double sum = 0;
  for (int row = 0; row < b->rows; row++)
    for (int column = 0; column < b->columns; column++) {
      const hl_cross c = cross_at(b, column, row);
      sum += c.across[0] * c.down[1] - c.across[1] * c.down[0];
    }
  return sum < 0;
}

static void swap(double a[2], double b[2])
{
  for (int axis = 0; axis < 2; axis++) {
    const double kept = a[axis];
    a[axis] = b[axis];
    b[axis] = kept;
  }
}

static void reverse_rows(const board *b)
{
  for (int row = 0; row < b->rows; row++)
    for (int i = 0; i < b->columns / 2; i++)
      swap(point(b, i, row), point(b, b->columns - 1 - i, row));
}

static void turn_half(const board *b)
{
  const int n = b->columns * b->rows;
  for (int i = 0; i < n / 2; i++)
    swap(b->at[i], b->at[n - 1 - i]);
}

/* A quarter, of a square board: transposed, then every row reversed. */
static void turn_quarter(const board *b)
{
  for (int row = 0; row < b->rows; row++)
    for (int column = 0; column < row; column++)
      swap(point(b, column, row), point(b, row, column));
  reverse_rows(b);
}

/* Rightward part of x, as a share. */
static double rightward(const board *b)
{
  const double *first = point(b, 0, 0);
  const double *last = point(b, b->columns - 1, 0);
  return (last[0] - first[0]) / hypot(last[0] - first[0], last[1] - first[1]);
}

/* Leaves the board turned the way that is the rule; false where no way has a black first square. */
static bool settle_first(const board *b, const hl_grey *grey)
{
  const int turns = b->columns == b->rows ? 4 : 2;
  int best = -1;
  double most = -2;
  bool any_black = false;
  if (is_left_handed(b))
    reverse_rows(b);
  for (int i = 0; i < turns; i++) {
    const bool black = first_slant(b, grey) < 0;
    const double right = rightward(b);
    if ((black && !any_black) || (black == any_black && right > most)) {
      best = i;
      most = right;
    }
    any_black = any_black || black;
    if (turns == 4)
      turn_quarter(b);
    else
      turn_half(b);
  }
  for (int i = 0; i < best; i++)
    if (turns == 4)
      turn_quarter(b);
    else
      turn_half(b);
  return any_black;
}

/* ---------------------------------------------------------------- is it the whole board */

/* Mean contrast beyond the next line on a side of the board, where the pattern would go on; the
 * lines are spaced as the last three are. NAN where that is outside the frame. */
static double beyond(const board *b, const hl_grey *grey, bool right, bool at_end)
{
  const int along = right ? b->rows : b->columns;
  const int last = at_end ? (right ? b->columns : b->rows) - 1 : 0;
  const int outward = at_end ? 1 : -1;
  double sum = 0;
  int n = 0;
  for (int i = 0; i < along; i++) {
    const double *p[3];
    for (int k = 0; k < 3; k++) {
      const int at = last - k * outward;
      p[k] = right ? point(b, at, i) : point(b, i, at);
    }
    hl_cross cross = cross_at(b, right ? last : i, right ? i : last);
    for (int axis = 0; axis < 2; axis++)
      cross.at[axis] = 3 * p[0][axis] - 3 * p[1][axis] + p[2][axis];
    if (!(cross.at[0] > 0 && cross.at[1] > 0 && cross.at[0] < grey->width - 1 &&
          cross.at[1] < grey->height - 1))
      continue;
    const bool odd = (last + outward + i) % 2 != 0;
    sum += (odd ? -1 : 1) * slant_of_side(grey, &cross, right, at_end);
    n++;
  }
  return n > 0 ? sum / n : NAN;
}

/* Does the pattern go on where the target ends? */
static bool is_larger(const board *b, const hl_grey *grey, char why[HL_REASON_MAX])
{
  const double own = first_slant(b, grey);
  int more[2] = {0, 0};
  for (int side = 0; side < 4; side++) {
    const double there = beyond(b, grey, side < 2, side % 2);
    if (!isnan(there) && there / own > goes_on)
      more[side / 2]++;
  }
  if (more[0] + more[1] == 0)
    return false;
  snprintf(why, HL_REASON_MAX,
           "the pattern goes on: at least %d x %d inner corners are seen; the target has %d x %d",
           b->columns + more[0], b->rows + more[1], b->columns, b->rows);
  return true;
}

static hl_status say_none(hl_ctx *ctx, const hl_target *target, const hl_opencv_bytes *image,
                          char why[HL_REASON_MAX])
{
  int columns = 0;
  int rows = 0;
  const hl_status st = hl_opencv_chessboard_size(ctx, image, &columns, &rows);
  if (st != HL_OK)
    return st;
  if (columns > 0)
    snprintf(why, HL_REASON_MAX,
             "no whole chessboard of %d x %d inner corners; one of about %d x %d is seen",
             target->columns, target->rows, columns > rows ? columns : rows,
             columns > rows ? rows : columns);
  else
    snprintf(why, HL_REASON_MAX,
             "no chessboard was found; the target has %d x %d inner corners, all must be seen",
             target->columns, target->rows);
  return HL_OK;
}

/* ---------------------------------------------------------------- the board */

static hl_status take_saddles(hl_ctx *ctx, const board *b, const hl_grey *grey, hl_corner *corner)
{
  const int n = b->columns * b->rows;
  hl_cross *cross = malloc((size_t)n * sizeof *cross);
  bool *moved = malloc((size_t)n * sizeof *moved);
  hl_status st = HL_OK;
  if (cross && moved) {
    for (int i = 0; i < n; i++) {
      cross[i] = cross_at(b, i % b->columns, i / b->columns);
      for (int axis = 0; axis < 2; axis++) {
        cross[i].across[axis] *= quarter;
        cross[i].down[axis] *= quarter;
      }
    }
    st = hl_saddles_refine(ctx, grey, cross, moved, n);
    for (int i = 0; st == HL_OK && i < n; i++)
      if (moved[i])
        corner[i] = (hl_corner){cross[i].at[0], cross[i].at[1], 1};
  } else {
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d corners", n);
  }
  free(cross);
  free(moved);
  return st;
}

static hl_status find(hl_ctx *ctx, const hl_target *target, hl_grey *grey, const board *b,
                      hl_corner *corner, hl_detection *detection, char why[HL_REASON_MAX])
{
  bool found = false;
  hl_grey_code_curved(grey);
  const hl_opencv_bytes image = {grey->width, grey->height, grey->stride, grey->code};
  hl_status st = hl_opencv_chessboard(ctx, &image, b->columns, b->rows, b->at, &found);
  if (st != HL_OK)
    return st;
  if (!found || !is_coherent(b, grey)) {
    st = say_none(ctx, target, &image, why);
    if (st == HL_OK)
      detection->blur_px = hl_frame_blur_say(grey, why);
    return st;
  }
  const bool black = settle_first(b, grey);
  if (is_larger(b, grey, why))
    return HL_OK;
  if (!black && b->columns % 2 != 0 && b->rows % 2 != 0 && b->columns != b->rows) {
    snprintf(why, HL_REASON_MAX,
             "the board is seen mirrored, or its first square is white: photograph it directly or "
             "flip the frames, or give it as %dx%d",
             b->rows, b->columns);
    return HL_OK;
  }
  return take_saddles(ctx, b, grey, corner);
}

hl_status hl_chessboard_find(hl_ctx *ctx, const hl_target *target, hl_grey *grey, hl_corner *corner,
                             hl_detection *detection, char why[HL_REASON_MAX])
{
  board b = {.columns = target->columns, .rows = target->rows};
  *detection = (hl_detection){0};
  why[0] = '\0';
  b.at = malloc((size_t)b.columns * (size_t)b.rows * sizeof *b.at);
  if (!b.at)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d x %d corners", b.columns, b.rows);
  const hl_status st = find(ctx, target, grey, &b, corner, detection, why);
  free(b.at);
  return st;
}
