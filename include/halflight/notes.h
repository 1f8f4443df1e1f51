/** Internal, not installed: lines for `used`, `left_out` and `reasons`. */
#ifndef HALFLIGHT_NOTES_H
#define HALFLIGHT_NOTES_H

#include "halflight/light.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Append a line; beyond HL_NOTES_MAX nothing happens. */
void hl_notes_add(hl_notes *notes, const char *what, const char *format, ...) HL_PRINTF(3, 4);

/** The same to a list; beyond HL_NOTES_MAX nothing happens. false without memory, the list as it
 * was. */
bool hl_note_list_add(hl_note_list *list, const char *what, const char *format, ...)
    HL_PRINTF(3, 4);

/** Replaces what the list holds. false without memory, the list as it was. */
bool hl_note_list_set(hl_note_list *list, const hl_notes *notes);

/** Release and empty. */
void hl_note_list_free(hl_note_list *list);

#ifdef __cplusplus
}
#endif
#endif
