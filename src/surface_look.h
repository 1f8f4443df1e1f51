/* One place of the frame, between pixels too. Private. */
#ifndef HL_SURFACE_LOOK_H
#define HL_SURFACE_LOOK_H

#include "halflight/surface.h"

/* Normal and view of the ball where the ray through (x, y) meets it; false where it passes by. */
bool hl_ball_look(const hl_camera *camera, const hl_sphere *ball, double x, double y,
                  double normal[3], double view[3]);

#endif
