/* Which terms the frame needs, and the direction with them.
 *
 * What is left after a fit is model error more than noise, so the weights decide much. From the
 * basin that relative weights found, nearly even ones let the highlight speak, where the direction is.
 * Under them the shape of the reflectance is chosen (light_shape.c), then the further terms are tried
 * on it one after another (light_terms.c), then what nothing explains is left out (light_outliers.c)
 * and all of it repeated as long as that changes much.
 */
#include <math.h>
#include <string.h>

#include "light_terms.h"

enum { ROUNDS = 2, PASSES = 6, AREA_ROUNDS = 2 };
static const double least_colored_gain = 0.02;

/* Cost that the pixels' noise alone leaves: second differences along the rows of the frame, in which
 * shading is straight, and in cells; the few that lie across an edge or a highlight are capped. */
static double noise_cost(const struct hl_light_work *work, const hl_surface *surface)
{
  const hl_light_data *d = &work->all;
  double sum = 0;
  for (int c = 0; c < d->channels; c++) {
    double cap = HUGE_VAL, mean = 0;
    for (int round = 0; round < 6; round++) {
      double total = 0;
      long used = 0;
      for (int i = 1; i + 1 < d->n; i++) {
        const int area = hl_light_area(d, i);
        if (area > 1) {
          total +=
              area * fmin(d->weight[c][i] / (area * (double)d->stretch[i]) * d->scatter[c][i], cap);
          used += area;
        }
        if (!hl_light_in_a_row(work, surface, i))
          continue;
        const double bend = d->value[c][i - 1] - 2 * d->value[c][i] + d->value[c][i + 1];
        total += fmin(d->weight[c][i] * bend * bend / 6, cap);
        used++;
      }
      mean = used > 0 ? total / (double)used : 0;
      cap = 6 * mean;
    }
    sum += mean * hl_light_pixels(d);
  }
  return sum;
}

static void trace_variants(hl_ctx *ctx, const hl_light_settled *out)
{
  static const char *const names[HL_VARIANTS] = {"matte",      "plain",   "foreshortened",
                                                 "plain bent", "fs bent", "ambient"};
  for (int i = 0; i < HL_VARIANTS; i++) {
    const hl_light_variant *v = &out->variant[i];
    if (isfinite(v->cost))
      hl_trace(ctx, "%s %-13s cost %.6g direction %.6f %.6f %.6f exponent %.2f nearness %.4f%s",
               i == (int)out->kept ? "kept " : "tried", names[i], v->cost, v->s[0], v->s[1],
               v->s[2], v->exponent, v->nearness, v->converged ? "" : ", not converged");
  }
  hl_trace(ctx, "noise cost %.6g, outliers %d", out->noise_cost, out->outliers);
  for (int i = 0; i < HL_LIGHT_TERMS; i++)
    hl_trace(ctx, "%s %-13s gain %.4f%s", out->on >> i & 1 ? "kept " : "left ",
             hl_light_term_name((hl_light_term)i), out->term[i].gain,
             out->term[i].screened ? " (predicted)" : "");
}

/* Shape and terms anew. */
static hl_status decide(hl_ctx *ctx, struct hl_light_work *work, const hl_surface *surface,
                        const hl_light_settings *settings, const double start[2][3],
                        hl_light_settled *out)
{
  out->variant[HL_VARIANT_AMBIENT].cost = HUGE_VAL;
  out->on = 0;
  hl_light_shape(work, settings, start, out);
  if (!isfinite(out->variant[out->kept].cost))
    return hl_fail(ctx, HL_ERR_DEGENERATE, "no reflectance model can be fitted to these pixels");
  hl_light_try_terms(work, surface, settings, start, out);
  out->compared_cost = out->variant[out->kept].cost;
  return HL_OK;
}

