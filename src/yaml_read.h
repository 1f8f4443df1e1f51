/* A YAML document as the JSON document of the same shape, so that one set of readers takes members
 * out of both (json_read.h). */
#ifndef HL_YAML_READ_H
#define HL_YAML_READ_H

#include "json_read.h"

/* The n bytes' only document. Plain scalars that spell a finite decimal number, true, false or null are
 * those; every other scalar is a text, .nan and .inf among them, so that a reader's refusal shows what
 * stands there. OpenCV's `%YAML:1.0`, which is no YAML, is blotted out in `bytes` first.
 * *out is the caller's (json_decref). HL_ERR_FORMAT with the line: no YAML, an alias (a few bytes of
 * them unfold to gigabytes), deep nesting, a key given twice or that is no text, a second document,
 * too many values; HL_ERR_MEMORY. */
hl_status hl_yaml_parse(hl_json_source source, char *bytes, size_t n, json_t **out);

#endif
