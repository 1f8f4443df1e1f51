/* What this build is. Versions are asked of the libraries themselves where they tell. */
#include "halflight/info.h"

#include <jansson.h>
#include <threads.h>
#include <yaml.h>

#include "halflight/bridge_libcamera.h"
#include "halflight/bridge_opencv.h"

#ifndef HL_APRILTAG_VERSION
#define HL_APRILTAG_VERSION NULL /* it does not tell at run time */
#endif

#define TEXT_OF(number) #number
#define DATE_TEXT(number) TEXT_OF(number)
#ifdef _OPENMP
#define OPENMP_VERSION DATE_TEXT(_OPENMP) /* year and month of the specification */
#else
#define OPENMP_VERSION NULL
#endif

#ifndef HL_ASSIMP_VERSION
#define HL_ASSIMP_VERSION NULL
#endif

enum { N_FEATURES = 9 };

/* Filled once, the same for everyone after. */
static hl_feature features[N_FEATURES];
static once_flag filled = ONCE_FLAG_INIT;

static void fill(void)
{
  const hl_feature all[N_FEATURES] = {
      {"jansson", jansson_version_str(), "", "cameras, balls and results as JSON"},
      {"libyaml", yaml_get_version_string(), "", "cameras of OpenCV and Kalibr"},
      {"libmd", HL_MD_VERSION, "", "the SHA-256 of frames"},
      {"cminpack", HL_CMINPACK_VERSION, "", "parametric fits"},
      {"OpenMP", OPENMP_VERSION, "a compiler with OpenMP", "more than one thread"},
      {"OpenCV", hl_opencv_version(), "-DHL_WITH_OPENCV=ON",
       "PNG, JPEG, TIFF and EXR frames; calibration"},
      {"AprilTag", HL_APRILTAG_VERSION, "-DHL_WITH_APRILTAG=ON",
       "AprilGrids as calibration targets"},
      {"assimp", HL_ASSIMP_VERSION, "-DHL_WITH_ASSIMP=ON", "meshes to relight"},
      {"libcamera", hl_libcamera_version(), "-DHL_WITH_LIBCAMERA=ON", "capture"},
  };
  for (int i = 0; i < N_FEATURES; i++)
    features[i] = all[i];
}

const char *hl_version(void)
{
  return HL_VERSION;
}

const hl_feature *hl_features(int *n)
{
  call_once(&filled, fill);
  *n = N_FEATURES;
  return features;
}
