/*
 * What kind of image a file is, and whether all of it is there.
 *
 * Decoders fill what is missing with grey and call it a success, which would move a light without a
 * word. PNG: chunks to IEND. JPEG: markers to EOI. TIFF and EXR carry offsets, which their decoders
 * check themselves.
 */
#include "image_whole.h"

#include <stdbool.h>
#include <string.h>

static bool starts(const unsigned char *bytes, size_t n, const char *magic, size_t length)
{
  return n >= length && memcmp(bytes, magic, length) == 0;
}

static size_t big_endian(const unsigned char *b, int count)
{
  size_t value = 0;
  for (int i = 0; i < count; i++)
    value = value << 8 | b[i];
  return value;
}

/* Chunks: length (4), kind (4), data, CRC (4). */
static bool png_ends(const unsigned char *b, size_t n)
{
  size_t at = 8;
  while (n - at >= 12) {
    const size_t length = big_endian(b + at, 4);
    if (length > n - at - 12)
      return false;
    if (memcmp(b + at + 4, "IEND", 4) == 0)
      return true;
    at += length + 12;
  }
  return false;
}

/* Past the entropy-coded data at `at`: the next marker that is neither a stuffed FF nor a restart.
 */
static size_t skip_scan(const unsigned char *b, size_t n, size_t at)
{
  for (; at + 1 < n; at++)
    if (b[at] == 0xff && b[at + 1] != 0 && b[at + 1] != 0xff &&
        !(b[at + 1] >= 0xd0 && b[at + 1] <= 0xd7))
      return at;
  return n;
}

/* Segments: FF, kind, length (2, counts itself), data. */
static bool jpeg_ends(const unsigned char *b, size_t n)
{
  size_t at = 2;
  while (at < n && n - at >= 2) {
    if (b[at] != 0xff)
      return false;
    const unsigned kind = b[at + 1];
    if (kind == 0xd9)
      return true;
    if (kind == 0xff) {
      at++;
      continue;
    }
    if (n - at < 4)
      return false;
    at += 2 + big_endian(b + at + 2, 2);
    if (kind == 0xda)
      at = skip_scan(b, n, at);
  }
  return false;
}

hl_status hl_image_whole(hl_ctx *ctx, const char *path, const unsigned char *bytes, size_t n,
                         const char **kind)
{
  bool whole = true;
  if (starts(bytes, n, "\x89PNG\r\n\x1a\n", 8)) {
    *kind = "PNG";
    whole = png_ends(bytes, n);
  } else if (starts(bytes, n, "\xff\xd8\xff", 3)) {
    *kind = "JPEG";
    whole = jpeg_ends(bytes, n);
  } else if (starts(bytes, n, "II*\0", 4) || starts(bytes, n, "MM\0*", 4)) {
    *kind = "TIFF";
  } else if (starts(bytes, n, "\x76\x2f\x31\x01", 4)) {
    *kind = "EXR";
  } else {
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: not an image: PNG, JPEG, TIFF, EXR or PFM is needed",
                   path);
  }
  if (!whole)
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: %s is truncated; a whole file is needed", path, *kind);
  return HL_OK;
}
