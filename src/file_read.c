/*
 * A whole file in memory. It is read until its end rather than measured first, so that pipes work
 * and a file that shrinks meanwhile cannot leave unread memory behind.
 */
#include "file_read.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static hl_status read_all(hl_ctx *ctx, const char *path, FILE *file, size_t limit,
                          unsigned char **bytes, size_t *n)
{
  size_t room = 1u << 16;
  size_t used = 0;
  unsigned char *all = malloc(room + 1);
  while (all) {
    used += fread(all + used, 1, room - used, file);
    if (used < room || used > limit)
      break;
    if (room > limit)
      room = limit;
    room = room * 2;
    unsigned char *more = realloc(all, room + 1);
    if (!more)
      free(all);
    all = more;
  }
  if (!all)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %zu bytes", path, room);
  const int failed = ferror(file);
  if (failed || used > limit || used == 0) {
    free(all);
    if (failed)
      return hl_fail(ctx, HL_ERR_IO, "%s: cannot read: %s", path, strerror(errno));
    if (used == 0)
      return hl_fail(ctx, HL_ERR_FORMAT, "%s: the file is empty", path);
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: over %zu bytes, the largest accepted", path, limit);
  }
  all[used] = 0;
  *bytes = all;
  *n = used;
  return HL_OK;
}

hl_status hl_file_read(hl_ctx *ctx, const char *path, size_t limit, unsigned char **bytes,
                       size_t *n)
{
  FILE *file = fopen(path, "rb");
  if (!file)
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
  const hl_status st = read_all(ctx, path, file, limit, bytes, n);
  fclose(file);
  return st;
}
