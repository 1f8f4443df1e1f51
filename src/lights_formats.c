/*
 * Files of lights, told apart by what they hold:
 *
 *   {"format": "halflight-lights"       lights.json
 *   {"format": "halflight-light"        light.json, one light
 *   {"directions":                      relight's .dome
 *   {"lights":                          AliceVision's JSON
 *   anything that is not an object      .lp
 */
#include "lights_formats.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file_read.h"
#include "halflight/vec3.h"
#include "lights_json.h"

#define LENGTH_MIN 1e-4 /* relight's own bound */

static const char blanks[] = " \t\r\n";
static const char byte_order_mark[] = "\xef\xbb\xbf";

/* In the order of hl_lights_format. */
static const struct {
  const char *name;
  void (*put)(const hl_lights *lights, hl_text *out);
  unsigned keeps; /* hl_lights_part */
} formats[] = {
    {"lp", hl_lights_lp_put, HL_LIGHTS_NAMES},
    {"dome", hl_lights_dome_put, 0},
    {"alicevision", hl_lights_alicevision_put, HL_LIGHTS_NAMES | HL_LIGHTS_INTENSITIES},
    {"usda", hl_lights_usda_put, HL_LIGHTS_NAMES | HL_LIGHTS_INTENSITIES | HL_LIGHTS_POSITIONS},
};

enum { N_FORMATS = sizeof formats / sizeof formats[0] };

const char *hl_lights_format_name(int format)
{
  return format >= 0 && format < N_FORMATS ? formats[format].name : NULL;
}

/* ---------------------------------------------------------------- reading */

hl_status hl_lights_room(hl_json_source source, size_t n, hl_lights *out)
{
  if (n < 1 || n > HL_LIGHTS_FILE_MAX)
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %zu lights; 1 to %d are accepted", source.path,
                   n, HL_LIGHTS_FILE_MAX);
  out->light = calloc(n, sizeof *out->light);
  if (!out->light)
    return hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for %zu lights", source.path, n);
  out->trusted = true;
  return HL_OK;
}

hl_status hl_lights_set(hl_json_source source, const char *where, const double d[3], int turn,
                        hl_rig_light *light)
{
  const double length = hl_norm(d);
  if (!(length >= LENGTH_MIN && length <= 1e12))
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: %s: direction %.6g %.6g %.6g has length %.6g; at least %g is needed",
                   source.path, where, d[0], d[1], d[2], length, LENGTH_MIN);
  const double ours[3] = {d[0], turn < 0 ? 0 - d[1] : d[1], turn < 0 ? 0 - d[2] : d[2]};
  light->found = light->trusted = true;
  hl_unit(ours, light->direction);
  hl_tangent_basis(light->direction, light->tangent_basis[0], light->tangent_basis[1]);
  for (int k = 0; k < 3; k++)
    light->color[k] = light->intensity[k] = 1;
  return HL_OK;
}

/* light.json: its frame has no name, its colour is all that is known of its strength. */
static hl_status read_one(hl_json_source source, const json_t *root, hl_lights *out)
{
  const json_t *one = json_array_get(json_object_get(root, "lights"), 0);
  if (!json_is_object(one))
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: lights holds no light; the file of a frame that shows one is needed",
                   source.path);
  double d[3], color[3] = {1, 1, 1};
  hl_status st = hl_json_numbers(source, one, "direction", 3, d);
  const size_t channels = json_array_size(json_object_get(one, "color"));
  if (st == HL_OK && channels == 3)
    st = hl_json_numbers(source, one, "color", 3, color);
  if (st == HL_OK)
    st = hl_lights_room(source, 1, out);
  if (st != HL_OK)
    return st;
  out->n = 1;
  hl_rig_light *light = &out->light[0];
  light->file = strdup("light");
  light->label = strdup("");
  if (!light->file || !light->label)
    return hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for a light", source.path);
  st = hl_lights_set(source, "lights[0]", d, 1, light);
  memcpy(light->color, color, sizeof color);
  memcpy(light->intensity, color, sizeof color);
  const char *status = json_string_value(json_object_get(root, "status"));
  out->trusted = light->trusted = status && strcmp(status, "ok") == 0;
  if (st == HL_OK && hl_json_has(one, "covariance_rad2"))
    st = hl_json_matrix(source, one, "covariance_rad2", 2, 2, light->covariance_rad2[0]);
  light->near = hl_json_has(one, "position_m");
  return st == HL_OK && light->near
             ? hl_json_numbers(source, one, "position_m", 3, light->position_m)
             : st;
}

static hl_status read_document(hl_json_source source, const json_t *root, hl_lights *out)
{
  static const char *const ours[] = {"halflight-lights", "halflight-light"};
  const char *format = json_string_value(json_object_get(root, "format"));
  for (int i = 0; format && i < 2; i++)
    if (strcmp(format, ours[i]) == 0) {
      const hl_status st = hl_json_header(source, root, ours[i], 1);
      if (st != HL_OK)
        return st;
      return i == 0 ? hl_lights_members(source, root, out) : read_one(source, root, out);
    }
  if (!format && json_object_get(root, "directions"))
    return hl_lights_dome_members(source, root, out);
  if (!format && json_object_get(root, "lights"))
    return hl_lights_alicevision_members(source, root, out);
  return hl_fail(source.ctx, HL_ERR_FORMAT,
                 "%s: no lights are known in it: no lights.json, no light.json, no `directions` as "
                 "relight's .dome has, no `lights` as AliceVision's has",
                 source.path);
}

