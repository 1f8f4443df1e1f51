/* Lines that read on bright and on dark ground, and the marks made of them. */
#ifndef HL_CLI_MARKS_H
#define HL_CLI_MARKS_H

#include <cairo.h>

typedef enum hl_ink { HL_INK_OUTLINE, HL_INK_HIGHLIGHT, HL_INK_LIGHT, HL_INK_ELLIPSE } hl_ink;

/* Stroke cairo's current path with a dark halo. */
void hl_marks_stroke(cairo_t *cr, hl_ink ink, double width);

/* A thin cross with an open middle, so that the highlight itself stays visible. */
void hl_marks_cross(cairo_t *cr, double x, double y);

/* An arrow, or a ring where it is seen end on. */
void hl_marks_arrow(cairo_t *cr, const double from[2], const double to[2]);

#endif
