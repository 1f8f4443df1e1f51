/*
 * Least squares fed row by row.
 *
 * Rows are turned into the triangle one at a time by Givens rotations (Golub and Van Loan, 5.2.3 and
 * 12.5.3): R'R = A'A and R'z = A'y without ever forming A or squaring its condition number. What is
 * left of a datum after its row has been used up is what no solution explains.
 *
 * The triangle of the last unknowns alone is the problem with the ones before them free: a nuisance
 * goes first.
 */
#include "triangle.h"

#include <math.h>
#include <string.h>

void hl_triangle_clear(hl_triangle *triangle, int n)
{
  memset(triangle, 0, sizeof *triangle);
  triangle->n = n;
}

void hl_triangle_add(hl_triangle *triangle, double *row, double datum)
{
  for (int i = 0; i < triangle->n; i++) {
    double *r = triangle->r[i];
    if (row[i] == 0)
      continue;
    const double length = hypot(r[i], row[i]);
    const double c = r[i] / length, s = row[i] / length;
    for (int k = i; k < triangle->n; k++) {
      const double upper = r[k];
      r[k] = c * upper + s * row[k];
      row[k] = c * row[k] - s * upper;
    }
    const double upper = triangle->z[i];
    triangle->z[i] = c * upper + s * datum;
    datum = c * datum - s * upper;
  }
  triangle->rest += datum * datum;
  triangle->rows++;
}
