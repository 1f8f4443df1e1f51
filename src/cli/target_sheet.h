/* The sheet a target is printed on: what goes where, in millimetres from its top left. */
#ifndef HL_CLI_TARGET_SHEET_H
#define HL_CLI_TARGET_SHEET_H

#include "draw.h"
#include "halflight/settings.h"
#include "halflight/target.h"

typedef enum hl_page { HL_PAGE_FIT, HL_PAGE_A4, HL_PAGE_A3, HL_PAGE_LETTER } hl_page;

typedef struct hl_sheet_settings {
  int border_bits; /* 0: not given, which is 2 for an AprilGrid */
  int page;        /* hl_page */
  double dpi;      /* of a PNG; 0: not given, which is 300 */
} hl_sheet_settings;

const hl_field_table *hl_sheet_fields(void);

typedef struct hl_sheet {
  hl_target target;
  int border_bits; /* 0 for a chessboard */
  hl_picture_kind kind;
  double dpi; /* of a PNG */
  double width_mm, height_mm;
  double first_mm[2]; /* the target's first corner */
  double span_mm[2];  /* from it to the last one */
  double around_mm;   /* the pattern goes on so far beyond the outer corners */
  double cell_mm;     /* a tag's bit, or a chessboard's square */
  double caption_mm;  /* top of what stands below the pattern */
  double left_mm;     /* where that begins */
  double ruler_mm;    /* its length */
  bool whole_pixels;  /* every edge of a PNG's pattern lies between two pixels */
} hl_sheet;

/* Pixels along x or y of a PNG's `mm`. */
int hl_sheet_pixels(const hl_sheet *sheet, double mm);

/* HL_ERR_ARG where the target cannot be drawn so, saying how it could. */
hl_status hl_sheet_plan(hl_ctx *ctx, const hl_target *target, hl_picture_kind kind,
                        const hl_sheet_settings *settings, hl_sheet *out);

/* Draw the target at true scale with a caption and a ruler. HL_ERR_IO; HL_ERR_UNAVAILABLE for tags
 * in a build without AprilTag. */
hl_status hl_draw_target(hl_ctx *ctx, const hl_sheet *sheet, const char *path);

#endif
