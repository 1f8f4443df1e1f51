/* lights.json, the document: one light and all of them. */
#ifndef HL_LIGHTS_JSON_H
#define HL_LIGHTS_JSON_H

#include <jansson.h>

#include "halflight/lights.h"
#include "json_read.h"

/* One light as a new object; by_intrinsics has `columns`. NULL without memory; the caller's. */
json_t *hl_rig_light_document(const hl_rig_light *light, int columns);

/* The light of an object, checked; its texts are the caller's, also on failure. `out` is zero before.
 * HL_OK; HL_ERR_FORMAT; HL_ERR_MEMORY. */
hl_status hl_rig_light_members(hl_json_source source, const json_t *object, int n_balls,
                               int columns, hl_rig_light *out);

/* The whole of an opened document. `out` is zero before; what it holds is the caller's, also on
 * failure. */
hl_status hl_lights_members(hl_json_source source, const json_t *root, hl_lights *out);

#endif
