/* What a piece of code prints, on standard output and standard error together. */
#ifndef HL_TEST_QUIET_H
#define HL_TEST_QUIET_H

#include <stdio.h>
#include <unistd.h>

#include "near.h"

typedef struct quiet {
  int out, err;
  FILE *file;
} quiet;

static inline quiet quiet_begin(void)
{
  fflush(NULL);
  quiet q = {dup(STDOUT_FILENO), dup(STDERR_FILENO), tmpfile()};
  assert_non_null(q.file);
  dup2(fileno(q.file), STDOUT_FILENO);
  dup2(fileno(q.file), STDERR_FILENO);
  return q;
}

/* Bytes that were printed since. */
static inline long quiet_end(quiet *q)
{
  fflush(NULL);
  dup2(q->out, STDOUT_FILENO);
  dup2(q->err, STDERR_FILENO);
  close(q->out);
  close(q->err);
  const long printed = lseek(fileno(q->file), 0, SEEK_END);
  fclose(q->file);
  return printed;
}

#endif
