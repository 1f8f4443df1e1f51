/* PNG files that say how large they are to be printed. */
#ifndef HL_CLI_PNG_DENSITY_H
#define HL_CLI_PNG_DENSITY_H

#include <cairo.h>

/* Write the surface; the file states `dpi` where that is above 0. */
cairo_status_t hl_png_write(cairo_surface_t *surface, const char *path, double dpi);

#endif
