/* Outputs are written beside their places under other names, then renamed together. What they replace
 * keeps a second name until the last rename is done. */
#define _XOPEN_SOURCE 700 // NOLINT(bugprone-reserved-identifier)
#include "outputs.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { STAGE_SUFFIX = 32 }; /* room for what a stage's name has more than its place */

static bool is_folder(const char *path)
{
  struct stat at;
  return stat(path, &at) == 0 && S_ISDIR(at.st_mode);
}

static bool exists(const char *path)
{
  struct stat at;
  return lstat(path, &at) == 0;
}

static size_t without_slashes(const char *path)
{
  size_t n = strlen(path);
  while (n > 1 && path[n - 1] == '/')
    n--;
  return n;
}

/* The folder a path is in, "." for a bare name. */
static void parent_of(const char *path, char parent[HL_OUTPUT_PATH_MAX])
{
  size_t n = without_slashes(path);
  while (n > 0 && path[n - 1] != '/')
    n--;
  snprintf(parent, HL_OUTPUT_PATH_MAX, "%.*s", (int)n, path);
  parent[without_slashes(parent)] = '\0';
  if (!parent[0])
    snprintf(parent, HL_OUTPUT_PATH_MAX, ".");
}

/* It must exist, or be the folder this run will make. */
static hl_status check_parent(hl_ctx *ctx, const hl_outputs *outputs, const char *path)
{
  char parent[HL_OUTPUT_PATH_MAX];
  parent_of(path, parent);
  const size_t n = without_slashes(outputs->folder);
  if (outputs->folder[0] && strlen(parent) == n && strncmp(parent, outputs->folder, n) == 0)
    return HL_OK;
  if (!is_folder(parent))
    return hl_fail(ctx, HL_ERR_IO, "%s: there is no folder %s; an existing one is needed", path,
                   parent);
  if (access(parent, W_OK | X_OK) != 0)
    return hl_fail(ctx, HL_ERR_IO, "%s: %s; a folder that can be written to is needed", path,
                   strerror(errno));
  return HL_OK;
}

/* What is there may be replaced: a regular file. A link stays a link: what it names is replaced. */
static hl_status check_target(hl_ctx *ctx, char *path)
{
  struct stat at;
  if (stat(path, &at) != 0)
    return HL_OK;
  if (S_ISDIR(at.st_mode))
    return hl_fail(ctx, HL_ERR_IO, "%s: is a folder; a file name is needed", path);
  if (!S_ISREG(at.st_mode))
    return hl_fail(ctx, HL_ERR_IO, "%s: is no regular file; a file name is needed", path);
  const bool link = lstat(path, &at) == 0 && S_ISLNK(at.st_mode);
  char *real = link ? realpath(path, NULL) : NULL;
  if (link && !real)
    return hl_fail(ctx, errno == ENOMEM ? HL_ERR_MEMORY : HL_ERR_IO,
                   "%s: cannot follow the link: %s", path, strerror(errno));
  if (real && strlen(real) + STAGE_SUFFIX < HL_OUTPUT_PATH_MAX)
    memcpy(path, real, strlen(real) + 1);
  free(real);
  return HL_OK;
}

hl_status hl_outputs_folder(hl_ctx *ctx, hl_outputs *outputs, const char *folder)
{
  if (strlen(folder) + 64 > HL_OUTPUT_PATH_MAX)
    return hl_fail(ctx, HL_ERR_IO, "%.80s...: the name is longer than %d bytes", folder,
                   HL_OUTPUT_PATH_MAX - 64);
  if (is_folder(folder)) {
    if (access(folder, W_OK | X_OK) != 0)
      return hl_fail(ctx, HL_ERR_IO, "%s: %s; a folder that can be written to is needed", folder,
                     strerror(errno));
    return HL_OK;
  }
  if (exists(folder))
    return hl_fail(ctx, HL_ERR_IO, "%s: is a file; a folder, or a name for a new one, is needed",
                   folder);
  const hl_status st = check_parent(ctx, outputs, folder);
  if (st == HL_OK)
    snprintf(outputs->folder, sizeof outputs->folder, "%s", folder);
  return st;
}

hl_status hl_outputs_add(hl_ctx *ctx, hl_outputs *outputs, const char *folder, const char *name,
                         int *index)
{
  const int i = outputs->n;
  const size_t before = folder ? strlen(folder) + 1 : 0;
  const size_t length = before + strlen(name);
  if (i >= HL_OUTPUTS_MAX || length + STAGE_SUFFIX > HL_OUTPUT_PATH_MAX)
    return hl_fail(ctx, HL_ERR_IO, "%.80s...: the name is longer than %d bytes", name,
                   HL_OUTPUT_PATH_MAX - STAGE_SUFFIX);
  char *path = outputs->path[i];
  if (folder) {
    memmove(path, folder, before - 1);
    path[before - 1] = '/';
  }
  memmove(path + before, name, length - before + 1);
  hl_status st = folder ? HL_OK : check_parent(ctx, outputs, path);
  if (st == HL_OK)
    st = check_target(ctx, path);
  if (st != HL_OK)
    return st;
  char suffix[STAGE_SUFFIX];
  snprintf(suffix, sizeof suffix, ".part-%ld", (long)getpid());
  const size_t resolved = strlen(path); /* a link was followed */
  memmove(outputs->stage[i], path, resolved);
  memmove(outputs->stage[i] + resolved, suffix, strlen(suffix) + 1);
  for (int k = 0; k < i; k++)
    if (strcmp(outputs->path[k], path) == 0)
      return hl_fail(ctx, HL_ERR_ARG, "%s is named for two outputs; a name each is needed", path);
  outputs->n++;
  *index = i;
  return HL_OK;
}

