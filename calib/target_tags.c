/*
 * Tags as AprilTag draws them. A family keeps the place of every bit of its codes, first bit highest,
 * counted from the corner of the black square.
 */
#include <apriltag/tag36h11.h>

#include "halflight/target.h"

hl_status hl_target_tag_cells(hl_ctx *ctx, int id,
                              bool out[HL_TARGET_TAG_CELLS][HL_TARGET_TAG_CELLS])
{
  apriltag_family_t *family = tag36h11_create();
  if (!family)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the tag family");
  hl_status st = HL_OK;
  if (id < 0 || (unsigned)id >= family->ncodes)
    st = hl_fail(ctx, HL_ERR_ARG, "tag %d is outside [0, %u] of family tag36h11", id,
                 family->ncodes - 1);
  const unsigned border = ((unsigned)family->width_at_border - HL_TARGET_TAG_CELLS) / 2;
  for (unsigned i = 0; st == HL_OK && i < family->nbits; i++)
    out[family->bit_y[i] - border][family->bit_x[i] - border] =
        family->codes[id] >> (family->nbits - 1 - i) & 1;
  tag36h11_destroy(family);
  return st;
}
