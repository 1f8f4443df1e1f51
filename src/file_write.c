/*
 * A file that appears whole or not at all: written beside its place under another name, flushed to
 * the disk, then renamed. Where the target is no regular file (a pipe, a terminal, /dev/null) there
 * is nothing to replace and the bytes go straight in.
 */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "file_write.h"
#include "halflight/export.h"

enum { NAMES_TRIED = 100 };

static hl_status cannot(hl_ctx *ctx, const char *verb, const char *path, int error)
{
  return hl_fail(ctx, error == ENOMEM ? HL_ERR_MEMORY : HL_ERR_IO, "%s: cannot %s: %s", path, verb,
                 strerror(error));
}

int hl_file_put(int file, const char *bytes, size_t n)
{
  while (n > 0) {
    const ssize_t written = write(file, bytes, n);
    if (written < 0 && errno == EINTR)
      continue;
    if (written < 0)
      return errno;
    bytes += written;
    n -= (size_t)written;
  }
  return 0;
}

/* A new file beside `path`, its name in *name (free). -1 and errno where there is none. */
static int open_beside(const char *path, char **name)
{
  const size_t room = strlen(path) + 48;
  char *text = malloc(room);
  if (!text)
    return -1;
  int file = -1;
  for (int i = 0; i < NAMES_TRIED && file < 0; i++) {
    snprintf(text, room, "%s.%ld-%d.tmp", path, (long)getpid(), i);
    file = open(text, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0 && errno != EEXIST)
      break;
  }
  if (file < 0) {
    const int error = errno;
    free(text);
    errno = error;
    return -1;
  }
  *name = text;
  return file;
}

static hl_status replace(hl_ctx *ctx, const char *path, const struct stat *old,
                         hl_file_producer produce, void *user)
{
  char *name = NULL;
  const int file = open_beside(path, &name);
  if (file < 0)
    return cannot(ctx, "create", path, errno);
  int error = produce(user, file);
  if (error == 0 && old && fchmod(file, old->st_mode & 07777) != 0)
    error = errno;
  if (error == 0 && fsync(file) != 0 && errno != EINVAL)
    error = errno;
  if (close(file) != 0 && error == 0)
    error = errno;
  if (error == 0 && rename(name, path) != 0)
    error = errno;
  if (error != 0)
    unlink(name);
  free(name);
  return error == 0 ? HL_OK : cannot(ctx, "write", path, error);
}

static hl_status pour(hl_ctx *ctx, const char *path, hl_file_producer produce, void *user)
{
  const int file = open(path, O_WRONLY | O_CLOEXEC);
  if (file < 0)
    return cannot(ctx, "open", path, errno);
  int error = produce(user, file);
  if (close(file) != 0 && error == 0)
    error = errno;
  return error == 0 ? HL_OK : cannot(ctx, "write", path, error);
}

hl_status hl_file_write_by(hl_ctx *ctx, const char *path, hl_file_producer produce, void *user)
{
  struct stat old;
  if (stat(path, &old) != 0)
    return replace(ctx, path, NULL, produce, user);
  if (S_ISDIR(old.st_mode))
    return cannot(ctx, "write", path, EISDIR);
  if (!S_ISREG(old.st_mode))
    return pour(ctx, path, produce, user);
  /* a link stays a link: what it names is replaced */
  char *real = realpath(path, NULL);
  if (!real && errno == ENOMEM)
    return cannot(ctx, "write", path, ENOMEM);
  const hl_status st = replace(ctx, real ? real : path, &old, produce, user);
  free(real);
  return st;
}

typedef struct block {
  const char *bytes;
  size_t n;
} block;

static int put_block(void *user, int file)
{
  const block *b = user;
  return hl_file_put(file, b->bytes, b->n);
}

hl_status hl_file_write(hl_ctx *ctx, const char *path, const char *bytes, size_t n)
{
  block b = {bytes, n};
  return hl_file_write_by(ctx, path, put_block, &b);
}
