/*
 * Numbers as text with a decimal point. printf follows the locale, which belongs to the program
 * around us; a %g text holds nothing but digits, signs, e and that one decimal mark.
 */
#include "number_text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
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

const char *hl_number_text_exact(double value, char text[HL_NUMBER_TEXT_MAX])
{
  char shortest[HL_NUMBER_TEXT_MAX - 4];
  for (int digits = 15; digits <= 17; digits++) {
    snprintf(shortest, sizeof shortest, "%.*g", digits, value);
    if (strtod(shortest, NULL) == value) /* in the locale it was printed in */
      break;
  }
  hl_number_text_point(shortest);
  const size_t whole = strspn(shortest, "-0123456789");
  const char *rest = shortest + whole;
  snprintf(text, HL_NUMBER_TEXT_MAX, "%.*s%s%s", (int)whole, shortest,
           *rest == '.' || !isfinite(value) ? "" : ".0", rest);
  return text;
}

/* strtod follows the locale too: it gets the point as the locale's mark. */
bool hl_number_parse(const char *text, size_t n, double *out)
{
  char copy[2 * HL_NUMBER_TEXT_MAX];
  char mark[16] = "";
  size_t used = 0;
  if (n == 0 || n > HL_NUMBER_TEXT_MAX - 8)
    return false;
  for (size_t i = 0; i < n; i++) {
    if (!text[i] || !strchr("+-0123456789.eE", text[i]))
      return false;
    if (text[i] != '.') {
      copy[used++] = text[i];
      continue;
    }
    if (mark[0] != '\0') /* a second point */
      return false;
    snprintf(mark, sizeof mark, "%.1f", 0.5);
    const size_t length = strlen(mark) - 2;
    memcpy(copy + used, mark + 1, length);
    used += length;
  }
  copy[used] = '\0';
  char *end = NULL;
  const double value = strtod(copy, &end);
  if (end != copy + used || !isfinite(value))
    return false;
  *out = value;
  return true;
}
