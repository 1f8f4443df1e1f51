/* How well a view's corners lie on a plane, each compared with its neighbours. */
#ifndef HL_BOARD_FIT_H
#define HL_BOARD_FIT_H

#include "halflight/corners.h"

typedef struct hl_board_fit {
  int seen;
  double rms_px; /* over the corners seen; 0 where nothing can be compared */
  double worst_px;
  int worst; /* its index; -1 for none */
} hl_board_fit;

/*
 * The distance of every corner seen from where a plane through it and its neighbours, up to two
 * columns and rows away, has it under a smooth lens. A wrong corner stands out, though it draws its
 * neighbours a little. O(corners).
 */
hl_board_fit hl_board_fit_of(const hl_target *target, const hl_corner *corner);

/* The gap between an AprilGrid's tags in sides of a tag, as its corners show it under any
 * perspective; 0 where too few neighbours are seen. */
double hl_board_spacing_ratio(const hl_target *target, const hl_corner *corner);

/*
 * Leave out the tags of an AprilGrid of which a corner is off by more than `limit_px` plus
 * `limit_side` of the tag's side, the worst first. Returns how many; stops after `most`.
 */
int hl_board_prune(const hl_target *target, hl_corner *corner, double limit_px, double limit_side,
                   int most);

#endif
