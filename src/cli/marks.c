/* Marks on a photo: a light line on a dark, broader one. */
#include "marks.h"

#include <math.h>

#include "palette.h"

static const double PI = 3.14159265358979323846;

void hl_marks_stroke(cairo_t *cr, hl_ink ink, double width)
{
  static const double rgb[][3] = {
      {HL_SKY_BLUE},   /* HL_INK_OUTLINE */
      {1, 1, 1},       /* HL_INK_HIGHLIGHT */
      {1, 0.87, 0.2},  /* HL_INK_LIGHT */
      {1, 0.45, 0.12}, /* HL_INK_ELLIPSE */
  };
  cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
  cairo_set_line_cap(cr, CAIRO_LINE_CAP_ROUND);
  cairo_set_source_rgba(cr, 0, 0, 0, 0.65);
  cairo_set_line_width(cr, width + 2.4);
  cairo_stroke_preserve(cr);
  cairo_set_source_rgb(cr, rgb[ink][0], rgb[ink][1], rgb[ink][2]);
  cairo_set_line_width(cr, width);
  cairo_stroke(cr);
}

void hl_marks_cross(cairo_t *cr, double x, double y)
{
  static const double way[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (int i = 0; i < 4; i++) {
    cairo_move_to(cr, x + 3 * way[i][0], y + 3 * way[i][1]);
    cairo_line_to(cr, x + 10 * way[i][0], y + 10 * way[i][1]);
  }
  hl_marks_stroke(cr, HL_INK_HIGHLIGHT, 1.3);
}

void hl_marks_arrow(cairo_t *cr, const double from[2], const double to[2])
{
  const double length = hypot(to[0] - from[0], to[1] - from[1]);
  if (length < 14) { /* seen end on: a ring */
    cairo_new_sub_path(cr);
    cairo_arc(cr, from[0], from[1], 14, 0, 2 * PI);
    hl_marks_stroke(cr, HL_INK_LIGHT, 1.6);
    return;
  }
  const double head = fmin(13, 0.5 * length);
  const double a = atan2(to[1] - from[1], to[0] - from[0]);
  cairo_move_to(cr, from[0], from[1]);
  cairo_line_to(cr, to[0], to[1]);
  for (int side = -1; side <= 1; side += 2) {
    cairo_move_to(cr, to[0] - head * cos(a + side * 0.42), to[1] - head * sin(a + side * 0.42));
    cairo_line_to(cr, to[0], to[1]);
  }
  hl_marks_stroke(cr, HL_INK_LIGHT, 1.8);
}
