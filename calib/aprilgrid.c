/*
 * An AprilGrid in a frame.
 *
 * Kalibr's boards have a black square at every corner of a tag, so that the corner is a saddle:
 * cornerSubPix finds it on the linear plane (saddle.c). A corner of a tag that stands alone is where
 * two edges meet; cornerSubPix draws it inwards, by 0.16 .. 0.34 px at a blur of 0.5 .. 1, while
 * AprilTag's refined edges on the linear plane are off by 0.05 .. 0.1 and without bias. So a view is
 * taken for one kind or the other by its quarters, and its corners come from the better method.
 * Tags that only the curved code shows have edges drawn inwards by the blur: they count little.
 *
 * A tag read in a mirror is no tag of the family. Where nothing is found, the frame is turned left to
 * right; if that shows tags, the board was seen mirrored.
 */
#include "aprilgrid.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "board_fit.h"
#include "frame_blur.h"
#include "halflight/bridge_opencv_corners.h"
#include "saddle.h"

enum { PRUNED_MAX = 20, TAGS_MIN = 2 };

static const double agreeing_least = 0.7; /* share of the pairs of tags */
static const double ratio_slack = 0.03;   /* of a tag's side */
static const double curved_sigma = 8;     /* measured: 0.35 .. 0.7 px against 0.05 .. 0.1 */
static const double off_px = 1.5;         /* a tag's corners, from where its neighbours have it, */
static const double off_side = 0.08; /* and the same in sides of the tag; wide lenses reach 0.07 */
static const double white_headroom = 1.15; /* noise above white must not be cut off */

typedef struct search {
  hl_ctx *ctx;
  const hl_target *target;
  hl_grey *grey;
  hl_tag_finder *finder;
  hl_tags tags;
  hl_grid_layout layout;
  double free; /* how far a corner's quarters reach, in sides of the tag */
} search;

/* ---------------------------------------------------------------- what is said of a bad view */

static int counting(const search *f)
{
  int n = 0;
  for (int i = 0; i < f->tags.n; i++)
    n += hl_grid_counts(f->target, &f->tags, i);
  return n;
}

static void say_tags(const search *f, const char *what, char why[HL_REASON_MAX])
{
  const int due = f->target->columns * f->target->rows;
  if (f->tags.n == 0)
    snprintf(why, HL_REASON_MAX, "no tag of family tag36h11 was found; the target has %d", due);
  else
    snprintf(why, HL_REASON_MAX, "saw %d tag%s of this family, ids %d .. %d; the target has %d%s",
             f->tags.n, f->tags.n == 1 ? "" : "s", f->tags.tag[0].id, f->tags.tag[f->tags.n - 1].id,
             due, what);
}

static void say_layout(const search *f, char why[HL_REASON_MAX])
{
  char what[80];
  const int columns = hl_grid_columns_of(f->target, &f->tags);
  if (columns > 0)
    snprintf(what, sizeof what, " in %d columns, but these lie as in %d", f->target->columns,
             columns);
  else
    snprintf(what, sizeof what, ", and these do not lie as its %d columns do", f->target->columns);
  say_tags(f, what, why);
}

/* Too few tags: is the board mirrored, there twice, or another one? */
static hl_status say_few(search *f, hl_detection *detection, char why[HL_REASON_MAX])
{
  hl_tags mirrored = {0};
  if (f->tags.n >= TAGS_MIN) {
    const bool foreign = f->tags.tag[f->tags.n - 1].id >= f->target->columns * f->target->rows;
    say_tags(f, foreign ? "" : ", each once", why);
    return HL_OK;
  }
  hl_grey_code_curved(f->grey);
  hl_grey_mirror(f->grey);
  hl_status st = hl_tags_find(f->ctx, f->finder, f->grey, HL_TAG_EDGES_FOUND, &mirrored);
  if (st == HL_OK && mirrored.n < TAGS_MIN) {
    hl_tags_free(&mirrored);
    hl_grey_widen(f->grey);
    st = hl_tags_find(f->ctx, f->finder, f->grey, HL_TAG_EDGES_FOUND, &mirrored);
  }
  if (st != HL_OK)
    return st;
  if (mirrored.n >= TAGS_MIN) {
    snprintf(why, HL_REASON_MAX,
             "the board is seen mirrored: photograph it directly, not through a mirror, or flip "
             "the frames");
  } else {
    say_tags(f, "", why);
    detection->blur_px = hl_frame_blur_say(f->grey, why);
  }
  hl_tags_free(&mirrored);
  return HL_OK;
}

