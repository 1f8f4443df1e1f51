/* Results as a person reads them on a terminal of 80 columns. */
#ifndef HL_CLI_SUMMARY_H
#define HL_CLI_SUMMARY_H

#include <stdio.h>

#include "halflight/halflight.h"

/* Words after a label, wrapped under each other. */
void hl_summary_line(FILE *out, const char *label, const char *text);

/* A line a note, the label before the first. */
void hl_summary_notes(FILE *out, const char *label, const hl_notes *notes);

void hl_summary_light(FILE *out, const hl_light *light, const hl_timing *timing);

void hl_summary_sphere(FILE *out, const hl_sphere *sphere, const hl_sphere_fit *fit);

void hl_summary_fit(FILE *out, const hl_fit *fit);

/* What the lights stand on and which are off it. */
void hl_summary_dome(FILE *out, const hl_lights *lights);
/* What the lights stand on; which are off it, false where none is. */
void hl_summary_dome_text(const hl_lights *lights, char *out, size_t size);
bool hl_summary_off_dome(const hl_lights *lights, char *out, size_t size);

/* "what: why; what: why" of the reasons. */
void hl_summary_reasons(const hl_notes *reasons, char *out, size_t size);

#endif
