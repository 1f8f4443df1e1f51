/* A number as other languages than JSON spell it: YAML, Python. */
#ifndef HL_NUMBER_JSON_H
#define HL_NUMBER_JSON_H

#include <jansson.h>

/* `5.`, `.5`, `+5`, `-1.e-3` as well as `5` and `0.5`; whatever the locale. NULL where the n bytes are
 * no finite decimal number (so is 017, which is 15 to some and 17 to others). */
json_t *hl_number_json(const char *text, size_t n);

#endif
