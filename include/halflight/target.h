/**
 * Calibration targets: what is printed, and where its corners are.
 *
 * Board frame: origin at the first corner, x along a row to the right, y down the rows, z into the
 * board, as it is read from the front. Corners are counted row by row. A chessboard of COLS x ROWS
 * has as many inner corners. An AprilGrid of COLS x ROWS tags has 2 COLS x 2 ROWS corners, the
 * outer corners of the tags' black squares; tags of size TAG are TAG x SPACING_RATIO apart.
 *
 * AprilGrids are Kalibr's: family tag36h11, ids row by row from the bottom left. A grid whose ids
 * begin at the top left is accepted where it is seen (calib/aprilgrid_layout.c). A chessboard's first
 * square, up left of its first corner, is black.
 */
#ifndef HALFLIGHT_TARGET_H
#define HALFLIGHT_TARGET_H

#include <stdbool.h>

#include "halflight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What is printed on a board. */
typedef enum hl_target_kind { HL_TARGET_APRILGRID, HL_TARGET_CHESSBOARD } hl_target_kind;

/** A printed board. */
typedef struct hl_target {
  hl_target_kind kind;
  int columns, rows;    /* tags, or inner corners */
  double size_m;        /* side of a tag's black square, or of a chessboard's square */
  double spacing_ratio; /* gap between tags over size_m; 0 for a chessboard */
} hl_target;

enum {
  HL_TARGET_SIDE_MAX = 64,      /* columns, rows */
  HL_TARGET_TAGS_MAX = 587,     /* family tag36h11 has no more */
  HL_TARGET_TAG_CELLS = 6,      /* of a tag's code, along each side */
  HL_TARGET_CHESSBOARD_MIN = 3, /* inner corners along each side */
  HL_TARGET_SPEC_MAX = 80
};

/** Bounds of a tag's or a square's side. */
#define HL_TARGET_SIZE_MIN_M 1e-5
#define HL_TARGET_SIZE_MAX_M 100.0 /**< the largest */
/** Bounds of the gap between tags, relative to the tag's side. */
#define HL_TARGET_RATIO_MIN 0.01
#define HL_TARGET_RATIO_MAX 10.0 /**< the largest */

/**
 * Check a target against the bounds above.
 * @return HL_OK; HL_ERR_ARG naming the member, its value and what would be accepted
 */
HL_API hl_status hl_target_check(hl_ctx *ctx, const hl_target *target);

/**
 * Parse `aprilgrid:COLSxROWS:TAG_M:SPACING_RATIO` or `chessboard:COLSxROWS:SQUARE_M`. Numbers are
 * decimal, as 0.03 or 3e-2, their mark a point whatever the locale.
 * @return HL_OK; HL_ERR_ARG saying which part, its value and what would be accepted
 */
HL_API hl_status hl_target_parse(hl_ctx *ctx, const char *spec, hl_target *out);

/** The spec as hl_target_parse reads it. Returns `text`. */
HL_API const char *hl_target_spec(const hl_target *target, char text[HL_TARGET_SPEC_MAX]);

/** Corners along x and along y, and all of them. */
HL_API int hl_target_corner_columns(const hl_target *target);
/** Rows of its corners. */
HL_API int hl_target_corner_rows(const hl_target *target);
/** How many corners it has. */
HL_API int hl_target_corners(const hl_target *target);

/** Corner `index` in the board frame [m]; z = 0. */
HL_API void hl_target_corner(const hl_target *target, int index, double out_m[3]);

/** Id of the AprilGrid's tag in `column` from the left and `row` from the top. */
HL_API int hl_target_tag_id(const hl_target *target, int column, int row);

/**
 * The code of a tag of family tag36h11 as it is printed upright, from AprilTag's own table.
 * @param id  0 .. HL_TARGET_TAGS_MAX - 1
 * @param out row by row from the top left, true where white; the black border is not part of it
 * @return HL_OK; HL_ERR_ARG (id); HL_ERR_MEMORY; HL_ERR_UNAVAILABLE in a build without AprilTag
 */
HL_API hl_status hl_target_tag_cells(hl_ctx *ctx, int id,
                                     bool out[HL_TARGET_TAG_CELLS][HL_TARGET_TAG_CELLS]);

#ifdef __cplusplus
}
#endif
#endif
