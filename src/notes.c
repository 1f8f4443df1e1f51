/* Lines of `used`, `left_out` and `reasons`; what finds no room is dropped. */
#include "halflight/notes.h"

#include <stdarg.h>
#include <stdio.h>

void hl_notes_add(hl_notes *notes, const char *what, const char *format, ...)
{
  if (notes->n >= HL_NOTES_MAX)
    return;
  hl_note *note = &notes->note[notes->n++];
  snprintf(note->what, sizeof note->what, "%s", what);
  va_list args;
  va_start(args, format);
  vsnprintf(note->why, sizeof note->why, format, args);
  va_end(args);
}
