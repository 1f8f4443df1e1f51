/* JSON documents as text a person can read: lists of numbers and small objects on one line. */
#ifndef HL_JSON_WRITE_H
#define HL_JSON_WRITE_H

#include <jansson.h>
#include <stdbool.h>

#include "halflight/status.h"

/* The document as text with a final newline; 17 digits, so that numbers survive a round trip.
 * Members keep the order they were set in. *out is the caller's (free). Takes over `document`; NULL
 * means that building it failed: HL_ERR_MEMORY. */
hl_status hl_json_text(hl_ctx *ctx, json_t *document, char **out);

/* A member of the document's top that is a long list, whose elements are made one by one. */
typedef struct hl_json_long {
  const char *member; /* null in the document itself */
  int n;
  json_t *(*element)(const void *user, int i); /* a new value; NULL without memory */
  const void *user;
} hl_json_long;

/* As hl_json_text, with a long list in its place. */
hl_status hl_json_long_text(hl_ctx *ctx, json_t *document, const hl_json_long *list, char **out);

/* The same text to a file, whole or not at all; some elements are held at a time. HL_ERR_IO;
 * HL_ERR_MEMORY. */
hl_status hl_json_long_write(hl_ctx *ctx, json_t *document, const hl_json_long *list,
                             const char *path);

/* Set a member, taking over `value`; NULL, for want of memory, is a failure: false. */
bool hl_json_set(json_t *object, const char *key, json_t *value);

/* `value` where it is good; else it is given back and NULL. */
json_t *hl_json_kept(json_t *value, bool good);

/* A number, or null where it is not finite (JSON has no other word for it). */
json_t *hl_json_real(double value);

/* n numbers as a list; NULL without memory. */
json_t *hl_json_reals(const double *values, int n);

#endif
