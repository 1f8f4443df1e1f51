/*
 * Rigid motions.
 *
 * With w the rotation vector, t = |w| and W = [w]x:
 *
 *   R(w)   = I + A W + B W^2,      A = sin t / t,  B = (1 - cos t) / t^2
 *   d(R p) = -[R p]x J dw,         J = I + B W + C W^2,  C = (t - sin t) / t^3   (left Jacobian)
 *
 * A motion x = (dw', ds) after (R, t) is dw' = J dw, ds = dt + t x J dw; one before it, x, is
 * (R w, R s + t x R w) after it.
 *
 * A, B and C are taken from their series where t is small. The way back goes through the unit
 * quaternion's largest component (Shepperd 1978), which is stable at every angle up to pi.
 */
#include "halflight/pose.h"

#include <string.h>

#include "halflight/vec3.h"

static const double small_angle = 0.1; /* the series' next term is below rounding there */

typedef struct factors {
  double a, b, c;
} factors;

static factors factors_of(double t)
{
  const double q = t * t;
  factors f = {1 - q / 6 * (1 - q / 20 * (1 - q / 42 * (1 - q / 72))),
               0.5 - q / 24 * (1 - q / 30 * (1 - q / 56 * (1 - q / 90))),
               1.0 / 6 - q / 120 * (1 - q / 42 * (1 - q / 72 * (1 - q / 110)))};
  if (t > small_angle) {
    f.a = sin(t) / t;
    f.b = 2 * sin(t / 2) * sin(t / 2) / q;
    f.c = (t - sin(t)) / (q * t);
  }
  return f;
}

/* I + x W + y W^2 */
static void polynomial(const double w[3], double x, double y, double out[3][3])
{
  const double q = hl_dot(w, w);
  const double cross[3][3] = {{0, -w[2], w[1]}, {w[2], 0, -w[0]}, {-w[1], w[0], 0}};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      out[i][j] = (i == j) + x * cross[i][j] + y * (w[i] * w[j] - (i == j ? q : 0));
}

void hl_pose_matrix(const hl_pose *pose, double out[3][3])
{
  const factors f = factors_of(hl_norm(pose->rotation_rad));
  polynomial(pose->rotation_rad, f.a, f.b, out);
}

void hl_pose_from_matrix(const double rotation[3][3], const double translation_m[3], hl_pose *out)
{
  const double(*r)[3] = rotation;
  const double trace = r[0][0] + r[1][1] + r[2][2];
  double v[3], s; /* sin(t/2) axis and cos(t/2), both times a common factor */
  int i = 0;
  for (int k = 1; k < 3; k++)
    i = r[k][k] > r[i][i] ? k : i;
  if (trace >= r[i][i]) {
    s = 1 + trace;
    v[0] = r[2][1] - r[1][2];
    v[1] = r[0][2] - r[2][0];
    v[2] = r[1][0] - r[0][1];
  } else {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    v[i] = 1 + r[i][i] - r[j][j] - r[k][k];
    v[j] = r[i][j] + r[j][i];
    v[k] = r[k][i] + r[i][k];
    s = r[k][j] - r[j][k];
  }
  const double length = hl_norm(v);
  const double sign = s < 0 ? -1 : 1;
  const double angle = 2 * atan2(length, fabs(s));
  const double scale = length > 0 ? sign * angle / length : 0;
  memcpy(out->translation_m, translation_m, sizeof out->translation_m);
  for (int k = 0; k < 3; k++)
    out->rotation_rad[k] = scale * v[k];
}

void hl_pose_apply(const hl_pose *pose, const double point[3], double out[3],
                   double by_pose[3][HL_POSE_SIZE], double by_point[3][3])
{
  const factors f = factors_of(hl_norm(pose->rotation_rad));
  double rotation[3][3], turned[3];
  polynomial(pose->rotation_rad, f.a, f.b, rotation);
  for (int i = 0; i < 3; i++)
    turned[i] = hl_dot(rotation[i], point);
  if (by_pose) {
    double left[3][3];
    polynomial(pose->rotation_rad, f.b, f.c, left);
    for (int j = 0; j < 3; j++) {
      const double column[3] = {left[0][j], left[1][j], left[2][j]};
      double moved[3];
      hl_cross(column, turned, moved);
      for (int i = 0; i < 3; i++) {
        by_pose[i][j] = moved[i];
        by_pose[i][3 + j] = i == j;
      }
    }
  }
  if (by_point)
    memcpy(by_point, rotation, sizeof rotation);
  hl_add_scaled(turned, 1, pose->translation_m, out);
}

/* out = [m 0; [t]x m x], x the lower right block */
static void blocks(const double m[3][3], const double t[3], const double x[3][3],
                   double out[HL_POSE_SIZE][HL_POSE_SIZE])
{
  memset(out, 0, sizeof(double[HL_POSE_SIZE][HL_POSE_SIZE]));
  for (int j = 0; j < 3; j++) {
    const double column[3] = {m[0][j], m[1][j], m[2][j]};
    double moved[3];
    hl_cross(t, column, moved);
    for (int i = 0; i < 3; i++) {
      out[i][j] = column[i];
      out[3 + i][j] = moved[i];
      out[3 + i][3 + j] = x[i][j];
    }
  }
}

void hl_pose_motion(const hl_pose *pose, double out[HL_POSE_SIZE][HL_POSE_SIZE])
{
  static const double unit[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const factors f = factors_of(hl_norm(pose->rotation_rad));
  double left[3][3];
  polynomial(pose->rotation_rad, f.b, f.c, left);
  blocks((const double(*)[3])left, pose->translation_m, unit, out);
}

void hl_pose_adjoint(const hl_pose *pose, double out[HL_POSE_SIZE][HL_POSE_SIZE])
{
  double rotation[3][3];
  hl_pose_matrix(pose, rotation);
  blocks((const double(*)[3])rotation, pose->translation_m, (const double(*)[3])rotation, out);
}

void hl_pose_compose(const hl_pose *a, const hl_pose *b, hl_pose *out)
{
  double first[3][3], second[3][3], product[3][3], moved[3];
  hl_pose_matrix(a, first);
  hl_pose_matrix(b, second);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      product[i][j] = 0;
      for (int k = 0; k < 3; k++)
        product[i][j] += first[i][k] * second[k][j];
    }
  hl_pose_apply(a, b->translation_m, moved, NULL, NULL);
  hl_pose_from_matrix((const double(*)[3])product, moved, out);
}

void hl_pose_inverse(const hl_pose *pose, hl_pose *out)
{
  double rotation[3][3], back[3];
  hl_pose_matrix(pose, rotation);
  for (int j = 0; j < 3; j++) {
    back[j] = 0;
    for (int i = 0; i < 3; i++)
      back[j] -= rotation[i][j] * pose->translation_m[i];
  }
  for (int i = 0; i < 3; i++) {
    out->rotation_rad[i] = -pose->rotation_rad[i];
    out->translation_m[i] = back[i];
  }
}
