/* A bar that redraws itself and leaves nothing. */
#define _XOPEN_SOURCE 700 // NOLINT(bugprone-reserved-identifier)
#include "progress.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { WIDTH = 30 };

void hl_progress(int done, int total, const char *what)
{
  hl_progress_on(stderr, done, total, what);
}

void hl_progress_on(FILE *to, int done, int total, const char *what)
{
  static const char full[] = "##############################";
  if (!to || !isatty(fileno(to)) || total <= 0)
    return;
  if (done >= total) {
    fprintf(to, "\r%*s\r", WIDTH + 40, "");
  } else {
    const int filled = WIDTH * done / total;
    fprintf(to, "\r[%.*s%*s] %d of %d %s", filled, full, WIDTH - filled, "", done, total, what);
  }
  fflush(to);
}
