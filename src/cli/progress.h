/* How far a long run is, on a terminal only. */
#ifndef HL_CLI_PROGRESS_H
#define HL_CLI_PROGRESS_H

#include <stdio.h>

/* Redraw the bar on standard error: `done` of `total` things called `what`. Nothing where standard
 * error is no terminal. The last call (done == total) removes the bar. */
void hl_progress(int done, int total, const char *what);
/* On a stream of its own; NULL draws nothing. */
void hl_progress_on(FILE *to, int done, int total, const char *what);

#endif
