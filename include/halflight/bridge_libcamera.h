/** Internal, not installed: what the rest of the library asks of libcamera, in plain C. */
#ifndef HALFLIGHT_BRIDGE_LIBCAMERA_H
#define HALFLIGHT_BRIDGE_LIBCAMERA_H

#ifdef __cplusplus
extern "C" {
#endif

/** Of the library found at run time; NULL in a build without it. */
const char *hl_libcamera_version(void);

#ifdef __cplusplus
}
#endif
#endif
