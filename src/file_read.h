/* A whole file in memory. */
#ifndef HL_FILE_READ_H
#define HL_FILE_READ_H

#include "halflight/status.h"

/* Read all of a file of at most `limit` bytes. *bytes is the caller's (free); a zero byte that *n
 * does not count follows the last. HL_ERR_IO (missing, unreadable); HL_ERR_FORMAT (empty, larger);
 * HL_ERR_MEMORY. */
hl_status hl_file_read(hl_ctx *ctx, const char *path, size_t limit, unsigned char **bytes,
                       size_t *n);

#endif
