/* Samples that count, brought together as the fits want them.
 *
 * Values are divided by their mean, so that nothing after depends on the exposure. A sample is left out
 * where it is not seen (n.v <= 0), not lit (n.s <= 0, the light known), or black in every channel: an
 * attached shadow, of which a sum of ridges along other directions than the light's knows nothing.
 *
 * Weights are those of shot noise, variance growing with the radiance: the directions of a highlight
 * and of what lies around it both count, where even weights see the highlight alone.
 *
 * Smaller sets are drawn by a hash of the sample itself, so that its place in the file does not matter.
 * The coarse one always holds the brightest, for a sharp highlight is a few samples; the others stand
 * for those left out, by their weight.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "fit_work.h"
#include "halflight/vec3.h"

enum { BRIGHTEST = 80, COARSE_BREAKS = 13 };
static const double least_weight_level = 0.05; /* of the mean: darker samples weigh no more */
static const double pi = 3.14159265358979323846;

/* Carves arrays off one block; with a NULL base it only adds up their sizes. */
typedef struct arena {
  char *base;
  size_t used;
} arena;

static double *carve(arena *a, size_t count)
{
  double *at = a->base ? (double *)(void *)(a->base + a->used) : NULL;
  a->used += (count * sizeof(double) + 63) / 64 * 64;
  return at;
}

static void carve_data(arena *a, hl_ridge_data *d, size_t n, int channels, bool views)
{
  for (int k = 0; k < 3; k++) {
    d->normal[k] = carve(a, n);
    d->view[k] = views ? carve(a, n) : NULL;
  }
  d->nv = carve(a, n);
  d->w = carve(a, n);
  for (int c = 0; c < channels; c++)
    d->y[c] = carve(a, n);
  d->channels = channels;
}

static void carve_work(arena *a, hl_fit_work *w, const hl_samples *s)
{
  const size_t n = (size_t)s->n;
  const bool views = s->view != NULL;
  carve_data(a, &w->all, n, s->channels, views);
  if (s->n > HL_FIT_MIDDLE)
    carve_data(a, &w->middle, 2 * HL_FIT_MIDDLE, s->channels, views);
  carve_data(a, &w->coarse, 2 * HL_FIT_COARSE, s->channels, views);
  w->residual = carve(a, 2 * HL_FIT_COARSE);
  w->scratch = carve(a, n);
}

/* ---- all ---- */

static void copy_sample(const hl_ridge_data *from, int i, hl_ridge_data *to, double times)
{
  const int at = to->n++;
  for (int k = 0; k < 3; k++) {
    to->normal[k][at] = from->normal[k][i];
    if (to->view[k])
      to->view[k][at] = from->view[k][i];
  }
  to->nv[at] = from->nv[i];
  to->w[at] = times * from->w[i];
  for (int c = 0; c < from->channels; c++)
    to->y[c][at] = from->y[c][i];
}

/* Whether a sample counts; it is then stored. */
static void gather_sample(hl_fit_work *w, const hl_samples *s, int i)
{
  static const double ahead[3] = {0, 0, 1};
  hl_ridge_data *d = &w->all;
  double n[3], v[3], least = HUGE_VAL, most = 0;
  hl_unit(s->normal + 3 * (size_t)i, n);
  hl_unit(s->view ? s->view + 3 * (size_t)i : ahead, v);
  for (int c = 0; c < s->channels; c++) {
    least = fmin(least, s->value[c][i]);
    most = fmax(most, s->value[c][i]);
  }
  const bool seen = hl_dot(n, v) > 0;
  const bool lit = !w->has_light || hl_dot(n, w->light) > 0;
  const bool bright = w->log_domain ? least > 0 : most > 0;
  w->not_seen += !seen;
  w->not_lit += seen && !lit;
  w->dark += seen && lit && !bright;
  if (!seen || !lit || !bright)
    return;
  const int at = d->n++;
  for (int k = 0; k < 3; k++) {
    d->normal[k][at] = n[k];
    if (d->view[k])
      d->view[k][at] = v[k];
    d->mean_view[k] += v[k];
  }
  d->nv[at] = hl_dot(n, v);
  for (int c = 0; c < s->channels; c++) {
    d->y[c][at] = s->value[c][i];
    w->level += s->value[c][i];
  }
}

