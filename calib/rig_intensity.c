/*
 * How bright each light is in two sessions.
 *
 * ln(I'/I) against the weighted mean of all that have not changed, since both are relative to a median of
 * their session: chi-squared of 1, leaving one out.
 */
#include <math.h>
#include <stdlib.h>

#include "rig_work.h"

static double mean_intensity(const hl_rig_light *light)
{
  return (light->intensity[0] + light->intensity[1] + light->intensity[2]) / 3;
}

bool hl_rig_has_intensity(const hl_rig_light *a, const hl_rig_light *b)
{
  return a->intensity_sigma > 0 && b->intensity_sigma > 0 && mean_intensity(a) > 0 &&
         mean_intensity(b) > 0;
}

typedef struct brightness {
  double change, variance; /* of ln(I'/I) */
  hl_rig_cause *cause;     /* NULL: not known */
} brightness;

static void judge_brightness(const hl_rig_run *r, brightness *b, double sum, double weight)
{
  const double own = b->cause->moved ? 0 : 1 / b->variance;
  const double rest = weight - own;
  const double left = b->change - (rest > 0 ? (sum - own * b->change) / rest : 0);
  const double statistic = rest > 0 ? left * left / (b->variance + 1 / rest) : 0;
  b->cause->change[0] = exp(left);
  hl_rig_judge(r, b->cause, fabs(expm1(left)), statistic, 1);
}

/* One round: all against the mean of those not yet named; the one furthest beyond its limit. */
static int worst_brightness(const hl_rig_run *r, brightness *b, const bool *named)
{
  double sum = 0, weight = 0, most = 0;
  int at = -1, still = 0;
  for (int i = 0; i < r->n; i++)
    /* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): the status says there is memory */
    if (b[i].cause && !named[i]) {
      sum += b[i].change / b[i].variance;
      weight += 1 / b[i].variance;
      still++;
    }
  for (int i = 0; i < r->n; i++) {
    if (!b[i].cause)
      continue;
    b[i].cause->moved = named[i];
    judge_brightness(r, &b[i], sum, weight);
    const double excess = b[i].cause->figure / b[i].cause->threshold;
    if (!named[i] && b[i].cause->moved && excess > most) {
      most = excess;
      at = i;
    }
  }
  return still > 2 ? at : -1;
}

hl_status hl_rig_compare_intensities(hl_ctx *ctx, hl_rig_run *r)
{
  const size_t n = r->n > 0 ? (size_t)r->n : 1;
  brightness *b = calloc(n, sizeof *b);
  bool *named = calloc(n, sizeof *named);
  const hl_status st =
      b && named ? HL_OK : hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d lights", r->n);
  for (int i = 0; st == HL_OK && i < r->n; i++) {
    const hl_rig_pair *pair = &r->pair[i];
    const hl_rig_light *p = &r->reference->light[pair->reference];
    const hl_rig_light *q = &r->current->light[pair->current];
    if (!hl_rig_has_intensity(p, q))
      continue;
    b[i].change = log(mean_intensity(q) / mean_intensity(p));
    b[i].variance =
        p->intensity_sigma * p->intensity_sigma + q->intensity_sigma * q->intensity_sigma;
    b[i].cause = hl_rig_add(r, HL_RIG_INTENSITY, pair->name, pair->reference, pair->current);
  }
  for (int at; st == HL_OK && (at = worst_brightness(r, b, named)) >= 0;)
    /* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): the status says there is memory */
    named[at] = true;
  free(named);
  free(b);
  return st;
}
