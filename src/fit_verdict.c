/* What a fit may claim, read off the fit itself.
 *
 * The paper's conditions are about linear, quadratic and coinciding terms; a fit's terms are never
 * exactly so. A curve counts as linear (quadratic) where no more than a fiftieth of its rms over the
 * samples is left by k t (k t + q t^2), directions coincide within two degrees, and three lie in a
 * plane where their triple product is below 0.03; the figures themselves are part of the fit.
 *
 * How well the directions are known: H, the Gauss-Newton matrix with the curves profiled out; with
 * sigma^2 = r'Wr/(N - p) the covariance of the directions is sigma^2 H^-1.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cholesky.h"
#include "fit_work.h"
#include "halflight/notes.h"
#include "halflight/vec3.h"

enum { ROUNDS = 60 };
static const double pi = 3.14159265358979323846;
static const double deg = 57.295779513082320877;
static const double linear_share = 0.02, quadratic_share = 0.02;
static const double coincident_rad = 0.035, flat_product = 0.03;
static const double worst_sigma_rad = 0.09; /* 5 deg */
static const double most_unexplained = 0.4;

/* ---- how well the directions are known ---- */

/* Largest eigenvalue of a symmetric matrix by powers; of its inverse where `factor` is Cholesky's. */
static double largest_eigenvalue(const double *matrix, const double *factor, int q)
{
  double x[HL_AXES_MAX], value = 0;
  for (int i = 0; i < q; i++)
    x[i] = 1 + 0.1 * i;
  for (int round = 0; round < ROUNDS; round++) {
    double y[HL_AXES_MAX], norm = 0;
    for (int i = 0; i < q; i++) {
      y[i] = factor ? x[i] : 0;
      for (int j = 0; j < q && !factor; j++)
        y[i] += matrix[i * q + j] * x[j];
    }
    if (factor)
      hl_cholesky_solve(factor, q, q, y);
    for (int i = 0; i < q; i++)
      norm += y[i] * y[i];
    norm = sqrt(norm);
    if (!(norm > 0))
      return 0;
    for (int i = 0; i < q; i++)
      x[i] = y[i] / norm;
    value = norm;
  }
  return value;
}

/* Deviation of the parameters from `first`, the larger half axis. */
static double deviation(const double *factor, int q, int first, int count)
{
  double c[2][2] = {{0}};
  for (int k = 0; k < count; k++) {
    double y[HL_AXES_MAX] = {0};
    y[first + k] = 1;
    hl_cholesky_solve(factor, q, q, y);
    for (int l = 0; l < count; l++)
      c[k][l] = y[first + l];
  }
  const double half = 0.5 * (c[0][0] + c[1][1]);
  return sqrt(
      fmax(0, half + sqrt(0.25 * (c[0][0] - c[1][1]) * (c[0][0] - c[1][1]) + c[0][1] * c[0][1])));
}

static void set_spread(const hl_fit_work *w, const hl_ridge_fit *fit, hl_fit *out)
{
  double h[HL_AXES_MAX * HL_AXES_MAX], u[HL_AXES_MAX * HL_AXES_MAX];
  const int q = hl_axes_parameters(&fit->axes);
  out->condition = 1;
  out->direction_sigma_rad = 0;
  if (q == 0)
    return;
  for (int i = 0; i < q; i++)
    for (int j = 0; j < q; j++)
      u[i * q + j] = h[i * q + j] = fit->hessian[i][j];
  hl_cholesky(u, q, q, 1e-14);
  const double most = largest_eigenvalue(h, NULL, q), least = largest_eigenvalue(NULL, u, q);
  out->condition = fmin(most * least, 1e300);
  const double samples = (double)w->all.n * w->all.channels;
  const double freedom = fmax(1, samples - hl_ridges_columns(&fit->ridges) * w->all.channels);
  const double sigma = sqrt(fit->misfit / freedom);
  int at = 0;
  if (fit->axes.seeks_light) {
    out->direction_sigma_rad = sigma * deviation(u, q, 0, 2);
    at = 2;
  }
  for (int i = 0; i < fit->axes.n; i++) {
    const hl_axis_kind kind = fit->axes.axis[i].kind;
    const int count = kind == HL_AXIS_FREE ? 2 : kind == HL_AXIS_PLANE ? 1 : 0;
    if (count > 0 && !fit->ridges.linear[i])
      out->direction_sigma_rad = fmax(out->direction_sigma_rad, sigma * deviation(u, q, at, count));
    at += count;
  }
  out->direction_sigma_rad = fmin(out->direction_sigma_rad, pi);
}

