/**
 * Measured materials: the MERL database's tables of isotropic BRDFs (Matusik, Pfister, Brand, McMillan,
 * A Data-Driven Reflectance Model, SIGGRAPH 2003), files NAME.binary.
 *
 * With h the half-vector of light s and view v, theta_half is the angle(n,h), theta_diff the angle(h,s)
 * and phi_diff the turn of s about h, from the plane of n and h on: in the frame (t, b, h) with
 * b = n x h / |n x h|, t = b x h,
 *
 *   s = (sin theta_diff cos phi_diff, sin theta_diff sin phi_diff, cos theta_diff).
 *
 * A table is a grid of cells over (theta_half, theta_diff, phi_diff), 90 x 90 x 180:
 * cell (i,j,k) holds theta_half in [(i/90)^2, ((i+1)/90)^2] 90 deg, theta_diff in [j, j+1] deg and
 * phi_diff in [k, k+1] deg. phi_diff + 180 deg is s and v changed places, the same by reciprocity.
 */
#ifndef HALFLIGHT_MERL_H
#define HALFLIGHT_MERL_H

#include <stdbool.h>

#include "halflight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  HL_MERL_THETA_HALF = 90,
  HL_MERL_THETA_DIFF = 90,
  HL_MERL_PHI_DIFF = 180,
  HL_MERL_CELLS = HL_MERL_THETA_HALF * HL_MERL_THETA_DIFF * HL_MERL_PHI_DIFF
};

/** Owner of one block of 3 x 1458000 doubles (35 MB); hl_merl_free releases it. */
typedef struct hl_merl {
  double *value; /* shape (3, 90, 90, 180): red, green, blue; as stored. BRDF [1/sr] is value times
                    hl_merl_scale(channel); a negative value is a cell that was not measured */
} hl_merl;

/** The three angles of a table [rad]: theta_half and theta_diff in [0, pi/2], phi_diff in [0, pi). */
typedef struct hl_merl_angles {
  double theta_half, theta_diff, phi_diff;
} hl_merl_angles;

/** How a table is asked between the centres of its cells. */
typedef enum hl_merl_lookup {
  HL_MERL_SMOOTH, /* trilinear in the table's own coordinates, weighted by (n.s)(n.v) of each cell */
  HL_MERL_NEAREST /* the cell that holds the angles: what the database's own reader does */
} hl_merl_lookup;

/** BRDF of a stored value 1: 1/1500, 1.15/1500, 1.66/1500 for channels 0, 1, 2. */
HL_API double hl_merl_scale(int channel);

/** Place of a cell within a channel. */
static inline size_t hl_merl_cell(int half, int diff, int phi)
{
  return ((size_t)half * HL_MERL_THETA_DIFF + (size_t)diff) * HL_MERL_PHI_DIFF + (size_t)phi;
}

/** Angles of a cell's centre. */
HL_API hl_merl_angles hl_merl_center(int half, int diff, int phi);

/** Unit light and view, for the normal (0,0,1), that have these angles; either may lie below the
 * horizon. */
HL_API void hl_merl_directions(hl_merl_angles angles, double s[3], double v[3]);

/** Angles of unit light and view about a unit normal. s = v has phi_diff 0, n = h too. */
HL_API hl_merl_angles hl_merl_angles_of(const double n[3], const double s[3], const double v[3]);

/** A table without a measured cell. HL_OK; HL_ERR_MEMORY. */
HL_API hl_status hl_merl_new(hl_ctx *ctx, hl_merl *out);
/** Release what it holds; NULL is accepted. */
HL_API void hl_merl_free(hl_merl *merl);

/**
 * Read NAME.binary.
 * @param out the caller's, hl_merl_free
 * @return HL_OK; HL_ERR_IO; HL_ERR_FORMAT (not 90 x 90 x 180 cells, truncated, bytes left over, a value
 *         that is not finite, no measured cell); HL_ERR_MEMORY. Peak memory about 110 MB.
 */
HL_API hl_status hl_merl_read(hl_ctx *ctx, const char *path, hl_merl *out);

/** Write NAME.binary, whole or not at all; reads back bit for bit. HL_OK; HL_ERR_IO; HL_ERR_MEMORY;
 * HL_ERR_ARG (a value that is not finite). */
HL_API hl_status hl_merl_write(hl_ctx *ctx, const char *path, const hl_merl *merl);

/** Share of the cells that are measured, of those whose centre has light and view above the horizon. */
HL_API double hl_merl_measured(const hl_merl *merl);

/**
 * BRDF [1/sr] at angles.
 *
 * HL_MERL_SMOOTH weighs the eight cells about the angles by their trilinear weights times
 * (n.s)(n.v) at their centres: BRDFs rise as 1/((n.s)(n.v)) at grazing angles, where their product
 * with it is smooth. A constant comes back exactly. Cells below the horizon and cells that were not
 * measured are passed over; where less than half of the weight is left, the angles are not measured.
 *
 * @param out shape (3); NaN where not measured
 * @return whether it is measured, in all channels. Allocates nothing.
 */
HL_API bool hl_merl_at(const hl_merl *merl, hl_merl_angles angles, hl_merl_lookup lookup,
                       double out[3]);

/** The same for unit normal, light and view; 0, and measured, where n.s <= 0 or n.v <= 0. */
HL_API bool hl_merl_eval(const hl_merl *merl, const double n[3], const double s[3],
                         const double v[3], hl_merl_lookup lookup, double out[3]);

#ifdef __cplusplus
}
#endif
#endif
