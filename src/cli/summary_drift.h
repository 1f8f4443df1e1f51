/* A drift check as a person reads it. */
#ifndef HL_CLI_SUMMARY_DRIFT_H
#define HL_CLI_SUMMARY_DRIFT_H

#include <stdio.h>

#include "halflight/halflight.h"

void hl_summary_drift(FILE *out, const hl_drift *drift, const hl_camera *reference);

/* "drifted: focal length 3.5 px, rotation 0.15 deg", or "same: ..." on one line. */
void hl_summary_verdict(const hl_drift *drift, char *out, size_t size);

void hl_summary_board_pose(FILE *out, const hl_board_pose *pose);

#endif
