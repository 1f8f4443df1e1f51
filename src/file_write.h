/* Files that appear whole or not at all and are too long to be held in memory. Private. */
#ifndef HL_FILE_WRITE_H
#define HL_FILE_WRITE_H

#include <stddef.h>

#include "halflight/status.h"

/* Writes all bytes to an open file; 0 or errno. */
int hl_file_put(int file, const char *bytes, size_t n);

/* Writes the content, by hl_file_put; 0 or errno. */
typedef int (*hl_file_producer)(void *user, int file);

/* As hl_file_write, of what `produce` writes. */
hl_status hl_file_write_by(hl_ctx *ctx, const char *path, hl_file_producer produce, void *user);

#endif
