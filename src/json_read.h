/* Reading a versioned JSON document member by member, each refusal naming file, member and value.
 */
#ifndef HL_JSON_READ_H
#define HL_JSON_READ_H

#include <jansson.h>
#include <stdbool.h>

#include "halflight/status.h"

typedef struct hl_json_source {
  hl_ctx *ctx;
  const char *path;
} hl_json_source;

enum { HL_JSON_BYTES_MAX = 64 << 20 }; /* larger files are refused */

/* Parse n bytes. *out is the caller's (json_decref). HL_ERR_FORMAT with the line; NaN and Infinity,
 * which Python writes, are refused with their place. */
hl_status hl_json_parse(hl_json_source source, const char *bytes, size_t n, json_t **out);

/* Is this an object of that "format" and of "version" 1 .. newest? */
hl_status hl_json_header(hl_json_source source, const json_t *root, const char *format, int newest);

/* Read a file, parse it and check its header. *out is the caller's. HL_ERR_IO, HL_ERR_FORMAT. */
hl_status hl_json_open(hl_json_source source, const char *format, int newest, json_t **out);

/* The same where several formats are welcome; *which is the place of the file's. */
hl_status hl_json_open_one_of(hl_json_source source, const char *const *formats, int n_formats,
                              int newest, int *which, json_t **out);

/* A finite number in [min, max]; HL_ERR_FORMAT otherwise. */
hl_status hl_json_number(hl_json_source source, const json_t *object, const char *member,
                         double min, double max, double *out);

/* A whole number in [min, max]. */
hl_status hl_json_int(hl_json_source source, const json_t *object, const char *member, int min,
                      int max, int *out);

/* Borrowed from the object. */
hl_status hl_json_string(hl_json_source source, const json_t *object, const char *member,
                         const char **out);

/* An array of exactly n finite numbers; a nested one of rows x columns, stored row by row. On
 * failure `out` may hold the first numbers. */
hl_status hl_json_numbers(hl_json_source source, const json_t *object, const char *member, int n,
                          double *out);
hl_status hl_json_matrix(hl_json_source source, const json_t *object, const char *member, int rows,
                         int columns, double *out);

/* Repeat, with the file's name before it, what a check of the finished struct found; returns
 * `status`. */
hl_status hl_json_blame(hl_json_source source, hl_status status, const char *msg);

/* Present and not null. */
bool hl_json_has(const json_t *object, const char *member);

#endif
