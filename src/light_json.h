/* LIGHT.json, the document: for those who add members to it. */
#ifndef HL_LIGHT_JSON_H
#define HL_LIGHT_JSON_H

#include <jansson.h>

#include "halflight/export.h"

/* "format" and "version" first; `timing` may be NULL. NULL without memory; the caller's (json_decref),
 * or hl_json_text's. */
json_t *hl_light_json_document(const hl_light *light, const hl_timing *timing);

#endif
