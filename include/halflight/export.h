/**
 * Results as files; each appears whole or not at all (temporary name beside it, then rename).
 */
#ifndef HALFLIGHT_EXPORT_H
#define HALFLIGHT_EXPORT_H

#include "halflight/light.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How long the steps took. */
typedef struct hl_timing {
  double read_ms, locate_ms, estimate_ms, export_ms;
} hl_timing;

/** LIGHT.json as text; *out is the caller's, release it with free(). `timing` may be NULL. */
HL_API hl_status hl_light_json(hl_ctx *ctx, const hl_light *light, const hl_timing *timing,
                               char **out);

/** Write LIGHT.json, whole or not at all. HL_ERR_IO; HL_ERR_MEMORY. */
HL_API hl_status hl_light_json_write(hl_ctx *ctx, const char *path, const hl_light *light,
                                     const hl_timing *timing);

/** Columns lobe, channel, quantity, angle_deg, value; decimal point whatever the locale. */
HL_API hl_status hl_curves_csv_write(hl_ctx *ctx, const char *path, const hl_light *light);

/**
 * `.lp` of RTI tools: the count, then a line `name x y z` a light; x right, y up, z towards the
 * camera.
 * @param names shape (n), file names without line breaks, written as they are; readers part a line
 *        at its spaces, so the command writes `_` for white space. directions shape (n,3) in the
 *        camera frame
 */
HL_API hl_status hl_lp_write(hl_ctx *ctx, const char *path, const char *const *names,
                             const double *directions, int n);

/** Text to a file, whole or not at all. HL_OK; HL_ERR_IO. */
HL_API hl_status hl_file_write(hl_ctx *ctx, const char *path, const char *bytes, size_t n);

#ifdef __cplusplus
}
#endif
#endif
