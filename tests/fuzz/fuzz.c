/* One reader under libFuzzer; HL_FUZZ_READER is its name.
 *
 * Beside what the sanitizers see: a status of the list, never one that says the caller is at fault
 * where a file is, and a message of one line whatever the file holds. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "readers.h"

#define CALL_(name) fuzz_##name
#define CALL(name) CALL_(name)

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n);

typedef struct memory_file {
  int descriptor;
  char path[32];
} memory_file;

void fuzz_demand(int holds, const char *what, const char *msg)
{
  if (holds)
    return;
  fprintf(stderr, "DEMAND: %s: %s\n", what, msg);
  abort();
}

static const char *put(memory_file *file, const void *bytes, size_t n)
{
  if (!file->path[0]) {
    file->descriptor = memfd_create("fuzz", 0);
    snprintf(file->path, sizeof file->path, "/proc/self/fd/%d", file->descriptor);
  }
  const int stored =
      ftruncate(file->descriptor, 0) == 0 && pwrite(file->descriptor, bytes, n, 0) == (ssize_t)n;
  fuzz_demand(stored, "the input can be stored", file->path);
  return file->path;
}

const char *fuzz_again(const void *bytes, size_t n)
{
  static memory_file file;
  return put(&file, bytes, n);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
  static memory_file file;
  uint8_t *copy = malloc(n + 1);
  if (!copy)
    return 0;
  if (n > 0)
    memcpy(copy, bytes, n);
  copy[n] = 0;
  const fuzz_input input = {copy, n, put(&file, copy, n)};
  hl_ctx ctx = {0};
  const hl_status st = CALL(HL_FUZZ_READER)(&ctx, &input);
  fuzz_demand((unsigned)st < HL_STATUS_COUNT, "a status of the list", "");
  if (st != HL_OK) {
    fuzz_demand(ctx.status == st, "the message is that of the status", ctx.msg);
    fuzz_demand(ctx.msg[0] != '\0', "a failure has a message", "");
    for (const char *c = ctx.msg; *c; c++)
      fuzz_demand((unsigned char)*c >= 0x20 && *c != 0x7f, "a message is one plain line", ctx.msg);
  }
  free(copy);
  return 0;
}
