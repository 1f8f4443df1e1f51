/* evidence.json: the pictures that `report` shows, kept beside a result by the verb that had the data.
 *
 *   {"format": "halflight-evidence", "version": 1, "of": "light.json",
 *    "used": [{"what", "why"}, ...],
 *    "pictures": [{"name", "title", "alt", "chart": true|false, "kind": "png"|"svg", "width", "height", "base64"}, ...]}
 *
 * `used` says why each term is used, where the result itself holds names only; it may be missing.
 */
#ifndef HL_CLI_EVIDENCE_H
#define HL_CLI_EVIDENCE_H

#include <jansson.h>

#include "draw.h"

enum { HL_EVIDENCE_PATH_MAX = 4200 };

typedef struct hl_evidence {
  json_t *document;
  char scratch[HL_EVIDENCE_PATH_MAX]; /* a picture is drawn there, read and removed */
} hl_evidence;

/* Draws `data` as a file; the hl_draw_... functions behind one signature. */
typedef hl_status hl_evidence_draw(hl_ctx *ctx, hl_picture_kind kind, const char *path,
                                   const void *data);

typedef struct hl_evidence_picture {
  const char *name, *title; /* a word for programs, a caption for people */
  char alt[320];            /* what is to be seen, for who cannot see it */
  bool chart;               /* drawn on white, its colours may be turned for a dark page */
  hl_picture_kind kind;     /* PNG or SVG */
  hl_evidence_draw *draw;
  const void *data;
} hl_evidence_picture;

/* Begin for the document called `of`; `stage` is where the evidence itself will be written, a picture is
 * drawn beside it. The caller ends it with hl_evidence_free, also after a failure. HL_ERR_MEMORY. */
hl_status hl_evidence_begin(hl_ctx *ctx, hl_evidence *out, const char *of, const char *stage);

/* HL_ERR_IO, HL_ERR_MEMORY, and what the drawing returns. */
hl_status hl_evidence_add(hl_ctx *ctx, hl_evidence *evidence, const hl_evidence_picture *picture);

/* HL_ERR_MEMORY. */
hl_status hl_evidence_used(hl_ctx *ctx, hl_evidence *evidence, const hl_notes *used);

/* HL_ERR_IO, HL_ERR_MEMORY. */
hl_status hl_evidence_write(hl_ctx *ctx, const hl_evidence *evidence, const char *path);

void hl_evidence_free(hl_evidence *evidence);

/* Check what another program may have written: HL_ERR_FORMAT names `path` and the picture. */
hl_status hl_evidence_check(hl_ctx *ctx, const char *path, const json_t *document);

#endif
