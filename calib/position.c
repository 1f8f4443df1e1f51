/*
 * A light's position from sights.
 *
 * With c0 the mean origin, b_i = c0 - c_i, and the light at L = c0 + s / w, sight i should look along
 *
 *   u_i = (L - c_i) / |L - c_i| = (s + w b_i) / |s + w b_i|
 *
 * which is smooth through w = 0, the light at infinity, and beyond, where rays part. Its residual is
 * the rotation from d_i to u_i in the tangents T_i of d_i, r_i = T_i u_i (angle / sin(angle)).
 *
 * An error e of the origin moves the measured direction by B_i e, and the one that would be right by
 * -T_i e / rho_i, rho_i = |L - c_i|, so the residual has covariance
 *
 *   C_i = own_i + (B_i + T_i / rho_i) E_i (B_i + T_i / rho_i)'
 *
 * Start, closed form: T_i (s0 + U delta + w b_i) = 0 is linear in delta and w about the mean direction
 * s0. Then Gauss-Newton on the sum of r' C^-1 r, C held within a step and taken
 * anew for the next: a sum that could lower itself by a larger C would draw the light nearer. (delta, w) being nearly
 * normal, the interval of the distance is that of w turned over; the light is at a finite distance
 * where w is above 0 by 1.96 of its deviations.
 */
#include "halflight/position.h"

#include <math.h>
#include <string.h>

#include "halflight/notes.h"
#include "halflight/vec3.h"
#include "sight.h"
#include "significance.h"
#include "spd.h"

enum { UNKNOWNS = 3, STEPS_MAX = 60, HALVINGS_MAX = 20 };

static const double two_sided = 1.959963984540054; /* 95 % of a normal deviate */
static const double one_sided = 1.644853626951472;
static const double too_improbable = 0.01;
static const double least_sigma_rad = 1e-9; /* so that sights stated as exact have a weight */

typedef struct sights {
  const hl_sight *sight;
  int n;
  const bool *used;
  double from[3];           /* c0 */
  double spread;            /* rms |b_i|, the unit of length: w is in 1 / spread */
  double held_s[3], held_w; /* where the covariances are taken */
} sights;

typedef struct answer {
  double s[3], w;
  double cost;
  double covariance[UNKNOWNS][UNKNOWNS]; /* of delta along the tangents of s, and w */
} answer;

/* ---- one sight */

typedef struct residual {
  double r[2];
  double weight[2][2]; /* C^-1 */
  double u[3], length; /* s + w b = length u */
  double b[3];
  double bend; /* angle / sin(angle) */
} residual;

static void covariance_of(const hl_sight *g, double nearness, double out[2][2])
{
  double by[2][3];
  for (int k = 0; k < 2; k++)
    for (int j = 0; j < 3; j++)
      by[k][j] = g->by_origin[k][j] + nearness * g->tangent_basis[k][j];
  for (int k = 0; k < 2; k++)
    for (int l = 0; l < 2; l++) {
      out[k][l] = g->own_rad2[k][l] + (k == l) * least_sigma_rad * least_sigma_rad;
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          out[k][l] += by[k][i] * g->origin_covariance_m2[i][j] * by[l][j];
    }
}

static residual residual_of(const sights *p, int i, const double s[3], double w)
{
  const hl_sight *g = &p->sight[i];
  residual out;
  double q[3], c[2][2];
  for (int k = 0; k < 3; k++)
    out.b[k] = (p->from[k] - g->origin_m[k]) / p->spread;
  hl_add_scaled(s, w, out.b, q);
  out.length = hl_norm(q);
  hl_unit(q, out.u);
  const double angle = hl_angle(g->direction, out.u), sine = sin(angle);
  out.bend = sine > 1e-8 ? angle / sine : 1;
  for (int k = 0; k < 2; k++)
    out.r[k] = out.bend * hl_dot(g->tangent_basis[k], out.u);
  hl_add_scaled(p->held_s, p->held_w, out.b, q);
  covariance_of(g, fmax(p->held_w, 0) / (hl_norm(q) * p->spread), c);
  const double determinant = c[0][0] * c[1][1] - c[0][1] * c[1][0];
  out.weight[0][0] = c[1][1] / determinant;
  out.weight[1][1] = c[0][0] / determinant;
  out.weight[0][1] = out.weight[1][0] = -c[0][1] / determinant;
  return out;
}

