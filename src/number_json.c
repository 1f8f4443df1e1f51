/*
 * A number respelt as JSON has it, which jansson then reads without a look at the locale:
 *
 *   [+-] digits [. [digits]] [e [+-] digits]    or    [+-] . digits [e ...]
 */
#include "number_json.h"

#include <string.h>

enum { LENGTH_MAX = 400 };

static size_t digits_at(const char *text, size_t n)
{
  size_t k = 0;
  while (k < n && text[k] >= '0' && text[k] <= '9')
    k++;
  return k;
}

typedef struct spelling {
  char text[LENGTH_MAX + 4];
  size_t n;
} spelling;

static void put(spelling *s, const char *bytes, size_t n)
{
  memcpy(s->text + s->n, bytes, n);
  s->n += n;
}

json_t *hl_number_json(const char *text, size_t n)
{
  spelling s = {.n = 0};
  if (n == 0 || n > LENGTH_MAX)
    return NULL;
  size_t at = text[0] == '+' || text[0] == '-';
  put(&s, text, text[0] == '-');
  const size_t whole = digits_at(text + at, n - at);
  if (whole > 1 && text[at] == '0')
    return NULL;
  put(&s, whole > 0 ? text + at : "0", whole > 0 ? whole : 1);
  at += whole;
  size_t fraction = 0;
  if (at < n && text[at] == '.') {
    fraction = digits_at(text + at + 1, n - at - 1);
    put(&s, text + at, fraction > 0 ? fraction + 1 : 0);
    put(&s, ".0", fraction > 0 ? 0 : 2);
    at += fraction + 1;
  }
  if (whole + fraction == 0)
    return NULL;
  if (at < n && (text[at] == 'e' || text[at] == 'E')) {
    const size_t sign = at + 1 < n && (text[at + 1] == '+' || text[at + 1] == '-');
    const size_t power = digits_at(text + at + 1 + sign, n - at - 1 - sign);
    put(&s, text + at, power > 0 ? 1 + sign + power : 0);
    at += power > 0 ? 1 + sign + power : 0;
  }
  if (at != n)
    return NULL;
  json_t *number = json_loadb(s.text, s.n, JSON_DECODE_ANY, NULL);
  /* a whole number too long for an integer */
  return number ? number : json_loadb(s.text, s.n, JSON_DECODE_ANY | JSON_DECODE_INT_AS_REAL, NULL);
}