static void scale_and_weigh(hl_fit_work *w)
{
  hl_ridge_data *d = &w->all;
  w->level /= (double)d->n * d->channels;
  hl_unit(d->mean_view, d->mean_view);
  for (int i = 0; i < d->n; i++) {
    double mean = 0;
    for (int c = 0; c < d->channels; c++) {
      d->y[c][i] /= w->level;
      mean += d->y[c][i] / d->channels;
      if (w->log_domain)
        d->y[c][i] = log(d->y[c][i]);
    }
    d->w[i] = w->log_domain ? 1 : 1 / (mean + least_weight_level);
    w->scratch[i] = mean;
  }
}

void hl_fit_divide(hl_fit_work *w, bool divided)
{
  hl_ridge_data *const sets[] = {&w->all, &w->middle, &w->coarse};
  const double sign = divided ? 1 : -1;
  if (divided == w->divided)
    return;
  for (int k = 0; k < 3; k++) {
    hl_ridge_data *d = sets[k];
    if (k == 1 && d->w == w->all.w) /* the same arrays */
      continue;
    for (int c = 0; c < d->channels; c++)
      for (int i = 0; i < d->n; i++)
        d->y[c][i] += sign * log(d->nv[i]);
  }
  w->divided = divided;
}

/* ---- some ---- */

static uint64_t mix(uint64_t h, double value)
{
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  h = (h ^ bits) * 0x9e3779b97f4a7c15u;
  return h ^ (h >> 29);
}

/* The least of a direction's digits are its own; a power of two times the radiance has the same. */
static uint64_t hash_of(const hl_ridge_data *d, int i, int seed, bool values)
{
  uint64_t h = 0xd1b54a32d192ed03u + (uint64_t)seed;
  for (int k = 0; k < 3; k++) {
    h = mix(h, d->normal[k][i]);
    if (d->view[k])
      h = mix(h, d->view[k][i]);
  }
  int exponent;
  for (int c = 0; c < d->channels && values; c++)
    h = mix(h, frexp(d->y[c][i], &exponent));
  h = (h ^ (h >> 32)) * 0xd6e8feb86659fd93u;
  return h ^ (h >> 32);
}

static double lot_of(const hl_ridge_data *d, int i, int seed, bool values)
{
  return (double)(hash_of(d, i, seed, values) >> 11) * 0x1p-53;
}

double hl_fit_lot(const hl_ridge_data *d, int i, int seed)
{
  return lot_of(d, i, seed, false);
}

/* The k-th largest, k from 0; Hoare's selection, reorders. */
static double largest(double *x, int n, int k)
{
  int low = 0, high = n - 1;
  while (low < high) {
    const double pivot = x[low + (high - low) / 2];
    int i = low, j = high;
    while (i <= j) {
      while (x[i] > pivot)
        i++;
      while (x[j] < pivot)
        j--;
      if (i <= j) {
        const double swap = x[i];
        x[i++] = x[j];
        x[j--] = swap;
      }
    }
    if (k <= j)
      high = j;
    else if (k >= i)
      low = i;
    else
      break;
  }
  return x[k];
}

static double mean_value(const hl_ridge_data *d, int i)
{
  double sum = 0;
  for (int c = 0; c < d->channels; c++)
    sum += d->y[c][i];
  return sum;
}

/* About `count` samples, at most twice as many: those above `bright` and a lot of the others, drawn by
 * their normals, or where many share theirs by their values too. */
static void draw(const hl_fit_work *w, double bright, int n_bright, int count, hl_ridge_data *out)
{
  const hl_ridge_data *d = &w->all;
  const double share = fmin(1, (double)(count - n_bright) / fmax(1, d->n - n_bright));
  memcpy(out->mean_view, d->mean_view, sizeof out->mean_view);
  for (int values = 0; values < 2; values++) {
    out->n = 0;
    for (int i = 0; i < d->n && out->n < 2 * count; i++) {
      if (mean_value(d, i) > bright)
        copy_sample(d, i, out, 1);
      else if (share >= 1 || lot_of(d, i, w->seed, values == 1) < share)
        copy_sample(d, i, out, 1 / share);
    }
    if (share >= 1 || (2 * out->n > count && 3 * out->n < 4 * count))
      break;
  }
}

static void draw_sets(hl_fit_work *w)
{
  const int n = w->all.n;
  if (n > HL_FIT_MIDDLE)
    draw(w, HUGE_VAL, 0, HL_FIT_MIDDLE, &w->middle);
  else
    w->middle = w->all;
  const bool few = n <= HL_FIT_COARSE;
  for (int i = 0; i < n && !few; i++)
    w->scratch[i] = mean_value(&w->all, i);
  draw(w, few ? HUGE_VAL : largest(w->scratch, n, BRIGHTEST), few ? 0 : BRIGHTEST, HL_FIT_COARSE,
       &w->coarse);
}

