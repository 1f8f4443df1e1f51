/* Tables of measured materials for the command's tests, by the published layout. It shares nothing with
 * the library: plain C, its own mathematics.
 *
 *   make_table NAME.binary [member=value ...]
 *
 * material=lambert (0.3, 0.2, 0.1 / sr) or glossy (and a lobe D(n.h) / (4 (n.s)(n.v))), hole=DEGREES
 * (cells with theta_half below it are not measured), dims=A,B,C (the header's), bytes=N (so many more,
 * or fewer), nan=1 (the last cell of blue).
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HALF = 90, DIFF = 90, PHI = 180, CELLS = HALF * DIFF * PHI };

static const double pi = 3.14159265358979323846;

typedef struct options {
  int glossy, dims[3], nan;
  long bytes;
  double hole;
} options;

static void fail(const char *what)
{
  fprintf(stderr, "make_table: %s\n", what);
  exit(2);
}

/* BRDF at a cell's centre; -1 where light or view is below the horizon. */
static double brdf(const options *o, int i, int j, int k, int channel)
{
  static const double body[3] = {0.3, 0.2, 0.1};
  const double half = (i + 0.5) / HALF, theta = half * half * pi / 2;
  const double diff = (j + 0.5) / DIFF * pi / 2, phi = (k + 0.5) / PHI * pi;
  const double p = cos(theta) * cos(diff), q = sin(theta) * sin(diff) * cos(phi);
  if (p - q <= 0 || p + q <= 0 || theta * 180 / pi < o->hole)
    return -1;
  if (!o->glossy)
    return body[channel];
  const double a2 = 0.04, c = cos(theta) * cos(theta) * (a2 - 1) + 1;
  return body[channel] + a2 / (pi * c * c) / (4 * (p - q) * (p + q));
}

static void set(options *o, const char *word)
{
  const char *value = strchr(word, '=');
  if (!value++)
    fail(word);
  if (strncmp(word, "material=", 9) == 0)
    o->glossy = strcmp(value, "glossy") == 0;
  else if (strncmp(word, "hole=", 5) == 0)
    o->hole = strtod(value, NULL);
  else if (strncmp(word, "nan=", 4) == 0)
    o->nan = 1;
  else if (strncmp(word, "bytes=", 6) == 0)
    o->bytes = strtol(value, NULL, 10);
  else if (strncmp(word, "dims=", 5) != 0 ||
           sscanf(value, "%d,%d,%d", &o->dims[0], &o->dims[1], &o->dims[2]) != 3)
    fail(word);
}

/* This machine is taken to be little-endian. */
int main(int argc, char **argv)
{
  static const double scale[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};
  options o = {0, {HALF, DIFF, PHI}, 0, 0, 0};
  if (argc < 2)
    fail("a file name is needed");
  for (int i = 2; i < argc; i++)
    set(&o, argv[i]);
  const size_t size = 12 + 8 * 3 * (size_t)CELLS;
  unsigned char *bytes = calloc(size + 64, 1);
  FILE *f = fopen(argv[1], "wb");
  if (!bytes || !f)
    fail(argv[1]);
  for (int i = 0; i < 3; i++) {
    const int32_t dim = o.dims[i];
    memcpy(bytes + 4 * i, &dim, 4);
  }
  for (int c = 0, at = 0; c < 3; c++)
    for (int i = 0; i < HALF; i++)
      for (int j = 0; j < DIFF; j++)
        for (int k = 0; k < PHI; k++, at++) {
          double value = brdf(&o, i, j, k, c);
          value = value < 0 ? -1 : value / scale[c];
          if (o.nan && at == 3 * CELLS - 1)
            value = NAN;
          memcpy(bytes + 12 + 8 * (size_t)at, &value, 8);
        }
  fwrite(bytes, 1, (size_t)((long)size + o.bytes), f);
  free(bytes);
  return fclose(f) == 0 ? 0 : 1;
}
