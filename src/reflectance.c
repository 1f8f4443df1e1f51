/* A fitted reflectance under any light and view.
 *
 * The models that are fitted are sums of curves of n.a with a in the plane of s and v, so a curve found
 * under one pair (s, v) is used under another by letting its axis follow: a = (cs s + cv v)/|.|.
 *
 * Between its points a curve is a cubic with the slopes of Fritsch and Butland (1984): with d, e the
 * chords left and right and p, q their widths,
 *
 *   m = 3 (p + q) / ((2q + p)/d + (q + 2p)/e)   where d e > 0,   0 elsewhere,
 *
 * at an end the three-point slope, cut back to keep the chord's sign and thrice its size. Such a cubic
 * rises and falls where the points do and nowhere else (paper L3), and passes through straight points
 * straight.
 */
#include "halflight/reflectance.h"

#include <string.h>

#include "halflight/vec3.h"
#include "smith.h"

/* Slope at an end: chords d (nearest) and e, widths p and q. */
static double end_slope(double p, double q, double d, double e)
{
  const double m = ((2 * p + q) * d - p * e) / (p + q);
  if (m * d <= 0)
    return 0;
  return fabs(m) > 3 * fabs(d) ? 3 * d : m;
}

static double inner_slope(double p, double q, double d, double e)
{
  return d * e > 0 ? 3 * (p + q) / ((2 * q + p) / d + (q + 2 * p) / e) : 0;
}

static double chord(const double *t, const double *y, int i)
{
  return (y[i + 1] - y[i]) / (t[i + 1] - t[i]);
}

static double slope_at(const double *t, const double *y, int n, int i)
{
  if (n == 2)
    return chord(t, y, 0);
  if (i == 0)
    return end_slope(t[1] - t[0], t[2] - t[1], chord(t, y, 0), chord(t, y, 1));
  if (i == n - 1)
    return end_slope(t[i] - t[i - 1], t[i - 1] - t[i - 2], chord(t, y, i - 1), chord(t, y, i - 2));
  return inner_slope(t[i] - t[i - 1], t[i + 1] - t[i], chord(t, y, i - 1), chord(t, y, i));
}

/* The interval that holds x, t[0] <= x <= t[n-1]. */
static int interval_of(const double *t, int n, double x)
{
  int low = 0, high = n - 1;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    if (t[middle] <= x)
      low = middle;
    else
      high = middle;
  }
  return low;
}

static double between(const double *t, const double *y, int n, int i, double x)
{
  const double w = t[i + 1] - t[i], u = (x - t[i]) / w;
  const double a = slope_at(t, y, n, i) * w, b = slope_at(t, y, n, i + 1) * w;
  const double rise = y[i + 1] - y[i];
  return y[i] + u * (a + u * (3 * rise - 2 * a - b + u * (a + b - 2 * rise)));
}

/* All channels of a term's curve at x. */
static void curve_at(const hl_lobe_term *term, int channels, bool log_domain, double x, double *out)
{
  const double low = term->t[0];
  const int last = term->n - 1;
  const int i = x > low && x < term->t[last] ? interval_of(term->t, term->n, x) : 0;
  for (int c = 0; c < channels; c++) {
    const double *y = term->value[c];
    if (x >= term->t[last])
      out[c] = y[last];
    else if (x > low)
      out[c] = between(term->t, y, term->n, i, x);
    else if (low > 0 && !log_domain)
      out[c] = x > 0 ? y[0] * x / low : 0;
    else
      out[c] = y[0];
  }
}

static double cosine_to_axis(const hl_lobe_term *term, const double n[3], const double s[3],
                             const double v[3])
{
  double a[3];
  if (term->fixed_axis)
    return hl_dot(n, term->axis);
  for (int k = 0; k < 3; k++)
    a[k] = term->cs * s[k] + term->cv * v[k];
  hl_unit(a, a);
  return hl_dot(n, a);
}

/* g of a term: how the lobe is foreshortened, shadowed and masked. */
static double geometry(const hl_lobe_term *term, double ns, double nv)
{
  double g = term->foreshortened ? 1 / nv : 1, unused;
  if (term->masking_exponent != 0)
    g *= exp(term->masking_exponent *
             (hl_smith_log(fmax(ns, hl_smith_least_cosine), &unused) + hl_smith_log(nv, &unused)));
  return g;
}

void hl_reflectance_at(const hl_reflectance *r, const double n[3], const double s[3],
                       const double v[3], double out[HL_CHANNELS_MAX])
{
  const double ns = hl_dot(n, s), nv = hl_dot(n, v);
  double sum[HL_CHANNELS_MAX] = {0};
  const bool seen = ns > 0 && nv > 0;
  for (int i = 0; i < r->n_terms && seen; i++) {
    const hl_lobe_term *term = &r->term[i];
    const double x = cosine_to_axis(term, n, s, v), g = geometry(term, ns, nv);
    double value[HL_CHANNELS_MAX];
    curve_at(term, r->channels, r->log_domain, x, value);
    for (int c = 0; c < r->channels; c++) {
      value[c] += term->view_slope[c] * x * (nv - term->at_cos_view);
      sum[c] += r->log_domain ? value[c] + log(g) : g * value[c];
    }
  }
  for (int c = 0; c < HL_CHANNELS_MAX; c++) {
    const double total = sum[r->channels == 1 ? 0 : c];
    out[c] = !seen ? 0 : r->log_domain ? exp(total) : total;
  }
}
