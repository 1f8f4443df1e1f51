/* Text that grows by doubling. */
#include "text.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "number_text.h"

static bool grow(hl_text *text, size_t needed)
{
  if (needed <= text->room)
    return true;
  if (needed > SIZE_MAX / 2)
    return false;
  char *bytes = realloc(text->bytes, 2 * needed);
  if (!bytes)
    return false;
  text->bytes = bytes;
  text->room = 2 * needed;
  return true;
}

void hl_text_add(hl_text *text, const char *more)
{
  const size_t length = strlen(more);
  text->failed = text->failed || !grow(text, text->n + length + 1);
  if (text->failed)
    return;
  memcpy(text->bytes + text->n, more, length + 1);
  text->n += length;
}

void hl_text_number(hl_text *text, double value, int digits)
{
  char number[HL_NUMBER_TEXT_MAX];
  hl_text_add(text, hl_number_text(value, digits, number));
}

void hl_text_exact(hl_text *text, const double *values, int n)
{
  char number[HL_NUMBER_TEXT_MAX];
  for (int i = 0; i < n; i++) {
    hl_text_add(text, i > 0 ? ", " : "");
    hl_text_add(text, hl_number_text_exact(values[i], number));
  }
}
