/** Internal, not installed: what camera files need to know of the lens models (hl_lens_name is
 * public). */
#ifndef HALFLIGHT_LENS_NAMES_H
#define HALFLIGHT_LENS_NAMES_H

#include "halflight/camera.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How many distortion coefficients it has; 0 past the last. */
int hl_lens_coefficients(int model);

#ifdef __cplusplus
}
#endif
#endif