/* ---------------------------------------------------------------- corners */

static bool same_place(const hl_tag *a, const hl_tag *b)
{
  double p[2];
  double q[2];
  hl_tag_center(a, p);
  hl_tag_center(b, q);
  return hypot(p[0] - q[0], p[1] - q[1]) < hl_tag_side(a) / 2;
}

static void put_tag(const search *f, const hl_tag *tag, double sigma, hl_corner *corner)
{
  for (int k = 0; k < 4; k++)
    corner[hl_grid_corner_index(f->target, &f->layout, tag->id, k)] =
        (hl_corner){tag->corner[k][0], tag->corner[k][1], sigma};
}

/* Corner k with its surroundings: `across` towards the tag's next corner, `down` to the one before.
 * The first and third quarter are then the tag's own and the one beyond the corner. */
static hl_cross cross_of(const search *f, const hl_tag *tag, int k)
{
  const double *at = tag->corner[k];
  const double *next = tag->corner[(k + 1) % 4];
  const double *before = tag->corner[(k + 3) % 4];
  hl_cross cross;
  for (int axis = 0; axis < 2; axis++) {
    cross.at[axis] = at[axis];
    cross.across[axis] = f->free * (next[axis] - at[axis]);
    cross.down[axis] = f->free * (before[axis] - at[axis]);
  }
  return cross;
}

/* Is the quarter beyond the tag as black as the tag? *white gets the lighter of the two others. */
static bool is_saddle(const search *f, const hl_cross *cross, double *white)
{
  double q[4];
  hl_cross_quarters(f->grey, cross, q);
  const double darker = fmin(q[1], q[3]);
  *white = fmax(q[1], q[3]);
  return darker > q[2] && q[0] - q[2] < 0.4 * (darker - q[2]);
}

/* All crosses of the tags that count, and which of them are saddles. Returns how many crosses. */
static int crosses_of(const search *f, hl_cross *cross, bool *saddle, int *index, double *white)
{
  int n = 0;
  *white = 0;
  for (int i = 0; i < f->tags.n; i++) {
    const hl_tag *tag = &f->tags.tag[i];
    if (!hl_grid_counts(f->target, &f->tags, i))
      continue;
    for (int k = 0; k < 4; k++, n++) {
      double here;
      cross[n] = cross_of(f, tag, k);
      saddle[n] = is_saddle(f, &cross[n], &here);
      index[n] = hl_grid_corner_index(f->target, &f->layout, tag->id, k);
      *white = fmax(*white, here);
    }
  }
  return n;
}

static hl_status take_saddles(const search *f, hl_cross *cross, bool *saddle, const int *index,
                              int n, hl_corner *corner)
{
  int m = 0;
  int *place = malloc(((size_t)n + 1) * sizeof *place);
  if (!place)
    return hl_fail(f->ctx, HL_ERR_MEMORY, "no memory for %d corners", n);
  for (int i = 0; i < n; i++)
    if (saddle[i]) {
      cross[m] = cross[i];
      place[m++] = index[i];
    }
  const hl_status st = hl_saddles_refine(f->ctx, f->grey, cross, saddle, m);
  for (int i = 0; st == HL_OK && i < m; i++)
    if (saddle[i])
      corner[place[i]] = (hl_corner){cross[i].at[0], cross[i].at[1], 1};
  free(place);
  return st;
}

