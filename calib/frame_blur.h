/* How sharp a frame is. */
#ifndef HL_FRAME_BLUR_H
#define HL_FRAME_BLUR_H

#include "grey.h"
#include "halflight/corners.h"

/* Standard deviation, in pixels, of what blurred the strongest edges of the frame; 0 where there are
 * none to speak of. */
double hl_frame_blur(const hl_grey *grey);

/* The same, and where that may be why no board was found, it is added to the reason. */
double hl_frame_blur_say(const hl_grey *grey, char why[HL_REASON_MAX]);

#endif
