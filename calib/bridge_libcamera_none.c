/* A build without libcamera. */
#include "halflight/bridge_libcamera.h"

#include "halflight/capture.h"

hl_status hl_capture_libcamera(hl_ctx *ctx, hl_capture_source *out)
{
  (void)out;
  return hl_fail(ctx, HL_ERR_UNAVAILABLE,
                 "capture from a camera is not in this build; -DHL_WITH_LIBCAMERA=ON is needed");
}

const char *hl_libcamera_version(void)
{
  return NULL;
}