hl_status hl_outputs_document(hl_ctx *ctx, hl_outputs *outputs, const char *out, const char *file,
                              int *document, int *evidence)
{
  const size_t n = strlen(out);
  *evidence = -1;
  if (n < 2 || out[n - 1] != '/')
    return hl_outputs_add(ctx, outputs, NULL, out, document);
  hl_status st = hl_outputs_folder(ctx, outputs, out);
  char folder[HL_OUTPUT_PATH_MAX];
  if (st != HL_OK)
    return st;
  snprintf(folder, sizeof folder, "%.*s", (int)without_slashes(out), out);
  st = hl_outputs_add(ctx, outputs, folder, file, document);
  return st == HL_OK ? hl_outputs_add(ctx, outputs, folder, "evidence.json", evidence) : st;
}

hl_status hl_outputs_begin(hl_ctx *ctx, hl_outputs *outputs)
{
  if (!outputs->folder[0])
    return HL_OK;
  if (mkdir(outputs->folder, 0777) == 0)
    outputs->made_folder = true;
  else if (!is_folder(outputs->folder)) /* another run may have made it meanwhile */
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot make the folder: %s", outputs->folder,
                   strerror(errno));
  return HL_OK;
}

/* A reader knows the place a file was meant for, not the name of its stage. */
static void restate(hl_ctx *ctx, const hl_outputs *outputs)
{
  for (int i = 0; ctx && i < outputs->n; i++) {
    const char *at = strstr(ctx->msg, outputs->stage[i]);
    if (!at)
      continue;
    char text[HL_MESSAGE_MAX];
    snprintf(text, sizeof text, "%.*s%s%s", (int)(at - ctx->msg), ctx->msg, outputs->path[i],
             at + strlen(outputs->stage[i]));
    hl_fail(ctx, ctx->status, "%s", text);
    return;
  }
}

static void kept_name(const char *path, char kept[HL_OUTPUT_PATH_MAX])
{
  snprintf(kept, HL_OUTPUT_PATH_MAX, "%.*s.kept-%ld", HL_OUTPUT_PATH_MAX - STAGE_SUFFIX, path,
           (long)getpid());
}

/* A second name for the file that is about to be replaced. Where links cannot be made, the file is
 * moved. */
static bool keep_old(const char *stage, const char *path)
{
  char kept[HL_OUTPUT_PATH_MAX];
  struct stat at;
  kept_name(path, kept);
  if (stat(path, &at) == 0)
    (void)chmod(stage, at.st_mode & 0777); /* a file system without modes has none to keep */
  return link(path, kept) == 0 || (errno != EEXIST && rename(path, kept) == 0);
}

/* The old file has its name again; the second name goes, which rename leaves between two links. */
static void put_back(const char *path)
{
  char kept[HL_OUTPUT_PATH_MAX];
  kept_name(path, kept);
  if (rename(kept, path) == 0)
    unlink(kept);
}

hl_status hl_outputs_commit(hl_ctx *ctx, hl_outputs *outputs)
{
  bool is_kept[HL_OUTPUTS_MAX] = {false};
  for (int i = 0; i < outputs->n; i++) {
    const char *stage = outputs->stage[i], *path = outputs->path[i];
    const bool is_new = !exists(path);
    is_kept[i] = !is_new && keep_old(stage, path);
    if ((is_new || is_kept[i]) && rename(stage, path) == 0)
      continue;
    const int reason = errno;
    for (int k = 0; k <= i; k++) {
      if (is_kept[k])
        put_back(outputs->path[k]);
      else if (k < i)
        unlink(outputs->path[k]);
    }
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot be written: %s", path, strerror(reason));
  }
  for (int i = 0; i < outputs->n; i++) {
    char kept[HL_OUTPUT_PATH_MAX];
    kept_name(outputs->path[i], kept);
    if (is_kept[i])
      unlink(kept);
  }
  outputs->committed = true;
  return HL_OK;
}

void hl_outputs_end(hl_ctx *ctx, hl_outputs *outputs)
{
  if (outputs->committed)
    return;
  restate(ctx, outputs);
  for (int i = 0; i < outputs->n; i++)
    unlink(outputs->stage[i]);
  if (outputs->made_folder)
    rmdir(outputs->folder);
}

hl_status hl_outputs_print(hl_ctx *ctx)
{
  errno = 0;
  if (fflush(stdout) == 0 && !ferror(stdout))
    return HL_OK;
  return hl_fail(ctx, HL_ERR_IO, "stdout: %s; a place that takes the result is needed",
                 errno ? strerror(errno) : "write failed");
}
