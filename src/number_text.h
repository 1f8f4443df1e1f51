/* Numbers as text with a decimal point, whatever the locale of the program around us. */
#ifndef HL_NUMBER_TEXT_H
#define HL_NUMBER_TEXT_H

enum { HL_NUMBER_TEXT_MAX = 40 };

/* `digits` significant ones, 1 .. 17. Returns `text`. */
const char *hl_number_text(double value, int digits, char text[HL_NUMBER_TEXT_MAX]);

/* Make whatever stands between the digits of a number a point, in place. */
void hl_number_text_point(char *text);

#endif
