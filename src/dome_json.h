/* The member "dome" of lights.json. */
#ifndef HL_DOME_JSON_H
#define HL_DOME_JSON_H

#include <jansson.h>

#include "halflight/lights.h"
#include "json_read.h"

/* NULL without memory; the caller's. */
json_t *hl_dome_document(const hl_lights *lights);

/* lights->dome and what its lights state of it, from the document's root; zero where it has none.
 * The lights have been read. HL_OK; HL_ERR_FORMAT. */
hl_status hl_dome_members(hl_json_source source, const json_t *root, hl_lights *lights);

#endif
