/* Pixels that the fit does not explain: a label, dust, a second weaker light.
 *
 * Where the fit is far worse than any model error, it is repeated on the share of the pixels that deviate
 * least, until that is the same (Rousseeuw and Van Driessen 1999, concentration steps of least trimmed
 * squares), from fits on halves of the ball, one of which the label spares.
 *
 * In any case they are told by their residual against what model error and the place of a steep highlight in its
 * pixel may leave, in units of a mean deviation that a tenth of wild pixels hardly moves.
 */
#include <math.h>
#include <string.h>

#include "light_work.h"

/* A residual is no outlier while it is explained by model error, or by where in the pixel a steep
 * highlight lies: relative part, and share of the prediction's change across the pixel. */
static const double outlier_relative = 0.05, outlier_absolute = 0.02, outlier_slope = 0.5;
static const double least_deviation2 = 0.1;
/* A label: the fit is repeated on the held share of the pixels that deviate least, and what then lies
 * beyond so many medians is left out, where the others' mean falls to a small part of what it was. */
enum { HALVES = 8, FIRST_STEPS = 3, STEPS = 8 };
static const double held_share = 0.75, most_medians = 60, most_share = 0.3, least_median = 1e-4;
static const double least_suspicion = 2, suspicious_ratio = 4, worth_leaving_out = 0.1;

/* Twice the squared deviation of a sample from what model error and its place in the pixel explain. */
static double deviation2(const hl_light_data *d, const hl_model_pixel *f, int c, int i)
{
  const double r = d->value[c][i] - f->value;
  const double edge = outlier_slope * d->footprint[i] * f->steepness;
  const double relative = outlier_relative * f->value;
  return r * r / (relative * relative + edge * edge + outlier_absolute * outlier_absolute);
}

/* Mean deviation of a channel's samples, each counted with `cap` at most; model->fit is in work->fit. */
static double capped_mean(const struct hl_light_work *work, int channel, double cap)
{
  const hl_light_data *d = &work->all;
  double sum = 0;
  long used = 0;
  for (int i = 0; i < d->n; i++)
    if (!(d->clipped[i] >> channel & 1)) {
      sum += fmin(deviation2(d, &work->fit[i], channel, i), cap);
      used++;
    }
  return used > 0 ? sum / (double)used : 0;
}

/* Largest deviation of each pixel's channels, by the fit at work->best, into score[i][0]; the same in
 * descending order into work->ranked. */
static void rank_deviations(struct hl_light_work *work, const hl_light_model *model)
{
  const hl_light_data *d = &work->all;
  for (int i = 0; i < d->n; i++)
    work->score[i][0] = 0;
  for (int c = 0; c < d->channels; c++) {
    hl_model_predict(model, d, &work->best.at, NULL, 0, d->n, c, work->fit);
    for (int i = 0; i < d->n; i++)
      if (!(d->clipped[i] >> c & 1))
        work->score[i][0] = fmax(work->score[i][0], deviation2(d, &work->fit[i], c, i));
  }
  for (int i = 0; i < d->n; i++)
    work->ranked[i] = (hl_ranked){work->score[i][0], i};
  hl_light_sort(work->ranked, work->ranked + work->max_pixels, d->n);
}

/* Marks pixels that deviate by more than `most` of the median; how many. */
static int mark_beyond(struct hl_light_work *work, double most)
{
  int marked = 0;
  const double median = work->ranked[work->all.n / 2].key;
  const double limit = most * fmax(median, least_median);
  for (int i = 0; i < work->all.n; i++)
    marked += work->outlier[i] = work->score[i][0] > limit;
  return marked;
}

static double mean_kept(const struct hl_light_work *work)
{
  double sum = 0;
  int n = 0;
  for (int i = 0; i < work->all.n; i++)
    if (!work->outlier[i]) {
      sum += work->score[i][0];
      n++;
    }
  return n > 0 ? sum / n : 0;
}

/* Refines on what is not marked; work->best is then that fit, and the pixels are ranked by it. */
static bool refit(struct hl_light_work *work, const hl_light_settings *settings,
                  hl_light_variant *one)
{
  hl_light_weigh(&work->all, hl_light_final_noise, work->outlier);
  if (hl_light_refine_variant(work, settings, one->s, 1, one) != HL_OK)
    return false;
  work->best = work->refined;
  rank_deviations(work, &one->model);
  return true;
}

