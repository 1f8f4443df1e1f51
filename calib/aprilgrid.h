/* An AprilGrid in a frame: which tag is where on the board, and its corners. */
#ifndef HL_APRILGRID_H
#define HL_APRILGRID_H

#include "grey.h"
#include "halflight/corners.h"
#include "tags.h"

/* How a board's tags are numbered and turned, as a view's tags have it. */
typedef struct hl_grid_layout {
  bool top_left_ids; /* ids from the top left instead of Kalibr's bottom left */
  int turned;        /* quarters clockwise, of every tag on the board */
  int pairs;         /* of neighbours that were looked at, */
  int agreeing;      /* and of those, pairs that lie as they should */
} hl_grid_layout;

/* Of ids that are there once and on the target. Columns are those of the target. */
hl_grid_layout hl_grid_layout_of(const hl_target *target, const hl_tags *tags);

/* Leave out the tags that most of their neighbours have elsewhere, the worst first. */
void hl_grid_leave_out(const hl_target *target, const hl_grid_layout *layout, hl_tags *tags);

/* Columns under which most pairs agree, whatever the target says; 0 where none explains them. */
int hl_grid_columns_of(const hl_target *target, const hl_tags *tags);

/* Is tag `i` the only one of its id, that one of the target's, and not left out? */
bool hl_grid_counts(const hl_target *target, const hl_tags *tags, int i);

/* Place of a tag's corner k (clockwise from the printed top left) in board order. */
int hl_grid_corner_index(const hl_target *target, const hl_grid_layout *layout, int id, int k);

/*
 * Find the board. `corner`, shape (hl_target_corners), all zero before, and `detection` are filled;
 * `why` gets a reason where the view is of no use, "" otherwise. Leaves grey->code overwritten.
 * HL_OK; HL_ERR_FORMAT (frame too large for AprilTag); HL_ERR_UNAVAILABLE; HL_ERR_MEMORY.
 */
hl_status hl_aprilgrid_find(hl_ctx *ctx, const hl_target *target, hl_grey *grey, hl_corner *corner,
                            hl_detection *detection, char why[HL_REASON_MAX]);

#endif
