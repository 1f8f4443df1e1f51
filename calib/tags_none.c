/* A build without AprilTag. */
#include "tags.h"

hl_status hl_tag_finder_new(hl_ctx *ctx, hl_tag_finder **out)
{
  (void)out;
  return hl_fail(ctx, HL_ERR_UNAVAILABLE,
                 "AprilTag is not in this build, so no tag can be found: build with "
                 "-DHL_WITH_APRILTAG=ON");
}

void hl_tag_finder_free(hl_tag_finder *finder)
{
  (void)finder;
}

hl_status hl_tags_find(hl_ctx *ctx, hl_tag_finder *finder, const hl_grey *grey, hl_tag_edges edges,
                       hl_tags *out)
{
  (void)grey;
  (void)edges;
  (void)out;
  return hl_tag_finder_new(ctx, &finder);
}
