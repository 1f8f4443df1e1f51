/* Lines of `reasons`, `used` and `left_out`, and matrices, in JSON documents. */
#ifndef HL_JSON_NOTES_H
#define HL_JSON_NOTES_H

#include <jansson.h>

#include "halflight/light.h"

/* All of them NULL without memory; the caller's (json_decref). */

/* ["what: why", ...] */
json_t *hl_json_reasons(const hl_notes *notes);

/* [{"what", "why"}, ...] */
json_t *hl_json_notes(const hl_notes *notes);

/* n rows of m numbers, from rows `stride` apart. */
json_t *hl_json_rows(const double *rows, int n, int m, int stride);

#endif
