/* The curves of one channel, clipped samples included.
 *
 * A clipped sample says "at least this much": it costs w (y - X x)^2 while X x < y and nothing
 * beyond, so the whole stays convex and once differentiable,
 *
 *   cost(x) = x'(A + R)x - 2 b'x + yy + sum over clipped of w max(0, y - row x)^2.
 *
 * Newton's step solves for those that pull at present; as who pulls changes on the way, the step is
 * cut where the cost is least along it, without which the rounds would cycle. R is the smoothing,
 * settled once a refinement, and the pull of the body's further columns to zero.
 */
#include "light_censor.h"

enum { ROUNDS = 20, HALVINGS = 10 };
static const double smoothness = 1e-6, ridge = 1e-12;

static double row_times(const hl_clipped_row *r, const double *x, int n, int m)
{
  double sum = 0;
  if (n > 0)
    for (int k = 0; k < 4; k++)
      sum += r->band[k] * x[r->first + k];
  for (int j = 0; j < m; j++)
    sum += r->border[j] * x[n + j];
  return sum;
}

static int solve_non_negative_body(const hl_light_model *model, hl_normal *a,
                                   hl_normal_factor *factor, double *x)
{
  if (hl_normal_factorise(a, factor) != 0)
    return -1;
  hl_normal_solve(factor, a->rhs, x);
  /* One power is a strength, and a strength is not negative; several are a curve. */
  if (model->has_lobe && model->body == 1 && x[a->n] < 0) {
    hl_normal_drop(a, 0);
    if (hl_normal_factorise(a, factor) != 0)
      return -1;
    hl_normal_solve(factor, a->rhs, x);
  }
  return 0;
}

/* Normal equations of a channel: the unclipped samples, summed over the blocks in order. */
static void sum_blocks(const hl_light_data *data, const hl_model_work *work, int channel,
                       hl_normal *base)
{
  *base = work->block[0][channel];
  for (int b = 1; b < hl_blocks(data->n); b++)
    hl_normal_merge(base, &work->block[b][channel]);
}

static void add_clipped(const hl_light_data *data, hl_model_work *work, int channel, hl_normal *a)
{
  for (int b = 0; b < hl_blocks(data->n); b++) {
    const hl_clipped_row *rows = hl_clipped_rows(data, work, b);
    for (int i = 0; i < work->n_clipped[b]; i++)
      if (rows[i].channel == channel && rows[i].active)
        hl_normal_add(a, rows[i].first, rows[i].band, rows[i].border, rows[i].weight,
                      rows[i].value);
  }
}

/* Let those clipped samples pull that x does not reach. Returns how many changed. */
static int choose_clipped(const hl_light_data *data, hl_model_work *work, int channel, int n, int m,
                          const double *x)
{
  int changed = 0;
  for (int b = 0; b < hl_blocks(data->n); b++) {
    hl_clipped_row *rows = hl_clipped_rows(data, work, b);
    for (int i = 0; i < work->n_clipped[b]; i++)
      if (rows[i].channel == channel) {
        const bool active = row_times(&rows[i], x, n, m) < rows[i].value;
        changed += active != rows[i].active;
        rows[i].active = active;
      }
  }
  return changed;
}

/* Slope of the clipped samples' cost (halved) along the step, a share t of it taken. */
static double clipped_slope(const hl_light_data *data, const hl_model_work *work, int channel,
                            double t)
{
  double sum = 0;
  for (int b = 0; b < hl_blocks(data->n); b++) {
    const hl_clipped_row *rows = hl_clipped_rows(data, work, b);
    for (int i = 0; i < work->n_clipped[b]; i++) {
      const double short_by = rows[i].value - rows[i].now - t * rows[i].change;
      if (rows[i].channel == channel && short_by > 0)
        sum -= rows[i].weight * short_by * rows[i].change;
    }
  }
  return sum;
}

