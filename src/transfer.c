/*
 * From stored values to linear ones.
 *
 * sRGB, IEC 61966-2-1: x / 12.92 up to 0.04045, ((x + 0.055) / 1.055)^2.4 above.
 * Gamma: x^gamma. Both continue as odd functions below zero.
 */
#include "transfer.h"

#include <math.h>

static double of_positive(hl_transfer transfer, double gamma, double x)
{
  switch (transfer) {
  case HL_TRANSFER_SRGB:
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
  case HL_TRANSFER_GAMMA:
    return pow(x, gamma);
  case HL_TRANSFER_AUTO:
  case HL_TRANSFER_LINEAR:
    break;
  }
  return x;
}

double hl_transfer_linear(hl_transfer transfer, double gamma, double stored)
{
  return copysign(of_positive(transfer, gamma, fabs(stored)), stored);
}
