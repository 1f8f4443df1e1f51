/* What one run leaves: its files, which all appear, or none does and what was there before stays; and
 * its text on stdout. */
#ifndef HL_CLI_OUTPUTS_H
#define HL_CLI_OUTPUTS_H

#include <stdbool.h>

#include "halflight/status.h"

enum { HL_OUTPUTS_MAX = 16, HL_OUTPUT_PATH_MAX = 4096 };

typedef struct hl_outputs {
  int n;
  bool made_folder, committed;
  char folder[HL_OUTPUT_PATH_MAX];                /* to be made; "" where none is */
  char path[HL_OUTPUTS_MAX][HL_OUTPUT_PATH_MAX];  /* where each file goes */
  char stage[HL_OUTPUTS_MAX][HL_OUTPUT_PATH_MAX]; /* where it is written first, beside it */
} hl_outputs;

/* Plan a folder for the files that follow; its parent must exist. HL_ERR_IO. */
hl_status hl_outputs_folder(hl_ctx *ctx, hl_outputs *outputs, const char *folder);

/* Plan a file, within `folder` where that is not NULL; *index is its place in path and stage.
 * Refuses early what could only fail after the work is done. HL_ERR_IO, HL_ERR_ARG. */
hl_status hl_outputs_add(hl_ctx *ctx, hl_outputs *outputs, const char *folder, const char *name,
                         int *index);

/* Plan `file` and evidence.json within the folder that `out` names by a slash at its end; where it has
 * none, `out` itself, and *evidence is -1. HL_ERR_IO, HL_ERR_ARG. */
hl_status hl_outputs_document(hl_ctx *ctx, hl_outputs *outputs, const char *out, const char *file,
                              int *document, int *evidence);

/* Make the folder, so that the stages can be written. HL_ERR_IO. */
hl_status hl_outputs_begin(hl_ctx *ctx, hl_outputs *outputs);

/* Give every written stage its name; a file that was there is replaced and leaves its mode. HL_ERR_IO,
 * with what was there put back. */
hl_status hl_outputs_commit(hl_ctx *ctx, hl_outputs *outputs);

/* After a commit nothing; else remove what the run left, and let a message that names a stage name
 * the place it was for. */
void hl_outputs_end(hl_ctx *ctx, hl_outputs *outputs);

/* Hand on what was printed: text that the disk or the pipe did not take is a failure too. HL_ERR_IO. */
hl_status hl_outputs_print(hl_ctx *ctx);

#endif
