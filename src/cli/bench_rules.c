/* What others do to find the light on a ball, from their description, for comparison only.
 *
 *   mirror law          s = 2 (n.v) n - v at the highlight; v = (0, 0, -1) and n from the ball's circle
 *                       (orthographic), or the pixel's ray and the sphere (perspective)
 *   Lambert             least squares of n.b = I over the lit pixels that are not clipped, s = b / |b|
 *   relight             8-bit grey within 50 degrees of the ball's centre; the threshold falls from 240 by
 *                       10 until ten pixels reach it, below 200 there is no light; the weighted centroid in
 *                       windows that halve; twice the normal's angle, plus that between the view to the
 *                       ball and to the highlight
 *   AliceVision         brightest point after a triangle blur of radius R / 20, orthographic mirror law;
 *                       white sphere: least squares over 0.2 < I < 0.8 within 0.95 R, orthographic
 */
#include <math.h>
#include <stdlib.h>

#include "bench_scene.h"
#include "halflight/vec3.h"

static const double LOBE_SHARE = 0.9; /* of the brightest: what belongs to a highlight */

static bool mirror(const double n[3], const double v[3], double light[3])
{
  for (int i = 0; i < 3; i++)
    light[i] = 2 * hl_dot(n, v) * n[i] - v[i];
  hl_unit(light, light);
  return true;
}

/* Outward normal that the circle gives, in a parallel view. */
static bool circle_normal(const hl_bench_scene *s, double x, double y, double n[3])
{
  n[0] = (x - s->circle[0]) / s->circle[2];
  n[1] = (y - s->circle[1]) / s->circle[2];
  const double rest = 1 - n[0] * n[0] - n[1] * n[1];
  n[2] = -sqrt(fmax(rest, 0));
  return rest >= 0;
}

static bool mirror_at(const hl_bench_scene *s, bool perspective, double x, double y,
                      double light[3])
{
  double n[3], v[3] = {0, 0, -1};
  if (!perspective)
    return circle_normal(s, x, y, n) && mirror(n, v, light);
  double ray[3];
  const double *center = s->sphere.center_m, r = s->sphere.radius_m;
  if (hl_camera_unproject(NULL, &s->camera, x, y, ray) != HL_OK)
    return false;
  const double along = hl_dot(ray, center);
  const double inside = along * along - hl_dot(center, center) + r * r;
  if (inside < 0)
    return false;
  for (int i = 0; i < 3; i++) {
    n[i] = (ray[i] * (along - sqrt(inside)) - center[i]) / r;
    v[i] = -ray[i];
  }
  return mirror(n, v, light);
}

static int brightest(const hl_bench_scene *s)
{
  int best = s->surface.pixel[0];
  for (int i = 1; i < s->surface.n; i++)
    if (s->grey[s->surface.pixel[i]] > s->grey[best])
      best = s->surface.pixel[i];
  return best;
}

bool hl_rule_brightest(const hl_bench_scene *s, bool perspective, double light[3])
{
  const int p = brightest(s), column = p % s->frame.width, row = p / s->frame.width;
  return mirror_at(s, perspective, column, row, light);
}

bool hl_rule_centroid(const hl_bench_scene *s, bool perspective, double light[3])
{
  const double least = LOBE_SHARE * (double)s->grey[brightest(s)];
  double x = 0, y = 0, weight = 0;
  for (int i = 0; i < s->surface.n; i++) {
    const int p = s->surface.pixel[i];
    const double g = (double)s->grey[p];
    if (g < least)
      continue;
    const int column = p % s->frame.width, row = p / s->frame.width;
    x += g * column;
    y += g * row;
    weight += g;
  }
  return weight > 0 && mirror_at(s, perspective, x / weight, y / weight, light);
}

/* Normal equations of n.b = I. */
typedef struct plane_sum {
  double a[3][3], b[3];
} plane_sum;

static void plane_add(plane_sum *sum, const double n[3], double value)
{
  for (int i = 0; i < 3; i++) {
    sum->b[i] += n[i] * value;
    for (int j = 0; j < 3; j++)
      sum->a[i][j] += n[i] * n[j];
  }
}

/* By Cramer's rule; three normal equations of unit rows need no more. */
static bool plane_solve(const plane_sum *sum, double light[3])
{
  double x[3], y[3], z[3];
  hl_cross(sum->a[1], sum->a[2], x);
  hl_cross(sum->a[2], sum->a[0], y);
  hl_cross(sum->a[0], sum->a[1], z);
  const double determinant = hl_dot(sum->a[0], x);
  if (!(determinant > 0))
    return false;
  for (int i = 0; i < 3; i++)
    light[i] = sum->b[0] * x[i] + sum->b[1] * y[i] + sum->b[2] * z[i];
  hl_unit(light, light);
  return true;
}

