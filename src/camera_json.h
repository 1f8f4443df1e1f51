/* CAMERA.json, the document: for those who add members to it or read more of it. */
#ifndef HL_CAMERA_JSON_H
#define HL_CAMERA_JSON_H

#include <jansson.h>

#include "halflight/camera.h"
#include "json_read.h"

/* A camera as a new object that members can be added to, "format" and "version" first; NULL
 * without memory. The caller's (json_decref), or hl_json_text's. */
json_t *hl_camera_json_document(const hl_camera *camera);

/* The camera of an opened document (hl_json_open with HL_CAMERA_JSON_FORMAT and _VERSION), checked.
 * Members it does not know are ignored. HL_OK; HL_ERR_FORMAT. */
hl_status hl_camera_json_members(hl_json_source source, const json_t *root, hl_camera *out);

#define HL_CAMERA_JSON_FORMAT "halflight-camera"
enum { HL_CAMERA_JSON_VERSION = 1 };

#endif
