/* Libraries that print on standard error, kept silent. */
#ifndef HL_HUSH_H
#define HL_HUSH_H

#include <stddef.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct hl_hush {
  FILE *file; /* NULL where none could be had: then nothing is held back */
  int saved;
} hl_hush;

/* From here on standard error of the whole process goes to an unnamed file. One thread at a time:
 * another one waits until hl_hush_end. Do not nest. */
void hl_hush_begin(hl_hush *hush);

/* Standard error is back. `line` gets the first line that was printed, "" for none; NULL where it is
 * not wanted. */
void hl_hush_end(hl_hush *hush, char *line, size_t room);

/* Standard error of the whole process goes nowhere from here to hl_hush_leave; any number of threads may
 * be between the two at once. hl_hush_begin waits until none is. */
void hl_hush_share(void);
void hl_hush_leave(void);

#ifdef __cplusplus
}
#endif
#endif
