/* Tags in a build without AprilTag. */
#include "halflight/target.h"

hl_status hl_target_tag_cells(hl_ctx *ctx, int id,
                              bool out[HL_TARGET_TAG_CELLS][HL_TARGET_TAG_CELLS])
{
  (void)id;
  (void)out;
  return hl_fail(ctx, HL_ERR_UNAVAILABLE,
                 "AprilTag is not in this build, so there are no tags: build with "
                 "-DHL_WITH_APRILTAG=ON");
}
