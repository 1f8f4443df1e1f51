/*
 * How well a view's corners lie on a plane, each compared with its neighbours.
 *
 * A window of 5 x 5 corners about each is mapped by a homography, and what that leaves, which is the
 * lens's doing, by a polynomial of third degree (second where few are seen). On exact corners of a
 * fisheye lens that sees 110 degrees, with a board across all of the frame, a homography alone leaves
 * 3 px (root mean square), and both 0.3.
 *
 * The gap g between tags, in sides of a tag, comes from the four corners a, b, c, d of two neighbours
 * on one line, whose cross ratio no perspective changes:
 *
 *   q = |ac| |bd| / (|bc| |ad|) = (1 + g)^2 / (g (2 + g)),   so   (1 + g)^2 = q / (q - 1)
 */
#include "board_fit.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "plane.h"
#include "spd.h"

enum {
  REACH = 2,
  WINDOW = (2 * REACH + 1) * (2 * REACH + 1),
  POINTS_MIN = 6,
  GAPS_MIN = 4,
  TERMS_MAX = 10
};

static bool is_seen(const hl_corner *c)
{
  return c->sigma > 0;
}

/* A corner and its neighbours. */
static int gather(const hl_target *target, const hl_corner *corner, int index,
                  double board[WINDOW][2], double pixel[WINDOW][2])
{
  const int columns = hl_target_corner_columns(target);
  const int rows = hl_target_corner_rows(target);
  int n = 0;
  for (int dy = -REACH; dy <= REACH; dy++)
    for (int dx = -REACH; dx <= REACH; dx++) {
      const int x = index % columns + dx;
      const int y = index / columns + dy;
      const int at = y * columns + x;
      double m[3];
      if (x < 0 || y < 0 || x >= columns || y >= rows || !is_seen(&corner[at]))
        continue;
      hl_target_corner(target, at, m);
      for (int k = 0; k < 2; k++)
        board[n][k] = m[k] / target->size_m;
      pixel[n][0] = corner[at].x;
      pixel[n][1] = corner[at].y;
      n++;
    }
  return n;
}

/* Powers of a place up to a degree; returns how many. */
static int powers(double u, double v, int degree, double out[TERMS_MAX])
{
  int n = 0;
  for (int sum = 0; sum <= degree; sum++)
    for (int k = 0; k <= sum; k++) {
      double term = 1;
      for (int i = 0; i < sum; i++)
        term *= i < k ? v : u;
      out[n++] = term;
    }
  return n;
}

/* Takes a polynomial off the errors, whose places are relative to the corner looked at; what is left
 * there goes to `out`. False where they do not determine it. */
static bool take_off(const double place[WINDOW][2], const double error[WINDOW][2], int n,
                     int degree, double out[2])
{
  double normal[TERMS_MAX * TERMS_MAX] = {0};
  double right[2][TERMS_MAX] = {{0}};
  double term[TERMS_MAX];
  hl_spd factor;
  int terms = 0;
  for (int i = 0; i < n; i++) {
    terms = powers(place[i][0], place[i][1], degree, term);
    for (int r = 0; r < terms; r++) {
      for (int c = 0; c < terms; c++)
        normal[r * terms + c] += term[r] * term[c];
      right[0][r] += term[r] * error[i][0];
      right[1][r] += term[r] * error[i][1];
    }
  }
  if (n <= terms || !hl_spd_factor(normal, terms, 0, &factor, NULL))
    return false;
  for (int k = 0; k < 2; k++) {
    hl_spd_solve(&factor, right[k], right[k]);
    out[k] -= right[k][0]; /* the place of the corner is (0, 0) */
  }
  return true;
}

/* In pixels; NAN where there is too little to compare with. */
static double residual(const hl_target *target, const hl_corner *corner, int index)
{
  double board[WINDOW][2];
  double pixel[WINDOW][2];
  double error[WINDOW][2];
  double m[3];
  hl_plane plane;
  const int n = gather(target, corner, index, board, pixel);
  if (n < POINTS_MIN ||
      !hl_plane_fit((const double(*)[2])board, (const double(*)[2])pixel, n, &plane))
    return NAN;
  hl_target_corner(target, index, m);
  double own[2] = {0, 0};
  for (int i = 0; i < n; i++) {
    double at[2];
    hl_plane_at(&plane, board[i], at);
    for (int k = 0; k < 2; k++) {
      error[i][k] = pixel[i][k] - at[k];
      board[i][k] = (board[i][k] - m[k] / target->size_m) / REACH;
    }
    if (board[i][0] == 0 && board[i][1] == 0)
      memcpy(own, error[i], sizeof own);
  }
  for (int degree = 3; degree >= 2; degree--)
    if (take_off((const double(*)[2])board, (const double(*)[2])error, n, degree, own))
      break;
  return hypot(own[0], own[1]);
}

