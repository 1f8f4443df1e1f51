/*
 * How an AprilGrid's tags are numbered and turned, from the tags of one view.
 *
 * A tag's sides are a measure on the board around it: with e, f its sides along the board's x and y
 * and p = 1 + spacing ratio, the tag c columns to the right and r rows down lies p (c e + r f) away.
 * That tells the numberings apart, whatever the tags' ids: from the top left instead of the bottom
 * left turns r around, and tags that are printed turned turn e and f. Every pair of tags up to three
 * apart votes. Under one row alone both numberings explain the pairs; then Kalibr's is taken, and
 * under one column alone the one whose tags are upright.
 */
#include <math.h>
#include <stdlib.h>

#include "aprilgrid.h"

enum { REACH = 3, TURNS = 4, PAIRS_MIN = 4 };

static const double slack = 0.3; /* of a tag's pitch, a tag of distance: perspective and lens */

bool hl_grid_counts(const hl_target *target, const hl_tags *tags, int i)
{
  const int id = tags->tag[i].id;
  return !tags->tag[i].left_out && id < target->columns * target->rows &&
         (i == 0 || tags->tag[i - 1].id != id) && (i + 1 == tags->n || tags->tag[i + 1].id != id);
}

/* Sides of a tag along the board's x and y. */
static void sides(const hl_tag *tag, int turned, double e[2], double f[2])
{
  const double *at[4];
  for (int k = 0; k < 4; k++)
    at[k] = tag->corner[(k - turned + TURNS) % TURNS];
  for (int axis = 0; axis < 2; axis++) {
    e[axis] = (at[1][axis] - at[0][axis] + at[2][axis] - at[3][axis]) / 2;
    f[axis] = (at[3][axis] - at[0][axis] + at[2][axis] - at[1][axis]) / 2;
  }
}

/* d = a e + b f. False for a tag without area. */
static bool resolve(const double e[2], const double f[2], const double d[2], double *a, double *b)
{
  const double area = e[0] * f[1] - e[1] * f[0];
  if (!(fabs(area) > 1e-9))
    return false;
  *a = (d[0] * f[1] - d[1] * f[0]) / area;
  *b = (e[0] * d[1] - e[1] * d[0]) / area;
  return true;
}

typedef struct votes {
  int pairs, agreeing;
} votes;

/* The tag `other` as seen from `tag`. */
static void vote(const hl_target *target, const hl_tag *tag, const hl_tag *other, bool top_left,
                 int turned, votes *v)
{
  double e[2];
  double f[2];
  double from[2];
  double to[2];
  double a;
  double b;
  const int c = other->id % target->columns - tag->id % target->columns;
  const int up = other->id / target->columns - tag->id / target->columns;
  const int r = top_left ? up : -up;
  const int distance = abs(c) > abs(r) ? abs(c) : abs(r);
  if (distance > REACH)
    return;
  v->pairs++;
  sides(tag, turned, e, f);
  hl_tag_center(tag, from);
  hl_tag_center(other, to);
  const double d[2] = {to[0] - from[0], to[1] - from[1]};
  const double p = 1 + target->spacing_ratio;
  const double most = slack * p * distance;
  v->agreeing += resolve(e, f, d, &a, &b) && fabs(a - p * c) <= most && fabs(b - p * r) <= most;
}

/* All others as seen from tag i. */
static void vote_from(const hl_target *target, const hl_tags *tags, int i, bool top_left,
                      int turned, votes *v)
{
  if (!hl_grid_counts(target, tags, i))
    return;
  for (int k = 0; k < tags->n; k++)
    if (i != k && hl_grid_counts(target, tags, k))
      vote(target, &tags->tag[i], &tags->tag[k], top_left, turned, v);
}

static void vote_all(const hl_target *target, const hl_tags *tags, bool top_left, int turned,
                     votes *v)
{
  for (int i = 0; i < tags->n; i++)
    vote_from(target, tags, i, top_left, turned, v);
}

/* Kalibr's numbering first, and tags upright first: what comes later must explain more. */
hl_grid_layout hl_grid_layout_of(const hl_target *target, const hl_tags *tags)
{
  hl_grid_layout best = {.agreeing = -1};
  for (int turned = 0; turned < TURNS; turned++)
    for (int top_left = 0; top_left < 2; top_left++) {
      votes v = {0};
      vote_all(target, tags, top_left, turned, &v);
      if (v.agreeing > best.agreeing)
        best = (hl_grid_layout){
            .top_left_ids = top_left, .turned = turned, .pairs = v.pairs, .agreeing = v.agreeing};
    }
  return best;
}

void hl_grid_leave_out(const hl_target *target, const hl_grid_layout *layout, hl_tags *tags)
{
  for (;;) {
    double least = 0.5; /* of its pairs */
    int worst = -1;
    for (int i = 0; i < tags->n; i++) {
      votes v = {0};
      vote_from(target, tags, i, layout->top_left_ids, layout->turned, &v);
      if (v.pairs > 0 && v.agreeing < least * v.pairs) {
        least = (double)v.agreeing / v.pairs;
        worst = i;
      }
    }
    if (worst < 0)
      return;
    tags->tag[worst].left_out = true;
  }
}

int hl_grid_columns_of(const hl_target *target, const hl_tags *tags)
{
  int best = 0;
  double most = 0.8; /* of the pairs; fewer explain nothing */
  for (int columns = 2; columns <= HL_TARGET_SIDE_MAX; columns++) {
    hl_target other = *target;
    other.columns = columns;
    other.rows = HL_TARGET_TAGS_MAX / columns;
    const hl_grid_layout layout = hl_grid_layout_of(&other, tags);
    const double share = layout.pairs > 0 ? (double)layout.agreeing / layout.pairs : 0;
    if (layout.pairs >= PAIRS_MIN && share > most) {
      best = columns;
      most = share;
    }
  }
  return best;
}

int hl_grid_corner_index(const hl_target *target, const hl_grid_layout *layout, int id, int k)
{
  const int on_board = (k + layout->turned) % TURNS;
  const int column = id % target->columns;
  const int from_first = id / target->columns;
  const int row = layout->top_left_ids ? from_first : target->rows - 1 - from_first;
  const int right = on_board == 1 || on_board == 2;
  const int down = on_board >= 2;
  return (2 * row + down) * hl_target_corner_columns(target) + 2 * column + right;
}