/* Tags of the linear code; those that it does not show keep the curved code's edges. */
static hl_status take_edges(const search *f, double white, hl_corner *corner)
{
  hl_tags linear = {0};
  hl_grey_code_linear(f->grey, (float)(white_headroom * white));
  const hl_status st = hl_tags_find(f->ctx, f->finder, f->grey, HL_TAG_EDGES_REFINED, &linear);
  for (int i = 0; st == HL_OK && i < f->tags.n; i++) {
    const hl_tag *tag = &f->tags.tag[i];
    if (!hl_grid_counts(f->target, &f->tags, i))
      continue;
    put_tag(f, tag, curved_sigma, corner);
    for (int k = 0; k < linear.n; k++)
      if (linear.tag[k].id == tag->id && same_place(tag, &linear.tag[k]))
        put_tag(f, &linear.tag[k], 1, corner);
  }
  hl_tags_free(&linear);
  return st;
}

static hl_status take_corners(search *f, hl_corner *corner)
{
  const size_t room = 4 * (size_t)f->tags.n + 1;
  hl_cross *cross = malloc(room * sizeof *cross);
  bool *saddle = malloc(room * sizeof *saddle);
  int *index = malloc(room * sizeof *index);
  hl_status st = HL_OK;
  if (cross && saddle && index) {
    double white;
    int saddles = 0;
    const int n = crosses_of(f, cross, saddle, index, &white);
    for (int i = 0; i < n; i++)
      saddles += saddle[i];
    st = 2 * saddles > n && hl_opencv_has_saddles()
             ? take_saddles(f, cross, saddle, index, n, corner)
             : take_edges(f, white, corner);
  } else {
    st = hl_fail(f->ctx, HL_ERR_MEMORY, "no memory for %d tags", f->tags.n);
  }
  free(cross);
  free(saddle);
  free(index);
  return st;
}

/* ---------------------------------------------------------------- the board */

/* Does the gap that the corners show differ from the target's? */
static bool is_spaced_otherwise(const search *f, const hl_corner *corner, char why[HL_REASON_MAX])
{
  const double ratio = hl_board_spacing_ratio(f->target, corner);
  if (ratio == 0 || fabs(ratio - f->target->spacing_ratio) <= ratio_slack)
    return false;
  snprintf(why, HL_REASON_MAX,
           "the tags are %.2f of a tag apart; the target's spacing ratio is %.4g", ratio,
           f->target->spacing_ratio);
  return true;
}

static hl_status find(search *f, hl_corner *corner, hl_detection *detection,
                      char why[HL_REASON_MAX])
{
  const int due = f->target->columns * f->target->rows;
  hl_status st = hl_tags_search(f->ctx, f->finder, f->grey, due, &f->tags);
  if (st != HL_OK)
    return st;
  detection->tags = f->tags.n;
  detection->border_bits = f->tags.border_bits;
  for (int i = 0; i < f->tags.n; i++)
    detection->foreign += f->tags.tag[i].id >= due;
  if (counting(f) < TAGS_MIN)
    return say_few(f, detection, why);
  f->layout = hl_grid_layout_of(f->target, &f->tags);
  detection->top_left_ids = f->layout.top_left_ids;
  if (f->layout.agreeing < agreeing_least * f->layout.pairs) {
    say_layout(f, why);
    return HL_OK;
  }
  hl_grid_leave_out(f->target, &f->layout, &f->tags);
  const double border =
      (double)f->tags.border_bits / (HL_TARGET_TAG_CELLS + 2 * f->tags.border_bits);
  f->free = fmin(border, f->target->spacing_ratio);
  st = take_corners(f, corner);
  if (st == HL_OK && !is_spaced_otherwise(f, corner, why)) {
    const int most = counting(f) / 3;
    hl_board_prune(f->target, corner, off_px, off_side, most < PRUNED_MAX ? most : PRUNED_MAX);
  }
  return st;
}

hl_status hl_aprilgrid_find(hl_ctx *ctx, const hl_target *target, hl_grey *grey, hl_corner *corner,
                            hl_detection *detection, char why[HL_REASON_MAX])
{
  search f = {.ctx = ctx, .target = target, .grey = grey};
  *detection = (hl_detection){0};
  why[0] = '\0';
  hl_status st = hl_tag_finder_new(ctx, &f.finder);
  if (st == HL_OK)
    st = find(&f, corner, detection, why);
  hl_tag_finder_free(f.finder);
  hl_tags_free(&f.tags);
  return st;
}
