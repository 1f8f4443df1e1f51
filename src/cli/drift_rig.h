/* drift of two replayed sessions, behind the verb. */
#ifndef HL_CLI_DRIFT_RIG_H
#define HL_CLI_DRIFT_RIG_H

#include <stdio.h>

#include "draw.h"
#include "halflight/halflight.h"
#include "outputs.h"

typedef struct hl_drift_rig_args {
  const char *reference, *current; /* folders of replayed sessions, or their lights.json */
  const char *picture, *out;       /* may be NULL; out: the folder of drift.json */
  bool json;
  hl_rig_drift_settings settings;
} hl_drift_rig_args;

/* A folder, or a file named lights.json. */
bool hl_drift_rig_is(const char *path);

/* Plan drift.json and evidence.json in a folder. HL_ERR_IO, HL_ERR_ARG. */
hl_status hl_drift_plan(hl_ctx *ctx, hl_outputs *outputs, const char *folder, int *document,
                        int *evidence);

/* HL_OK; HL_ERR_RESIDUAL where the rig drifted, what cannot be compared is a failure. */
hl_status hl_drift_rig_run(hl_ctx *ctx, const hl_drift_rig_args *args);

/* A person's words, and one line of them. */
void hl_summary_rig_drift(FILE *out, const hl_rig_drift *drift);
void hl_summary_rig_verdict(const hl_rig_drift *drift, char *out, size_t size);

/* The lights as the camera sees their dome, and the balls. */
hl_status hl_draw_rig_drift(hl_ctx *ctx, hl_picture_kind kind, const char *path,
                            const hl_rig_drift *drift, const hl_lights *reference,
                            const char *verdict);

#endif
