/* From stored values to linear ones. */
#ifndef HL_TRANSFER_H
#define HL_TRANSFER_H

#include "halflight/frame.h"

/* Linear value of a stored one; odd, so that noise below black stays noise about zero. `transfer`
 * is not HL_TRANSFER_AUTO. */
double hl_transfer_linear(hl_transfer transfer, double gamma, double stored);

#endif
