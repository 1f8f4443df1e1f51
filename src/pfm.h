/* Portable float maps. */
#ifndef HL_PFM_H
#define HL_PFM_H

#include <stdbool.h>

#include "halflight/frame.h"

/* Whether the file's first bytes are a PFM's. */
bool hl_pfm_is(const unsigned char *bytes, size_t n);

/* Decode a PFM in memory: pixels top row first, *pixels is the caller's (free). `path` is for
 * messages. HL_ERR_FORMAT (header, size, truncated); HL_ERR_MEMORY. */
hl_status hl_pfm_decode(hl_ctx *ctx, const char *path, const unsigned char *bytes, size_t n,
                        float **pixels, int *width, int *height, int *channels);

#endif
