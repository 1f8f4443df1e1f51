/* A calibration as a person reads it. */
#ifndef HL_CLI_SUMMARY_CALIBRATION_H
#define HL_CLI_SUMMARY_CALIBRATION_H

#include <stdio.h>

#include "halflight/halflight.h"

void hl_summary_calibration(FILE *out, const hl_calibration *calibration);

#endif
