/* A fit as its user sees it: curves as tables in the samples' units, figures a term. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fit_work.h"
#include "halflight/vec3.h"
#include "ridge_rows.h"

static const double pi = 3.14159265358979323846;

/* ---- figures of a term over the samples ---- */

/* Sums of powers of t and the curve f, a channel. */
typedef struct moments {
  double n, t, tt, ttt, tttt;
  double f[HL_CHANNELS_MAX], ff[HL_CHANNELS_MAX], ft[HL_CHANNELS_MAX], ftt[HL_CHANNELS_MAX];
  double shown[2];
} moments;

static void add_moments(const hl_ridge_pass *p, const hl_ridge_rows *rows, const hl_ridge_fit *fit,
                        int term, moments *m)
{
  const hl_ridge_term_rows *r = &rows->term[term];
  const int run = fit->ridges.linear[term] ? 1 : 4;
  for (int i = 0; i < rows->count; i++) {
    const double t = r->t[i];
    m->shown[0] = fmin(m->shown[0], t);
    m->shown[1] = fmax(m->shown[1], t);
    m->n++;
    m->t += t;
    m->tt += t * t;
    m->ttt += t * t * t;
    m->tttt += t * t * t * t;
    for (int c = 0; c < p->data->channels; c++) {
      double f = 0;
      for (int k = 0; k < run; k++)
        f += r->value[i][k] * fit->curves.x[c][r->at[i] + k];
      f /= r->g[i];
      m->f[c] += f;
      m->ff[c] += f * f;
      m->ft[c] += f * t;
      m->ftt[c] += f * t * t;
    }
  }
}

/* About their means: a free curve has a constant too, which says nothing of its shape. */
static moments without_constant(const moments *m, int channels)
{
  moments out = *m;
  const double by = m->n > 0 ? 1 / m->n : 0;
  out.tttt -= by * m->tt * m->tt;
  out.ttt -= by * m->t * m->tt;
  out.tt -= by * m->t * m->t;
  for (int c = 0; c < channels; c++) {
    out.ff[c] -= by * m->f[c] * m->f[c];
    out.ft[c] -= by * m->f[c] * m->t;
    out.ftt[c] -= by * m->f[c] * m->tt;
  }
  return out;
}

/* Shares of the curve's rms that no k t, and no k t + q t^2, explains. */
static void set_shape(const moments *m, int channels, hl_term *out)
{
  double ff = 0, linear = 0, quadratic = 0;
  const double det = m->tt * m->tttt - m->ttt * m->ttt;
  for (int c = 0; c < channels; c++) {
    const double k = (m->ft[c] * m->tttt - m->ftt[c] * m->ttt) / (det > 0 ? det : 1);
    const double q = (m->ftt[c] * m->tt - m->ft[c] * m->ttt) / (det > 0 ? det : 1);
    ff += m->ff[c];
    linear += m->tt > 0 ? m->ft[c] * m->ft[c] / m->tt : 0;
    quadratic += k * m->ft[c] + q * m->ftt[c];
  }
  out->off_linear = ff > 0 ? sqrt(fmax(0, 1 - linear / ff)) : 0;
  out->off_quadratic = ff > 0 && det > 0 ? sqrt(fmax(0, 1 - quadratic / ff)) : out->off_linear;
}

static void set_moments(const hl_fit_work *w, const hl_ridge_fit *fit, moments m[HL_TERMS_MAX])
{
  hl_ridge_pass pass;
  hl_ridge_rows rows;
  hl_ridge_pass_begin(&fit->ridges, &fit->axes, &w->all, &pass);
  memset(m, 0, HL_TERMS_MAX * sizeof *m);
  for (int j = 0; j < fit->ridges.n; j++)
    m[j].shown[0] = 1;
  for (int first = 0; first < w->all.n; first += HL_RIDGE_CHUNK) {
    const int count = w->all.n - first < HL_RIDGE_CHUNK ? w->all.n - first : HL_RIDGE_CHUNK;
    hl_ridge_rows_at(&pass, first, count, false, &rows);
    for (int j = 0; j < fit->ridges.n; j++)
      add_moments(&pass, &rows, fit, j, &m[j]);
  }
  for (int j = 0; j < fit->ridges.n && w->free_curves; j++)
    if (!fit->ridges.linear[j])
      m[j] = without_constant(&m[j], w->all.channels);
}

