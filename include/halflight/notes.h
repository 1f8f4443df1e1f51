/** Internal, not installed: lines for `used`, `left_out` and `reasons`. */
#ifndef HALFLIGHT_NOTES_H
#define HALFLIGHT_NOTES_H

#include "halflight/light.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Append a line; beyond HL_NOTES_MAX nothing happens. */
void hl_notes_add(hl_notes *notes, const char *what, const char *format, ...) HL_PRINTF(3, 4);

#ifdef __cplusplus
}
#endif
#endif