bool hl_rule_lambert(const hl_bench_scene *s, double light[3])
{
  const double most = (double)s->grey[brightest(s)];
  plane_sum sum = {0};
  for (int i = 0; i < s->surface.n; i++) {
    const int p = s->surface.pixel[i];
    const double g = (double)s->grey[p];
    bool clipped = false;
    for (int c = 0; c < s->frame.channels; c++)
      clipped = clipped || s->frame.state[p * s->frame.channels + c] != HL_SAMPLE_OK;
    if (g > 0.02 * most && !clipped)
      plane_add(&sum, s->surface.normal + 3 * i, g);
  }
  return plane_solve(&sum, light);
}

/* The code of an 8-bit picture in sRGB. */
static int code_of(const hl_bench_scene *s, int x, int y)
{
  if (x < 0 || y < 0 || x >= s->frame.width || y >= s->frame.height)
    return 0;
  const double g = fmin(fmax((double)s->grey[y * s->frame.width + x], 0), 1);
  return (int)(255 * (g <= 0.0031308 ? 12.92 * g : 1.055 * pow(g, 1 / 2.4) - 0.055) + 0.5);
}

/* Centroid of codes of at least `least`, within `reach` of (x, y) and the inner circle. */
static int spot(const hl_bench_scene *s, int least, double reach, bool weighted, double *x,
                double *y)
{
  const double inner = s->circle[2] * sin(50 * 3.14159265358979323846 / 180);
  double sx = 0, sy = 0, sum = 0;
  int n = 0;
  for (int j = (int)(*y - reach); j <= (int)(*y + reach + 1); j++)
    for (int i = (int)(*x - reach); i <= (int)(*x + reach + 1); i++) {
      if (hypot(i - s->circle[0], j - s->circle[1]) > inner)
        continue;
      const int code = code_of(s, i, j);
      if (code < least)
        continue;
      const double w = weighted ? code : 1;
      sx += w * i;
      sy += w * j;
      sum += w;
      n++;
    }
  if (n > 0) {
    *x = sx / sum;
    *y = sy / sum;
  }
  return n;
}

bool hl_rule_relight(const hl_bench_scene *s, double light[3])
{
  const double inner = s->circle[2] * sin(50 * 3.14159265358979323846 / 180);
  double x = 0, y = 0;
  int least = 250, n = 0;
  do {
    least -= 10;
    x = s->circle[0];
    y = s->circle[1];
    n = spot(s, least, inner, false, &x, &y);
  } while (n < 10 && least > 110);
  if (n < 1 || least < 200)
    return false;
  for (int halving = 0; halving < 5; halving++) /* down to a sixteenth */
    if (spot(s, least, ldexp(inner, -halving), true, &x, &y) == 0)
      break;
  double at[3], center[3], cross[3], n3[3];
  if (!circle_normal(s, x, y, n3) || hl_camera_unproject(NULL, &s->camera, x, y, at) != HL_OK)
    return false;
  hl_unit(s->sphere.center_m, center);
  hl_cross(at, center, cross);
  const double d = fmax(hypot(n3[0], n3[1]), 1e-12);
  const double angle = 2 * asin(d) + asin(hl_norm(cross));
  light[0] = n3[0] / d * sin(angle);
  light[1] = n3[1] / d * sin(angle);
  light[2] = -fabs(cos(angle));
  return true;
}

bool hl_rule_alicevision_bright(const hl_bench_scene *s, double light[3])
{
  const int w = s->frame.width, k = (int)(s->circle[2] / 20 + 0.5);
  int best = s->surface.pixel[0];
  double most = -1;
  for (int i = 0; i < s->surface.n; i++) {
    const int p = s->surface.pixel[i], x = p % w, y = p / w;
    double sum = 0;
    for (int b = -k; b <= k; b++)
      for (int a = -k; a <= k; a++)
        if (x + a >= 0 && x + a < w && y + b >= 0 && y + b < s->frame.height)
          sum += (k + 1 - abs(a)) * (k + 1 - abs(b)) * (double)s->grey[(y + b) * w + x + a];
    if (sum > most) {
      most = sum;
      best = p;
    }
  }
  const int column = best % w, row = best / w;
  return mirror_at(s, false, column, row, light);
}

bool hl_rule_alicevision_white(const hl_bench_scene *s, double light[3])
{
  plane_sum sum = {0};
  for (int i = 0; i < s->surface.n; i++) {
    const int p = s->surface.pixel[i];
    const double g = (double)s->grey[p];
    double n[3];
    const int column = p % s->frame.width, row = p / s->frame.width;
    if (g > 0.2 && g < 0.8 && circle_normal(s, column, row, n) && hypot(n[0], n[1]) < 0.95)
      plane_add(&sum, n, g);
  }
  return plane_solve(&sum, light);
}
