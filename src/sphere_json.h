/* SPHERE.json, the document: for those who put a ball into a larger one. */
#ifndef HL_SPHERE_JSON_H
#define HL_SPHERE_JSON_H

#include <jansson.h>

#include "halflight/sphere.h"
#include "json_read.h"

/* A ball as a new object, "format" and "version" first; NULL without memory. `fit` may be NULL. The
 * caller's (json_decref), or hl_json_text's. */
json_t *hl_sphere_json_document(const hl_sphere *sphere, const hl_sphere_fit *fit);

/* The ball of an object, checked. Members it does not know are ignored. `out` is zero before. HL_OK;
 * HL_ERR_FORMAT. */
hl_status hl_sphere_json_members(hl_json_source source, const json_t *root, hl_sphere *out);

#endif
