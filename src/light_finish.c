/* The answer from cells brought to all pixels.
 *
 * Which terms the frame needs was settled on cells (light_pixels.c); what is kept is refined once more
 * on every pixel, from there. A pixel's mean differs from its middle by its share of what its cell's
 * does: the bend of the shading times the square of the side.
 */
#include <string.h>

#include "light_rows.h"
#include "light_work.h"

enum { PASSES = 4 };

/* Takes off the pixels what light_area.c took off their cells; marks those of cells left out. */
static void hand_down(struct hl_light_work *work)
{
  const hl_light_samples *cells = &work->aside;
  for (int p = 0; p < work->all.n; p++) {
    const int i = work->owner[p];
    work->outlier[p] = i >= 0 && cells->outlier[i];
    for (int c = 0; i >= 0 && c < work->all.channels; c++) {
      const double area = cells->area[c][i] / hl_light_area(&cells->all, i);
      work->all.value[c][p] += work->area[c][p] - area;
      work->area[c][p] = area;
    }
  }
}

hl_status hl_light_finish(hl_ctx *ctx, struct hl_light_work *work,
                          const hl_light_settings *settings, hl_light_settled *out)
{
  const bool reject =
      settings->outlier_sigmas > 0 && !(settings->without & 1U << HL_LIGHT_OUTLIERS);
  hl_light_variant *kept = &out->variant[out->kept];
  const double cost = kept->cost; /* the others' is that on cells, too */
  int marked = 0;
  hl_light_exchange(work);
  hand_down(work);
  for (int p = 0; p < work->all.n; p++)
    marked += work->outlier[p];
  for (int pass = 0; pass < PASSES; pass++) {
    hl_light_weigh(&work->all, hl_light_final_noise, work->outlier);
    if (hl_light_refine_variant(work, settings, kept->s, 1, kept) != HL_OK)
      return hl_fail(ctx, HL_ERR_DEGENERATE, "the fit was lost on all pixels");
    work->best = work->refined;
    out->iterations += work->refined.iterations;
    const int before = marked;
    if (reject && out->concentrated)
      marked = hl_light_mark_beyond(work, &kept->model);
    else if (reject)
      marked = hl_light_mark_outliers(work, &kept->model, settings->outlier_sigmas);
    if (marked <= before + before / 20)
      break;
  }
  out->outliers = marked;
  out->sought = work->all.n;
  kept->cost = cost;
  return HL_OK;
}

void hl_light_predict_pixels(struct hl_light_work *work, const hl_light_model *model)
{
  const hl_light_data *d = &work->all;
  const hl_model_point *at = &work->best.at;
  const int n = model->has_lobe ? model->spline.n : 0, m = hl_model_border(model);
  for (int first = 0; first < d->n; first += HL_ROWS_CHUNK) {
    const int count = d->n - first < HL_ROWS_CHUNK ? d->n - first : HL_ROWS_CHUNK;
    hl_rows c;
    hl_rows_at(model, d, first, count, at, false, &c);
    for (int i = 0; i < count; i++) {
      const int p = first + i;
      double band[4] = {0}, border[HL_BORDER_MAX] = {0}, fit = 0, data = 0;
      const bool lit = c.lit[i] > 0 || model->ambient;
      const int column = n > 0 ? hl_spline_values(&model->spline, c.u[i], band) : 0;
      hl_rows_border(model, &c, i, border);
      for (int k = 0; k < d->channels; k++) {
        const double *x = at->x[k];
        double lobe = 0, body = 0;
        for (int l = 0; n > 0 && l < 4; l++)
          lobe += band[l] * x[column + l];
        for (int j = 0; j < m; j++)
          body += border[j] * x[n + j];
        fit += (lit ? c.lit[i] * c.g[i] * lobe + body : 0) + work->area[k][p];
        data += d->value[k][p] + work->area[k][p];
      }
      work->predicted[p] = (float)(fit / d->channels);
      work->measured[p] = (float)(data / d->channels);
    }
  }
}

void hl_light_spread_over(struct hl_light_work *work, int surface_n)
{
  const float level = (float)work->brightness.level;
  const hl_light_samples *pixels = &work->aside; /* where cells were worked on */
  const bool cells = work->on_cells;
  const int n = cells ? pixels->all.n : work->all.n;
  float(*sample)[HL_CELL_LEVELS] = work->bend; /* no longer needed */
  for (int i = 0; i < work->all.n; i++) {
    sample[i][0] = level * work->predicted[i];
    sample[i][1] = level * work->measured[i];
    sample[i][2] = work->outlier[i] ? 0 : 1;
  }
  if (n < surface_n) {
    memset(work->predicted, 0, (size_t)surface_n * sizeof *work->predicted);
    memset(work->measured, 0, (size_t)surface_n * sizeof *work->measured);
    memset(work->weight, 0, (size_t)surface_n * sizeof *work->weight);
  }
  for (int p = 0; p < n; p++) {
    const int i = cells ? work->owner[p] : p;
    const int at = cells ? pixels->index[p] : work->index[p];
    work->predicted[at] = i >= 0 ? sample[i][0] : 0;
    work->measured[at] = i >= 0 ? sample[i][1] : 0;
    work->weight[at] = i >= 0 ? sample[i][2] : 0;
  }
}
