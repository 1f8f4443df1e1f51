/* The light model's rows for a light at a finite distance.
 *
 * Seen from the ball's centre the light lies along s at distance R/k, R the ball's radius and k the
 * nearness. A point of the ball is R n from the centre, so with
 *
 *   w = s - k n,   s(p) = w/|w|,   fall = 1/|w|^2,
 *
 * s(p) is where the point sees the light and fall its irradiance against that at the centre: neither
 * needs the point itself. k = 0 is the distant light. The rows are those of light_rows.c with s(p) for s,
 * all but the ambient's times fall. Derivatives, with dw = t for a tangent of s and dw = -n for k:
 *
 *   ds(p) = (dw - (s(p).dw) s(p))/|w|,   dfall = -2 fall s(p).dw/|w|,
 *   d(n.s) = n.ds,   du = -(n.ds - (n.h)(h.ds)) / (|s(p) + v| u)
 */
#include <math.h>

#include "halflight/vec3.h"
#include "light_rows.h"
#include "smith.h"

typedef struct pixel {
  double n[3], v[3], s[3], h[3];
  double away, half; /* |w|, |s(p) + v| */
  double nl, ramp, footprint;
} pixel;

static pixel look(const hl_light_data *data, int p, const hl_model_point *at)
{
  pixel x;
  for (int k = 0; k < 3; k++) {
    x.n[k] = data->normal[k][p];
    x.v[k] = data->view[k][p];
  }
  hl_add_scaled(at->s, -at->nearness, x.n, x.s);
  x.away = hl_norm(x.s) + 1e-15;
  for (int k = 0; k < 3; k++) {
    x.s[k] /= x.away;
    x.h[k] = x.s[k] + x.v[k];
  }
  x.half = hl_norm(x.h) + 1e-15;
  for (int k = 0; k < 3; k++)
    x.h[k] /= x.half;
  x.footprint = data->footprint[p];
  x.nl = hl_dot(x.n, x.s);
  const double r = x.nl / x.footprint + 0.5;
  x.ramp = r < 0 ? 0 : r > 1 ? 1 : r;
  return x;
}

static void slope_of(const pixel *x, const double dw[3], int k, int i, double smith,
                     double exponent, hl_rows *c)
{
  const double along = hl_dot(x->s, dw);
  double ds[3];
  for (int j = 0; j < 3; j++)
    ds[j] = (dw[j] - along * x->s[j]) / x->away;
  const double dnl = hl_dot(x->n, ds);
  const double nh = 1 - 0.5 * c->u[i] * c->u[i];
  const double edge = x->ramp > 0 && x->ramp < 1 ? dnl / x->footprint : 0;
  c->dfall[k][i] = -2 * c->fall[i] * along / x->away;
  c->du[k][i] = -(dnl - nh * hl_dot(x->h, ds)) / (x->half * c->u[i]);
  c->dlit[k][i] = edge * c->fall[i] + x->ramp * c->dfall[k][i];
  c->dbody[k][i] = x->ramp * dnl;
  c->dg[k][i] = c->g[i] * exponent * smith * dnl;
}

void hl_rows_near(const hl_light_model *model, const hl_light_data *data, int first, int count,
                  const hl_model_point *at, bool slopes, hl_rows *c)
{
  for (int i = 0; i < count; i++) {
    const pixel x = look(data, first + i, at);
    double smith = 0, unused, d[3];
    hl_add_scaled(x.n, -1, x.h, d);
    c->u[i] = hl_norm(d) + 1e-12;
    c->nv[i] = hl_dot(x.n, x.v);
    c->fall[i] = 1 / (x.away * x.away);
    c->lit[i] = x.ramp * c->fall[i];
    c->body[i] = x.ramp < 1 ? 0.5 * x.ramp * x.ramp * x.footprint : x.nl;
    c->g[i] = model->lobe == HL_LOBE_FORESHORTENED ? 1 / c->nv[i] : 1;
    if (model->masking) {
      const bool bites = x.nl > hl_smith_least_cosine;
      c->masking[i] = hl_smith_log(bites ? x.nl : hl_smith_least_cosine, &smith) +
                      hl_smith_log(c->nv[i], &unused);
      c->g[i] *= exp(at->exponent * c->masking[i]);
      smith = bites ? smith : 0;
    }
    if (!slopes)
      continue;
    const double inward[3] = {-x.n[0], -x.n[1], -x.n[2]};
    slope_of(&x, at->t[0], 0, i, smith, at->exponent, c);
    slope_of(&x, at->t[1], 1, i, smith, at->exponent, c);
    slope_of(&x, inward, 2, i, smith, at->exponent, c);
  }
}
