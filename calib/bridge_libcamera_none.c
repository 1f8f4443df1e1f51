/* A build without libcamera. */
#include "halflight/bridge_libcamera.h"

#include <stddef.h>

const char *hl_libcamera_version(void)
{
  return NULL;
}