static double cost_of(const residual *e)
{
  return e->r[0] * (e->weight[0][0] * e->r[0] + e->weight[0][1] * e->r[1]) +
         e->r[1] * (e->weight[1][0] * e->r[0] + e->weight[1][1] * e->r[1]);
}

static double total_cost(const sights *p, const double s[3], double w)
{
  double sum = 0;
  for (int i = 0; i < p->n; i++)
    if (p->used[i]) {
      const residual e = residual_of(p, i, s, w);
      sum += cost_of(&e);
    }
  return sum;
}

/* ---- all of them */

typedef struct normal {
  double matrix[UNKNOWNS][UNKNOWNS], right[UNKNOWNS], tangent[2][3];
} normal;

/* Derivatives of u by delta and w are those of q, across u, over its length. */
static void accumulate(const hl_sight *g, const residual *e, normal *to)
{
  double slope[2][UNKNOWNS];
  for (int j = 0; j < UNKNOWNS; j++) {
    const double *q = j < 2 ? to->tangent[j] : e->b;
    double across[3];
    hl_add_scaled(q, -hl_dot(q, e->u), e->u, across);
    for (int k = 0; k < 2; k++)
      slope[k][j] = e->bend * hl_dot(g->tangent_basis[k], across) / e->length;
  }
  for (int k = 0; k < 2; k++)
    for (int l = 0; l < 2; l++)
      for (int i = 0; i < UNKNOWNS; i++) {
        to->right[i] -= slope[k][i] * e->weight[k][l] * e->r[l];
        for (int j = 0; j < UNKNOWNS; j++)
          to->matrix[i][j] += slope[k][i] * e->weight[k][l] * slope[l][j];
      }
}

static normal linearise(sights *p, const double s[3], double w)
{
  memcpy(p->held_s, s, sizeof p->held_s);
  p->held_w = w;
  normal out = {.right = {0}};
  hl_tangent_basis(s, out.tangent[0], out.tangent[1]);
  for (int i = 0; i < p->n; i++)
    if (p->used[i]) {
      const residual e = residual_of(p, i, s, w);
      accumulate(&p->sight[i], &e, &out);
    }
  return out;
}

static void moved(const double s[3], const normal *at, const double step[UNKNOWNS], double by,
                  double out[3])
{
  hl_add_scaled(s, by * step[0], at->tangent[0], out);
  hl_add_scaled(out, by * step[1], at->tangent[1], out);
  hl_unit(out, out);
}

/* False where the sights do not determine direction and nearness. */
static bool solve(sights *p, answer *out)
{
  double s[3] = {0, 0, 0}, w = 0;
  hl_spd factor;
  for (int i = 0; i < p->n; i++)
    if (p->used[i])
      hl_add_scaled(s, 1, p->sight[i].direction, s);
  if (!(hl_norm(s) > 0))
    return false;
  hl_unit(s, s);
  normal at = linearise(p, s, w); /* at w = 0 this is the closed form */
  for (int i = 0; i < STEPS_MAX; i++) {
    const double cost = total_cost(p, s, w);
    double step[UNKNOWNS], next[3], by = 1;
    if (!hl_spd_factor(at.matrix[0], UNKNOWNS, 0, &factor, NULL))
      return false;
    hl_spd_solve(&factor, at.right, step);
    for (int k = 0; k < HALVINGS_MAX; k++) {
      by = ldexp(1, -k);
      moved(s, &at, step, by, next);
      if (total_cost(p, next, w + by * step[2]) <= cost * (1 + 1e-12))
        break;
    }
    const double size = fabs(by * step[0]) + fabs(by * step[1]) + fabs(by * step[2]);
    memcpy(s, next, sizeof s);
    w += by * step[2];
    at = linearise(p, s, w);
    if (size < 1e-12)
      break;
  }
  if (!hl_spd_factor(at.matrix[0], UNKNOWNS, 0, &factor, NULL))
    return false;
  hl_spd_inverse(&factor, out->covariance[0]);
  memcpy(out->s, s, sizeof s);
  out->w = w;
  out->cost = total_cost(p, s, w);
  return isfinite(out->cost) && isfinite(w);
}