static void set_spline(hl_fit_work *w)
{
  const double top = w->free_curves ? 2 : sqrt(2.0);
  double breaks[COARSE_BREAKS];
  for (int i = 0; i < COARSE_BREAKS; i++) {
    const double share = (double)i / (COARSE_BREAKS - 1);
    breaks[i] = top * share * share;
  }
  hl_spline_init(&w->coarse_spline, breaks, COARSE_BREAKS);
}

/* ---- refusals ---- */

/* Normals on one circle, or in one point, all have the same product with some vector: the least
 * eigenvalue of their scatter about the mean is 0. */
static bool on_a_circle(const hl_ridge_data *d)
{
  double mean[3] = {0}, s[3][3] = {{0}};
  for (int i = 0; i < d->n; i++)
    for (int k = 0; k < 3; k++)
      mean[k] += d->normal[k][i] / d->n;
  for (int i = 0; i < d->n; i++)
    for (int k = 0; k < 3; k++)
      for (int l = 0; l < 3; l++)
        s[k][l] += (d->normal[k][i] - mean[k]) * (d->normal[l][i] - mean[l]) / d->n;
  const double p = s[0][1] * s[0][1] + s[0][2] * s[0][2] + s[1][2] * s[1][2];
  const double q = (s[0][0] + s[1][1] + s[2][2]) / 3;
  double r = 2 * p;
  for (int k = 0; k < 3; k++)
    r += (s[k][k] - q) * (s[k][k] - q);
  r = sqrt(r / 6) + 1e-300;
  double b[3][3];
  for (int k = 0; k < 3; k++)
    for (int l = 0; l < 3; l++)
      b[k][l] = (s[k][l] - (k == l ? q : 0)) / r;
  const double det = b[0][0] * (b[1][1] * b[2][2] - b[1][2] * b[2][1]) -
                     b[0][1] * (b[1][0] * b[2][2] - b[1][2] * b[2][0]) +
                     b[0][2] * (b[1][0] * b[2][1] - b[1][1] * b[2][0]);
  const double phi = acos(fmax(-1, fmin(1, det / 2))) / 3;
  const double least = q + 2 * r * cos(phi + 2 * pi / 3);
  return !(least > 1e-9);
}

static hl_status refuse(hl_ctx *ctx, const hl_fit_work *w, int samples, int unknowns)
{
  const int n = w->all.n;
  if (n == 0 && w->not_lit > 0)
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "none of %d samples is lit: n.s <= 0 for all with --light %.4g,%.4g,%.4g; a "
                   "light on the side of the normals, in their frame, is needed",
                   samples, w->light[0], w->light[1], w->light[2]);
  if (n == 0 && w->dark > 0)
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "all of %d samples are black; radiance above 0 is needed", w->dark);
  if (n == 0)
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "none of %d samples is seen: n.v <= 0 for all; normals that face the view are "
                   "needed",
                   samples);
  if (n < unknowns)
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "%d samples that are lit and seen; the model has %d unknowns and needs as many",
                   n, unknowns);
  if (on_a_circle(&w->all))
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "all normals lie on one circle: no direction can be told from them; a surface "
                   "that curves both ways is needed");
  return HL_OK;
}

hl_status hl_fit_gather(hl_ctx *ctx, const hl_samples *s, const double *light,
                        const hl_fit_settings *settings, int unknowns, hl_fit_work **out)
{
  hl_fit_work *w = calloc(1, sizeof *w);
  arena a = {NULL, 0};
  if (w) {
    carve_work(&a, w, s);
    w->pool = a.base = malloc(a.used);
  }
  if (!w || !w->pool) {
    free(w);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a fit to %d samples", s->n);
  }
  a.used = 0;
  carve_work(&a, w, s);
  w->has_light = light != NULL;
  if (light)
    hl_unit(light, w->light);
  w->log_domain = settings->domain == HL_DOMAIN_LOG;
  w->free_curves = settings->free_curves != 0;
  w->lobe = settings->lobe;
  w->starts = settings->starts;
  w->seed = settings->seed;
  w->folds = settings->folds;
  for (int i = 0; i < s->n; i++)
    gather_sample(w, s, i);
  const hl_status st = refuse(ctx, w, s->n, unknowns);
  if (st != HL_OK) {
    hl_fit_work_free(w);
    return st;
  }
  scale_and_weigh(w);
  draw_sets(w);
  set_spline(w);
  *out = w;
  return HL_OK;
}

void hl_fit_work_free(hl_fit_work *work)
{
  if (!work)
    return;
  free(work->pool);
  free(work);
}
