/* JSON documents as text a person can read: lists of numbers and small objects on one line. */
#ifndef HL_JSON_WRITE_H
#define HL_JSON_WRITE_H

#include <jansson.h>

#include "halflight/status.h"

/* The document as text with a final newline; 17 digits, so that numbers survive a round trip.
 * Members keep the order they were set in. *out is the caller's (free). Takes over `document`; NULL
 * means that building it failed: HL_ERR_MEMORY. */
hl_status hl_json_text(hl_ctx *ctx, json_t *document, char **out);

/* A number, or null where it is not finite (JSON has no other word for it). */
json_t *hl_json_real(double value);

/* n numbers as a list; NULL without memory. */
json_t *hl_json_reals(const double *values, int n);

#endif
