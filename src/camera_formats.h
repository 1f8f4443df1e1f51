/* One reader and one writer a camera format. The readers take a document that has been parsed, whatever
 * its language; the writers a camera that has been checked. */
#ifndef HL_CAMERA_FORMATS_H
#define HL_CAMERA_FORMATS_H

#include "halflight/camera.h"
#include "json_read.h"
#include "text.h"

/* Is it one, by the members it has? */
bool hl_camera_opencv_is(const json_t *root);
bool hl_camera_kalibr_is(const json_t *root);

/* HL_OK; HL_ERR_FORMAT naming member and value, or what hl_camera_check says. */
hl_status hl_camera_opencv_members(hl_json_source source, const json_t *root, hl_camera *out);
hl_status hl_camera_kalibr_members(hl_json_source source, const json_t *root, hl_camera *out);
hl_status hl_camera_mrcal_members(hl_json_source source, const json_t *root, hl_camera *out);

/* HL_OK, also where `out` failed to grow; HL_ERR_FORMAT where the format has no such lens. */
hl_status hl_camera_opencv_put(hl_ctx *ctx, const hl_camera *camera, hl_text *out);
hl_status hl_camera_kalibr_put(hl_ctx *ctx, const hl_camera *camera, hl_text *out);
hl_status hl_camera_mrcal_put(hl_ctx *ctx, const hl_camera *camera, hl_text *out);

/* For the readers: width and height out of a member of two whole numbers; then the check of the
 * finished camera, in the file's name. */
hl_status hl_camera_formats_size(hl_json_source source, const json_t *object, const char *member,
                                 hl_camera *camera);
hl_status hl_camera_formats_finish(hl_json_source source, hl_camera *camera, hl_camera *out);

/* fx, fy, cx, cy in this order, as all formats but OpenCV's have them. */
void hl_camera_formats_set_core(hl_camera *camera, const double core[4]);

#endif
