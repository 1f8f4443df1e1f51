/* One-lobe parametric fits: starts over the whole range of widths, the best few refined, the winner
 * written as a fit like any other. */

#include "halflight/parametric.h"
#include "halflight/notes.h"
#include "halflight/vec3.h"
#include "parametric_model.h"
#include <cminpack.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STARTS = 25, REFINED = 4, EVALUATIONS_MAX = 200, LEAST_SAMPLES = 4 };
static const double half_pi = 1.57079632679489661923;

/* What a sample is worth: 0 where it is not lit. */
static bool gather_sample(const hl_samples *samples, int i, const double s[3], hl_fit_model model,
                          double *body, double *abscissa)
{
  static const double front[3] = {0, 0, 1};
  const double *n = samples->normal + 3 * (size_t)i;
  const double *v = samples->view ? samples->view + 3 * (size_t)i : front;
  double h[3], d[3];
  hl_add_scaled(s, 1, v, h);
  hl_unit(h, h);
  hl_add_scaled(n, -1, h, d);
  const double half_chord = hl_norm(d) / 2, cosine = 1 - 2 * half_chord * half_chord;
  const double angle = 2 * asin(fmin(1, half_chord));
  *body = hl_dot(n, s);
  /* log1p keeps what 1 - cosine has of digits; beyond the horizon (n.h)^mu is 0 */
  *abscissa = model == HL_FIT_TORRANCE_SPARROW ? angle * angle
              : cosine > 0                     ? -log1p(-2 * half_chord * half_chord)
                                               : HUGE_VAL;
  return *body > 0;
}

/* One block: body, abscissa, lobe, values; then residual, slope and the solver's own. */
typedef struct block {
  double *start, *residual, *slope, *work;
} block;

static hl_status gather(hl_ctx *ctx, const hl_samples *samples, hl_fit_model model,
                        const double s[3], hl_parametric *m, block *b)
{
  const size_t n = (size_t)samples->n, channels = (size_t)samples->channels;
  b->start = malloc((3 + 4 * channels) * n * sizeof *b->start);
  if (!b->start) {
    hl_fail(ctx, HL_ERR_MEMORY, "no memory for %zu samples", n);
    return HL_ERR_MEMORY;
  }
  *m = (hl_parametric){.model = model, .channels = samples->channels};
  m->body = b->start;
  m->abscissa = m->body + n;
  m->lobe = m->abscissa + n;
  for (size_t c = 0; c < channels; c++)
    m->value[c] = m->lobe + (1 + c) * n;
  b->residual = m->lobe + (1 + channels) * n;
  b->slope = b->residual + channels * n;
  b->work = b->slope + channels * n;
  for (int i = 0; i < samples->n; i++) {
    if (!gather_sample(samples, i, s, model, &m->body[m->n], &m->abscissa[m->n]))
      continue;
    for (int c = 0; c < m->channels; c++)
      m->value[c][m->n] = samples->value[c][i];
    m->n++;
  }
  return HL_OK;
}

static double sum_of(const hl_parametric *m)
{
  double sum = 0;
  for (int c = 0; c < m->channels; c++)
    for (int i = 0; i < m->n; i++)
      sum += m->value[c][i];
  return sum;
}

/* cminpack's callback: residuals (1) or their slopes (2) at x. */
static int evaluate(void *model, int rows, int n, const double *x, double *residual, double *slope,
                    int stride, int what)
{
  (void)rows;
  (void)n;
  (void)stride;
  if (what == 1)
    hl_parametric_residuals(model, x[0], residual);
  else
    hl_parametric_slopes(model, x[0], slope);
  return 0;
}

static double refine(hl_parametric *m, const block *b, double *p)
{
  double scale[1] = {1}, qtf[1], wa1[1], wa2[1], wa3[1];
  int evaluations = 0, slopes = 0, pivot[1];
  const int rows = m->channels * m->n;
  /* to rounding; a step of 1 is a factor e in mu */
  lmder(evaluate, m, rows, 1, p, b->residual, b->slope, rows, 1e-15, 1e-15, 0, EVALUATIONS_MAX,
        scale, 2, 1, 0, &evaluations, &slopes, pivot, qtf, wa1, wa2, wa3, b->work);
  return hl_parametric_solve(m, *p);
}

/* Best log mu over all: local minima of a grid, lowest first, refined. */
static double search(hl_parametric *m, const block *b)
{
  const double low = log(hl_parametric_least), high = log(hl_parametric_most);
  double at[STARTS], cost[STARTS], best = 0, least = HUGE_VAL;
  bool tried[STARTS] = {false};
  for (int k = 0; k < STARTS; k++) {
    at[k] = low + (high - low) * (k + 0.5) / STARTS;
    cost[k] = hl_parametric_solve(m, at[k]);
  }
  for (int round = 0; round < REFINED; round++) {
    int next = -1;
    for (int k = 0; k < STARTS; k++) {
      const bool lowest =
          (k == 0 || cost[k] <= cost[k - 1]) && (k == STARTS - 1 || cost[k] <= cost[k + 1]);
      if (!tried[k] && lowest && (next < 0 || cost[k] < cost[next]))
        next = k;
    }
    if (next < 0)
      break;
    tried[next] = true;
    double p = at[next];
    const double reached = refine(m, b, &p);
    if (reached < least) {
      least = reached;
      best = fmin(fmax(p, low), high);
    }
  }
  return best;
}