/* Share of the variance that goes with each term, the other curves refitted, on the middle samples. */
static void set_gains(hl_fit_work *w, const hl_ridge_fit *fit, hl_fit *out)
{
  hl_roughness roughness;
  const double square = hl_ridge_square(&w->middle);
  hl_ridges_gram(&fit->ridges, &fit->axes, &w->middle, w->threads, &w->refine.ridge, &w->whole);
  const double whole = hl_curves_misfit(&w->whole, &fit->curves);
  for (int i = 0; i < fit->ridges.n; i++) {
    double without = square;
    if (fit->ridges.n > 1) {
      const int first = hl_ridges_first(&fit->ridges, i);
      hl_gram_without(&w->whole, first, hl_ridges_first(&fit->ridges, i + 1) - first,
                      &w->refine.gram);
      w->rival = *fit;
      hl_fit_drop(&w->rival, i);
      hl_roughness_from(&w->rival.ridges, &w->refine.gram, &roughness);
      hl_curves_solve(&w->rival.ridges, &w->refine.gram, &roughness, &w->refine.curves,
                      &w->rival.curves);
      without = w->rival.curves.misfit;
    }
    out->term[i].gain = square > 0 ? fmax(0, (without - whole) / square) : 0;
  }
}

/* ---- curves ---- */

/* Chords dense at the highlight and where the curve leaves zero; ascending t. */
static void set_curve(const hl_fit_work *w, const hl_ridge_fit *fit, int i, hl_term *term)
{
  const double root2 = sqrt(2.0);
  const double low = w->free_curves ? sqrt(fmax(0, 2 - 2 * term->shown[1])) : 0;
  const double high = w->free_curves ? sqrt(2 - 2 * term->shown[0]) : root2;
  const double unit = w->log_domain ? 1 : w->level;
  term->n = fit->ridges.linear[i] ? 2 : HL_CURVE_POINTS;
  for (int k = 0; k < term->n; k++) {
    const double share = 0.5 - 0.5 * cos(pi * (term->n - 1 - k) / (term->n - 1));
    const double u = low + (high - low) * share;
    term->t[k] = k == 0 && !w->free_curves ? 0 : 1 - 0.5 * u * u;
    for (int c = 0; c < w->all.channels; c++)
      term->value[c][k] = unit * hl_ridge_value(&fit->ridges, i, fit->curves.x[c], term->t[k]);
  }
  /* monotone to the last bit, where the spline is so to rounding */
  for (int c = 0; c < w->all.channels && !w->free_curves; c++)
    for (int k = 1; k < term->n; k++)
      term->value[c][k] = fmax(term->value[c][k], term->value[c][k - 1]);
  /* the scale of a product, in its first factor */
  for (int c = 0; c < w->all.channels && w->log_domain && i == 0; c++)
    for (int k = 0; k < term->n; k++)
      term->value[c][k] += fit->curves.x[c][hl_ridges_columns(&fit->ridges) - 1] + log(w->level);
}

static void set_strength(int channels, hl_term *term)
{
  for (int c = 0; c < channels; c++)
    term->strength[c] = hl_term_value(term, c, 1);
}

/* What can be moved between a plain lobe and a free linear part (eq. 5): as much as leaves the lobe
 * monotone goes to the linear part. Where the lobe's argument is seen below zero nothing can: the lobe
 * is zero there and the linear part is not. */