/* ---- how close to the edge ---- */

static void set_geometry(hl_fit *out)
{
  out->least_angle_rad = pi;
  out->coplanarity = 1;
  for (int i = 0; i < out->n_terms; i++)
    for (int j = 0; j < i; j++) {
      const double *a = out->term[i].direction, *b = out->term[j].direction;
      out->least_angle_rad = fmin(out->least_angle_rad, hl_angle(a, b));
      for (int k = 0; k < j; k++) {
        double cross[3];
        hl_cross(a, b, cross);
        out->coplanarity = fmin(out->coplanarity, fabs(hl_dot(cross, out->term[k].direction)));
      }
    }
}

static bool is_linear(const hl_term *term)
{
  return term->role == HL_TERM_LINEAR || term->off_linear < linear_share;
}

static bool is_quadratic(const hl_term *term)
{
  return !is_linear(term) && term->off_quadratic < quadratic_share;
}

typedef struct verdict {
  hl_identifiability verdict;
  const char *proposition, *stays_free;
} verdict;

static const char strength_free[] = "the light's strength against the albedo";

/* Two terms about the same direction, or two linear ones, or two quadratic ones. */
static bool is_degenerate(const hl_fit *out, int linear, int quadratic, verdict *v)
{
  *v = (verdict){HL_AMBIGUOUS, NULL, NULL};
  if (linear > 1) {
    v->proposition = "Remark 1: at most one term can be linear";
    v->stays_free = "how the linear terms divide their sum, and with it their directions";
  } else if (out->n_terms > 1 && out->least_angle_rad < coincident_rad) {
    v->proposition = "Remark 3: two directions coincide";
    v->stays_free = "how radiance divides between the curves about the shared direction";
  } else if (quadratic > 1) {
    v->proposition = "Remark 2: at most one term can be quadratic";
    v->stays_free = "how the quadratic terms divide their sum, and with it their directions";
  }
  return v->proposition != NULL;
}

/* Whether the linear one of two terms is about the given light: Prop. 5 holds of no other. */
static bool is_along_light(const hl_fit *out)
{
  for (int i = 0; i < out->n_terms; i++)
    if (is_linear(&out->term[i]))
      return hl_angle(out->term[i].direction, out->light) < coincident_rad;
  return false;
}

/* A linear part that is not there: what is left is one curve. */
static bool lacks_linear_part(const hl_fit *out)
{
  bool zero = out->model == HL_FIT_DICHROMATIC;
  for (int c = 0; c < out->channels; c++)
    zero = zero && !(out->term[0].strength[c] > 0);
  return zero;
}

static verdict verdict_of_two(const hl_fit *out, int linear, int quadratic, bool known)
{
  if (lacks_linear_part(out) && !out->light_given)
    return (verdict){HL_AMBIGUOUS,
                     "Remark 3: no linear part, or one along the lobe, the light not known",
                     "whether the lobe's direction is the half vector (no linear part: the light "
                     "is its mirror image of the view) or the light itself"};
  if (linear == 1 && out->light_given && is_along_light(out))
    return (verdict){HL_UNIQUE, "Proposition 5: one lobe, the light's direction known",
                     strength_free};
  if (linear == 1 && out->light_given && !known)
    return (verdict){HL_AMBIGUOUS, "Proposition 3: one lobe and a linear part not along the light",
                     "a share k b.n between lobe and linear part; the lobe's direction b is "
                     "determined"};
  if (linear == 1 && !known)
    return (verdict){
        HL_AMBIGUOUS, "Proposition 3: one lobe and a linear part, the light not known",
        out->has_light ? "a share k b.n between lobe and linear part, were the linear part not "
                         "along the light that the lobe's direction b, taken as h, implies"
                       : "a share k b.n between lobe and linear part, here as much of it as L1-L4 "
                         "allow in the linear part; the lobe's direction b is determined"};
  if (known)
    return (verdict){HL_UNIQUE, "Section 5.2: curves along known, independent directions",
                     strength_free};
  if (quadratic == 1)
    return (verdict){HL_NOT_GUARANTEED, "Proposition 6 asks for two curves that are not quadratic",
                     "what a quadratic curve and the other one can share"};
  return (verdict){HL_UNIQUE, "Proposition 6: two lobes, neither linear nor quadratic",
                   strength_free};
}

