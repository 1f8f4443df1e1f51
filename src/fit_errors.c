/* How far a fit is from samples, in radiance also where it was fitted in its logarithm. */
#include <math.h>

#include "fit_work.h"
#include "ridge_rows.h"

typedef struct sums {
  double off, data, square, residual;
  long n;
} sums;

static void add_chunk(const hl_fit_work *w, const hl_ridge_data *d, int channel, int first,
                      int count, const double *fit, double about, sums *s)
{
  for (int i = 0; i < count; i++) {
    double y = d->y[channel][first + i], f = fit[i];
    if (w->log_domain) {
      /* what was multiplied by n.v is so on both sides: it weighs, but does not add */
      const double by = w->divided ? 1 / d->nv[first + i] : 1;
      y = by * exp(y);
      f = by * exp(f);
    }
    s->off += fabs(f - y);
    s->data += y;
    s->square += (y - about) * (y - about);
    s->residual += (f - y) * (f - y);
    s->n++;
  }
}

void hl_fit_errors_of(const hl_fit_work *w, const hl_ridge_fit *fit, const hl_ridge_data *d,
                      hl_fit_errors *out)
{
  hl_ridge_pass pass;
  hl_ridge_rows rows;
  double off = 0, data = 0, square = 0, residual = 0;
  hl_ridge_pass_begin(&fit->ridges, &fit->axes, d, &pass);
  for (int c = 0; c < d->channels; c++) {
    sums s = {0};
    /* about 1, the mean over the channels, then moved to the channel's own mean */
    for (int first = 0; first < d->n; first += HL_RIDGE_CHUNK) {
      const int count = d->n - first < HL_RIDGE_CHUNK ? d->n - first : HL_RIDGE_CHUNK;
      double predicted[HL_RIDGE_CHUNK];
      hl_ridge_rows_at(&pass, first, count, false, &rows);
      hl_ridge_rows_predict(&pass, &rows, fit->curves.x[c], predicted);
      add_chunk(w, d, c, first, count, predicted, 1, &s);
    }
    const double mean = s.data / (double)s.n;
    off += s.off;
    data += s.data;
    square += s.square - (double)s.n * (mean - 1) * (mean - 1);
    residual += s.residual;
  }
  out->relative = data > 0 ? off / data : 0;
  out->unexplained = square > 0 ? fmin(residual / square, 1e300) : 0;
}
