/**
 * What the lights of a rig stand on: how far they are from a sphere, from rings about an axis, or from
 * a plane grid, and which of them are off.
 *
 * Directions alone are on a sphere by themselves, so that a sphere is looked for only where positions
 * are known. Each shape states a density of lights; it is compared, by the Bayesian information
 * criterion, with lights without order (uniform over a cap, or normal about their mean; of positions
 * uniform over a ball, or normal). A shape is claimed where its log odds reach HL_DOME_EVIDENCE_MIN,
 * at most a quarter of the lights are off it, and the rest has twice as many coordinates as the shape
 * has unknowns (src/dome.c).
 */
#ifndef HALFLIGHT_DOME_H
#define HALFLIGHT_DOME_H

#include <stdbool.h>

#include "halflight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What the lights of a rig may stand on. */
typedef enum hl_dome_shape {
  HL_DOME_NONE,
  HL_DOME_SPHERE, /* positions only */
  HL_DOME_RINGS,  /* circles about one axis; of positions one circle in space */
  HL_DOME_GRID    /* nodes of a plane lattice; its cells are parallelograms */
} hl_dome_shape;

enum { HL_DOME_RINGS_MAX = 8, HL_DOME_SHAPES = 4, HL_DOME_LIGHTS_MIN = 6 };

/** Natural logarithm of the odds from which a shape is claimed: chosen on 1600 drawn rigs of 8 to 47
 * lights without order, over a hemisphere, in a cone, crowded or all around, of which 2 pass it. */
#define HL_DOME_EVIDENCE_MIN 12.0

/** One shape laid through the lights. Lengths are metres where positions were given; a grid of
 * directions is known up to its distance, and its plane is 1 away. */
typedef struct hl_dome_fit {
  hl_dome_shape shape;
  bool fitted;     /* false: too few lights for it, and the rest is zero */
  bool pole;       /* rings: a light is on the axis itself, and belongs */
  double evidence; /* log odds against lights without order, natural */
  double rms;      /* distance of the lights that belong to it [rad or m] */
  double sigma;    /* deviation of one coordinate of that, parameters accounted for */
  int n_on, n_off; /* lights that belong to it, lights that do not */
  double axis[3];  /* rings: unit */
  int n_rings;     /* circles with at least three lights each */
  double half_angle_rad[HL_DOME_RINGS_MAX]; /* of directions: from the axis, ascending */
  double center_m[3];                       /* of positions: the sphere's or the circle's */
  double radius_m;
  double corner[3], step[2][3]; /* grid: node (i, j) is corner + i step[0] + j step[1] */
  int first[2], size[2];        /* lowest i, j of a light that belongs; nodes from there on */
} hl_dome_fit;

/** All shapes that were tried, and which of them, if any, is claimed. */
typedef struct hl_dome {
  hl_dome_shape shape;             /* HL_DOME_NONE: no claim */
  bool positions;                  /* fitted to positions [m], else to directions [rad] */
  int n;                           /* lights it was fitted to */
  hl_dome_fit fit[HL_DOME_SHAPES]; /* by shape */
} hl_dome;

/**
 * Fit all shapes to lights.
 * @param x         shape (n,3) row-major: unit directions, or positions [m]
 * @param sigma     what the lights are known to, one coordinate [rad or m], >= 0; no shape is taken to
 *                  hold more closely
 * @param off       shape (n), each light's distance from the claimed shape [rad or m]; 0 without one
 * @param is_off    shape (n), lights that do not belong to the claimed shape
 * @return HL_OK, also without a claim; HL_ERR_ARG (n < 0, sigma, a direction that is not unit, a number
 *         that is not finite: which); HL_ERR_MEMORY
 * Outputs are written only on HL_OK. Cost: some 50 ms; the search goes by at most 64 lights, so that more of
 * them add O(n).
 * Source: Schwarz, Estimating the Dimension of a Model, Ann. Statist. 6 (1978), eq. 2.
 */
HL_API hl_status hl_dome_fit_to(hl_ctx *ctx, const double *x, int n, bool positions, double sigma,
                                hl_dome *out, double *off, bool *is_off);

/** "sphere", "rings", "grid"; "none" for HL_DOME_NONE and outside the list. */
HL_API const char *hl_dome_shape_text(hl_dome_shape shape);

#ifdef __cplusplus
}
#endif
#endif
