/* Lines of `used`, `left_out` and `reasons`; what finds no room is dropped. */
#include "halflight/notes.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

bool hl_note_list_add(hl_note_list *list, const char *what, const char *format, ...)
{
  if (list->n >= HL_NOTES_MAX)
    return true;
  hl_note *note = realloc(list->note, ((size_t)list->n + 1) * sizeof *note);
  if (!note)
    return false;
  list->note = note;
  note += list->n++;
  snprintf(note->what, sizeof note->what, "%s", what);
  va_list args;
  va_start(args, format);
  vsnprintf(note->why, sizeof note->why, format, args);
  va_end(args);
  return true;
}

bool hl_note_list_set(hl_note_list *list, const hl_notes *notes)
{
  hl_note *note = notes->n > 0 ? malloc((size_t)notes->n * sizeof *note) : NULL;
  if (notes->n > 0 && !note)
    return false;
  if (note)
    memcpy(note, notes->note, (size_t)notes->n * sizeof *note);
  free(list->note);
  *list = (hl_note_list){notes->n, note};
  return true;
}

void hl_note_list_free(hl_note_list *list)
{
  free(list->note);
  *list = (hl_note_list){0};
}
