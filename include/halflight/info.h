/** What this build is: version, features, library versions. */
#ifndef HALFLIGHT_INFO_H
#define HALFLIGHT_INFO_H

#include "halflight/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A library that this build uses, or could. */
typedef struct hl_feature {
  const char *name;    /* "OpenCV", ... */
  const char *version; /* of the library found at run time; NULL when not built in */
  const char *option;  /* what to set so that it is: "-DHL_WITH_OPENCV=ON" */
  const char *gives;   /* what it is for, one clause */
} hl_feature;

/** "MAJOR.MINOR.PATCH". */
HL_API const char *hl_version(void);

/** Borrowed static table; *n receives its length. */
HL_API const hl_feature *hl_features(int *n);

#ifdef __cplusplus
}
#endif
#endif
