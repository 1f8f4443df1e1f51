/* Text that grows; a failure to grow is kept until the end. */
#ifndef HL_TEXT_H
#define HL_TEXT_H

#include <stdbool.h>
#include <stddef.h>

typedef struct hl_text {
  char *bytes; /* owner's, free() */
  size_t n, room;
  bool failed;
} hl_text;

void hl_text_add(hl_text *text, const char *more);

/* A number with `digits` significant digits and a decimal point. */
void hl_text_number(hl_text *text, double value, int digits);

/* Each as hl_number_text_exact has it, parted by ", ". */
void hl_text_exact(hl_text *text, const double *values, int n);

#endif
