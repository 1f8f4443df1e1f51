/* A linear frame as a picture for the eye. */
#ifndef HL_CLI_DEVELOP_H
#define HL_CLI_DEVELOP_H

#include <cairo.h>

#include "halflight/halflight.h"

/* An image of about 1/`shrink` of the frame's size, tone-mapped; the surface's pixels (may be NULL)
 * set the exposure. NULL without memory. The caller releases it with cairo_surface_destroy. */
cairo_surface_t *hl_develop(const hl_frame *frame, const hl_surface *surface, int shrink);

#endif
