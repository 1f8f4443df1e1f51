/*
 * Every tag of a frame, by as many passes as it takes.
 *
 * On the photos of a Kalibr board of 36 tags by a telephone, 3072 x 4080 px, AprilTag alone finds 14,
 * 1, 6, 3 and 0 tags; with white grown by a pixel 36, 36, 36, 36 and 21, which are all. Small tags
 * are lost that way, and edges move by what grew, so the passes are joined.
 */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "tags.h"

enum { PASSES = 3 };

void hl_tag_center(const hl_tag *tag, double out[2])
{
  for (int axis = 0; axis < 2; axis++)
    out[axis] = (tag->corner[0][axis] + tag->corner[1][axis] + tag->corner[2][axis] +
                 tag->corner[3][axis]) /
                4;
}

double hl_tag_side(const hl_tag *tag)
{
  double sum = 0;
  for (int k = 0; k < 4; k++) {
    const double *a = tag->corner[k];
    const double *b = tag->corner[(k + 1) % 4];
    sum += hypot(a[0] - b[0], a[1] - b[1]) / 4;
  }
  return sum;
}

void hl_tags_free(hl_tags *tags)
{
  free(tags->tag);
  *tags = (hl_tags){0};
}

/* Different ids in 0 .. enough - 1. */
static int distinct(const hl_tags *tags, int enough)
{
  int n = 0;
  for (int i = 0; i < tags->n; i++)
    n += tags->tag[i].id < enough && (i == 0 || tags->tag[i].id != tags->tag[i - 1].id);
  return n;
}

/* Is the same tag, and not another of the same id, there already? */
static bool has(const hl_tags *tags, const hl_tag *tag)
{
  double a[2];
  double b[2];
  hl_tag_center(tag, a);
  for (int i = 0; i < tags->n; i++) {
    if (tags->tag[i].id != tag->id)
      continue;
    hl_tag_center(&tags->tag[i], b);
    if (hypot(a[0] - b[0], a[1] - b[1]) < hl_tag_side(tag) / 2)
      return true;
  }
  return false;
}

/* Adds what is new; takes over `more`. */
static hl_status join(hl_ctx *ctx, hl_tags *tags, hl_tags *more)
{
  if (more->border_bits != tags->border_bits) {
    if (more->n > tags->n) {
      hl_tags_free(tags);
      *tags = *more;
    } else {
      hl_tags_free(more);
    }
    return HL_OK;
  }
  hl_tag *tag = realloc(tags->tag, (size_t)(tags->n + more->n + 1) * sizeof *tag);
  if (!tag) {
    hl_tags_free(more);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d tags", tags->n + more->n);
  }
  tags->tag = tag;
  const hl_tags before = *tags;
  for (int i = 0; i < more->n; i++)
    if (!has(&before, &more->tag[i]))
      tags->tag[tags->n++] = more->tag[i];
  qsort(tags->tag, (size_t)tags->n, sizeof *tags->tag, hl_tag_order);
  hl_tags_free(more);
  return HL_OK;
}

hl_status hl_tags_search(hl_ctx *ctx, hl_tag_finder *finder, hl_grey *grey, int enough,
                         hl_tags *out)
{
  hl_tags tags = {0};
  hl_grey_code_curved(grey);
  hl_status st = hl_tags_find(ctx, finder, grey, HL_TAG_EDGES_FOUND, &tags);
  for (int pass = 1; st == HL_OK && pass < PASSES && distinct(&tags, enough) < enough; pass++) {
    hl_tags more = {0};
    hl_grey_widen(grey);
    st = hl_tags_find(ctx, finder, grey, HL_TAG_EDGES_FOUND, &more);
    if (st == HL_OK)
      st = join(ctx, &tags, &more);
  }
  if (st == HL_OK)
    *out = tags;
  else
    hl_tags_free(&tags);
  return st;
}
