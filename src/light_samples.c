/* What is worked on: the pixels, or cells of them (light_pixels.c). Both are kept, and exchanged. */
#include <string.h>

#include "light_work.h"

void hl_light_exchange(struct hl_light_work *work)
{
  hl_light_samples *other = &work->aside;
  const hl_light_samples own = {work->all,
                                work->grey,
                                work->index,
                                work->outlier,
                                {work->area[0], work->area[1], work->area[2]}};
  work->all = other->all;
  work->grey = other->grey;
  work->index = other->index;
  work->outlier = other->outlier;
  memcpy(work->area, other->area, sizeof work->area);
  *other = own;
  work->on_cells = !work->on_cells;
}

void hl_light_to_cells(struct hl_light_work *work, int most)
{
  hl_light_samples *cells = &work->aside;
  hl_light_take_cells(work, most, &work->all, &cells->all, cells);
  hl_light_exchange(work);
  hl_light_data *grey = &work->grey;
  double *value = grey->value[0], *weight = grey->weight[0], *scatter = grey->scatter[0];
  uint8_t *clipped = grey->clipped;
  *grey = work->all;
  grey->channels = 1;
  grey->value[0] = value;
  grey->weight[0] = weight;
  grey->scatter[0] = scatter;
  grey->clipped = clipped;
  for (int i = 0; i < work->all.n; i++) {
    double sum = 0, square = 0;
    for (int c = 0; c < work->all.channels; c++) {
      sum += work->all.value[c][i];
      square += work->all.scatter[c][i];
      work->area[c][i] = 0;
    }
    value[i] = sum / work->all.channels;
    scatter[i] = square / (work->all.channels * work->all.channels);
    clipped[i] = work->all.clipped[i] != 0;
    work->outlier[i] = 0;
  }
}