/* Refits, `steps` times, on the held share of the pixels; returns their mean deviation, infinite where there
 * is no fit. */
static double concentrate(struct hl_light_work *work, const hl_light_settings *settings, int steps,
                          hl_light_variant *one)
{
  const int n = work->all.n, beyond = n - (int)(held_share * n);
  double sum = 0;
  for (int step = 0; step < steps; step++) {
    memset(work->outlier, 0, (size_t)n);
    for (int i = 0; i < beyond; i++)
      work->outlier[work->ranked[i].index] = 1;
    if (!refit(work, settings, one))
      return HUGE_VAL;
  }
  for (int i = beyond; i < n; i++)
    sum += work->ranked[i].key;
  return sum / (n - beyond);
}

/* Marks the half of the ball that looks to one of `HALVES` sides. */
static void mark_half(struct hl_light_work *work, int side)
{
  const double turn = 6.283185307179586 * side / HALVES;
  const double x = cos(turn), y = sin(turn);
  for (int i = 0; i < work->all.n; i++)
    work->outlier[i] = work->all.normal[0][i] * x + work->all.normal[1][i] * y > 0;
}

/* From a fit on one half without bends, which would follow the label. */
static double from_half(struct hl_light_work *work, const hl_light_settings *settings,
                        const hl_light_variant *kept, int side, hl_light_variant *one)
{
  *one = *kept;
  one->model.masking = false;
  one->model.body = 1;
  one->exponent = 0;
  mark_half(work, side);
  return refit(work, settings, one) ? concentrate(work, settings, FIRST_STEPS, one) : HUGE_VAL;
}

int hl_light_concentrate(struct hl_light_work *work, const hl_light_settings *settings,
                         const hl_light_settled *settled)
{
  const int n = work->all.n;
  const hl_light_variant *kept = &settled->variant[settled->kept];
  hl_light_variant one;
  double least = HUGE_VAL;
  int best = 0;
  rank_deviations(work, &kept->model);
  memset(work->outlier, 0, (size_t)n);
  const double before = mean_kept(work);
  if (!(before > least_suspicion && before > suspicious_ratio * work->ranked[n / 2].key))
    return 0;
  work->restore = work->best;
  for (int side = 0; side < HALVES; side++) {
    const double mean = from_half(work, settings, kept, side, &one);
    if (mean < least) {
      least = mean;
      best = side;
    }
  }
  if (isfinite(least) && isfinite(from_half(work, settings, kept, best, &one)) &&
      isfinite(concentrate(work, settings, STEPS, &one))) {
    const int marked = mark_beyond(work, most_medians);
    if (marked <= most_share * n && mean_kept(work) < worth_leaving_out * before)
      return marked;
  }
  work->best = work->restore;
  memset(work->outlier, 0, (size_t)n);
  return 0;
}

int hl_light_mark_beyond(struct hl_light_work *work, const hl_light_model *model)
{
  rank_deviations(work, model);
  return mark_beyond(work, most_medians);
}

int hl_light_mark_outliers(struct hl_light_work *work, const hl_light_model *model, double sigmas)
{
  const hl_light_data *d = &work->all;
  int marked = 0;
  memset(work->outlier, 0, (size_t)d->n);
  if (!(sigmas > 0))
    return 0;
  for (int c = 0; c < d->channels; c++) {
    hl_model_predict(model, d, &work->best.at, NULL, 0, d->n, c, work->fit);
    double mean = 1; /* one that a tenth of wild pixels hardly moves */
    for (int round = 0; round < 4; round++)
      mean = fmax(capped_mean(work, c, 9 * mean), least_deviation2);
    for (int i = 0; i < d->n; i++)
      if (!(d->clipped[i] >> c & 1) &&
          deviation2(d, &work->fit[i], c, i) > sigmas * sigmas * mean) {
        marked += !work->outlier[i];
        work->outlier[i] = 1;
      }
  }
  return marked;
}
