/*
 * Portable float maps: `PF` (three channels) or `Pf` (one), width, height, scale, then one byte of
 * white space and 4-byte floats, bottom row first. A negative scale means little-endian. Its size
 * is a unit that nobody agrees on, so it is not applied.
 */
#include "pfm.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/export.h"

#define PIXELS_MAX ((size_t)1 << 28)

enum { TOKEN_MAX = 32 };

typedef struct reader {
  const unsigned char *bytes;
  size_t n, at;
} reader;

static bool is_space(unsigned char c)
{
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

/* Next word of the header; "" at the end. Comments run from # to the end of a line. */
static void next_word(reader *r, char word[TOKEN_MAX])
{
  bool comment = false;
  for (; r->at < r->n; r->at++) {
    const unsigned char c = r->bytes[r->at];
    comment = comment ? c != '\n' : c == '#';
    if (!comment && !is_space(c))
      break;
  }
  size_t length = 0;
  for (; r->at < r->n && !is_space(r->bytes[r->at]) && length < TOKEN_MAX - 1; r->at++)
    word[length++] = (char)r->bytes[r->at];
  word[length] = '\0';
}

/* A size in 1 .. 2^28; 0 where the word is none. */
static size_t to_size(const char *word)
{
  size_t value = 0;
  if (strspn(word, "0123456789") != strlen(word) || word[0] == '\0')
    return 0;
  for (; *word; word++) {
    value = 10 * value + (size_t)(*word - '0');
    if (value > PIXELS_MAX)
      return 0;
  }
  return value;
}

/* Read by hand, since strtod follows the locale: only its sign and that it is a number not zero
 * matter. */
static bool is_scale(const char *word)
{
  const char *digits = word + (word[0] == '-' || word[0] == '+');
  const size_t mantissa = strspn(digits, "0123456789.");
  bool nonzero = false;
  for (size_t i = 0; i < mantissa; i++)
    nonzero = nonzero || (digits[i] >= '1' && digits[i] <= '9');
  const char *rest = digits + mantissa;
  return nonzero && (*rest == '\0' || strspn(rest, "eE+-0123456789") == strlen(rest));
}

/* Words may hold anything: only printable ones go into a message. */
static const char *shown(const char *word)
{
  for (const char *c = word; *c; c++)
    if (*c < ' ' || *c > '~')
      return "?";
  return word;
}

static hl_status read_header(hl_ctx *ctx, const char *path, reader *r, size_t *width,
                             size_t *height, bool *little)
{
  char w[TOKEN_MAX] = "", h[TOKEN_MAX] = "", scale[TOKEN_MAX] = "";
  next_word(r, w);
  next_word(r, h);
  next_word(r, scale);
  const size_t columns = to_size(w), rows = to_size(h);
  if (columns == 0 || rows == 0 || columns > PIXELS_MAX / rows)
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "%s: PFM size '%s' x '%s'; whole numbers with 1 to 2^28 pixels are needed", path,
                   shown(w), shown(h));
  if (!is_scale(scale))
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: PFM scale '%s'; a number other than 0 is needed", path,
                   shown(scale));
  *width = columns;
  *height = rows;
  *little = scale[0] == '-';
  return HL_OK;
}

bool hl_pfm_is(const unsigned char *bytes, size_t n)
{
  return n >= 3 && bytes[0] == 'P' && (bytes[1] == 'F' || bytes[1] == 'f') &&
         (is_space(bytes[2]) || bytes[2] == '#');
}

static float to_float(const unsigned char *b, bool little)
{
  const uint32_t bits =
      little ? (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24
             : (uint32_t)b[3] | (uint32_t)b[2] << 8 | (uint32_t)b[1] << 16 | (uint32_t)b[0] << 24;
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

hl_status hl_pfm_decode(hl_ctx *ctx, const char *path, const unsigned char *bytes, size_t n,
                        float **pixels, int *width, int *height, int *channels)
{
  if (!hl_pfm_is(bytes, n))
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: not a PFM; 'PF' or 'Pf' is needed at its start", path);
  const size_t c = bytes[1] == 'F' ? 3 : 1;
  reader r = {bytes, n, 2};
  size_t w = 1, h = 1;
  bool little = false;
  hl_status st = read_header(ctx, path, &r, &w, &h, &little);
  if (st != HL_OK)
    return st;
  const size_t needed = 4 * c * w * h;
  r.at += r.at < n;
  /* a header written with CR LF, unless that LF is the first pixel's byte */
  if (r.at < n && bytes[r.at - 1] == '\r' && bytes[r.at] == '\n' && n - r.at > needed)
    r.at++;
  if (needed == 0 || n - r.at < needed)
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "%s: PFM of %zu x %zu pixels is truncated: %zu of %zu bytes of pixels", path, w,
                   h, n - r.at, needed);
  float *out = malloc(needed);
  if (!out)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %zu x %zu pixels", path, w, h);
  for (size_t y = 0; y < h; y++) {
    const unsigned char *row = bytes + r.at + 4 * c * w * (h - 1 - y);
    for (size_t i = 0; i < c * w; i++)
      out[y * c * w + i] = to_float(row + 4 * i, little);
  }
  *pixels = out;
  *width = (int)w;
  *height = (int)h;
  *channels = (int)c;
  return HL_OK;
}

static void put_float(float value, unsigned char *b)
{
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  for (int i = 0; i < 4; i++)
    b[i] = (unsigned char)(bits >> (8 * i));
}

hl_status hl_pfm_write(hl_ctx *ctx, const char *path, const float *pixels, int width, int height,
                       int channels)
{
  if (channels != 1 && channels != 3)
    return hl_fail(ctx, HL_ERR_ARG, "%s: channels = %d; a PFM has 1 or 3", path, channels);
  if (width < 1 || height < 1 || (size_t)width > PIXELS_MAX / (size_t)height)
    return hl_fail(ctx, HL_ERR_ARG, "%s: size %d x %d; 1 to 2^28 pixels are needed", path, width,
                   height);
  char header[64];
  const size_t head = (size_t)snprintf(header, sizeof header, "%s\n%d %d\n-1.0\n",
                                       channels == 3 ? "PF" : "Pf", width, height);
  const size_t row = (size_t)width * (size_t)channels;
  const size_t n = head + 4 * row * (size_t)height;
  unsigned char *bytes = malloc(n);
  if (!bytes)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %d x %d pixels", path, width, height);
  memcpy(bytes, header, head);
  for (size_t y = 0; y < (size_t)height; y++)
    for (size_t i = 0; i < row; i++)
      put_float(pixels[((size_t)height - 1 - y) * row + i], bytes + head + 4 * (y * row + i));
  const hl_status st = hl_file_write(ctx, path, (const char *)bytes, n);
  free(bytes);
  return st;
}
