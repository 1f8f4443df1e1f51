/*
 * A target in a frame: found, then judged.
 *
 * A view is left out with a reason where its corners would harm a calibration more than they help:
 * too few of them; corners that no plane explains; a blur that reaches into the surroundings of the
 * corners, so that their saddles are not their own.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "aprilgrid.h"
#include "board_fit.h"
#include "chessboard.h"
#include "edge_blur.h"

enum { CORNERS_MIN = 8 }; /* a plane takes 4; as many again can contradict it */

static const double fit_px = 0.5; /* root mean square off the plane, */
static const double fit_side =
    0.05; /* and the same in sides of a tag or square; wide lenses reach 0.04 */
static const double blur_tag = 0.28;    /* of the narrower of a tag's border and the gap, */
static const double blur_square = 0.14; /* and of a square's side: there the error is 0.15 px */
static const double blur_free = 0.8;    /* px that are never too much */
static const double grid = 1e6; /* places are kept in millionths, which a .vnl holds exactly */

/* ---------------------------------------------------------------- blur */

static int ascending(const void *a, const void *b)
{
  const double p = *(const double *)a;
  const double q = *(const double *)b;
  return (p > q) - (p < q);
}

/* How far beside an edge nothing else is, in its length. */
static double plain_beside(const hl_target *target, int border_bits)
{
  if (target->kind == HL_TARGET_CHESSBOARD)
    return 1;
  return fmin((double)border_bits / (HL_TARGET_TAG_CELLS + 2 * border_bits), target->spacing_ratio);
}

/* The most that is accepted, in sides of a tag or square. */
static double blur_most(const hl_target *target, int border_bits)
{
  const double plain = plain_beside(target, border_bits);
  return target->kind == HL_TARGET_CHESSBOARD ? blur_square * plain : blur_tag * plain;
}

typedef struct blur {
  double px;   /* median */
  double side; /* median length of the edges */
} blur;

static double median(double *value, int n)
{
  if (n == 0)
    return 0;
  qsort(value, (size_t)n, sizeof *value, ascending);
  return value[n / 2];
}

static void measure_edge(const hl_grey *grey, const hl_corner *a, const hl_corner *b, double plain,
                         double *blurs, double *sides, int *n_blurs, int *n_sides)
{
  const double p[2] = {a->x, a->y};
  const double q[2] = {b->x, b->y};
  const double length = hypot(q[0] - p[0], q[1] - p[1]);
  const double px = hl_edge_blur(grey, p, q, 0.8 * plain * length);
  sides[(*n_sides)++] = length;
  if (!isnan(px))
    blurs[(*n_blurs)++] = px;
}

static hl_status measure(hl_ctx *ctx, const hl_target *target, const hl_grey *grey,
                         const hl_corner *corner, int border_bits, blur *out)
{
  const int columns = hl_target_corner_columns(target);
  const int rows = hl_target_corner_rows(target);
  const bool tags = target->kind == HL_TARGET_APRILGRID;
  const double plain = plain_beside(target, border_bits);
  const size_t room = 2 * (size_t)columns * (size_t)rows;
  double *values = malloc(2 * room * sizeof *values);
  if (!values)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %zu edges", room);
  double *sides = values + room;
  int n_blurs = 0;
  int n_sides = 0;
  for (int i = 0; i < columns * rows; i++) {
    const int x = i % columns;
    const int y = i / columns;
    if (!(corner[i].sigma > 0))
      continue;
    if (x + 1 < columns && corner[i + 1].sigma > 0 && !(tags && x % 2))
      measure_edge(grey, &corner[i], &corner[i + 1], plain, values, sides, &n_blurs, &n_sides);
    if (y + 1 < rows && corner[i + columns].sigma > 0 && !(tags && y % 2))
      measure_edge(grey, &corner[i], &corner[i + columns], plain, values, sides, &n_blurs,
                   &n_sides);
  }
  *out = (blur){.px = median(values, n_blurs), .side = median(sides, n_sides)};
  free(values);
  return HL_OK;
}

/* ---------------------------------------------------------------- verdict */

static int count(const hl_target *target, const hl_corner *corner)
{
  int n = 0;
  for (int i = 0; i < hl_target_corners(target); i++)
    n += corner[i].sigma > 0;
  return n;
}

