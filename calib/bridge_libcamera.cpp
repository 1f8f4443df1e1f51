/* libcamera, behind plain C functions; no exception leaves this file. */
#include "halflight/bridge_libcamera.h"

#include <libcamera/camera_manager.h>

const char *hl_libcamera_version(void)
{
  try {
    return libcamera::CameraManager::version().c_str();
  } catch (...) {
    return nullptr;
  }
}
