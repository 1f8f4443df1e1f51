/**
 * Samples of a curved surface: normals, what was measured there, and from where it was seen.
 *
 * In a SAMPLES.csv the frame is the file's own; the view is (0,0,1) where no columns say otherwise.
 */
#ifndef HALFLIGHT_SAMPLES_H
#define HALFLIGHT_SAMPLES_H

#include "halflight/light.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Owner of its arrays; hl_samples_free releases them. Unit vectors; radiance is BRDF x cos. */
typedef struct hl_samples {
  int n, channels;                /* channels 1 or 3 */
  double *normal;                 /* shape (n,3) */
  double *view;                   /* shape (n,3); NULL: (0,0,1) for all */
  double *value[HL_CHANNELS_MAX]; /* shape (n) each: radiance; NULL from `channels` on */
} hl_samples;

/**
 * Read SAMPLES.csv: a header that names columns nx, ny, nz, then value or r, g, b, and optionally vx,
 * vy, vz, in any order; one row a sample, decimal points whatever the locale; empty lines and lines
 * that start with # are passed over. Normals and views are made unit where they are within 1 % of it.
 * One pass; memory for the samples alone.
 * @return HL_OK; HL_ERR_IO; HL_ERR_FORMAT (line, column and value of what is wrong: a normal that is
 *         zero, not finite or not unit; a value that is not finite or below 0; a column missing);
 *         HL_ERR_MEMORY
 */
HL_API hl_status hl_samples_read(hl_ctx *ctx, const char *path, hl_samples *out);
/** Release what it holds and zero it; NULL is accepted. */
HL_API void hl_samples_free(hl_samples *samples);

/** What hl_samples_read promises of every sample, for samples that were made in memory. HL_OK;
 * HL_ERR_ARG (which sample, which value). */
HL_API hl_status hl_samples_check(hl_ctx *ctx, const hl_samples *samples);

/** Write SAMPLES.csv, whole or not at all: columns nx, ny, nz, then value or r, g, b, and
 * vx, vy, vz where the samples have views; nine digits, decimal points whatever the locale. HL_OK;
 * HL_ERR_IO; HL_ERR_MEMORY. */
HL_API hl_status hl_samples_write(hl_ctx *ctx, const char *path, const hl_samples *samples);

#ifdef __cplusplus
}
#endif
#endif
