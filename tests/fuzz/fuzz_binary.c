/* Pictures and tables of numbers. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "pfm.h"
#include "readers.h"

static hl_status read_frame(hl_ctx *ctx, const char *path)
{
  hl_frame frame = {0};
  const hl_status st = hl_frame_read(ctx, path, NULL, &frame);
  if (st != HL_OK)
    return st;
  const size_t n = (size_t)frame.width * (size_t)frame.height * (size_t)frame.channels;
  for (size_t i = 0; i < n; i++)
    fuzz_demand(isfinite(frame.radiance[i]), "radiance is finite", "");
  hl_frame_free(&frame);
  return HL_OK;
}

hl_status fuzz_pfm(hl_ctx *ctx, const fuzz_input *input)
{
  if (!hl_pfm_is(input->bytes, input->n))
    return HL_OK;
  return read_frame(ctx, input->path);
}

/* Whatever kind of picture the bytes are: what comes before the decoders, and the decoders. */
hl_status fuzz_frame(hl_ctx *ctx, const fuzz_input *input)
{
  return read_frame(ctx, input->path);
}

/* The header, then a table that is all zeros but for the rest of the input, or not filled up. */
hl_status fuzz_merl(hl_ctx *ctx, const fuzz_input *input)
{
  static const int sides[3] = {HL_MERL_THETA_HALF, HL_MERL_THETA_DIFF, HL_MERL_PHI_DIFF};
  hl_merl table = {0};
  if (input->n > sizeof sides && memcmp(input->bytes, sides, sizeof sides) == 0 &&
      input->bytes[input->n - 1] % 2 == 0) {
    const off_t whole = (off_t)sizeof sides + 3 * (off_t)HL_MERL_CELLS * (off_t)sizeof(double);
    fuzz_demand(truncate(input->path, whole) == 0, "the file can grow", "");
  }
  const hl_status st = hl_merl_read(ctx, input->path, &table);
  if (st == HL_OK)
    hl_merl_free(&table);
  return st;
}