static verdict verdict_of_many(const hl_fit *out)
{
  if (out->least_angle_rad < coincident_rad)
    return (verdict){HL_NOT_GUARANTEED, "Section 4.4, Remark 3: three or more terms, two coincide",
                     "how curves about a shared direction divide, and what all of them share"};
  if (out->coplanarity < flat_product)
    return (verdict){HL_NOT_GUARANTEED, "Section 4.4, Remark 3: three or more terms, coplanar",
                     "the directions and what their curves share"};
  return (verdict){HL_NOT_GUARANTEED, "Section 4.4: three or more terms",
                   "the directions and what their curves share"};
}

static verdict verdict_of(const hl_fit *out)
{
  int linear = 0, quadratic = 0;
  verdict v;
  bool known = out->model == HL_FIT_ADDITIVE;
  for (int i = 0; i < out->n_terms; i++) {
    linear += is_linear(&out->term[i]);
    quadratic += is_quadratic(&out->term[i]);
  }
  if (!known && out->n_terms > 2)
    return verdict_of_many(out);
  if (is_degenerate(out, known ? 0 : linear, known ? 0 : quadratic, &v))
    return v;
  if (out->n_terms == 1)
    return (verdict){HL_UNIQUE, "Propositions 1 and 2: one curve along one direction",
                     strength_free};
  if (out->n_terms == 2)
    return verdict_of_two(out, linear, quadratic, known);
  if (out->n_terms == 3 && out->coplanarity >= flat_product)
    return (verdict){HL_UNIQUE, "Section 5.2: curves along known, independent directions",
                     strength_free};
  return (verdict){HL_AMBIGUOUS, "Remark 3: the directions are linearly dependent",
                   "linear parts k_i a_i.n that add up to nothing"};
}

/* ---- trust ---- */

static void judge_trust(const hl_ridge_fit *fit, hl_fit *out)
{
  if (!(out->unexplained_variance < most_unexplained))
    hl_notes_add(&out->reasons, "model",
                 "%.0f %% of the variance is unexplained: not one material under one light, or "
                 "normals of another surface",
                 100 * fmin(1, out->unexplained_variance));
  if (out->model == HL_FIT_DICHROMATIC && is_linear(&out->term[1]))
    hl_notes_add(&out->reasons, "lobe",
                 "its curve is linear (off by %.2g %%), so its direction is not determined; a "
                 "glossier surface, or --model ridge, is needed",
                 100 * out->term[1].off_linear);
  else if (out->model != HL_FIT_ADDITIVE && !(out->direction_sigma_rad < worst_sigma_rad))
    hl_notes_add(&out->reasons, "direction",
                 "known to %.0f deg only (one deviation): more samples, less noise, or a surface "
                 "that curves more, is needed",
                 deg * out->direction_sigma_rad);
  if (!fit->converged)
    hl_notes_add(&out->left_out, "convergence", "the directions still moved after the last step");
  out->trusted = out->reasons.n == 0;
}

void hl_fit_judge(const hl_fit_work *w, const hl_ridge_fit *fit, hl_fit *out)
{
  set_spread(w, fit, out);
  set_geometry(out);
  const verdict v = verdict_of(out);
  out->verdict = v.verdict;
  snprintf(out->proposition, sizeof out->proposition, "%s", v.proposition);
  snprintf(out->stays_free, sizeof out->stays_free, "%s", v.stays_free);
  judge_trust(fit, out);
}
