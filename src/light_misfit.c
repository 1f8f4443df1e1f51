/* What the direction may be off by because the model does not hold.
 *
 * Three things tell; where the model holds they come to next to nothing.
 *
 * 1. Residuals that neighbours share. Scores summed over tiles give the sandwich M_tiles = sum g_t g_t', which
 *    is the white one's within its own scatter where residuals are independent. What it exceeds that by,
 *    along the axes where it does, is counted for tiles of two sizes: small ones see the highlight's
 *    misfit, large ones the body's.
 * 2. What the answer moves by to another defensible model: its sibling with, or without, the bends; and from
 *    a plain lobe to the foreshortened, which is what materials have. A model's misfit is its cost beyond
 *    that of the pixels' noise. The closer the kept one's comes to the other's, the less the data prefer it:
 *    the move counts by the kept one's share of both. It lies along the plane of light and view almost entirely,
 *    because a mirror image about that plane is common to all isotropic reflectance.
 * 3. Where pixels were left out that might have told models apart, the same by likelihood.
 *
 * The weights of 1 were set by hand near a fit by likelihood (Student's t, 5 degrees) to the errors on 25
 * measured materials under five lights, 6 of them also as networks, and on 15 path-traced frames: the ones
 * that tests/bench/merl_coverage.py and the fixtures show again, so those figures are in-sample.
 */
#include <math.h>
#include <string.h>

#include "halflight/vec3.h"
#include "light_work.h"

enum { TILES_ACROSS = 64, SMALL_TILES = 24, LARGE_TILES = 6, LEAST_SIDE = 4 };
static const double small_weight = 2, large_weight = 0.5;
static const double thinned_share = 0.9;
/* Of a pixel's share in the noise's cost, over its square; and how many deviations of the sum are chance. */
static const double squares_variance = 3, chance_deviations = 3;

double hl_light_relative_size(double a[2][2], double b[2][2])
{
  const double det = b[0][0] * b[1][1] - b[0][1] * b[1][0];
  if (!(det > 0))
    return 1;
  const double p = (b[1][1] * a[0][0] - b[0][1] * a[1][0]) / det;
  const double q = (b[1][1] * a[0][1] - b[0][1] * a[1][1]) / det;
  const double r = (b[0][0] * a[1][0] - b[1][0] * a[0][0]) / det;
  const double s = (b[0][0] * a[1][1] - b[1][0] * a[0][1]) / det;
  const double half = 0.5 * (p + s);
  return half + sqrt(fmax(0, half * half - (p * s - q * r)));
}

/* Scores summed over square tiles of the surface's bounding box, then their outer products. */
static void tile_products(const struct hl_light_work *work, const hl_surface *surface, int across,
                          int q, double m[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX])
{
  double tile[HL_TILES_MAX][HL_NONLINEAR_MAX] = {{0}};
  const int x0 = work->box.x0, x1 = work->box.x1, y0 = work->box.y0, y1 = work->box.y1;
  const int span = (x1 - x0 > y1 - y0 ? x1 - x0 : y1 - y0) + 1;
  int side = span / across > LEAST_SIDE ? span / across : LEAST_SIDE;
  while (span / side + 1 > TILES_ACROSS)
    side++;
  for (int p = 0; p < work->all.n; p++) {
    const int pixel = surface->pixel[work->index[p]];
    const int x = (pixel % surface->width - x0) / side, y = (pixel / surface->width - y0) / side;
    for (int u = 0; u < q; u++)
      tile[y * TILES_ACROSS + x][u] += work->score[p][u];
  }
  memset(m, 0, HL_NONLINEAR_MAX * sizeof *m);
  for (int t = 0; t < HL_TILES_MAX; t++)
    for (int u = 0; u < q; u++)
      for (int v = 0; v < q; v++)
        m[u][v] += tile[t][u] * tile[t][v];
}

/* Adds weight times the part of `a` beyond `b`: with b = L L' and L^-1 a L^-T = U diag(e) U', that is
 * L U diag(max(0, e - 1)) U' L'. */
static void add_excess(double a[2][2], double b[2][2], double weight, double out[2][2])
{
  const double l00 = sqrt(b[0][0]), l10 = b[1][0] / l00, l11 = sqrt(fmax(0, b[1][1] - l10 * l10));
  if (!(l00 > 0 && l11 > 0))
    return;
  const double c00 = a[0][0] / (l00 * l00), c01 = (a[0][1] - l10 * a[0][0] / l00) / (l00 * l11);
  const double r = (a[1][1] - 2 * l10 * a[0][1] / l00 + l10 * l10 * c00) / (l11 * l11);
  const double angle = 0.5 * atan2(2 * c01, c00 - r), co = cos(angle), si = sin(angle);
  const double axis[2][2] = {{co, si}, {-si, co}};
  for (int k = 0; k < 2; k++) {
    const double x = axis[k][0], y = axis[k][1];
    const double beyond = x * x * c00 + 2 * x * y * c01 + y * y * r - 1;
    const double d[2] = {l00 * x, l10 * x + l11 * y};
    for (int u = 0; u < 2; u++)
      for (int v = 0; v < 2; v++)
        out[u][v] += weight * fmax(0, beyond) * d[u] * d[v];
  }
}

