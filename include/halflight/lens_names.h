/** Internal, not installed: how camera files spell the lens models. */
#ifndef HALFLIGHT_LENS_NAMES_H
#define HALFLIGHT_LENS_NAMES_H

#ifdef __cplusplus
extern "C" {
#endif

/** Name of an hl_lens_model; NULL past the last. */
const char *hl_lens_name(int model);

/** How many distortion coefficients it has; 0 past the last. */
int hl_lens_coefficients(int model);

#ifdef __cplusplus
}
#endif
#endif
