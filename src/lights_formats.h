/* Lights in the files of other tools: what the readers and writers of each share. */
#ifndef HL_LIGHTS_FORMATS_H
#define HL_LIGHTS_FORMATS_H

#include <jansson.h>

#include "halflight/interchange.h"
#include "json_read.h"
#include "text.h"

enum { HL_LIGHTS_FILE_MAX = 100000 }; /* lights in one file */

/* Readers: `out` is zero before; what it holds is the caller's, also on failure. `bytes` ends with a
 * zero byte. */
hl_status hl_lights_lp_parse(hl_json_source source, const char *bytes, size_t n, hl_lights *out);
hl_status hl_lights_dome_members(hl_json_source source, const json_t *root, hl_lights *out);
hl_status hl_lights_alicevision_members(hl_json_source source, const json_t *root, hl_lights *out);

/* Writers: at least one light was found. */
void hl_lights_lp_put(const hl_lights *lights, hl_text *out);
void hl_lights_dome_put(const hl_lights *lights, hl_text *out);
void hl_lights_alicevision_put(const hl_lights *lights, hl_text *out);
void hl_lights_usda_put(const hl_lights *lights, hl_text *out);

/* Room for n lights, all zero. */
hl_status hl_lights_room(hl_json_source source, size_t n, hl_lights *out);

/* The light is found at d of the file's frame with y and z turned by `turn` (-1 or 1), intensity 1.
 * HL_ERR_FORMAT where d has next to no length; `where` names the place. */
hl_status hl_lights_set(hl_json_source source, const char *where, const double d[3], int turn,
                        hl_rig_light *light);

/* "text" as JSON and USD both read it: quotes and backslashes escaped, control characters as blanks, what
 * is no UTF-8 as question marks. */
void hl_lights_quote(hl_text *out, const char *text);

#endif
