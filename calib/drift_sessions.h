/* Two calibrations as evidence of what changed between them. */
#ifndef HL_DRIFT_SESSIONS_H
#define HL_DRIFT_SESSIONS_H

#include "drift_parts.h"
#include "drift_side.h"

/* Changes of the intrinsics and, where *with_mount comes out true, of the mount: six more. The two
 * have one lens model. HL_ERR_MEMORY. */
hl_status hl_drift_sessions(hl_ctx *ctx, const hl_drift_side *reference,
                            const hl_drift_side *current, double false_alarm, hl_evidence *out,
                            bool *with_mount, hl_notes *notes);

#endif