static hl_status repeat(hl_ctx *ctx, struct hl_light_work *work, const hl_light_settings *settings,
                        int rounds, hl_light_settled *out)
{
  hl_light_variant *kept = &out->variant[out->kept];
  if (hl_light_refine_variant(work, settings, kept->s, rounds, kept) != HL_OK)
    return hl_fail(ctx, HL_ERR_DEGENERATE, "the fit was lost on repeating it");
  work->best = work->refined;
  out->iterations += work->refined.iterations;
  return HL_OK;
}

/* Every channel has a lobe of its own in any case: whether that is needed is told, no more. */
static void judge_colored_lobe(struct hl_light_work *work, const hl_light_settings *settings,
                               hl_light_settled *out)
{
  hl_term_verdict *verdict = &out->term[HL_LIGHT_COLORED_LOBE];
  const hl_light_variant *kept = &out->variant[out->kept];
  const bool forced = settings->with >> HL_LIGHT_COLORED_LOBE & 1;
  *verdict = (hl_term_verdict){.least = least_colored_gain};
  if (settings->without >> HL_LIGHT_COLORED_LOBE & 1)
    verdict->unfit = "not asked for";
  else if (work->all.channels < 2)
    verdict->unfit = "the frame has one channel";
  else if (!kept->model.has_lobe)
    verdict->unfit = "there is no lobe";
  if (verdict->unfit)
    return;
  const double more = hl_light_one_shape(work, &kept->model, settings->threads);
  verdict->gain = hl_light_gain(work, kept->cost + more, kept->cost);
  verdict->least += hl_light_noise_gain(work, kept->model.spline.n);
  if (forced || verdict->gain > verdict->least)
    out->on |= 1U << HL_LIGHT_COLORED_LOBE;
}

hl_status hl_light_settle(hl_ctx *ctx, struct hl_light_work *work, const hl_surface *surface,
                          const hl_light_settings *settings, const double start[2][3],
                          hl_light_settled *out)
{
  const bool reject =
      settings->outlier_sigmas > 0 && !(settings->without & 1U << HL_LIGHT_OUTLIERS);
  hl_status st = HL_OK;
  memset(out, 0, sizeof *out);
  out->sought = work->all.n;
  work->model.censor_rounds = 0;
  hl_light_weigh(&work->all, hl_light_final_noise, NULL);
  out->noise_cost = noise_cost(work, surface);
  for (int pass = 0; pass < PASSES && st == HL_OK; pass++) {
    /* a few pixels left out do not change which terms are needed */
    if (pass == 0 || out->outliers > work->all.n / 100)
      st = decide(ctx, work, surface, settings, start, out);
    if (st == HL_OK)
      st = repeat(ctx, work, settings, work->hurried ? 1 : ROUNDS, out);
    if (st != HL_OK || !reject || pass == PASSES - 1)
      break;
    const int before = out->outliers;
    const hl_light_model *model = &out->variant[out->kept].model;
    if (pass == 0)
      out->concentrated = hl_light_concentrate(work, settings, out);
    if (pass == 0 && out->concentrated)
      out->outliers = out->concentrated;
    else if (out->concentrated)
      out->outliers = hl_light_mark_beyond(work, model);
    else
      out->outliers = hl_light_mark_outliers(work, model, settings->outlier_sigmas);
    if (out->outliers <= before + before / 20)
      break;
    hl_light_weigh(&work->all, hl_light_final_noise, work->outlier);
  }
  memcpy(out->compared_s, work->best.at.s, sizeof out->compared_s);
  /* a glance's noise is beyond what pixels' areas move the light by */
  const int rounds = work->glanced || !surface->is_ball ? 0 : work->on_cells ? 1 : AREA_ROUNDS;
  for (int round = 0; st == HL_OK && round < rounds; round++) {
    hl_light_bring_to_middle(work, &out->variant[out->kept].model, surface, settings->threads);
    st = repeat(ctx, work, settings, 1, out);
  }
  if (st != HL_OK)
    return st;
  judge_colored_lobe(work, settings, out);
  trace_variants(ctx, out);
  return HL_OK;
}
