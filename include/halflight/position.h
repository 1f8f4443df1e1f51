/**
 * Where a near light is, from sights: directions towards it seen from several places, by several balls
 * in one frame or by one ball in several places.
 *
 * A sight is a ray with an origin c, a direction d and their covariances. The light is sought as
 * direction s and nearness w = 1 / distance from the sights' mean origin, L = c0 + s / w, in which the
 * rays' angular residuals are nearly linear also where the light is too far to tell (calib/position.c).
 */
#ifndef HALFLIGHT_POSITION_H
#define HALFLIGHT_POSITION_H

#include "halflight/light.h"
#include "halflight/sphere.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { HL_SIGHTS_MAX = 256 };

/** All in one frame: that of the camera, or of the rig where the camera moved. */
typedef struct hl_sight {
  double origin_m[3];
  double origin_covariance_m2[3][3];
  double direction[3]; /* unit, towards the light */
  double tangent_basis[2][3];
  double own_rad2[2][2];  /* covariance of the direction with the origin held */
  double by_origin[2][3]; /* how the direction follows an error of the origin [rad/m] */
  bool doubted;           /* the estimate said that it is not to be trusted */
} hl_sight;

/** How a sight fits. */
typedef struct hl_sight_fit {
  bool used;          /* false: it contradicts the others, and was left out */
  double off_rad;     /* angle from its direction to the light's position */
  double chi_squared; /* of its two residuals; of one left out, against the others' answer */
} hl_sight_fit;

/** Where a near light is, and how sure that is. */
typedef struct hl_position {
  bool trusted; /* false: reasons say why */
  hl_notes reasons, left_out;
  bool found; /* the rays meet at a finite distance, at 95 % confidence; else no position */
  double position_m[3];
  double covariance_m2[3][3]; /* by propagation; distance_95_m holds far from small errors too */
  double from_m[3];           /* c0, mean origin of the sights used */
  double direction[3];        /* unit, from there; of a light at infinity where none was found */
  double distance_m;          /* from there; HUGE_VAL where none was found */
  double distance_95_m[2];    /* interval; the far end HUGE_VAL where none was found */
  double least_distance_m;    /* the light is farther than this at 95 %, one-sided */
  double chi_squared;
  int dof;            /* 2 sights - 3 */
  double probability; /* of so large a chi-squared where nothing is wrong */
  int n, n_used;
  hl_sight_fit sight[HL_SIGHTS_MAX]; /* in the order given */
} hl_position;

/**
 * The sight of one ball.
 *
 * Where the estimate placed the light near, its direction is from the ball's centre. Where it took the
 * light as distant, its direction is that at some point of the ball: the sight starts at the middle
 * of the highlight, c + R h, and may be off by half a radius in each direction (one deviation).
 * Drawn balls of three materials with the light 5 to 50 radii away, taken as distant, left 0.0 to 0.8
 * radii from the line of sight through the highlight, and 0.4 to 1.2 through the centre.
 *
 * @return HL_OK; HL_ERR_ARG (no direction found; the sphere, as hl_sphere_check has it)
 */
HL_API hl_status hl_sight_of_light(hl_ctx *ctx, const hl_light *light, const hl_sphere *sphere,
                                   hl_sight *out);

/**
 * The same from LIGHT.json, as `estimate` writes it, and the SPHERE.json it was estimated with.
 * @return HL_OK; HL_ERR_IO; HL_ERR_FORMAT (also a file without a light); HL_ERR_MEMORY
 */
HL_API hl_status hl_sight_read(hl_ctx *ctx, const char *light_path, const char *sphere_path,
                               hl_sight *out);

/**
 * Intersect sights by weighted least squares on their angular residuals: closed form, then
 * Gauss-Newton.
 *
 * Of three sights or more, up to a third are left out where they contradict the others (chi-squared
 * less than 1 % probable) and the rest, and only that rest, agrees. Sights are taken as independent
 * of each other: what the camera's intrinsics move in all of them together is not seen. A position
 * that a doubted sight helped to place is not trusted.
 *
 * @param n   2 .. HL_SIGHTS_MAX
 * @param out written on HL_OK and on HL_ERR_DEGENERATE (found = false; direction, least_distance_m
 *            and reasons filled where the sights have different origins)
 * @return HL_OK, also where the answer is not to be trusted (out->trusted says);
 *         HL_ERR_ARG (n, a direction that is not unit, a tangent basis that is none, a matrix that is
 *         no covariance: which sight, which value);
 *         HL_ERR_DEGENERATE (one origin for all; rays parallel, or parting, within their ellipses)
 * Allocates nothing. O(n), O(n^2) where sights contradict each other.
 */
HL_API hl_status hl_position_of_sights(hl_ctx *ctx, const hl_sight *sights, int n,
                                       hl_position *out);

/**
 * POSITION.json (format "halflight-position", version 1); *out is the caller's, release it with free().
 * @param names of the sights, shape (position->n)
 * @return HL_OK; HL_ERR_MEMORY
 */
HL_API hl_status hl_position_json(hl_ctx *ctx, const hl_position *position,
                                  const char *const *names, char **out);

#ifdef __cplusplus
}
#endif
#endif
