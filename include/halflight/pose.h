/**
 * Rigid motions: a rotation vector (Rodrigues: axis times angle) and a translation.
 *
 * `cam_from_board` is applied as p_cam = R(rotation_rad) p_board + translation_m. The six numbers of
 * a pose, wherever they stand in a row, are rotation first, then translation; derivatives are by the
 * components of the rotation vector itself, as OpenCV and mrcal take them.
 */
#ifndef HALFLIGHT_POSE_H
#define HALFLIGHT_POSE_H

#include "halflight/api.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { HL_POSE_SIZE = 6 };

/** A rigid motion. */
typedef struct hl_pose {
  double rotation_rad[3];
  double translation_m[3];
} hl_pose;

/** The rotation as a matrix, row by row. */
HL_API void hl_pose_matrix(const hl_pose *pose, double out[3][3]);

/** Pose of a rotation matrix and a translation; the rotation vector's length is within [0, pi]. */
HL_API void hl_pose_from_matrix(const double rotation[3][3], const double translation_m[3],
                                hl_pose *out);

/**
 * out = R p + t, with its derivatives.
 * @param by_pose  shape (3,6); may be NULL
 * @param by_point shape (3,3), the rotation itself; may be NULL
 */
HL_API void hl_pose_apply(const hl_pose *pose, const double point[3], double out[3],
                          double by_pose[3][HL_POSE_SIZE], double by_point[3][3]);

/** out = a after b: a_from_c = a_from_b b_from_c. `out` may be either. */
HL_API void hl_pose_compose(const hl_pose *a, const hl_pose *b, hl_pose *out);

/**
 * A pose that is moved a little after itself, by x = (turn w [rad], shift s [m]): p -> p + w x p + s.
 * How x follows the pose's own six numbers, shape (6,6).
 */
HL_API void hl_pose_motion(const hl_pose *pose, double out[HL_POSE_SIZE][HL_POSE_SIZE]);

/** What such a motion x before a pose is after it: pose exp(x) = exp(out x) pose. */
HL_API void hl_pose_adjoint(const hl_pose *pose, double out[HL_POSE_SIZE][HL_POSE_SIZE]);

/** `out` may be `pose`. */
HL_API void hl_pose_inverse(const hl_pose *pose, hl_pose *out);

#ifdef __cplusplus
}
#endif
#endif
