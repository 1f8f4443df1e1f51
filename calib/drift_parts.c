/*
 * Which parts of a camera moved.
 *
 * The evidence is x delta = z + e, e of unit covariance, delta the changes. With S a set of parts,
 * P_S the projection onto the columns of x that belong to S, and P that onto all of them,
 *
 *   T_S = |P z|^2 - |P_S z|^2  ~  chi-squared(rank x - rank x_S)   where no part outside S moved
 *
 * (F where the noise comes from few residuals): the misfit that is left when S is free and the others
 * are held; for x = L^-1, L L' = Cov(delta), it is delta_R' Cov_RR^-1 delta_R, R the parts outside S.
 *
 *   - Verdict: drifted where T of the empty set is reached with less than the rate of false alarms.
 *     This is the only test that can raise an alarm, so the rate is that of the whole comparison.
 *   - What moved: the smallest S whose T_S is unremarkable at that rate. A mount that is knocked turns
 *     and shifts at once, so both together count as one thing: fewer things go before fewer parts. Of
 *     several sets of that size it is the one with the least T_S + 2 rank x_S (Akaike 1974), which is
 *     the likeliest where ranks are equal. Others that would do are noted.
 *   - Each part's own test is that of adding it to, or taking it from, S, at a rate shared evenly by
 *     the parts (Sidak 1967); its change is that with S and itself free.
 *
 * Ranks come from Gram and Schmidt's method with pivoting, since one view of a board does not tell
 * every change apart. Columns are scaled to unit length first: k3 and fx differ by ten orders of
 * magnitude.
 */
#include "drift_parts.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "halflight/notes.h"
#include "significance.h"

/* A column of which less than this is left beside others is one of them, to rounding. */
static const double dependent = 1e-9;

void hl_evidence_of(const hl_triangle *triangle, int first, const double *scale, double noise_dof,
                    hl_evidence *out)
{
  out->n = triangle->n - first;
  out->noise_dof = noise_dof;
  for (int i = 0; i < out->n; i++) {
    out->z[i] = triangle->z[first + i];
    for (int k = 0; k < out->n; k++)
      out->x[i][k] = triangle->r[first + i][first + k] / scale[k];
  }
}

/* The changes of a set of parts, all others held. */
typedef struct explanation {
  double explained; /* |P_S z|^2 */
  int rank;
  double delta[HL_CHANGES_MAX];
  double root[HL_CHANGES_MAX][HL_CHANGES_MAX]; /* Cov(delta) = root root' */
} explanation;

static bool belongs(const hl_part *part, int n_parts, unsigned set, int column)
{
  for (int p = 0; p < n_parts; p++)
    if (set >> p & 1 && column >= part[p].first && column < part[p].first + part[p].n)
      return true;
  return false;
}

static double dot(const double *a, const double *b, int n)
{
  double sum = 0;
  for (int i = 0; i < n; i++)
    sum += a[i] * b[i];
  return sum;
}

/* Columns of x, orthonormalised: x[, order] = q r. */
typedef struct basis {
  int rank;
  int order[HL_CHANGES_MAX];
  double q[HL_CHANGES_MAX][HL_CHANGES_MAX]; /* q[j] is the j-th vector */
  double r[HL_CHANGES_MAX][HL_CHANGES_MAX];
} basis;

/* What the basis leaves of a column; returns its share of the column's length. */
static double left_over(const hl_evidence *e, const basis *b, int column, double v[HL_CHANGES_MAX])
{
  for (int i = 0; i < e->n; i++)
    v[i] = e->x[i][column];
  const double whole = sqrt(dot(v, v, e->n));
  for (int j = 0; j < 2 * b->rank; j++) { /* twice: the second time takes what rounding left */
    const double *q = b->q[j % b->rank];
    const double share = dot(q, v, e->n);
    for (int i = 0; i < e->n; i++)
      v[i] -= share * q[i];
  }
  return whole > 0 ? sqrt(dot(v, v, e->n)) / whole : 0;
}

/* Appends the column of which the basis leaves most; false where it leaves nothing of any. */
static bool extend(const hl_evidence *e, const bool *used, basis *b)
{
  double best[HL_CHANGES_MAX] = {0}, most = 0;
  int at = -1;
  for (int k = 0; k < e->n; k++) {
    double v[HL_CHANGES_MAX];
    const double share = used[k] ? left_over(e, b, k, v) : 0;
    if (!(share > most))
      continue;
    most = share;
    at = k;
    memcpy(best, v, sizeof best);
  }
  if (!(most > dependent))
    return false;
  const double length = sqrt(dot(best, best, e->n));
  for (int i = 0; i < e->n; i++)
    b->q[b->rank][i] = best[i] / length;
  b->order[b->rank++] = at;
  return true;
}

