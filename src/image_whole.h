/* What kind of image a file is, and whether all of it is there. */
#ifndef HL_IMAGE_WHOLE_H
#define HL_IMAGE_WHOLE_H

#include "halflight/status.h"

/* HL_OK for a whole PNG, JPEG, TIFF or EXR; HL_ERR_FORMAT for a truncated one (decoders fill the
 * rest in silence) or for anything else. *kind is its name, static. */
hl_status hl_image_whole(hl_ctx *ctx, const char *path, const unsigned char *bytes, size_t n,
                         const char **kind);

#endif