static const char *start_of(const unsigned char *bytes)
{
  const char *text = (const char *)bytes;
  if (strncmp(text, byte_order_mark, 3) == 0)
    text += 3;
  return text + strspn(text, blanks);
}

hl_status hl_lights_import(hl_ctx *ctx, const char *path, hl_lights *out)
{
  const hl_json_source source = {ctx, path};
  unsigned char *bytes = NULL;
  size_t n = 0;
  hl_status st = hl_file_read(ctx, path, HL_JSON_BYTES_MAX, &bytes, &n);
  if (st != HL_OK)
    return st;
  hl_lights *lights = calloc(1, sizeof *lights);
  json_t *root = NULL;
  const char *text = start_of(bytes);
  const size_t marked = strncmp((const char *)bytes, byte_order_mark, 3) == 0 ? 3 : 0;
  if (!lights)
    st = hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for the lights", path);
  else if (*text != '{')
    st = hl_lights_lp_parse(source, (const char *)bytes + marked, n - marked, lights);
  else {
    st = hl_json_parse(source, (const char *)bytes + marked, n - marked, &root);
    if (st == HL_OK)
      st = read_document(source, root, lights);
  }
  json_decref(root);
  free(bytes);
  if (st == HL_OK)
    *out = *lights;
  else
    hl_lights_free(lights);
  free(lights);
  return st;
}

hl_status hl_lights_file_is(hl_ctx *ctx, const char *path, bool *out)
{
  unsigned char *bytes = NULL;
  size_t n = 0;
  const hl_status st = hl_file_read(ctx, path, HL_JSON_BYTES_MAX, &bytes, &n);
  if (st != HL_OK)
    return st;
  const char *text = start_of(bytes);
  const size_t length = strlen(path);
  *out = (*text >= '0' && *text <= '9') ||
         (*text != '{' && length > 3 && strcmp(path + length - 3, ".lp") == 0);
  json_t *root =
      *text == '{' ? json_loadb(text, n - (size_t)(text - (char *)bytes), 0, NULL) : NULL;
  if (root) {
    const char *format = json_string_value(json_object_get(root, "format"));
    *out = format ? strncmp(format, "halflight-light", 15) == 0
                  : json_object_get(root, "directions") || json_object_get(root, "lights");
  }
  json_decref(root);
  free(bytes);
  return HL_OK;
}

/* ---------------------------------------------------------------- writing */

/* Bytes of the UTF-8 character at c; 0 where there is none (names may be of any code page). */
static int utf8_bytes(const unsigned char *c)
{
  const int n = c[0] < 0x80 ? 1 : c[0] < 0xc2 ? 0 : c[0] < 0xe0 ? 2 : c[0] < 0xf0 ? 3 : 4;
  const unsigned char least = c[0] == 0xe0 ? 0xa0 : c[0] == 0xf0 ? 0x90 : 0x80;
  const unsigned char most = c[0] == 0xed ? 0x9f : c[0] == 0xf4 ? 0x8f : 0xbf;
  if (c[0] > 0xf4 || (n > 1 && (c[1] < least || c[1] > most)))
    return 0;
  for (int i = 2; i < n; i++)
    if (c[i] < 0x80 || c[i] > 0xbf)
      return 0;
  return n;
}

void hl_lights_quote(hl_text *out, const char *text)
{
  hl_text_add(out, "\"");
  for (const char *c = text; *c;) {
    const int n = utf8_bytes((const unsigned char *)c);
    char one[5] = {0};
    if (n > 1)
      memcpy(one, c, (size_t)n);
    else if (*c == '"' || *c == '\\')
      memcpy(one, (const char[]){'\\', *c}, 2);
    else
      one[0] = n == 0 ? '?' : (unsigned char)*c < ' ' ? ' ' : *c;
    hl_text_add(out, one);
    c += n > 0 ? n : 1;
  }
  hl_text_add(out, "\"");
}

unsigned hl_lights_lost(const hl_lights *lights, hl_lights_format format)
{
  unsigned has = 0;
  for (int i = 0; i < lights->n; i++) {
    const hl_rig_light *l = &lights->light[i];
    if (!l->found)
      continue;
    has |= HL_LIGHTS_NAMES;
    for (int k = 0; k < 3; k++)
      if (l->intensity[k] != 1)
        has |= HL_LIGHTS_INTENSITIES;
    if (l->near) /* the place of a lamp means something to others only where the ball's is known */
      has |= HL_LIGHTS_POSITIONS;
    if (l->covariance_rad2[0][0] != 0)
      has |= HL_LIGHTS_COVARIANCES;
  }
  if ((unsigned)format >= N_FORMATS)
    return has;
  return has & ~(lights->n_balls > 0 ? formats[format].keeps
                                     : formats[format].keeps & ~(unsigned)HL_LIGHTS_POSITIONS);
}

hl_status hl_lights_text(hl_ctx *ctx, const hl_lights *lights, hl_lights_format format, char **out)
{
  if ((unsigned)format >= N_FORMATS)
    return hl_fail(ctx, HL_ERR_ARG, "format = %d is none of the known formats of lights",
                   (int)format);
  int found = 0;
  for (int i = 0; i < lights->n; i++)
    found += lights->light[i].found;
  if (found < 1)
    return hl_fail(ctx, HL_ERR_ARG, "none of %d lights was found; at least 1 is needed", lights->n);
  hl_text text = {0};
  formats[format].put(lights, &text);
  if (text.failed) {
    free(text.bytes);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the text of %d lights", lights->n);
  }
  *out = text.bytes;
  return HL_OK;
}
