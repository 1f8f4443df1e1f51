/*
 * cairo writes a PNG's pixels but not their size. The chunk that holds it, pHYs, may stand right
 * behind the header (PNG specification, 11.3.5.3): pixels a metre along x and y, and 1, the metre.
 */
#include "png_density.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

enum { HEADER = 8 + 25 /* signature and IHDR */, DENSITY = 4 + 4 + 9 + 4 };

typedef struct png_stream {
  FILE *file;
  size_t written; /* of cairo's bytes */
  unsigned char density[DENSITY];
} png_stream;

static void put32(unsigned char *at, unsigned long value)
{
  for (int i = 0; i < 4; i++)
    at[i] = (unsigned char)(value >> (24 - 8 * i));
}

static void make_density(double dpi, unsigned char out[DENSITY])
{
  static const unsigned char name[4] = {'p', 'H', 'Y', 's'};
  const unsigned long per_metre = (unsigned long)lround(dpi / 0.0254);
  put32(out, 9);
  memcpy(out + 4, name, sizeof name);
  put32(out + 8, per_metre);
  put32(out + 12, per_metre);
  out[16] = 1;
  put32(out + 17, crc32(0, out + 4, 13));
}

static cairo_status_t write_piece(void *closure, const unsigned char *bytes, unsigned int n)
{
  png_stream *s = closure;
  const size_t left = s->written < HEADER ? HEADER - s->written : 0;
  const size_t head = n < left ? n : left;
  size_t due = n;
  size_t done = fwrite(bytes, 1, head, s->file);
  if (left > 0 && head == left) {
    due += DENSITY;
    done += fwrite(s->density, 1, DENSITY, s->file);
  }
  done += fwrite(bytes + head, 1, n - head, s->file);
  s->written += n;
  return done == due ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_WRITE_ERROR;
}

cairo_status_t hl_png_write(cairo_surface_t *surface, const char *path, double dpi)
{
  if (!(dpi > 0))
    return cairo_surface_write_to_png(surface, path);
  png_stream s = {.file = fopen(path, "wb")};
  if (!s.file)
    return CAIRO_STATUS_WRITE_ERROR;
  make_density(dpi, s.density);
  const cairo_status_t status = cairo_surface_write_to_png_stream(surface, write_piece, &s);
  const int closed = fclose(s.file);
  return status == CAIRO_STATUS_SUCCESS && closed != 0 ? CAIRO_STATUS_WRITE_ERROR : status;
}
