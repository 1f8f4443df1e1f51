/* A pixel is the mean of its area, the model a value at its middle.
 *
 * Over a square of side 1 the mean of F is F + (Fxx + Fyy)/24 to third order, which the middles of the
 * square's sides give: (sum of F at the four - 4 F)/6. It is largest where the lobe bends and grows
 * towards the limb, where a pixel's normals spread along one direction, and so pulls the light: 0.005 deg
 * on a ball of 80 px. It is taken off the data, from the fit at hand, rather than put into every row:
 * the fit hardly moves, so once or twice is enough. Pixels that the shadow's edge crosses have their own
 * mean in the model.
 */
#include "halflight/vec3.h"
#include "light_censor.h"
#include "light_work.h"
#include "surface_look.h"

enum { CHUNK = 64, SIDES = 4 };

static const double point_rad = 1e-6; /* footprint of a point */

/* Some pixels looked at beside their middles. */
typedef struct beside {
  double at[6][CHUNK], footprint[CHUNK];
  hl_light_data data;
} beside;

static void beside_of(int count, int channels, beside *b)
{
  b->data = (hl_light_data){.n = count, .channels = channels, .footprint = b->footprint};
  for (int k = 0; k < 3; k++) {
    b->data.normal[k] = b->at[k];
    b->data.view[k] = b->at[3 + k];
  }
  for (int i = 0; i < count; i++)
    b->footprint[i] = point_rad;
}

/* Whether the pixel sees the light as a whole. */
static bool is_lit(const struct hl_light_work *work, int p)
{
  const hl_light_data *d = &work->all;
  const double *s = work->best.at.s;
  return d->normal[0][p] * s[0] + d->normal[1][p] * s[1] + d->normal[2][p] * s[2] >
         d->footprint[p] + work->best.at.nearness;
}

/* The middles of the pixels' sides; `counts` is cleared where one of them passes the ball by. */
static void look_beside(const struct hl_light_work *work, const hl_surface *surface, int first,
                        int side, beside *b, bool *counts)
{
  static const double dx[SIDES] = {-0.5, 0.5, 0, 0}, dy[SIDES] = {0, 0, -0.5, 0.5};
  for (int i = 0; i < b->data.n; i++) {
    const int pixel = surface->pixel[work->index[first + i]];
    const int wide = work->all.side ? work->all.side[first + i] : 1;
    const double middle = wide > 1 ? -0.5 : 0; /* a cell's lies before its middle pixel */
    const int across = pixel % surface->width, down = pixel / surface->width;
    const double column = across + middle, row = down + middle;
    double normal[3], view[3];
    counts[i] =
        counts[i] && hl_ball_look(&surface->camera, &surface->ball, column + wide * dx[side],
                                  row + wide * dy[side], normal, view);
    for (int k = 0; k < 3; k++) {
      b->at[k][i] = counts[i] ? normal[k] : work->all.normal[k][first + i];
      b->at[3 + k][i] = counts[i] ? view[k] : work->all.view[k][first + i];
    }
  }
}

static void area_of_chunk(struct hl_light_work *work, const hl_light_model *model,
                          const hl_surface *surface, int first, int count)
{
  hl_light_data *d = &work->all;
  const hl_model_point *at = &work->best.at;
  double sum[HL_CHANNELS_MAX][CHUNK] = {{0}};
  hl_model_pixel fit[CHUNK];
  bool counts[CHUNK];
  beside b;
  beside_of(count, d->channels, &b);
  for (int i = 0; i < count; i++)
    counts[i] = is_lit(work, first + i);
  for (int side = 0; side < SIDES; side++) {
    look_beside(work, surface, first, side, &b, counts);
    for (int c = 0; c < d->channels; c++) {
      hl_model_predict(model, &b.data, at, NULL, 0, count, c, fit);
      for (int i = 0; i < count; i++)
        sum[c][i] += fit[i].value;
    }
  }
  for (int c = 0; c < d->channels; c++) {
    hl_model_predict(model, d, at, NULL, first, count, c, fit);
    for (int i = 0; i < count; i++) {
      double *area = &work->area[c][first + i];
      d->value[c][first + i] += *area;
      *area = counts[i] ? (sum[c][i] - SIDES * fit[i].value) / 6 : 0;
      d->value[c][first + i] -= *area;
    }
  }
}

static void area_of_block(struct hl_light_work *work, const hl_light_model *model,
                          const hl_surface *surface, int b)
{
  const int end = hl_block_first(work->all.n, b + 1);
  for (int first = hl_block_first(work->all.n, b); first < end; first += CHUNK)
    area_of_chunk(work, model, surface, first, end - first < CHUNK ? end - first : CHUNK);
}

static HL_APART void area_parallel(struct hl_light_work *work, const hl_light_model *model,
                                   const hl_surface *surface, int threads)
{
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (int b = 0; b < HL_BLOCKS; b++)
    area_of_block(work, model, surface, b);
  (void)threads;
}

void hl_light_bring_to_middle(struct hl_light_work *work, const hl_light_model *model,
                              const hl_surface *surface, int threads)
{
  if (threads > 1)
    area_parallel(work, model, surface, threads);
  else
    for (int b = 0; b < HL_BLOCKS; b++)
      area_of_block(work, model, surface, b);
}
