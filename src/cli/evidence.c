/* Pictures as base64 (RFC 4648) in a JSON document. */
#include "evidence.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SIDE_MAX = 8192, PICTURES_MAX = 64, PNG_HEAD = 24 };

static const char LETTERS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

static hl_status no_memory(hl_ctx *ctx)
{
  return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the pictures");
}

/* free(); NULL without memory. */
static char *encode(const unsigned char *bytes, size_t n)
{
  char *text = malloc(4 * ((n + 2) / 3) + 1);
  char *at = text;
  for (size_t i = 0; text && i < n; i += 3) {
    const size_t left = n - i < 3 ? n - i : 3;
    const unsigned a = bytes[i], b = left > 1 ? bytes[i + 1] : 0, c = left > 2 ? bytes[i + 2] : 0;
    *at++ = LETTERS[a >> 2];
    *at++ = LETTERS[(a & 3) << 4 | b >> 4];
    *at++ = LETTERS[(b & 15) << 2 | c >> 6];
    *at++ = LETTERS[c & 63];
    if (left < 3)
      at[-1] = '=';
    if (left < 2)
      at[-2] = '=';
  }
  if (text)
    *at = '\0';
  return text;
}

static unsigned char *read_whole(hl_ctx *ctx, const char *path, size_t *n)
{
  FILE *f = fopen(path, "rb");
  long size = -1;
  if (f && fseek(f, 0, SEEK_END) == 0)
    size = ftell(f);
  unsigned char *bytes = size > 0 ? malloc((size_t)size + 1) : NULL;
  const bool good =
      bytes && fseek(f, 0, SEEK_SET) == 0 && fread(bytes, 1, (size_t)size, f) == (size_t)size;
  if (f)
    fclose(f);
  if (!good) {
    free(bytes);
    hl_fail(ctx, HL_ERR_IO, "%s: a picture was drawn there and cannot be read back", path);
    return NULL;
  }
  bytes[size] = '\0';
  *n = (size_t)size;
  return bytes;
}

/* Of a PNG by its header, of an SVG by the attributes that cairo writes first. */
static void size_of(hl_picture_kind kind, const unsigned char *bytes, size_t n, int size[2])
{
  double width = 0, height = 0;
  size[0] = size[1] = 1;
  if (kind == HL_PICTURE_PNG && n >= PNG_HEAD) {
    for (int i = 0; i < 2; i++)
      size[i] = bytes[18 + 4 * i] << 8 | bytes[19 + 4 * i];
    return;
  }
  const char *text = (const char *)bytes;
  const char *w = strstr(text, " width=\""), *h = strstr(text, " height=\"");
  width = w ? strtod(w + 8, NULL) : 0;
  height = h ? strtod(h + 9, NULL) : 0;
  if (width >= 1 && width <= SIDE_MAX && height >= 1 && height <= SIDE_MAX) {
    size[0] = (int)width;
    size[1] = (int)height;
  }
}

hl_status hl_evidence_begin(hl_ctx *ctx, hl_evidence *out, const char *of, const char *stage)
{
  snprintf(out->scratch, sizeof out->scratch, "%s.draw", stage);
  out->document = json_pack("{s:s, s:i, s:s, s:[]}", "format", "halflight-evidence", "version", 1,
                            "of", of, "pictures");
  return out->document ? HL_OK : no_memory(ctx);
}

hl_status hl_evidence_add(hl_ctx *ctx, hl_evidence *evidence, const hl_evidence_picture *picture)
{
  size_t n = 0;
  int size[2];
  hl_status st = picture->draw(ctx, picture->kind, evidence->scratch, picture->data);
  unsigned char *bytes = st == HL_OK ? read_whole(ctx, evidence->scratch, &n) : NULL;
  unlink(evidence->scratch);
  if (!bytes)
    return st == HL_OK ? HL_ERR_IO : st;
  size_of(picture->kind, bytes, n, size);
  char *text = encode(bytes, n);
  free(bytes);
  json_t *entry =
      text ? json_pack("{s:s, s:s, s:s, s:b, s:s, s:i, s:i, s:s}", "name", picture->name, "title",
                       picture->title, "alt", picture->alt, "chart", picture->chart, "kind",
                       picture->kind == HL_PICTURE_PNG ? "png" : "svg", "width", size[0], "height",
                       size[1], "base64", text)
           : NULL;
  free(text);
  if (!entry || json_array_append_new(json_object_get(evidence->document, "pictures"), entry) != 0)
    st = no_memory(ctx);
  return st;
}

hl_status hl_evidence_used(hl_ctx *ctx, hl_evidence *evidence, const hl_notes *used)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; good && i < used->n; i++)
    good = json_array_append_new(list, json_pack("{s:s, s:s}", "what", used->note[i].what, "why",
                                                 used->note[i].why)) == 0;
  if (!good) {
    json_decref(list);
    return no_memory(ctx);
  }
  return json_object_set_new(evidence->document, "used", list) == 0 ? HL_OK : no_memory(ctx);
}

hl_status hl_evidence_write(hl_ctx *ctx, const hl_evidence *evidence, const char *path)
{
  char *text = json_dumps(evidence->document, JSON_INDENT(1));
  if (!text)
    return no_memory(ctx);
  const hl_status st = hl_file_write(ctx, path, text, strlen(text));
  free(text);
  return st;
}

void hl_evidence_free(hl_evidence *evidence)
{
  json_decref(evidence->document);
  evidence->document = NULL;
}

/* ---- what another program may have written */

static bool is_side(const json_t *value)
{
  return json_is_integer(value) && json_integer_value(value) >= 1 &&
         json_integer_value(value) <= SIDE_MAX;
}

/* The first bytes must be those of the kind: a page shows nothing else under its name. */
static bool is_picture(const json_t *picture)
{
  static const char *const texts[] = {"name", "title", "alt", "kind", "base64"};
  for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
    if (!json_is_string(json_object_get(picture, texts[i])))
      return false;
  const char *kind = json_string_value(json_object_get(picture, "kind"));
  const char *code = json_string_value(json_object_get(picture, "base64"));
  const char *start = strcmp(kind, "png") == 0   ? "iVBORw0KGgo"
                      : strcmp(kind, "svg") == 0 ? "PD94bWwg" /* "<?xml " */
                                                 : NULL;
  const size_t letters = strspn(code, LETTERS);
  return start && strncmp(code, start, strlen(start)) == 0 && strlen(code) % 4 == 0 &&
         strlen(code) - letters <= 2 && strspn(code + letters, "=") == strlen(code) - letters &&
         is_side(json_object_get(picture, "width")) && is_side(json_object_get(picture, "height"));
}

hl_status hl_evidence_check(hl_ctx *ctx, const char *path, const json_t *document)
{
  const json_t *pictures = json_object_get(document, "pictures");
  if (!json_is_array(pictures) || json_array_size(pictures) > PICTURES_MAX)
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: pictures is no list of at most %d", path, PICTURES_MAX);
  for (size_t i = 0; i < json_array_size(pictures); i++)
    if (!is_picture(json_array_get(pictures, i)))
      return hl_fail(ctx, HL_ERR_FORMAT,
                     "%s: pictures[%d] is no picture: name, title, alt, kind (png or svg), width, "
                     "height and base64 are needed",
                     path, (int)i);
  return HL_OK;
}
