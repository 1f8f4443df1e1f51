/* Lights on a hemisphere, as an inline drawing that stands still without script and turns with it. */
#ifndef HL_CLI_REPORT_DOME_H
#define HL_CLI_REPORT_DOME_H

#include "report_page.h"

typedef struct hl_dome_light {
  const char *label;
  double direction[3]; /* unit, camera frame */
  double basis[2][3];
  double covariance_rad2[2][2];
  bool trusted;
} hl_dome_light;

/* One light of LIGHT.json or of LIGHTS.json; false where it states no direction. */
bool hl_dome_light_read(const json_t *light, const char *label, bool trusted, hl_dome_light *out);

/* The figure with its caption and the buttons that the script shows. */
void hl_page_dome(hl_page *page, const hl_dome_light *lights, int n);

#endif
