/* NAME.binary: three 4-byte integers 90, 90, 180, then the cells of red, of green and of blue as 8-byte
 * floats, all little-endian.
 *
 * The database's own reader asks for the product of the three alone; a table of another shape would be
 * read askew, so each is checked, and that the file ends where it should. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file_read.h"
#include "halflight/export.h"
#include "halflight/merl.h"

enum { HEAD = 12, REAL = 8 };
static const size_t values = 3 * (size_t)HL_MERL_CELLS;
static const size_t file_bytes = HEAD + REAL * 3 * (size_t)HL_MERL_CELLS;
static const size_t bytes_max = (size_t)1 << 28; /* larger files are no tables */

static int32_t get_int(const unsigned char *b)
{
  const uint32_t bits =
      (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
  int32_t value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static double get_real(const unsigned char *b)
{
  uint64_t bits = 0;
  for (int i = REAL - 1; i >= 0; i--)
    bits = bits << 8 | b[i];
  double value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static void put_real(double value, unsigned char *b)
{
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  for (int i = 0; i < REAL; i++)
    b[i] = (unsigned char)(bits >> (8 * i));
}

/* Words for the place of a value, such as "green[12,0,179]". */
static void place_of(size_t i, char text[64])
{
  static const char *const channels[3] = {"red", "green", "blue"};
  const size_t cell = i % HL_MERL_CELLS;
  snprintf(text, 64, "%s[%zu,%zu,%zu]", channels[i / HL_MERL_CELLS],
           cell / ((size_t)HL_MERL_THETA_DIFF * HL_MERL_PHI_DIFF),
           cell / HL_MERL_PHI_DIFF % HL_MERL_THETA_DIFF, cell % HL_MERL_PHI_DIFF);
}

static hl_status check_shape(hl_ctx *ctx, const char *path, const unsigned char *bytes, size_t n)
{
  if (n < HEAD)
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "%s: %zu bytes are no MERL table; one of 90 x 90 x 180 cells has %zu", path, n,
                   file_bytes);
  const int32_t dims[3] = {get_int(bytes), get_int(bytes + 4), get_int(bytes + 8)};
  if (dims[0] != HL_MERL_THETA_HALF || dims[1] != HL_MERL_THETA_DIFF || dims[2] != HL_MERL_PHI_DIFF)
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "%s: a table of %d x %d x %d cells; one of MERL's, 90 x 90 x 180, is needed",
                   path, (int)dims[0], (int)dims[1], (int)dims[2]);
  if (n != file_bytes)
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: %s: %zu bytes; a table of 90 x 90 x 180 cells has %zu",
                   path, n < file_bytes ? "truncated" : "bytes left over after the table", n,
                   file_bytes);
  return HL_OK;
}

static hl_status decode(hl_ctx *ctx, const char *path, const unsigned char *bytes, hl_merl *out)
{
  hl_merl merl;
  hl_status st = hl_merl_new(ctx, &merl);
  if (st != HL_OK)
    return st;
  for (size_t i = 0; i < values && st == HL_OK; i++) {
    merl.value[i] = get_real(bytes + HEAD + REAL * i);
    if (!isfinite(merl.value[i])) {
      char place[64];
      place_of(i, place);
      st = hl_fail(ctx, HL_ERR_FORMAT, "%s: %s = %g; a finite number is needed", path, place,
                   merl.value[i]);
    }
  }
  if (st == HL_OK && !(hl_merl_measured(&merl) > 0))
    st = hl_fail(ctx, HL_ERR_FORMAT,
                 "%s: no cell above the horizon is measured (all are below 0); a table that holds "
                 "a BRDF is needed",
                 path);
  if (st == HL_OK)
    *out = merl;
  else
    hl_merl_free(&merl);
  return st;
}

hl_status hl_merl_read(hl_ctx *ctx, const char *path, hl_merl *out)
{
  unsigned char *bytes = NULL;
  size_t n = 0;
  hl_status st = hl_file_read(ctx, path, bytes_max, &bytes, &n);
  if (st != HL_OK)
    return st;
  st = check_shape(ctx, path, bytes, n);
  if (st == HL_OK)
    st = decode(ctx, path, bytes, out);
  free(bytes);
  return st;
}

hl_status hl_merl_write(hl_ctx *ctx, const char *path, const hl_merl *merl)
{
  static const unsigned char head[HEAD] = {HL_MERL_THETA_HALF, 0, 0, 0, HL_MERL_THETA_DIFF, 0, 0, 0,
                                           HL_MERL_PHI_DIFF,   0, 0, 0};
  for (size_t i = 0; i < values; i++)
    if (!isfinite(merl->value[i])) {
      char place[64];
      place_of(i, place);
      return hl_fail(ctx, HL_ERR_ARG, "%s: %s = %g; a finite number is needed", path, place,
                     merl->value[i]);
    }
  unsigned char *bytes = malloc(file_bytes);
  if (!bytes)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %zu bytes", path, file_bytes);
  memcpy(bytes, head, HEAD);
  for (size_t i = 0; i < values; i++)
    put_real(merl->value[i], bytes + HEAD + REAL * i);
  const hl_status st = hl_file_write(ctx, path, (const char *)bytes, file_bytes);
  free(bytes);
  return st;
}