/* Largest useful share of the step from x to y: all of it, or where the convex cost is least. */
static double censored_share(const hl_light_data *data, hl_model_work *work, int channel,
                             const hl_normal *base, const double *x, const double *y)
{
  const int total = base->n + base->m;
  double step[HL_COLUMNS_MAX], at_x[HL_COLUMNS_MAX], at_step[HL_COLUMNS_MAX];
  double constant = 0, curvature = 0;
  for (int i = 0; i < total; i++)
    step[i] = y[i] - x[i];
  hl_normal_times(base, x, at_x);
  hl_normal_times(base, step, at_step);
  for (int i = 0; i < total; i++) {
    constant += step[i] * (at_x[i] - base->rhs[i]);
    curvature += step[i] * at_step[i];
  }
  for (int b = 0; b < hl_blocks(data->n); b++) {
    hl_clipped_row *rows = hl_clipped_rows(data, work, b);
    for (int i = 0; i < work->n_clipped[b]; i++)
      if (rows[i].channel == channel) {
        rows[i].now = row_times(&rows[i], x, base->n, base->m);
        rows[i].change = row_times(&rows[i], step, base->n, base->m);
      }
  }
  double low = 0, high = 1;
  if (!(constant + curvature + clipped_slope(data, work, channel, 1) > 0))
    return 1;
  for (int halving = 0; halving < HALVINGS; halving++) {
    const double t = 0.5 * (low + high);
    if (constant + t * curvature + clipped_slope(data, work, channel, t) > 0)
      high = t;
    else
      low = t;
  }
  return low;
}

/* x'(Ax - 2b) + yy over the samples that pull; the regularisation is part of A. */
static double censored_cost(const hl_light_data *data, const hl_model_work *work, int channel,
                            const hl_normal *base, const double *x)
{
  double ax[HL_COLUMNS_MAX], cost = base->yy;
  hl_normal_times(base, x, ax);
  for (int i = 0; i < base->n + base->m; i++)
    cost += x[i] * (ax[i] - 2 * base->rhs[i]);
  for (int b = 0; b < hl_blocks(data->n); b++) {
    const hl_clipped_row *rows = hl_clipped_rows(data, work, b);
    for (int i = 0; i < work->n_clipped[b]; i++)
      if (rows[i].channel == channel) {
        const double short_by = rows[i].value - row_times(&rows[i], x, base->n, base->m);
        if (short_by > 0)
          cost += rows[i].weight * short_by * short_by;
      }
  }
  return cost;
}

static void weigh_body(const hl_light_model *model, int channel, hl_normal *a)
{
  for (int j = 1; j < model->body; j++)
    a->corner[j][j] += model->body_weight[channel];
}

/* Newton on the convex one-sided problem, each step cut where its cost is least. */
int hl_censor_solve(const hl_light_model *model, const hl_light_data *data, int channel,
                    hl_model_work *work, hl_model_point *out, double *cost)
{
  double *x = out->x[channel], y[HL_COLUMNS_MAX];
  hl_normal base, a;
  sum_blocks(data, work, channel, &base);
  if (!work->keep_smoothing) {
    a = base;
    add_clipped(data, work, channel, &a);
    hl_smoothing_from(&a, smoothness, ridge, &work->smoothing[channel]);
  }
  hl_normal_regularise(&base, &work->smoothing[channel]);
  weigh_body(model, channel, &base);
  const int rounds = work->censor_rounds > 0 ? work->censor_rounds : ROUNDS;
  bool settled = false;
  for (int round = 0; round < rounds && !settled; round++) {
    a = base;
    add_clipped(data, work, channel, &a);
    if (solve_non_negative_body(model, &a, &out->factor[channel], y) != 0)
      return -1;
    const double share = round == 0 ? 1 : censored_share(data, work, channel, &base, x, y);
    for (int i = 0; i < base.n + base.m; i++)
      x[i] = round == 0 ? y[i] : x[i] + share * (y[i] - x[i]);
    settled = choose_clipped(data, work, channel, a.n, a.m, x) == 0 && share >= 1;
  }
  if (!settled) { /* the factor must be that of the samples that pull at x */
    a = base;
    add_clipped(data, work, channel, &a);
    if (solve_non_negative_body(model, &a, &out->factor[channel], y) != 0)
      return -1;
  }
  *cost = censored_cost(data, work, channel, &base, x);
  return 0;
}

void hl_censor_normal(const hl_light_model *model, const hl_light_data *data, int channel,
                      const double *x, hl_model_work *work, hl_normal *normal)
{
  sum_blocks(data, work, channel, normal);
  choose_clipped(data, work, channel, normal->n, normal->m, x);
  add_clipped(data, work, channel, normal);
  hl_normal_regularise(normal, &work->smoothing[channel]);
  weigh_body(model, channel, normal);
}
