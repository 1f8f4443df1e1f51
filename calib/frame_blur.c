/*
 * How sharp a frame is where it is sharpest.
 *
 * A step blurred by s has a slope in proportion to 1/s, so its slopes after a further blur by a and
 * by b are in a ratio q with q^2 = (s^2 + b^2) / (s^2 + a^2) (Zhuo and Sim, Defocus map estimation
 * from a single image, 2011). Taken at the steepest pixel of every cell of the frame; the median of
 * the steepest tenth of them. Rendered boards: within 0.1 px up to 2; beyond 3 it is too small, the
 * more the noisier the frame, so it is said as "at least".
 */
#include "frame_blur.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CELLS = 48, RADIUS = 6, TAPS = 2 * RADIUS + 1, TOP = 10 };

static const double fine = 1; /* px, of the two further blurs */
static const double coarse = 2;
static const double worth_saying = 1.5; /* px; a sharp lens has 0.5 .. 1 */

static void kernels(double sigma, double smooth[TAPS], double slope[TAPS])
{
  double sum = 0;
  double ramp = 0;
  for (int i = 0; i < TAPS; i++) {
    const double x = i - RADIUS;
    smooth[i] = exp(-0.5 * x * x / (sigma * sigma));
    slope[i] = x * smooth[i];
    sum += smooth[i];
    ramp += x * slope[i];
  }
  for (int i = 0; i < TAPS; i++) {
    smooth[i] /= sum;
    slope[i] /= ramp;
  }
}

static double steepness(const hl_grey *grey, int x, int y, const double smooth[TAPS],
                        const double slope[TAPS])
{
  double gx = 0;
  double gy = 0;
  for (int i = 0; i < TAPS; i++) {
    const float *row =
        grey->linear + (size_t)(y + i - RADIUS) * (size_t)grey->width + (size_t)(x - RADIUS);
    for (int k = 0; k < TAPS; k++) {
      gx += smooth[i] * slope[k] * (double)row[k];
      gy += slope[i] * smooth[k] * (double)row[k];
    }
  }
  return hypot(gx, gy);
}

/* The steepest pixel of a cell of the frame by plain differences; 0 where it is flat. */
static double steepest(const hl_grey *grey, const int from[2], const int to[2], int at[2])
{
  const ptrdiff_t stride = grey->width;
  double most = 0;
  for (int y = from[1]; y < to[1]; y++)
    for (int x = from[0]; x < to[0]; x++) {
      const float *p = grey->linear + (size_t)y * (size_t)grey->width + (size_t)x;
      const double gx = (double)(p[1] - p[-1]);
      const double gy = (double)(p[stride] - *(p - stride));
      const double g = gx * gx + gy * gy;
      if (g > most) {
        most = g;
        at[0] = x;
        at[1] = y;
      }
    }
  return most;
}

typedef struct place {
  double steepness, blur;
} place;

static int steepest_first(const void *a, const void *b)
{
  const double p = ((const place *)a)->steepness;
  const double q = ((const place *)b)->steepness;
  return (p < q) - (p > q);
}

static int sharpest_first(const void *a, const void *b)
{
  const double p = ((const place *)a)->blur;
  const double q = ((const place *)b)->blur;
  return (p > q) - (p < q);
}

double hl_frame_blur(const hl_grey *grey)
{
  place found[CELLS * CELLS];
  double smooth[2][TAPS];
  double slope[2][TAPS];
  int n = 0;
  kernels(fine, smooth[0], slope[0]);
  kernels(coarse, smooth[1], slope[1]);
  const int room[2] = {grey->width - 2 * RADIUS, grey->height - 2 * RADIUS};
  if (room[0] < CELLS || room[1] < CELLS)
    return 0;
  for (int cell = 0; cell < CELLS * CELLS; cell++) {
    const int column = cell % CELLS;
    const int row = cell / CELLS;
    const int from[2] = {RADIUS + room[0] * column / CELLS, RADIUS + room[1] * row / CELLS};
    const int to[2] = {RADIUS + room[0] * (column + 1) / CELLS,
                       RADIUS + room[1] * (row + 1) / CELLS};
    int at[2] = {from[0], from[1]};
    if (!(steepest(grey, from, to, at) > 0))
      continue;
    const double a = steepness(grey, at[0], at[1], smooth[0], slope[0]);
    const double b = steepness(grey, at[0], at[1], smooth[1], slope[1]);
    const double q = a * a / (b * b);
    if (a > b && b > 0)
      found[n++] = (place){a, sqrt(fmax((coarse * coarse - q * fine * fine) / (q - 1), 0))};
  }
  qsort(found, (size_t)n, sizeof *found, steepest_first);
  const int top = n / TOP;
  qsort(found, (size_t)top, sizeof *found, sharpest_first);
  return top > 0 ? found[top / 2].blur : 0;
}

double hl_frame_blur_say(const hl_grey *grey, char why[HL_REASON_MAX])
{
  const double blur = hl_frame_blur(grey);
  const size_t used = strlen(why);
  if (blur > worth_saying)
    snprintf(why + used, HL_REASON_MAX - used, "; the frame is blurred by at least %.1f px", blur);
  return blur;
}
