/* The cone of rays that graze a ball, and how firmly outline points hold it. Private to calib/. */
#ifndef HALFLIGHT_CALIB_SPHERE_POSE_H
#define HALFLIGHT_CALIB_SPHERE_POSE_H

#include "halflight/sphere.h"

/* Solves A x = b for a symmetric positive definite A; false where it is not, to 1e-12. */
bool hl_solve3(const double a[3][3], const double b[3], double x[3]);

/* Unit axis with two unit vectors that complete it, and the half-angle. */
typedef struct hl_cone {
  double e1[3], e2[3], axis[3];
  double half_angle_rad;
} hl_cone;

/* The same cone turned by (turn1, turn2) rad towards e1 and e2 and opened by `open` rad. */
hl_cone hl_cone_step(const hl_cone *cone, const double step[3]);

/* Linear least squares for u.w = 1. Returns false where the rays do not span a cone. */
bool hl_cone_from_rays(const double *rays, int n, const double *weights, hl_cone *out);

/* One reading of the outline: where it lies outside the cone, and how sure that is. */
typedef struct hl_cone_offset {
  double azimuth_rad; /* about the axis, from e1 towards e2 */
  double offset_rad;  /* outward */
  double sigma_rad;
  double row[3]; /* out: cos, sin of the azimuth, 1 */
  double weight; /* out: 0 = set aside, up to 1 */
  double slope;  /* out: how its pull on the fit changes with the offset */
} hl_cone_offset;

typedef struct hl_cone_fit {
  double step[3];          /* turn1, turn2, open */
  double covariance[3][3]; /* of step, from the readings' own scatter */
  double inverse[3][3];    /* of step, from the stated sigmas and the excess */
  double bread[3][3];      /* inverse of sum slope row row' */
  double excess_rad;       /* scatter beyond the stated sigmas */
  double rms_rad;          /* of the readings kept, about the fit */
  int n_kept;
} hl_cone_fit;

/*
 * Robust (Tukey) weighted least squares of the three steps from n readings; `limit_rad` > 0 caps
 * the scale beyond which a reading is set aside. Returns false where the readings kept do not
 * determine the cone.
 */
bool hl_cone_fit_offsets(hl_cone_offset *readings, int n, double limit_rad, hl_cone_fit *out);

/* d center / d step */
void hl_cone_center_by_step(const hl_cone *cone, double radius_m, double out[3][3]);

/* Centre and 3x3 covariance from a cone, the covariance of its steps and the radius. */
void hl_cone_to_sphere(const hl_cone *cone, const double covariance[3][3], double radius_m,
                       hl_sphere *out);

#endif
