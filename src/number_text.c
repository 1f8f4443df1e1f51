/*
 * Numbers as text with a decimal point. printf follows the locale, which belongs to the program
 * around us; a %g text holds nothing but digits, signs, e and that one decimal mark.
 */
#include "number_text.h"

#include <stdio.h>
#include <string.h>

static const char plain[] = "+-0123456789abcdefghijklmnopqrstuvwxyz";

void hl_number_text_point(char *text)
{
  char *mark = text + strspn(text, plain);
  const size_t length = strcspn(mark, plain);
  if (length > 0) {
    memmove(mark + 1, mark + length, strlen(mark + length) + 1);
    *mark = '.';
  }
}

const char *hl_number_text(double value, int digits, char text[HL_NUMBER_TEXT_MAX])
{
  snprintf(text, HL_NUMBER_TEXT_MAX, "%.*g", digits, value);
  hl_number_text_point(text);
  return text;
}
