/* What estimate and locate read: the frame, its camera, and options that need more than a number.
 */
#ifndef HL_CLI_INPUTS_H
#define HL_CLI_INPUTS_H

#include "halflight/halflight.h"

/* --transfer linear|srgb|gamma:G into hl_frame_settings. */
hl_status hl_inputs_transfer(hl_ctx *ctx, const char *text, void *frame_settings);

/* --with NAME, --without NAME: one bit more in hl_light_settings.with or .without. */
hl_status hl_inputs_with(hl_ctx *ctx, const char *text, void *mask);
hl_status hl_inputs_without(hl_ctx *ctx, const char *text, void *mask);

/* --circle X,Y,R into hl_sphere_settings. */
hl_status hl_inputs_circle(hl_ctx *ctx, const char *text, void *sphere_settings);

/* Bounds of --radius-m; the member is a double, 0 = not given. */
const hl_field_table *hl_inputs_radius_fields(void);

/* Camera, then frame, then whether they belong together (HL_ERR_FORMAT where not). */
hl_status hl_inputs_read(hl_ctx *ctx, const char *frame_path, const char *camera_path,
                         const hl_frame_settings *settings, hl_camera *camera, hl_frame *frame);

/* Put the file a failure is about before its message; settings (HL_ERR_ARG) are no file's fault.
 * Returns `status`. */
hl_status hl_inputs_blame(hl_ctx *ctx, hl_status status, const char *path);

/* Monotonic clock [ms]. */
double hl_inputs_clock_ms(void);

#endif
