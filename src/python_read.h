/* A Python literal as the JSON document of the same shape (see yaml_read.h). */
#ifndef HL_PYTHON_READ_H
#define HL_PYTHON_READ_H

#include "json_read.h"

/* What ast.literal_eval takes of it: dictionaries with text keys, lists, tuples, texts and byte
 * strings of one line, decimal numbers, True, False, None, comments. *out is the caller's
 * (json_decref). HL_ERR_FORMAT with the line; HL_ERR_MEMORY. */
hl_status hl_python_parse(hl_json_source source, const char *bytes, size_t n, json_t **out);

#endif
