/* The profile across a short piece of a ball's rim. Private to calib/. */
#ifndef HALFLIGHT_CALIB_SPHERE_RIM_H
#define HALFLIGHT_CALIB_SPHERE_RIM_H

enum { HL_RIM_TERMS = 8, HL_RIM_BALL_TERM = 3, HL_RIM_PIXELS_MAX = 512 };

/* Pixels about the rim: depth inside it [px], place along it (-1..1), squared normal, value. */
typedef struct hl_rim_pixels {
  int n;
  double t[HL_RIM_PIXELS_MAX], s[HL_RIM_PIXELS_MAX], gx2[HL_RIM_PIXELS_MAX], gy2[HL_RIM_PIXELS_MAX],
      value[HL_RIM_PIXELS_MAX];
  double a[HL_RIM_PIXELS_MAX],
      b[HL_RIM_PIXELS_MAX]; /* widths of the two boxes a pixel averages over */
} hl_rim_pixels;

/* The terms solved for at one offset: Cholesky factor, what they leave, and the terms: three of the
 * background, then five of the ball. */
typedef struct hl_rim_fit {
  double offset, ssr, c[HL_RIM_TERMS], l[HL_RIM_TERMS][HL_RIM_TERMS];
} hl_rim_fit;

/* The linear part at one offset [px]; `reach` [px] scales the terms that grow with depth. */
void hl_rim_solve(const hl_rim_pixels *px, double offset, double reach, hl_rim_fit *out);

/* Slope of the residual by the offset, the linear part projected out: its square and its product
 * with the residual. */
void hl_rim_slope(const hl_rim_pixels *px, const hl_rim_fit *fit, double reach, double *information,
                  double *pull);

#endif
