/* The evidence that `estimate` keeps for a report of one frame. */
#ifndef HL_CLI_EVIDENCE_FRAME_H
#define HL_CLI_EVIDENCE_FRAME_H

#include "draw.h"

/* Write evidence.json at `path`: photo, normals, fit, residual, masks, curves among their data. `work`
 * is that of the estimate; `light_json` is where its result is written. HL_ERR_IO, HL_ERR_MEMORY. */
hl_status hl_evidence_of_frame(hl_ctx *ctx, const char *path, const hl_photo *photo,
                               const hl_light_work *work, const char *light_json);

#endif
