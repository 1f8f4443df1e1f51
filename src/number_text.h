/* Numbers as text with a decimal point, whatever the locale of the program around us. */
#ifndef HL_NUMBER_TEXT_H
#define HL_NUMBER_TEXT_H

#include <stdbool.h>
#include <stddef.h>

enum { HL_NUMBER_TEXT_MAX = 40 };

/* `digits` significant ones, 1 .. 17. Returns `text`. */
const char *hl_number_text(double value, int digits, char text[HL_NUMBER_TEXT_MAX]);

/* The fewest digits that give the value back, always with a point, so that readers of YAML 1.1 and of
 * Python take it for no integer and no text: 640.0, 0.1, 1.0e-05. Returns `text`. */
const char *hl_number_text_exact(double value, char text[HL_NUMBER_TEXT_MAX]);

/* The decimal number that fills `n` bytes, rounded to the nearest double. False where they are no
 * number, more than HL_NUMBER_TEXT_MAX - 8 bytes, or the number is not finite. */
bool hl_number_parse(const char *text, size_t n, double *out);

/* Make whatever stands between the digits of a number a point, in place. */
void hl_number_text_point(char *text);

#endif
