/**
 * Lights as neighbouring tools keep them.
 *
 *   lp           RTI tools: `name x y z` a light; x right, y up, z towards the camera
 *   dome         relight's JSON of a dome; the frame of lp
 *   alicevision  the JSON of AliceVision's photometric stereo; x right, y down, z forward, as here
 *   usda         OpenUSD text: a DistantLight a light, a SphereLight where its place is known;
 *                x right, y up, z backward, the camera at the origin as USD's cameras look
 *
 * All of them are written; all but usda are read.
 */
#ifndef HALFLIGHT_INTERCHANGE_H
#define HALFLIGHT_INTERCHANGE_H

#include "halflight/lights.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Files of other tools that hold lights. */
typedef enum hl_lights_format {
  HL_LIGHTS_LP,
  HL_LIGHTS_DOME,
  HL_LIGHTS_ALICEVISION,
  HL_LIGHTS_USDA
} hl_lights_format;

/** "lp", "dome", "alicevision", "usda"; NULL past the last. */
HL_API const char *hl_lights_format_name(int format);

/**
 * Lights of any file that holds some: lp, dome, alicevision, lights.json, and light.json as a list of
 * one. Told apart by what they hold. Of files of other tools `out` has names, directions (made unit)
 * and intensities (1 where there are none); no camera, no ball, no covariance, and a light without a
 * direction, as dome keeps one of zeros, is not found.
 * @param out the caller's, hl_lights_free; untouched on failure
 * @return HL_OK; HL_ERR_IO; HL_ERR_FORMAT with the line or the element, and the value; HL_ERR_MEMORY
 */
HL_API hl_status hl_lights_import(hl_ctx *ctx, const char *path, hl_lights *out);

/** Does the file look like one that hl_lights_import reads? A file that is not JSON does where it
 * begins with a digit or its name ends in .lp. HL_OK, HL_ERR_IO, HL_ERR_FORMAT, HL_ERR_MEMORY. */
HL_API hl_status hl_lights_file_is(hl_ctx *ctx, const char *path, bool *out);

/**
 * The text of a file, decimal point whatever the locale. *out is the caller's, free(). Lights that
 * were not found are left out; dome keeps their places, with zeros as relight has them.
 * Brightness in usda: `intensity` times `color` is the irradiance at the ball, relative to the
 * session's median light.
 * @return HL_OK; HL_ERR_ARG (no such format, no light was found); HL_ERR_MEMORY. O(n).
 */
HL_API hl_status hl_lights_text(hl_ctx *ctx, const hl_lights *lights, hl_lights_format format,
                                char **out);

/** What lights may have beside directions. */
typedef enum hl_lights_part {
  HL_LIGHTS_NAMES = 1,
  HL_LIGHTS_INTENSITIES = 2,
  HL_LIGHTS_POSITIONS = 4,
  HL_LIGHTS_COVARIANCES = 8
} hl_lights_part;

/** Parts that these lights have and the format has no place for; 0 = nothing is lost. */
HL_API unsigned hl_lights_lost(const hl_lights *lights, hl_lights_format format);

#ifdef __cplusplus
}
#endif
#endif
