/* Lines of `reasons`, `used` and `left_out`, and matrices, in JSON documents. */
#ifndef HL_JSON_NOTES_H
#define HL_JSON_NOTES_H

#include <jansson.h>

#include "halflight/light.h"
#include "json_read.h"

/* All of them NULL without memory; the caller's (json_decref). */

/* ["what: why", ...] */
json_t *hl_json_reasons(const hl_notes *notes);

/* [{"what", "why"}, ...] */
json_t *hl_json_notes(const hl_notes *notes);
json_t *hl_json_note_list(const hl_note_list *list);

/* n rows of m numbers, from rows `stride` apart. */
json_t *hl_json_rows(const double *rows, int n, int m, int stride);

/* Lines that hl_json_notes wrote; the first HL_NOTES_MAX of them, texts cut to their room. HL_OK;
 * HL_ERR_FORMAT. */
hl_status hl_json_notes_read(hl_json_source source, const json_t *object, const char *member,
                             hl_notes *out);
/* `out` is empty before. HL_ERR_MEMORY too. */
hl_status hl_json_note_list_read(hl_json_source source, const json_t *object, const char *member,
                                 hl_note_list *out);

#endif
