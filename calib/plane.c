/*
 * A plane seen by a camera, by least squares: with h33 = 1 and w = h31 x + h32 y + 1,
 *
 *   (h11 x + h12 y + h13 - u w) / w = 0,   (h21 x + h22 y + h23 - v w) / w = 0
 *
 * is linear but for the 1/w in front, which is taken from the round before; it turns the algebraic
 * error into one in pixels. Both sides are centred and scaled first (Hartley, In defence of the
 * 8-point algorithm, 1997), so that h33 is not small and the normal equations are good to 1e-10.
 *
 * Own code, since AprilGrids are found without OpenCV too, and this runs once a corner over a few
 * neighbours.
 */
#include "plane.h"

#include <math.h>
#include <string.h>

#include "spd.h"

enum { UNKNOWNS = 8, ROUNDS = 3 };

/* scaled = s (p - center) */
typedef struct scaling {
  double center[2], s;
} scaling;

static scaling scaling_of(const double (*p)[2], int n)
{
  scaling out = {{0, 0}, 1};
  double spread = 0;
  for (int i = 0; i < n; i++)
    for (int k = 0; k < 2; k++)
      out.center[k] += p[i][k] / n;
  for (int i = 0; i < n; i++)
    spread += hypot(p[i][0] - out.center[0], p[i][1] - out.center[1]) / n;
  if (spread > 0)
    out.s = 1 / spread;
  return out;
}

/* One row a' h = b with weight q into the normal equations. */
static void add_row(double normal[UNKNOWNS][UNKNOWNS], double right[UNKNOWNS],
                    const double a[UNKNOWNS], double b, double q)
{
  for (int i = 0; i < UNKNOWNS; i++) {
    for (int k = 0; k < UNKNOWNS; k++)
      normal[i][k] += q * a[i] * a[k];
    right[i] += q * a[i] * b;
  }
}

static bool solve(const double (*board)[2], const double (*pixel)[2], int n, const scaling *from,
                  const scaling *to, double h[UNKNOWNS])
{
  double normal[UNKNOWNS][UNKNOWNS] = {{0}};
  double right[UNKNOWNS] = {0};
  hl_spd factor;
  for (int i = 0; i < n; i++) {
    const double x = from->s * (board[i][0] - from->center[0]);
    const double y = from->s * (board[i][1] - from->center[1]);
    const double u = to->s * (pixel[i][0] - to->center[0]);
    const double v = to->s * (pixel[i][1] - to->center[1]);
    const double w = h[6] * x + h[7] * y + 1;
    const double across[UNKNOWNS] = {x, y, 1, 0, 0, 0, -u * x, -u * y};
    const double down[UNKNOWNS] = {0, 0, 0, x, y, 1, -v * x, -v * y};
    if (!(w > 1e-3)) /* beyond the horizon */
      return false;
    add_row(normal, right, across, u, 1 / (w * w));
    add_row(normal, right, down, v, 1 / (w * w));
  }
  if (!hl_spd_factor(normal[0], UNKNOWNS, 0, &factor, NULL))
    return false;
  hl_spd_solve(&factor, right, h);
  return true;
}

static void multiply(const double a[3][3], const double b[3][3], double out[3][3])
{
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++)
      out[i][k] = a[i][0] * b[0][k] + a[i][1] * b[1][k] + a[i][2] * b[2][k];
}

bool hl_plane_fit(const double (*board)[2], const double (*pixel)[2], int n, hl_plane *out)
{
  if (n < HL_PLANE_POINTS_MIN)
    return false;
  const scaling from = scaling_of(board, n);
  const scaling to = scaling_of(pixel, n);
  double h[UNKNOWNS] = {0};
  for (int round = 0; round < ROUNDS; round++)
    if (!solve(board, pixel, n, &from, &to, h))
      return false;
  const double middle[3][3] = {{h[0], h[1], h[2]}, {h[3], h[4], h[5]}, {h[6], h[7], 1}};
  const double before[3][3] = {
      {from.s, 0, -from.s * from.center[0]}, {0, from.s, -from.s * from.center[1]}, {0, 0, 1}};
  const double after[3][3] = {{1 / to.s, 0, to.center[0]}, {0, 1 / to.s, to.center[1]}, {0, 0, 1}};
  double part[3][3];
  multiply(middle, before, part);
  multiply(after, part, out->h);
  return true;
}

void hl_plane_at(const hl_plane *plane, const double board[2], double pixel[2])
{
  double p[3];
  for (int i = 0; i < 3; i++)
    p[i] = plane->h[i][0] * board[0] + plane->h[i][1] * board[1] + plane->h[i][2];
  pixel[0] = p[0] / p[2];
  pixel[1] = p[1] / p[2];
}
