/* Tags of family tag36h11 in an 8-bit image. */
#ifndef HL_TAGS_H
#define HL_TAGS_H

#include <stdbool.h>

#include "grey.h"
#include "halflight/status.h"

/* Corners of a tag's black square, as it is printed upright: top left, top right, bottom right,
 * bottom left. Pixels; (0,0) is the centre of the top-left one. */
typedef struct hl_tag {
  int id;
  bool left_out; /* false as it is found; others may set it */
  double corner[4][2];
} hl_tag;

/* For qsort: by id, then by place. */
static inline int hl_tag_order(const void *a, const void *b)
{
  const hl_tag *p = a;
  const hl_tag *q = b;
  for (int i = 0; p->id == q->id && i < 8; i++) {
    const double x = p->corner[i / 2][i % 2], y = q->corner[i / 2][i % 2];
    if (x < y || x > y)
      return x < y ? -1 : 1;
  }
  return p->id - q->id;
}

/* Owner of `tag`; hl_tags_free releases it. */
typedef struct hl_tags {
  int n;
  int border_bits; /* 1 or 2; 0 where there are none */
  hl_tag *tag;     /* by id, then by place */
} hl_tags;

enum { HL_TAGS_SIDE_MAX = 32767 };

/* AprilTag's detector with its tables, which take longer to make than a small frame to search. One a
 * thread. */
typedef struct hl_tag_finder hl_tag_finder;

/* HL_OK; HL_ERR_UNAVAILABLE without AprilTag; HL_ERR_MEMORY. *out is the caller's
 * (hl_tag_finder_free). */
hl_status hl_tag_finder_new(hl_ctx *ctx, hl_tag_finder **out);
void hl_tag_finder_free(hl_tag_finder *finder);

/* Where a tag's corners are said to be. */
typedef enum hl_tag_edges {
  HL_TAG_EDGES_FOUND,  /* on the border between black and white, to about half a pixel */
  HL_TAG_EDGES_REFINED /* on the steepest place across each edge; now and then of another edge */
} hl_tag_edges;

/*
 * Find the tags in grey->code whose black border is one bit wide, or two as Kalibr's: whichever it
 * shows more of. AprilTag 3.3.0 writes past an array of its own in images under HL_GREY_SIDE_MIN
 * pixels a side, so grey->code is never smaller. While it searches, the process's standard error is
 * held back. HL_OK, also for none; HL_ERR_FORMAT (over HL_TAGS_SIDE_MAX); HL_ERR_MEMORY.
 */
hl_status hl_tags_find(hl_ctx *ctx, hl_tag_finder *finder, const hl_grey *grey, hl_tag_edges edges,
                       hl_tags *out);

/*
 * The same with all means until tags 0 .. enough - 1 are found; leaves grey->code overwritten. Black
 * squares that touch a tag's corners, as on Kalibr's boards, may run into it; where tags are missing,
 * white grows by a pixel, twice, and what is found then is added. Those corners are off by up to
 * three pixels. Returns as hl_tags_find.
 */
hl_status hl_tags_search(hl_ctx *ctx, hl_tag_finder *finder, hl_grey *grey, int enough,
                         hl_tags *out);

/* Middle of a tag's corners. */
void hl_tag_center(const hl_tag *tag, double out[2]);

/* Mean length of a tag's sides. */
double hl_tag_side(const hl_tag *tag);

void hl_tags_free(hl_tags *tags);

#endif