/* ---- as a fit */

static double lobe_at(hl_fit_model model, double mu, double angle)
{
  return model == HL_FIT_TORRANCE_SPARROW ? exp(-mu * angle * angle) : pow(cos(angle), mu);
}

static void draw_terms(const hl_parametric *m, double mu, hl_fit *f)
{
  hl_term *body = &f->term[0], *lobe = &f->term[1];
  f->n_terms = 2;
  *body = (hl_term){.role = HL_TERM_LINEAR, .in_plane = true, .cs = 1, .n = 2};
  *lobe = (hl_term){.role = HL_TERM_LOBE, .in_plane = true, .cs = 1, .cv = 1, .n = HL_CURVE_POINTS};
  snprintf(body->name, sizeof body->name, "s");
  snprintf(lobe->name, sizeof lobe->name, "h");
  memcpy(body->direction, f->light, sizeof body->direction);
  hl_add_scaled(f->light, 1, f->view, lobe->direction);
  hl_unit(lobe->direction, lobe->direction);
  body->t[1] = 1;
  for (int i = 0; i < lobe->n; i++) {
    const double share = 1 - (double)i / (lobe->n - 1), angle = half_pi * share * share;
    lobe->t[i] = i == 0 ? 0 : cos(angle);
    for (int c = 0; c < m->channels; c++)
      lobe->value[c][i] =
          m->ks[c] * (i == 0 && m->model == HL_FIT_BLINN_PHONG ? 0 : lobe_at(m->model, mu, angle));
  }
  for (int c = 0; c < m->channels; c++) {
    body->value[c][1] = body->strength[c] = m->kd[c];
    lobe->strength[c] = m->ks[c];
  }
}

/* Share of a curve's squares over the samples that no k t, or no k t + q t^2, explains; its root. */
static void shape_of(const double *t, const double *f, int n, hl_term *term)
{
  double tt = 0, t3 = 0, t4 = 0, ft = 0, ft2 = 0, ff = 0;
  for (int i = 0; i < n; i++) {
    const double t2 = t[i] * t[i];
    tt += t2;
    t3 += t2 * t[i];
    t4 += t2 * t2;
    ft += f[i] * t[i];
    ft2 += f[i] * t2;
    ff += f[i] * f[i];
  }
  const double left = t4 - t3 * t3 / tt, along = ft2 - ft * t3 / tt;
  const double linear = ff - ft * ft / tt;
  const double quadratic = left > 1e-12 * t4 ? linear - along * along / left : linear;
  term->off_linear = ff > 0 ? sqrt(fmax(0, linear) / ff) : 0;
  term->off_quadratic = ff > 0 ? sqrt(fmax(0, quadratic) / ff) : 0;
}

/* What the samples show of both curves, and what each is worth. `t` is scratch, shape (n). */
static void measure_terms(const hl_parametric *m, double variance, double *t, hl_fit *f)
{
  double without[2] = {0}, with = 0;
  for (int k = 0; k < 2; k++) {
    hl_term *term = &f->term[k];
    term->shown[0] = 1;
    for (int i = 0; i < m->n; i++) {
      t[i] = k == 0                                ? m->body[i]
             : m->model == HL_FIT_TORRANCE_SPARROW ? cos(sqrt(m->abscissa[i]))
                                                   : exp(-m->abscissa[i]);
      term->shown[0] = fmin(term->shown[0], t[i]);
      term->shown[1] = fmax(term->shown[1], t[i]);
    }
    const double *f_i = k == 0 ? m->body : m->lobe;
    shape_of(t, f_i, m->n, term);
    const double *other = k == 0 ? m->lobe : m->body;
    for (int c = 0; c < m->channels; c++) {
      double xx = 0, xy = 0, yy = 0;
      for (int i = 0; i < m->n; i++) {
        xx += other[i] * other[i];
        xy += other[i] * m->value[c][i];
        yy += m->value[c][i] * m->value[c][i];
      }
      without[k] += xx > 0 ? yy - fmax(0, xy) * fmax(0, xy) / xx : yy;
      with += k == 0 ? m->square[c] : 0;
    }
    f->term[k].gain = variance > 0 ? fmax(0, without[k] - with) / variance : 0;
  }
}

