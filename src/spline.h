/* Cubic B-splines on given breaks: values and slopes of the four functions that live at a point. */
#ifndef HL_SPLINE_H
#define HL_SPLINE_H

enum { HL_SPLINE_MAX = 48, HL_SPLINE_BINS = 1024 };

typedef struct hl_spline {
  int n;         /* functions */
  int intervals; /* n - 3 */
  double low, high;
  double left[HL_SPLINE_MAX];       /* left end of each interval */
  double poly[HL_SPLINE_MAX][4][4]; /* [interval][power of u - left][function] */
  double bins_per_unit;
  unsigned char bin[HL_SPLINE_BINS]; /* interval at a bin's left end */
} hl_spline;

/* breaks: ascending, n_breaks in [2, HL_SPLINE_MAX - 2]. */
void hl_spline_init(hl_spline *spline, const double *breaks, int n_breaks);

/* Of `intervals` candidate intervals between `candidate` breaks, of which each holds samples[j], join
 * neighbours from the low end until every one holds `least`. Returns how many breaks are left; out may
 * be `candidate`. */
int hl_spline_thin(const double *candidate, const int *samples, int intervals, int least,
                   double *out);

/* Interval of u, clamped to the domain. Functions interval .. interval + 3 live there. */
static inline int hl_spline_interval(const hl_spline *spline, double u)
{
  double at = (u - spline->low) * spline->bins_per_unit;
  at = at > 0 ? at : 0;
  at = at < HL_SPLINE_BINS - 1 ? at : HL_SPLINE_BINS - 1;
  int i = spline->bin[(int)at];
  while (i + 1 < spline->intervals && u >= spline->left[i + 1])
    i++;
  return i;
}

static inline int hl_spline_values(const hl_spline *spline, double u, double value[4])
{
  const int i = hl_spline_interval(spline, u);
  const double(*c)[4] = spline->poly[i];
  const double x = u - spline->left[i];
  double sum[4];
  for (int k = 0; k < 4; k++) /* power by power, so that the four functions become vectors */
    sum[k] = c[2][k] + x * c[3][k];
  for (int k = 0; k < 4; k++)
    sum[k] = c[1][k] + x * sum[k];
  for (int k = 0; k < 4; k++)
    value[k] = c[0][k] + x * sum[k];
  return i;
}

static inline void hl_spline_slopes(const hl_spline *spline, int i, double u, double slope[4])
{
  const double(*c)[4] = spline->poly[i];
  const double x = u - spline->left[i];
  for (int k = 0; k < 4; k++)
    slope[k] = c[1][k] + x * (2 * c[2][k] + 3 * x * c[3][k]);
}

#endif