static void orthonormalise(const hl_evidence *e, const bool *used, basis *b)
{
  memset(b, 0, sizeof *b);
  while (b->rank < e->n && extend(e, used, b))
    ;
  for (int j = 0; j < b->rank; j++)
    for (int i = 0; i <= j; i++)
      for (int k = 0; k < e->n; k++)
        b->r[i][j] += b->q[i][k] * e->x[k][b->order[j]];
}

static explanation explain(const hl_evidence *e, const hl_part *part, int n_parts, unsigned set)
{
  explanation out = {0};
  bool used[HL_CHANGES_MAX];
  basis b;
  for (int k = 0; k < e->n; k++)
    used[k] = belongs(part, n_parts, set, k);
  orthonormalise(e, used, &b);
  out.rank = b.rank;
  /* r^-1, column by column: the last one is applied to q'z */
  for (int c = 0; c <= b.rank; c++) {
    double y[HL_CHANGES_MAX];
    for (int i = b.rank - 1; i >= 0; i--) {
      const double right = c < b.rank ? i == c : dot(b.q[i], e->z, e->n);
      out.explained += c < b.rank ? 0 : right * right;
      y[i] = right;
      for (int k = i + 1; k < b.rank; k++)
        y[i] -= b.r[i][k] * y[k];
      y[i] /= b.r[i][i];
      if (c < b.rank)
        out.root[b.order[i]][c] = y[i];
      else
        out.delta[b.order[i]] = y[i];
    }
  }
  return out;
}

/* ---- the smallest set ---- */

enum { SETS_MAX = 1 << HL_DRIFT_CAUSES_MAX, ALTERNATIVES_MAX = 3 };

/* One set of parts, as an answer. */
typedef struct answer {
  bool passes;        /* what it leaves is unremarkable */
  int things;         /* intrinsics' parts, and the mount as one */
  double probability; /* of what it leaves */
  double criterion;   /* Akaike's */
} answer;

typedef struct question {
  const hl_evidence *evidence;
  const hl_part *part;
  int n_parts;
  double false_alarm;
  explanation whole;
} question;

static int parts_in(unsigned set)
{
  int n = 0;
  for (; set; set >>= 1)
    n += (int)(set & 1u);
  return n;
}

static int things_in(const question *q, unsigned set)
{
  int things = 0;
  bool mount = false;
  for (int p = 0; p < q->n_parts; p++) {
    const bool of_mount = strcmp(q->part[p].what, "mount") == 0;
    mount = mount || (of_mount && set >> p & 1);
    things += !of_mount && set >> p & 1;
  }
  return things + mount;
}

static answer answer_of(const question *q, unsigned set)
{
  const explanation e = explain(q->evidence, q->part, q->n_parts, set);
  const double left = q->whole.explained - e.explained;
  answer a = {.things = things_in(q, set), .criterion = left + 2 * e.rank};
  a.probability = hl_significance(left, q->whole.rank - e.rank, q->evidence->noise_dof);
  a.passes = a.probability >= q->false_alarm;
  return a;
}

/* "centre and rotation" */
static void name_set(const question *q, unsigned set, char *out, size_t size)
{
  size_t at = 0;
  int left = parts_in(set);
  out[0] = '\0';
  for (int p = 0; p < q->n_parts; p++) {
    if (!(set >> p & 1))
      continue;
    const char *link = at == 0 ? "" : left == 1 ? " and " : ", ";
    const int more = snprintf(out + at, size - at, "%s%s", link, q->part[p].part);
    at += more > 0 && (size_t)more < size - at ? (size_t)more : 0;
    left--;
  }
}

/* Sets of no more parts that would do as well, and hold neither the chosen one nor a smaller one that
 * would. */
