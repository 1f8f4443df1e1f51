/* The evidence of results that one chart shows. Each writes evidence.json at `path`. HL_ERR_IO,
 * HL_ERR_MEMORY. */
#ifndef HL_CLI_EVIDENCE_CHARTS_H
#define HL_CLI_EVIDENCE_CHARTS_H

#include "bench_measure.h"
#include "draw.h"

hl_status hl_evidence_of_bench(hl_ctx *ctx, const char *path, const hl_bench_table *table);

hl_status hl_evidence_of_calibration(hl_ctx *ctx, const char *path,
                                     const hl_calibration *calibration, const hl_corners *corners);

hl_status hl_evidence_of_drift(hl_ctx *ctx, const char *path, const hl_drift *drift,
                               const char *verdict);

hl_status hl_evidence_of_fit(hl_ctx *ctx, const char *path, const hl_fit *fit,
                             const hl_samples *samples);

hl_status hl_evidence_of_rig_drift(hl_ctx *ctx, const char *path, const hl_rig_drift *drift,
                                   const hl_lights *reference, const char *verdict);

#endif
