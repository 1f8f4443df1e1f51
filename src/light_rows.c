/* The light model as rows of a linear problem in its curves, given a direction of light.
 *
 *   I_c(p) = sum_k x_ck row_k(p),   row = [ lit g B_0(u) .. lit g B_{n-1}(u) | D  D n.v  D^2 | 1 ]
 *
 *   h = (s + v)/|s + v|,   u = |n - h| = 2 sin(angle(n,h) / 2), smooth where acos is not
 *   g = (1 or 1/(n.v)) M^a,   B cubic B-splines over u
 *   M = G(n.s) G(n.v): Smith's shadowing and masking (smith.h); a is fitted
 *   lit = share of the pixel that sees the light, D = mean of max(0, n.s) over the pixel: with w the
 *       change of n.s across the pixel, a ramp from -w/2 to w/2, so that the cost does not jump when
 *       the shadow's edge crosses a pixel's centre
 *
 * D n.v and D^2 let the body's shading bend away from Lambert's, as Fresnel transmission and fibres
 * do; both vanish at the shadow's edge, so that its place still says where the light is.
 *
 * Derivatives for a tangent t of s:
 *   d(n.s) = n.t,   du = -(n.t - (n.h)(h.t)) / (|s + v| u)
 */
#include "light_rows.h"

#include <math.h>

#include "smith.h"

void hl_rows_geometry(const hl_light_model *model, const hl_light_data *data, int first, int count,
                      const double s[3], double exponent, const double (*t)[3], hl_rows *c)
{
  const double *nx = data->normal[0] + first, *ny = data->normal[1] + first,
               *nz = data->normal[2] + first;
  const double *vx = data->view[0] + first, *vy = data->view[1] + first,
               *vz = data->view[2] + first;
  const double *footprint = data->footprint + first;
  const double sx = s[0], sy = s[1], sz = s[2];
  const bool foreshortened = model->lobe == HL_LOBE_FORESHORTENED;
  double nl[HL_ROWS_CHUNK], ramp[HL_ROWS_CHUNK], *nv = c->nv;
  for (int i = 0; i < count; i++) {
    const double ax = sx + vx[i], ay = sy + vy[i], az = sz + vz[i];
    const double inverse = 1 / sqrt(ax * ax + ay * ay + az * az + 1e-30);
    const double dx = nx[i] - ax * inverse, dy = ny[i] - ay * inverse, dz = nz[i] - az * inverse;
    c->u[i] = sqrt(dx * dx + dy * dy + dz * dz) + 1e-12;
    nl[i] = nx[i] * sx + ny[i] * sy + nz[i] * sz;
    nv[i] = nx[i] * vx[i] + ny[i] * vy[i] + nz[i] * vz[i];
  }
  for (int i = 0; i < count; i++) {
    const double w = footprint[i];
    const double r = nl[i] / w + 0.5;
    ramp[i] = r < 0 ? 0 : r > 1 ? 1 : r;
    c->lit[i] = ramp[i];
    c->body[i] = r > 1 ? nl[i] : 0.5 * ramp[i] * ramp[i] * w;
    c->g[i] = foreshortened ? 1 / nv[i] : 1;
  }
  if (t)
    for (int k = 0; k < 2; k++)
      for (int i = 0; i < count; i++) {
        const double nt = nx[i] * t[k][0] + ny[i] * t[k][1] + nz[i] * t[k][2];
        const double ax = sx + vx[i], ay = sy + vy[i], az = sz + vz[i];
        const double inverse = 1 / sqrt(ax * ax + ay * ay + az * az + 1e-30);
        const double ht = (vx[i] * t[k][0] + vy[i] * t[k][1] + vz[i] * t[k][2]) * inverse;
        const double nh = 1 - 0.5 * c->u[i] * c->u[i];
        c->du[k][i] = -(nt - nh * ht) * inverse / c->u[i];
        c->dlit[k][i] = ramp[i] > 0 && ramp[i] < 1 ? nt / footprint[i] : 0;
        c->dbody[k][i] = ramp[i] * nt;
        c->dg[k][i] = 0;
      }
  if (model->masking)
    for (int i = 0; i < count; i++) {
      double rate, unused;
      const bool bites = nl[i] > hl_smith_least_cosine;
      c->masking[i] =
          hl_smith_log(bites ? nl[i] : hl_smith_least_cosine, &rate) + hl_smith_log(nv[i], &unused);
      c->g[i] *= exp(exponent * c->masking[i]);
      if (t && bites)
        for (int k = 0; k < 2; k++)
          c->dg[k][i] =
              c->g[i] * exponent * rate * (nx[i] * t[k][0] + ny[i] * t[k][1] + nz[i] * t[k][2]);
    }
}