/* Adds weight times the square of what the answer moves by to that variant. */
static void add_move(const struct hl_light_work *work, const hl_light_settled *settled,
                     const hl_light_variant *to, double weight, double out[2][2])
{
  const hl_model_point *at = &work->best.at;
  double moved[3];
  if (!isfinite(to->cost) || !(weight > 0))
    return;
  hl_add_scaled(to->s, -1, settled->compared_s, moved);
  const double delta[2] = {hl_dot(moved, at->t[0]), hl_dot(moved, at->t[1])};
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++)
      out[u][v] += weight * delta[u] * delta[v];
}

/* The kept variant's share of its own and another's misfit. What is within the noise cost's own uncertainty is none,
 * the less so the more structure the residual has, which noise has not. */
static double misfit_share(const struct hl_light_work *work, const hl_light_settled *settled,
                           const hl_light_variant *other, double structure)
{
  const double n = hl_light_effective(&work->all) * work->all.channels;
  const double noise = settled->noise_cost;
  const double by_chance = chance_deviations * sqrt(squares_variance / n) / fmax(structure, 1);
  const double own = settled->compared_cost - noise * (1 + by_chance);
  return own > 0 ? own / (own + fmax(0, other->cost - noise)) : 0;
}

/* Chi-square that chance exceeds once in 1000 (Wilson and Hilferty). */
static double rare_chi2(int freedom)
{
  const double q = 2 / (9.0 * freedom);
  return freedom * pow(1 - q + 3.09 * sqrt(q), 3);
}

/* Bends that the noise alone would not ask for, yet too slight to be kept. */
static bool asks_for_bends(const struct hl_light_work *work, const hl_light_settled *settled)
{
  const hl_light_model *model = &settled->variant[settled->kept].model;
  const int channels = work->all.channels;
  return model->has_lobe && !model->masking &&
         settled->bent_gain * work->all.n * channels > rare_chi2(1 + 2 * channels);
}

static void add_moves(const struct hl_light_work *work, const hl_light_settled *settled,
                      double structure, double out[2][2])
{
  static const hl_variant siblings[HL_VARIANTS] = {
      [HL_VARIANT_MATTE] = HL_VARIANT_FORESHORTENED,
      [HL_VARIANT_PLAIN] = HL_VARIANT_PLAIN_BENT,
      [HL_VARIANT_PLAIN_BENT] = HL_VARIANT_PLAIN,
      [HL_VARIANT_FORESHORTENED] = HL_VARIANT_FORESHORTENED_BENT,
      [HL_VARIANT_FORESHORTENED_BENT] = HL_VARIANT_FORESHORTENED};
  const hl_light_variant *all = settled->variant, *sibling = &all[siblings[settled->kept]];
  add_move(work, settled, sibling,
           asks_for_bends(work, settled) ? 1 : misfit_share(work, settled, sibling, structure),
           out);
  if (all[settled->kept].model.lobe != HL_LOBE_PLAIN || !all[settled->kept].model.has_lobe)
    return;
  const hl_light_variant *other = &all[HL_VARIANT_FORESHORTENED];
  if (all[HL_VARIANT_FORESHORTENED_BENT].cost < other->cost)
    other = &all[HL_VARIANT_FORESHORTENED_BENT];
  add_move(work, settled, other, misfit_share(work, settled, other, structure), out);
}

/* All other variants by likelihood: twice its logarithm falls by the cost over the variance of a pixel's
 * residual. */
static void add_moves_by_likelihood(const struct hl_light_work *work,
                                    const hl_light_settled *settled, double out[2][2])
{
  const double half = 0.5 * hl_light_effective(&work->all);
  double weight[HL_VARIANTS] = {0}, total = 1;
  for (int i = 0; i < HL_VARIANTS; i++)
    if (i != (int)settled->kept && isfinite(settled->variant[i].cost)) {
      weight[i] = exp(-half * fmax(0, settled->variant[i].cost / settled->compared_cost - 1));
      total += weight[i];
    }
  for (int i = 0; i < HL_VARIANTS; i++)
    add_move(work, settled, &settled->variant[i], weight[i] / total, out);
}

void hl_light_misfit(const struct hl_light_work *work, const hl_surface *surface,
                     const hl_light_settled *settled, int q, double white[2][2],
                     double tiles[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX], hl_light_spread *out)
{
  double by_tile[2][2];
  tile_products(work, surface, LARGE_TILES, q, tiles);
  hl_light_sandwich(out->inverse, tiles, q, by_tile);
  add_excess(by_tile, white, large_weight, out->model);
  const double at_large = hl_light_relative_size(by_tile, white);
  tile_products(work, surface, SMALL_TILES, q, tiles);
  hl_light_sandwich(out->inverse, tiles, q, by_tile);
  add_excess(by_tile, white, small_weight, out->model);
  out->structure = hl_light_relative_size(by_tile, white);
  add_moves(work, settled, at_large, out->model);
  if (work->glanced || hl_light_effective(&work->all) < thinned_share * hl_light_pixels(&work->all))
    add_moves_by_likelihood(work, settled, out->model);
}