static hl_status judge(hl_ctx *ctx, const hl_target *target, const hl_grey *grey,
                       const hl_corner *corner, hl_detection *detection, char why[HL_REASON_MAX])
{
  blur b = {0};
  if (count(target, corner) == 0) {
    snprintf(why, HL_REASON_MAX, "the board was found, but none of its corners is clear");
    return HL_OK;
  }
  const hl_status st = measure(ctx, target, grey, corner, detection->border_bits, &b);
  if (st != HL_OK)
    return st;
  detection->blur_px = b.px;
  const double blur_limit = fmax(blur_free, blur_most(target, detection->border_bits) * b.side);
  const hl_board_fit fit = hl_board_fit_of(target, corner);
  const double fit_limit = fit_px + fit_side * b.side;
  if (b.px > blur_limit)
    snprintf(why, HL_REASON_MAX,
             "the board is blurred by %.1f px; up to %.1f are accepted at its size in the frame",
             b.px, blur_limit);
  else if (fit.seen < CORNERS_MIN)
    snprintf(why, HL_REASON_MAX, "%d corner%s seen; at least %d are needed", fit.seen,
             fit.seen == 1 ? "" : "s", CORNERS_MIN);
  else if (!(fit.rms_px <= fit_limit))
    snprintf(why, HL_REASON_MAX,
             "the corners fit no plane seen by a camera: they are %.1f px from where their "
             "neighbours have them; up to %.1f are accepted",
             fit.rms_px, fit_limit);
  return HL_OK;
}

static void settle(const hl_frame *frame, hl_corner *corner, int n)
{
  for (int i = 0; i < n; i++) {
    hl_corner *c = &corner[i];
    const bool inside =
        c->x >= 0 && c->y >= 0 && c->x <= frame->width - 1 && c->y <= frame->height - 1;
    if (c->sigma > 0 && inside)
      *c = (hl_corner){rint(c->x * grid) / grid, rint(c->y * grid) / grid, c->sigma};
    else
      *c = (hl_corner){0, 0, 0};
  }
}

/* ---------------------------------------------------------------- the frame */

static hl_status look(hl_ctx *ctx, const hl_target *target, const hl_frame *frame,
                      hl_corner *corner, hl_detection *detection, char why[HL_REASON_MAX])
{
  hl_grey grey = {0};
  hl_status st = hl_grey_of(ctx, frame, &grey);
  *detection = (hl_detection){0};
  if (st == HL_OK)
    st = target->kind == HL_TARGET_APRILGRID
             ? hl_aprilgrid_find(ctx, target, &grey, corner, detection, why)
             : hl_chessboard_find(ctx, target, &grey, corner, detection, why);
  if (st == HL_OK)
    settle(frame, corner, hl_target_corners(target));
  if (st == HL_OK && why[0] == '\0')
    st = judge(ctx, target, &grey, corner, detection, why);
  hl_grey_free(&grey);
  return st;
}

static hl_status check_size(hl_ctx *ctx, const hl_corners *corners, const hl_frame *frame,
                            const char *name)
{
  if (frame->width < 2 || frame->height < 2)
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: %d x %d pixels; at least 2 x 2 are needed", name,
                   frame->width, frame->height);
  if (corners->width == 0 || (corners->width == frame->width && corners->height == frame->height))
    return HL_OK;
  return hl_fail(ctx, HL_ERR_FORMAT,
                 "%s: %d x %d pixels; the frames before have %d x %d, and one camera has one size",
                 name, frame->width, frame->height, corners->width, corners->height);
}

hl_status hl_corners_detect(hl_ctx *ctx, hl_corners *corners, const hl_frame *frame,
                            const char *name, hl_detection *detection)
{
  hl_status st = check_size(ctx, corners, frame, name);
  if (st != HL_OK)
    return st;
  char why[HL_REASON_MAX] = "";
  hl_detection saw = {0};
  hl_view *view = NULL;
  const int n = hl_target_corners(&corners->target);
  hl_corner *corner = calloc((size_t)n, sizeof *corner);
  if (!corner)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %d corners", name, n);
  st = look(ctx, &corners->target, frame, corner, &saw, why);
  if (st == HL_OK)
    st = hl_corners_add(ctx, corners, name, &view);
  if (st == HL_OK) {
    memcpy(view->corner, corner, (size_t)n * sizeof *corner);
    memcpy(view->why, why, sizeof why);
    view->seen = count(&corners->target, corner);
    view->used = why[0] == '\0';
    corners->width = frame->width;
    corners->height = frame->height;
    if (detection)
      *detection = saw;
  }
  free(corner);
  return st;
}
