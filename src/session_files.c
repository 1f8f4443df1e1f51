/*
 * Paths of a session stay within its folder: a manifest from elsewhere must not make anyone read or
 * replace a file that is not the session's. The text is checked first, then what the disk makes of
 * it, because a link may lead out where the text does not.
 */
#include "session_files.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { SHOWN_MAX = 80 };

bool hl_session_plain(const char *file)
{
  const char *at = file;
  for (;;) {
    const size_t n = strcspn(at, "/");
    if (n == 0 || (n == 1 && at[0] == '.') || (n == 2 && at[0] == '.' && at[1] == '.'))
      return false;
    if (at[n] == '\0')
      return true;
    at += n + 1;
  }
}

char *hl_session_join(const char *folder, const char *file)
{
  const size_t room = strlen(folder) + strlen(file) + 2;
  char *path = malloc(room);
  if (path)
    snprintf(path, room, "%s/%s", folder, file);
  return path;
}

static bool within(const char *real, const char *folder)
{
  const size_t n = strlen(folder);
  return strncmp(real, folder, n) == 0 &&
         (real[n] == '\0' || real[n] == '/' || (n > 0 && folder[n - 1] == '/'));
}

static hl_status refuse(hl_ctx *ctx, const char *what, const char *file, const char *why)
{
  return hl_fail(ctx, HL_ERR_FORMAT, "%s = \"%.*s\" %s; a relative path within it is needed", what,
                 SHOWN_MAX, file, why);
}

/* `path` is cut, component by component, to what exists. */
static hl_status check_on_disk(hl_ctx *ctx, const char *what, const char *file, const char *folder,
                               size_t n_folder, char *path)
{
  while (strlen(path) > n_folder) {
    char *real = realpath(path, NULL);
    const int error = errno;
    if (real) {
      const bool good = within(real, folder);
      free(real);
      return good ? HL_OK : refuse(ctx, what, file, "leads out of the session's folder");
    }
    struct stat at;
    if (error == ELOOP || (error == ENOENT && lstat(path, &at) == 0))
      return refuse(ctx, what, file, "is a link that leads nowhere in the session's folder");
    if (error != ENOENT && error != ENOTDIR)
      return hl_fail(ctx, error == ENOMEM ? HL_ERR_MEMORY : HL_ERR_IO, "%s = \"%.*s\": %s", what,
                     SHOWN_MAX, file, strerror(error));
    *strrchr(path, '/') = '\0';
  }
  return HL_OK;
}

hl_status hl_session_inside(hl_ctx *ctx, const char *what, const char *folder, const char *file)
{
  if (!hl_session_plain(file))
    return refuse(ctx, what, file, "is no plain path within the session's folder");
  char *real = realpath(folder, NULL);
  if (!real)
    return hl_fail(ctx, errno == ENOMEM ? HL_ERR_MEMORY : HL_ERR_IO, "%s: cannot open: %s", folder,
                   strerror(errno));
  char *path = hl_session_join(folder, file);
  const hl_status st = path ? check_on_disk(ctx, what, file, real, strlen(folder), path)
                            : hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for a path", folder);
  free(path);
  free(real);
  return st;
}