hl_board_fit hl_board_fit_of(const hl_target *target, const hl_corner *corner)
{
  hl_board_fit fit = {.worst = -1};
  double sum = 0;
  int n = 0;
  for (int i = 0; i < hl_target_corners(target); i++) {
    if (!is_seen(&corner[i]))
      continue;
    fit.seen++;
    const double r = residual(target, corner, i);
    if (isnan(r))
      continue;
    sum += r * r;
    n++;
    if (fit.worst < 0 || r > fit.worst_px) {
      fit.worst_px = r;
      fit.worst = i;
    }
  }
  fit.rms_px = n > 0 ? sqrt(sum / n) : 0;
  return fit;
}

static double distance(const hl_corner *a, const hl_corner *b)
{
  return hypot(a->x - b->x, a->y - b->y);
}

/* Of four corners a step apart; 0 where they do not show it. */
static double gap_along(const hl_corner *first, int step)
{
  const hl_corner *p[4];
  for (int k = 0; k < 4; k++) {
    p[k] = first + k * step;
    if (!is_seen(p[k]))
      return 0;
  }
  const double q =
      distance(p[0], p[2]) * distance(p[1], p[3]) / (distance(p[1], p[2]) * distance(p[0], p[3]));
  return q > 1 ? sqrt(q / (q - 1)) - 1 : 0;
}

static int ascending(const void *a, const void *b)
{
  const double p = *(const double *)a;
  const double q = *(const double *)b;
  return (p > q) - (p < q);
}

double hl_board_spacing_ratio(const hl_target *target, const hl_corner *corner)
{
  double gap[4 * HL_TARGET_TAGS_MAX]; /* two a tag across, and two down */
  const int columns = hl_target_corner_columns(target);
  const int rows = hl_target_corner_rows(target);
  int n = 0;
  for (int i = 0; i < columns * rows; i++) {
    const int x = i % columns;
    const int y = i / columns;
    const double across = x % 2 == 0 && x + 3 < columns ? gap_along(&corner[i], 1) : 0;
    const double down = y % 2 == 0 && y + 3 < rows ? gap_along(&corner[i], columns) : 0;
    if (across > 0)
      gap[n++] = across;
    if (down > 0)
      gap[n++] = down;
  }
  if (n < GAPS_MIN)
    return 0;
  qsort(gap, (size_t)n, sizeof *gap, ascending);
  return gap[n / 2];
}

/* The corners of tag (column, row), clockwise from its top left. */
static void corners_of(const hl_target *target, int column, int row, int index[4])
{
  const int columns = hl_target_corner_columns(target);
  index[0] = 2 * row * columns + 2 * column;
  index[1] = index[0] + 1;
  index[2] = index[1] + columns;
  index[3] = index[0] + columns;
}

/* Mean of the sides whose ends are seen; 0 for none. */
static double side_of(const hl_corner *corner, const int index[4])
{
  double sum = 0;
  int n = 0;
  for (int k = 0; k < 4; k++) {
    const hl_corner *a = &corner[index[k]];
    const hl_corner *b = &corner[index[(k + 1) % 4]];
    if (!is_seen(a) || !is_seen(b))
      continue;
    sum += distance(a, b);
    n++;
  }
  return n > 0 ? sum / n : 0;
}

static double worst_of(const hl_target *target, const hl_corner *corner, const int index[4])
{
  double worst = 0;
  for (int k = 0; k < 4; k++)
    if (is_seen(&corner[index[k]])) {
      const double r = residual(target, corner, index[k]);
      worst = r > worst ? r : worst;
    }
  return worst;
}

int hl_board_prune(const hl_target *target, hl_corner *corner, double limit_px, double limit_side,
                   int most)
{
  for (int removed = 0;; removed++) {
    double farthest = 1;
    int tag = -1;
    int index[4];
    for (int i = 0; i < target->columns * target->rows; i++) {
      corners_of(target, i % target->columns, i / target->columns, index);
      const double limit = limit_px + limit_side * side_of(corner, index);
      const double over = worst_of(target, corner, index) / limit;
      if (over > farthest) {
        farthest = over;
        tag = i;
      }
    }
    if (tag < 0 || removed == most)
      return removed;
    corners_of(target, tag % target->columns, tag / target->columns, index);
    for (int k = 0; k < 4; k++)
      corner[index[k]] = (hl_corner){0, 0, 0};
  }
}
