/* --scale, --aim and --replace of relight: as often as wanted, done in the order they were given. */
#ifndef HL_CLI_RELIGHT_EDITS_H
#define HL_CLI_RELIGHT_EDITS_H

#include "halflight/relight.h"

enum { HL_RELIGHT_EDITS_MAX = 16 };

typedef enum hl_relight_edit_kind {
  HL_RELIGHT_SCALE,
  HL_RELIGHT_AIM,
  HL_RELIGHT_REPLACE
} hl_relight_edit_kind;

typedef struct hl_relight_edit {
  hl_relight_edit_kind kind;
  char term[HL_TERM_NAME_MAX];
  double number[2]; /* the factor, or cs and cv */
  const char *path; /* of the curve */
} hl_relight_edit;

typedef struct hl_relight_edits {
  int n;
  hl_relight_edit list[HL_RELIGHT_EDITS_MAX];
} hl_relight_edits;

/* Option parsers: TERM=F, TERM=CS,CV and TERM=CURVE.csv; `member` is the hl_relight_edits. */
hl_status hl_relight_edits_scale(hl_ctx *ctx, const char *text, void *member);
hl_status hl_relight_edits_aim(hl_ctx *ctx, const char *text, void *member);
hl_status hl_relight_edits_replace(hl_ctx *ctx, const char *text, void *member);

hl_status hl_relight_edits_apply(hl_ctx *ctx, const hl_relight_edits *edits,
                                 hl_reflectance *reflectance);

#endif