static void fix_gauge(hl_fit *out)
{
  hl_term *linear = &out->term[0], *lobe = &out->term[1];
  double most = lobe->shown[0] < 0 ? 0 : HUGE_VAL;
  for (int c = 0; c < out->channels; c++)
    for (int k = 1; k < lobe->n; k++) {
      const double rise =
          (lobe->value[c][k] - lobe->value[c][k - 1]) / (lobe->t[k] - lobe->t[k - 1]);
      if (linear->value[c][1] > 0 && lobe->t[k] >= lobe->shown[0] &&
          lobe->t[k - 1] <= lobe->shown[1])
        most = fmin(most, rise / linear->value[c][1]);
    }
  if (!(most > 0 && most < HUGE_VAL))
    return;
  double a[3];
  hl_add_scaled(linear->direction, most, lobe->direction, a);
  for (int c = 0; c < out->channels; c++) {
    for (int k = 0; k < lobe->n; k++)
      lobe->value[c][k] = fmax(k > 0 ? lobe->value[c][k - 1] : 0,
                               lobe->value[c][k] - most * linear->value[c][1] * lobe->t[k]);
    linear->value[c][1] *= hl_norm(a);
  }
  hl_unit(a, linear->direction);
}

/* ---- names ---- */

static void add_multiple(char *text, size_t room, double k, const char *letter)
{
  const size_t n = strlen(text);
  if (k == 0)
    return;
  snprintf(text + n, room - n, "%s%.3g%s", n > 0 && k > 0 ? "+" : "", k, letter);
  /* 1s is s */
  if (fabs(k) == 1)
    snprintf(text + n, room - n, "%s%s", k < 0 ? "-" : n > 0 ? "+" : "", letter);
}

static bool is_whole(double x)
{
  return fabs(x - round(x)) < 1e-9;
}

static double to_whole(double x)
{
  return is_whole(x) ? round(x) + 0.0 : x;
}

static void set_axis(const hl_axes *axes, int i, bool knows_light, hl_term *term)
{
  const hl_axis *axis = &axes->axis[i];
  memcpy(term->direction, axis->a, sizeof term->direction);
  term->in_plane = knows_light && (axis->kind == HL_AXIS_NAMED || axis->kind == HL_AXIS_PLANE);
  if (!term->in_plane)
    return;
  /* the larger part counts one, unless both are whole already */
  const double most = fmax(fabs(axis->cs), fabs(axis->cv));
  const bool whole = is_whole(axis->cs) && is_whole(axis->cv);
  term->cs = to_whole(whole ? axis->cs : axis->cs / most);
  term->cv = to_whole(whole ? axis->cv : axis->cv / most);
  if (term->cs == 1 && term->cv == 1) {
    snprintf(term->name, sizeof term->name, "h");
    return;
  }
  add_multiple(term->name, sizeof term->name, term->cs, "s");
  add_multiple(term->name, sizeof term->name, term->cv, "v");
}

void hl_fit_tables(hl_fit_work *w, hl_ridge_fit *fit, bool light_found, hl_fit *out)
{
  moments m[HL_TERMS_MAX];
  hl_fit_errors errors;
  out->log_domain = w->log_domain;
  out->free_curves = w->free_curves;
  out->n_samples = w->all.n;
  out->channels = w->all.channels;
  out->n_terms = fit->ridges.n;
  out->light_given = w->has_light;
  out->has_light = w->has_light || light_found;
  memcpy(out->view, w->all.mean_view, sizeof out->view);
  if (out->has_light)
    memcpy(out->light, light_found ? fit->axes.light : w->light, sizeof out->light);
  set_moments(w, fit, m);
  for (int i = 0; i < out->n_terms; i++) {
    hl_term *term = &out->term[i];
    term->role = fit->ridges.linear[i] ? HL_TERM_LINEAR : HL_TERM_LOBE;
    term->foreshortened = fit->ridges.foreshortened[i] || (w->divided && i == 0);
    memcpy(term->shown, m[i].shown, sizeof term->shown);
    set_axis(&fit->axes, i, out->has_light, term);
    set_shape(&m[i], out->channels, term);
    set_curve(w, fit, i, term);
  }
  const bool gauge = out->model == HL_FIT_DICHROMATIC && !out->has_light &&
                     !out->term[1].foreshortened && !w->log_domain;
  if (gauge && !w->free_curves)
    fix_gauge(out);
  for (int i = 0; i < out->n_terms; i++)
    set_strength(out->channels, &out->term[i]);
  hl_fit_errors_of(w, fit, &w->all, &errors);
  out->relative_error = errors.relative;
  out->unexplained_variance = errors.unexplained;
  set_gains(w, fit, out);
}
