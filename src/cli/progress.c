/* A bar that redraws itself and leaves nothing. */
#define _XOPEN_SOURCE 700 // NOLINT(bugprone-reserved-identifier)
#include "progress.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { WIDTH = 30 };

void hl_progress(int done, int total, const char *what)
{
  static const char full[] = "##############################";
  if (!isatty(STDERR_FILENO) || total <= 0)
    return;
  if (done >= total) {
    fprintf(stderr, "\r%*s\r", WIDTH + 40, "");
  } else {
    const int filled = WIDTH * done / total;
    fprintf(stderr, "\r[%.*s%*s] %d of %d %s", filled, full, WIDTH - filled, "", done, total, what);
  }
  fflush(stderr);
}
