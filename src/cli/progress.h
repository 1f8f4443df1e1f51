/* How far a long run is, on a terminal only. */
#ifndef HL_CLI_PROGRESS_H
#define HL_CLI_PROGRESS_H

/* Redraw the bar on standard error: `done` of `total` things called `what`. Nothing where standard
 * error is no terminal. The last call (done == total) removes the bar. */
void hl_progress(int done, int total, const char *what);

#endif