/* Mean origin and spread of the sights used; false where they are one point. */
static bool gather(sights *p)
{
  int n = 0;
  memset(p->from, 0, sizeof p->from);
  for (int i = 0; i < p->n; i++)
    if (p->used[i]) {
      hl_add_scaled(p->from, 1, p->sight[i].origin_m, p->from);
      n++;
    }
  for (int k = 0; k < 3; k++)
    p->from[k] /= n;
  double sum = 0, size = 0;
  for (int i = 0; i < p->n; i++)
    if (p->used[i]) {
      double b[3];
      hl_add_scaled(p->from, -1, p->sight[i].origin_m, b);
      sum += hl_dot(b, b);
      size += hl_dot(p->sight[i].origin_m, p->sight[i].origin_m);
    }
  p->spread = sqrt(sum / n);
  return p->spread > 1e-9 * sqrt(size / n);
}

static double probability_of(double cost, int n_used)
{
  return hl_significance(cost, 2 * n_used - UNKNOWNS, HUGE_VAL);
}

/* ---- sights that contradict the others */

/* Leaves out the one whose absence lets the rest, and no other rest, agree. *ambiguous: several would. */
static bool leave_one_out(sights *p, bool *used, int n_used, answer *best, bool *ambiguous)
{
  int which = -1, agreeing = 0;
  double least = HUGE_VAL;
  for (int i = 0; i < p->n; i++) {
    answer a;
    if (!used[i])
      continue;
    used[i] = false;
    const bool solved = gather(p) && solve(p, &a);
    used[i] = true;
    if (!solved)
      continue;
    agreeing += probability_of(a.cost, n_used - 1) >= too_improbable;
    if (a.cost < least) {
      least = a.cost;
      which = i;
      *best = a;
    }
  }
  *ambiguous = agreeing > 1;
  if (which < 0 || *ambiguous)
    return false;
  used[which] = false;
  return true;
}

/* All sights, or all but those few that contradict the rest; p->used points at `used`. */
static bool settle(sights *p, bool *used, answer *out, int *n_used)
{
  bool ambiguous = false;
  *n_used = p->n;
  if (!gather(p) || !solve(p, out))
    return false;
  bool kept[HL_SIGHTS_MAX];
  answer a = *out;
  int left = p->n;
  memcpy(kept, used, (size_t)p->n * sizeof *kept);
  while (probability_of(a.cost, left) < too_improbable && p->n - left < p->n / 3 && left > 2 &&
         leave_one_out(p, used, left, &a, &ambiguous))
    left--;
  if (left < p->n && probability_of(a.cost, left) >= too_improbable) {
    *out = a;
    *n_used = left;
  } else {
    memcpy(used, kept, (size_t)p->n * sizeof *kept);
  }
  memcpy(p->held_s, out->s, sizeof p->held_s);
  p->held_w = out->w;
  return gather(p);
}

/* ---- what is said of it */

