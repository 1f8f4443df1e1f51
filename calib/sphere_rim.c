/*
 * The profile across a short piece of a ball's rim.
 *
 * The gradient's maximum is biased: near the limb the ball's own radiance is not flat. Its normal
 * turns away like sqrt(depth), so radiance there is a smooth function of sqrt(t), t = depth inside
 * the outline in pixels. A pixel sees the average over its square. With the outline straight over
 * one pixel, at signed depth t and normal (gx, gy), the average of any function f(t) that is zero
 * outside is its second antiderivative F2 at four corners:
 *
 *   [F2(t+(a+b)/2) - F2(t+(a-b)/2) - F2(t-(a-b)/2) + F2(t-(a+b)/2)] / (a b),  a = |gx|, b = |gy|.
 *
 * For f = t^p: F2 = t^(p+2) / ((p+1)(p+2)), t > 0. Each sector of the rim is then linear in
 *
 *   I = (1 - M0) (b0 + b1 s + b2 t) + M0 (c0 + c3 s) + M_1/2 (c1 + c4 s) + M1 c2,  s along the rim,
 *.
 *
 * A blur beyond the pixel's square is taken as wider a and b.
 */
#include "sphere_rim.h"

#include <math.h>
#include <string.h>

/* One pixel's terms and their derivatives by the depth; those outside [first, last) are zero. */
typedef struct pixel_row {
  int first, last;
  double row[HL_RIM_TERMS], slope[HL_RIM_TERMS];
} pixel_row;

/* Averages of t^0, t^1/2, t^1 over the pixel's square, and their derivatives by the depth. */
static inline void moments(double t, double a, double b, double m[3], double dm[3])
{
  if (t > 1.25 * (a + b)) {
    /* the whole pixel is inside, where a curvature term serves to 1e-4 */
    const double root = sqrt(t), spread = (a * a + b * b) / 96;
    m[0] = 1;
    m[1] = root - spread / (t * root);
    m[2] = t;
    dm[0] = 0;
    dm[1] = 0.5 / root + 1.5 * spread / (t * t * root);
    dm[2] = 1;
    return;
  }
  const double at[4] = {t + (a + b) / 2, t + (a - b) / 2, t - (a - b) / 2, t - (a + b) / 2};
  const double k = 1 / (a * b);
  m[0] = m[1] = m[2] = dm[0] = dm[1] = dm[2] = 0;
  for (int c = 0; c < 4; c++) {
    const double u = at[c];
    if (!(u > 0))
      continue;
    const double f = c == 0 || c == 3 ? k : -k, r = sqrt(u);
    dm[0] += f * u;
    dm[1] += f * u * r * (2.0 / 3.0);
    dm[2] += f * u * u * 0.5;
    m[0] += f * u * u * 0.5;
    m[1] += f * u * u * r * (4.0 / 15.0);
    m[2] += f * u * u * u * (1.0 / 6.0);
  }
}

/* One row of the linear system: outside the outline only the background terms, well inside only the
 * ball's. Inline, so that the derivatives cost nothing where they are not used. */
static inline void basis(const hl_rim_pixels *px, int i, double offset, double reach,
                         pixel_row *out)
{
  const double t = px->t[i] + offset, s = px->s[i], half = 0.5 * (px->a[i] + px->b[i]);
  const double k = 1 / reach;
  out->first = 0;
  out->last = HL_RIM_TERMS;
  if (t <= -half) {
    const double row[3] = {1, s, t * k};
    memcpy(out->row, row, sizeof row);
    out->slope[0] = out->slope[1] = 0;
    out->slope[2] = k;
    out->last = HL_RIM_BALL_TERM;
    return;
  }
  double m[3], d[3];
  moments(t, px->a[i], px->b[i], m, d);
  const double outside = 1 - m[0];
  if (t >= half)
    out->first = HL_RIM_BALL_TERM;
  const double row[HL_RIM_TERMS] = {outside,  outside * s, outside * t * k, m[0],
                                    m[0] * s, m[1],        m[1] * s,        m[2] * k};
  const double slope[HL_RIM_TERMS] = {
      -d[0], -d[0] * s, outside * k - d[0] * t * k, d[0], d[0] * s, d[1], d[1] * s, d[2] * k};
  memcpy(out->row, row, sizeof row);
  memcpy(out->slope, slope, sizeof slope);
}

/* Cholesky of a symmetric matrix in place; a small ridge keeps terms without pixels harmless. */
static void factor(double a[HL_RIM_TERMS][HL_RIM_TERMS])
{
  for (int i = 0; i < HL_RIM_TERMS; i++) {
    a[i][i] += 1e-9 * a[i][i] + 1e-12;
    for (int j = 0; j <= i; j++) {
      double sum = a[i][j];
      for (int k = 0; k < j; k++)
        sum -= a[i][k] * a[j][k];
      a[i][j] = i == j ? sqrt(fmax(sum, 1e-14)) : sum / a[j][j];
    }
  }
}

static void substitute(const double l[HL_RIM_TERMS][HL_RIM_TERMS], double x[HL_RIM_TERMS])
{
  for (int i = 0; i < HL_RIM_TERMS; i++) {
    for (int k = 0; k < i; k++)
      x[i] -= l[i][k] * x[k];
    x[i] /= l[i][i];
  }
  for (int i = HL_RIM_TERMS - 1; i >= 0; i--) {
    for (int k = i + 1; k < HL_RIM_TERMS; k++)
      x[i] -= l[k][i] * x[k];
    x[i] /= l[i][i];
  }
}

void hl_rim_solve(const hl_rim_pixels *px, double offset, double reach, hl_rim_fit *out)
{
  memset(out, 0, sizeof *out);
  out->offset = offset;
  double squares = 0, explained = 0, right[HL_RIM_TERMS] = {0};
  for (int i = 0; i < px->n; i++) {
    pixel_row r;
    const double v = px->value[i];
    basis(px, i, offset, reach, &r);
    for (int j = r.first; j < r.last; j++) {
      for (int k = r.first; k <= j; k++)
        out->l[j][k] += r.row[j] * r.row[k];
      right[j] += r.row[j] * v;
    }
    squares += v * v;
  }
  factor(out->l);
  memcpy(out->c, right, sizeof right);
  substitute((const double(*)[HL_RIM_TERMS])out->l, out->c);
  for (int j = 0; j < HL_RIM_TERMS; j++)
    explained += out->c[j] * right[j];
  out->ssr = squares - explained;
}

void hl_rim_slope(const hl_rim_pixels *px, const hl_rim_fit *f, double reach, double *information,
                  double *pull)
{
  double jj = 0, jr = 0, b[HL_RIM_TERMS] = {0}, x[HL_RIM_TERMS];
  for (int i = 0; i < px->n; i++) {
    pixel_row p;
    double r = px->value[i], d = 0;
    basis(px, i, f->offset, reach, &p);
    for (int j = p.first; j < p.last; j++) {
      r -= p.row[j] * f->c[j];
      d += p.slope[j] * f->c[j];
    }
    for (int j = p.first; j < p.last; j++)
      b[j] += p.row[j] * d;
    jj += d * d;
    jr += d * r;
  }
  memcpy(x, b, sizeof x);
  substitute((const double(*)[HL_RIM_TERMS])f->l, x);
  for (int j = 0; j < HL_RIM_TERMS; j++)
    jj -= x[j] * b[j];
  *information = fmax(jj, 0);
  *pull = jr;
}
