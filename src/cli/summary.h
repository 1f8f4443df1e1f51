/* Results as a person reads them on a terminal of 80 columns. */
#ifndef HL_CLI_SUMMARY_H
#define HL_CLI_SUMMARY_H

#include <stdio.h>

#include "halflight/halflight.h"

void hl_summary_light(FILE *out, const hl_light *light, const hl_timing *timing);

void hl_summary_sphere(FILE *out, const hl_sphere *sphere, const hl_sphere_fit *fit);

/* "what: why; what: why" of the reasons. */
void hl_summary_reasons(const hl_notes *reasons, char *out, size_t size);

#endif