static void note_alternatives(const question *q, const answer *answers, unsigned chosen,
                              hl_notes *notes)
{
  const unsigned sets = 1u << q->n_parts;
  bool named[SETS_MAX] = {false};
  for (int told = 0; told < ALTERNATIVES_MAX; told++) {
    unsigned next = 0;
    for (unsigned set = 1; set < sets; set++) {
      bool minimal = (set & chosen) != chosen;
      for (unsigned less = 1; less < set; less++)
        minimal = minimal && !((set & less) == less && answers[less].passes);
      if (answers[set].passes && minimal && parts_in(set) <= parts_in(chosen) && !named[set] &&
          (next == 0 || answers[set].criterion < answers[next].criterion))
        next = set;
    }
    if (next == 0)
      return;
    char name[HL_NOTE_TEXT_MAX / 2];
    name_set(q, next, name, sizeof name);
    hl_notes_add(notes, "cause", "%s would explain it too (probability %.2g)", name,
                 answers[next].probability);
    named[next] = true;
  }
}

/* Fewer things, then fewer parts, then the likelier. */
static bool is_smaller(const answer *answers, unsigned a, unsigned b)
{
  if (answers[a].things != answers[b].things)
    return answers[a].things < answers[b].things;
  if (parts_in(a) != parts_in(b))
    return parts_in(a) < parts_in(b);
  return answers[a].criterion < answers[b].criterion;
}

static unsigned smallest_set(const question *q, hl_notes *notes)
{
  const unsigned sets = 1u << q->n_parts;
  answer answers[SETS_MAX] = {{0}};
  unsigned best = sets - 1; /* all parts leave nothing */
  for (unsigned set = 1; set < sets; set++)
    answers[set] = answer_of(q, set);
  for (unsigned set = 1; set < sets; set++) {
    if (answers[set].passes && is_smaller(answers, set, best))
      best = set;
  }
  note_alternatives(q, answers, best, notes);
  return best;
}

/* ---- each part ---- */

static double quadratic(const hl_part *part, const double *a)
{
  double sum = 0;
  for (int i = 0; i < part->n; i++)
    for (int k = 0; k < part->n; k++)
      sum += a[i] * part->metric[i][k] * a[k];
  return sum;
}

/* Expected figure^2 of the noise alone. */
static double noise_figure(const hl_part *part, const explanation *e)
{
  double sum = 0;
  for (int c = 0; c < e->rank; c++) {
    double a[HL_DISTORTION_MAX];
    for (int i = 0; i < part->n; i++)
      a[i] = e->root[part->first + i][c];
    sum += quadratic(part, a);
  }
  return sum;
}

static void fill_cause(const question *q, int p, unsigned moved, hl_drift_cause *out)
{
  const hl_part *part = &q->part[p];
  const unsigned with = moved | 1u << p;
  const explanation e = explain(q->evidence, q->part, q->n_parts, with);
  const explanation other = explain(q->evidence, q->part, q->n_parts, with & ~(1u << p));
  const double t = e.explained - other.explained;
  const int rank = e.rank - other.rank;
  *out = (hl_drift_cause){.what = part->what,
                          .part = part->part,
                          .unit = part->unit,
                          .moved = moved >> p & 1,
                          .n = part->n};
  for (int i = 0; i < part->n; i++) {
    const double *root = e.root[part->first + i];
    out->change[i] = e.delta[part->first + i];
    out->sigma[i] = sqrt(dot(root, root, e.rank));
  }
  out->figure = sqrt(quadratic(part, out->change));
  out->significance = hl_significance(t, rank, q->evidence->noise_dof);
  if (rank == 0) {
    out->threshold = NAN;
    return;
  }
  const double rate = -expm1(log1p(-q->false_alarm) / q->n_parts);
  const double limit = hl_significance_limit(rate, rank, q->evidence->noise_dof);
  /* where it did not move at all there is no direction: the mean over all of them */
  out->threshold =
      t > 1e-9 ? out->figure * sqrt(limit / t) : sqrt(limit / rank * noise_figure(part, &e));
}

void hl_parts_judge(const hl_evidence *evidence, const hl_part *part, int n_parts, hl_drift *out)
{
  question q = {
      .evidence = evidence, .part = part, .n_parts = n_parts, .false_alarm = out->false_alarm};
  q.whole = explain(evidence, part, n_parts, (1u << n_parts) - 1);
  out->significance = hl_significance(q.whole.explained, q.whole.rank, evidence->noise_dof);
  out->drifted = out->significance < out->false_alarm;
  const unsigned moved = out->drifted ? smallest_set(&q, &out->notes) : 0;
  out->n_causes = n_parts;
  for (int p = 0; p < n_parts; p++)
    fill_cause(&q, p, moved, &out->cause[p]);
}
