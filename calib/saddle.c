/*
 * Corners where two black and two white quarters meet: saddles of radiance.
 *
 * OpenCV's cornerSubPix looks for the point that every gradient around is perpendicular to the way
 * to (Forstner 1987). Half a turn about a saddle maps it onto itself, so blur does not move it,
 * provided the window sees little but the four quarters: a window of 0.6 of their reach is the best
 * there. On rendered boards, 640 x 480 px, blur 0.7 px, noise 0.5 % of white (errors in px, root
 * mean square of the distance):
 *
 *   half the window:                   2     3     4     5     6
 *   tags of 51 px, quarters of 10 px  .056  .059  .034  .031  .060
 *   tags of 25 px, quarters of 5 px   .056  .038  .052  .24   .77
 *
 * AprilTag's own edges on those boards, coded as sRGB: 0.52, nearly all of it inward.
 */
#include "saddle.h"

#include <math.h>
#include <stdlib.h>

#include "halflight/bridge_opencv_corners.h"

static const double share = 0.6;  /* of the quarters' reach */
static const double moved_px = 2; /* a corner may move so far: coded edges are off by about the */
static const double moved_reach = 0.1; /* blur, widened white by up to two pixels a side */

void hl_cross_quarters(const hl_grey *grey, const hl_cross *cross, double quarter[4])
{
  static const double side[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  static const double way[3] = {0.35, 0.5, 0.65};
  for (int k = 0; k < 4; k++) {
    double sum = 0;
    for (int i = 0; i < 9; i++) {
      const double u = side[k][0] * way[i % 3];
      const double v = side[k][1] * way[i / 3];
      sum += hl_grey_at(grey, cross->at[0] + u * cross->across[0] + v * cross->down[0],
                        cross->at[1] + u * cross->across[1] + v * cross->down[1]);
    }
    quarter[k] = sum / 9;
  }
}

/* Distance from the corner to the nearer border of the parallelogram that the quarters fill. */
static double reach_of(const hl_cross *cross)
{
  const double *e = cross->across;
  const double *f = cross->down;
  const double area = fabs(e[0] * f[1] - e[1] * f[0]);
  const double longer = fmax(hypot(e[0], e[1]), hypot(f[0], f[1]));
  return longer > 0 ? area / longer : 0;
}

int hl_cross_half(const hl_cross *cross)
{
  const double half = share * reach_of(cross) + 0.5;
  return half < HL_SADDLE_HALF_MAX ? (int)half : HL_SADDLE_HALF_MAX;
}

/* Runs the bridge on those with room for a window. */
static hl_status refine(hl_ctx *ctx, const hl_grey *grey, const hl_cross *cross, int n, int *half,
                        double (*at)[2], int *index)
{
  int m = 0;
  for (int i = 0; i < n; i++) {
    const double *p = cross[i].at;
    const int size = hl_cross_half(&cross[i]);
    const bool inside = p[0] >= size && p[1] >= size && p[0] <= grey->width - 1 - size &&
                        p[1] <= grey->height - 1 - size;
    if (size < HL_SADDLE_HALF_MIN || !inside)
      continue;
    half[m] = size;
    at[m][0] = p[0];
    at[m][1] = p[1];
    index[m++] = i;
  }
  index[m] = -1;
  return hl_opencv_saddles(ctx, grey->linear, grey->width, grey->height, half, at, m);
}

hl_status hl_saddles_refine(hl_ctx *ctx, const hl_grey *grey, hl_cross *cross, bool *moved, int n)
{
  const size_t room = (size_t)n + 1;
  int *half = malloc(room * sizeof *half);
  int *index = malloc(room * sizeof *index);
  double(*at)[2] = malloc(room * sizeof *at);
  hl_status st = HL_ERR_MEMORY;
  for (int i = 0; i < n; i++)
    moved[i] = false;
  if (half && index && at) {
    index[0] = -1;
    st = refine(ctx, grey, cross, n, half, at, index);
  } else {
    hl_fail(ctx, st, "no memory for %d corners", n);
  }
  for (int m = 0; st == HL_OK && index[m] >= 0; m++) {
    hl_cross *c = &cross[index[m]];
    const double way = hypot(at[m][0] - c->at[0], at[m][1] - c->at[1]);
    /* where nothing was found the point has not moved at all */
    moved[index[m]] = way > 0 && way <= moved_px + moved_reach * reach_of(c);
    if (moved[index[m]]) {
      c->at[0] = at[m][0];
      c->at[1] = at[m][1];
    }
  }
  free(half);
  free(index);
  free(at);
  return st;
}