static void place(const sights *p, const answer *a, hl_position *out)
{
  const double sigma = sqrt(a->covariance[2][2]), w = a->w;
  const double nearest = w + two_sided * sigma, farthest = w - two_sided * sigma;
  memcpy(out->from_m, p->from, sizeof p->from);
  memcpy(out->direction, a->s, sizeof a->s);
  out->found = farthest > 0;
  out->least_distance_m =
      w + one_sided * sigma > 0 ? p->spread / (w + one_sided * sigma) : HUGE_VAL;
  out->distance_95_m[0] = nearest > 0 ? p->spread / nearest : HUGE_VAL;
  out->distance_95_m[1] = out->found ? p->spread / farthest : HUGE_VAL;
  out->distance_m = HUGE_VAL;
  if (!out->found)
    return;
  double tangent[2][3], by[3][UNKNOWNS];
  const double distance = p->spread / w;
  hl_tangent_basis(a->s, tangent[0], tangent[1]);
  for (int k = 0; k < 3; k++) {
    by[k][0] = distance * tangent[0][k];
    by[k][1] = distance * tangent[1][k];
    by[k][2] = -distance / w * a->s[k];
  }
  for (int k = 0; k < 3; k++)
    for (int l = 0; l < 3; l++)
      for (int i = 0; i < UNKNOWNS; i++)
        for (int j = 0; j < UNKNOWNS; j++)
          out->covariance_m2[k][l] += by[k][i] * a->covariance[i][j] * by[l][j];
  out->distance_m = distance;
  hl_add_scaled(p->from, distance, a->s, out->position_m);
}

static void tell(const sights *p, const answer *a, hl_position *out)
{
  for (int i = 0; i < p->n; i++) {
    const residual e = residual_of(p, i, a->s, a->w);
    out->sight[i] = (hl_sight_fit){p->used[i], hypot(e.r[0], e.r[1]), cost_of(&e)};
    if (!p->used[i])
      hl_notes_add(&out->left_out, "sight", "number %d is %.3g deg off where the others meet",
                   i + 1, out->sight[i].off_rad * 57.29577951308232);
  }
  out->trusted = out->probability >= too_improbable;
  if (!out->trusted)
    hl_notes_add(&out->reasons, "sights contradict each other",
                 "chi-squared %.3g on %d degrees of freedom, probability %.2g", out->chi_squared,
                 out->dof, out->probability);
  for (int i = 0; i < p->n; i++)
    if (p->used[i] && p->sight[i].doubted) {
      out->trusted = false;
      hl_notes_add(&out->reasons, "sight not trusted",
                   "number %d comes from an estimate that is not to be trusted: see its reasons",
                   i + 1);
    }
}

static hl_status too_far(hl_ctx *ctx, hl_position *out)
{
  out->trusted = false;
  if (!isfinite(out->least_distance_m)) {
    hl_notes_add(&out->reasons, "sights part", "they meet behind the balls, not at a light");
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "the sights part, as if the light were behind the balls; sights of one light in "
                   "one frame of reference are needed");
  }
  hl_notes_add(&out->reasons, "sights are parallel",
               "within their ellipses: the light is at least %.4g m away", out->least_distance_m);
  return hl_fail(ctx, HL_ERR_DEGENERATE,
                 "the sights are parallel within their ellipses: the light is at least %.4g m away "
                 "(95 %%); balls farther apart or smaller ellipses are needed",
                 out->least_distance_m);
}

hl_status hl_position_of_sights(hl_ctx *ctx, const hl_sight *list, int n, hl_position *out)
{
  bool used[HL_SIGHTS_MAX];
  sights p = {.sight = list, .n = n, .used = used};
  answer a;
  const hl_status st = hl_sights_check(ctx, list, n);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < n; i++)
    used[i] = true;
  *out = (hl_position){.n = n, .distance_m = HUGE_VAL, .distance_95_m = {0, HUGE_VAL}};
  if (!settle(&p, used, &a, &out->n_used)) {
    hl_notes_add(&out->reasons, "one place", "all sights start at one point, or look every way");
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "the sights start at one point, or look every way; one light seen from several "
                   "places is needed");
  }
  out->chi_squared = a.cost;
  out->dof = 2 * out->n_used - UNKNOWNS;
  out->probability = probability_of(a.cost, out->n_used);
  place(&p, &a, out);
  tell(&p, &a, out);
  return out->found ? HL_OK : too_far(ctx, out);
}
