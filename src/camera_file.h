/* A camera out of whatever file, for those who read more of a CAMERA.json than the camera. */
#ifndef HL_CAMERA_FILE_H
#define HL_CAMERA_FILE_H

#include <jansson.h>

#include "halflight/camera.h"

/* As hl_camera_read. *document is the caller's (json_decref): the root of a CAMERA.json, NULL where
 * the file is of another format. `document` may be NULL. */
hl_status hl_camera_file_read(hl_ctx *ctx, const char *path, hl_camera *out, json_t **document);

#endif