/* Errors over the samples, lit or not: an unlit one is predicted 0. */
static double measure_fit(const hl_samples *samples, const hl_parametric *m, hl_fit *f)
{
  double difference = 0, sum = 0, squares = 0, variance = 0;
  for (int c = 0; c < m->channels; c++) {
    double mean = 0, lit = 0, all = 0, all2 = 0, lit2 = 0;
    for (int i = 0; i < m->n; i++) {
      const double r = m->kd[c] * m->body[i] + m->ks[c] * m->lobe[i] - m->value[c][i];
      difference += fabs(r);
      lit += m->value[c][i];
      lit2 += m->value[c][i] * m->value[c][i];
      squares += r * r;
    }
    for (int i = 0; i < samples->n; i++) {
      all += samples->value[c][i];
      all2 += samples->value[c][i] * samples->value[c][i];
    }
    difference += all - lit;
    squares += fmax(0, all2 - lit2);
    mean = all / samples->n;
    variance += fmax(0, all2 - all * mean);
    sum += all;
  }
  f->relative_error = difference / sum;
  f->unexplained_variance = variance > 0 ? squares / variance : 0;
  return variance;
}

static void state_verdict(const hl_parametric *m, double mu, hl_fit *f)
{
  double most = 0;
  for (int c = 0; c < m->channels; c++)
    most = fmax(most, m->ks[c]);
  const bool narrow = m->model == HL_FIT_TORRANCE_SPARROW;
  hl_notes_add(&f->used, narrow ? "simplified Torrance-Sparrow" : "Blinn-Phong",
               narrow ? "exp(-mu angle(n,h)^2), mu = %.6g" : "(n.h)^mu, mu = %.6g", mu);
  f->verdict = most > 0 ? HL_UNIQUE : HL_AMBIGUOUS;
  snprintf(f->proposition, sizeof f->proposition, "Proposition 5, the lobe's form taken as given");
  snprintf(f->stays_free, sizeof f->stays_free, "%s",
           most > 0 ? "the light's strength against the albedo"
                    : "mu: there is no lobe to have a width");
  f->trusted = most > 0;
  if (!(most > 0))
    hl_notes_add(&f->reasons, "no lobe", "the samples show none that this model could be");
  else if (mu <= 1.0001 * hl_parametric_least || mu >= 0.9999 * hl_parametric_most)
    hl_notes_add(&f->reasons, "width", "mu = %.6g is the end of its range: no lobe of this form",
                 mu);
  f->trusted = f->reasons.n == 0;
}

static void mean_view(const hl_samples *samples, double out[3])
{
  out[0] = out[1] = 0;
  out[2] = samples->view ? 0 : 1;
  for (int i = 0; samples->view && i < samples->n; i++)
    hl_add_scaled(out, 1, samples->view + 3 * (size_t)i, out);
  hl_unit(out, out);
}

static hl_status check(hl_ctx *ctx, const hl_samples *samples, hl_fit_model model,
                       const double light[3], double s[3])
{
  const hl_status st = hl_samples_check(ctx, samples);
  if (st != HL_OK)
    return st;
  hl_unit(light, s);
  if (!(hl_norm(s) > 0.5))
    return hl_fail(ctx, HL_ERR_ARG, "light (%g, %g, %g); a direction is needed", light[0], light[1],
                   light[2]);
  if (model == HL_FIT_TORRANCE_SPARROW || model == HL_FIT_BLINN_PHONG)
    return HL_OK;
  return hl_fail(
      ctx, HL_ERR_ARG,
      "model %d is not parametric; HL_FIT_TORRANCE_SPARROW or HL_FIT_BLINN_PHONG is needed",
      (int)model);
}

static void describe(const hl_samples *samples, const hl_parametric *m, double mu,
                     const double s[3], double *scratch, hl_fit *f)
{
  f->model = m->model;
  f->n_samples = samples->n;
  f->channels = samples->channels;
  f->has_light = f->light_given = true;
  memcpy(f->light, s, sizeof f->light);
  mean_view(samples, f->view);
  draw_terms(m, mu, f);
  f->condition = f->coplanarity = 1; /* no direction is sought */
  f->least_angle_rad = hl_angle(f->term[0].direction, f->term[1].direction);
  measure_terms(m, measure_fit(samples, m, f), scratch, f);
  state_verdict(m, mu, f);
}

hl_status hl_fit_parametric(hl_ctx *ctx, const hl_samples *samples, hl_fit_model model,
                            const double light[3], hl_fit *out)
{
  double s[3];
  hl_parametric m;
  block b;
  hl_status st = check(ctx, samples, model, light, s);
  if (st == HL_OK)
    st = gather(ctx, samples, model, s, &m, &b);
  if (st != HL_OK)
    return st;
  if (m.n < LEAST_SAMPLES)
    st = hl_fail(ctx, HL_ERR_DEGENERATE,
                 "%d of %d samples are lit by light (%.6g, %.6g, %.6g); at least %d are needed",
                 m.n, samples->n, s[0], s[1], s[2], LEAST_SAMPLES);
  else if (!(sum_of(&m) > 0))
    st = hl_fail(ctx, HL_ERR_DEGENERATE, "all %d lit samples are black; some radiance is needed",
                 m.n);
  if (st == HL_OK) {
    hl_fit f = {0};
    const double p = search(&m, &b);
    (void)hl_parametric_solve(&m, p);
    describe(samples, &m, exp(p), s, b.slope, &f);
    *out = f;
  }
  free(b.start);
  return st;
}
