/* The curves of one channel, clipped samples included. Private. */
#ifndef HL_LIGHT_CENSOR_H
#define HL_LIGHT_CENSOR_H

#include "light_model.h"

/* First sample of a block; a few are not worth parting, and all but the first block are empty. */
static inline int hl_block_first(int n, int b)
{
  if (n < HL_BLOCKS_FROM)
    return b == 0 ? 0 : n;
  return (int)((long long)n * b / HL_BLOCKS);
}

/* Blocks that may hold samples. */
static inline int hl_blocks(int n)
{
  return n < HL_BLOCKS_FROM ? 1 : HL_BLOCKS;
}

/* Rows of the clipped samples of block b. */
static inline hl_clipped_row *hl_clipped_rows(const hl_light_data *data, const hl_model_work *work,
                                              int b)
{
  return work->clipped + (size_t)hl_block_first(data->n, b) * (size_t)data->channels;
}

/* Solve for out->x[channel] and its factor from the blocks that are accumulated; 0 or -1. */
int hl_censor_solve(const hl_light_model *model, const hl_light_data *data, int channel,
                    hl_model_work *work, hl_model_point *out, double *cost);

/* The same problem's normal equations with those clipped samples that pull at x. */
void hl_censor_normal(const hl_light_model *model, const hl_light_data *data, int channel,
                      const double *x, hl_model_work *work, hl_normal *normal);

#endif
