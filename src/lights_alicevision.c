/*
 * AliceVision's lights (src/aliceVision/lightingEstimation/lightingCalibration.cpp, writeJSON; read
 * by photometricStereo/photometricDataIO.cpp): a list `lights` of {lightId or viewId, type,
 * direction, intensity}. The frame is the camera's, x right, y down, z forward: their reader turns an
 * .lp by (x, -y, -z), and their normals towards the camera have a negative z. Where lights have a
 * lightId the pictures take them in the order of the file. `file` is ours; their reader passes it by.
 *
 * boost's property_tree writes each number as a text, so texts that are numbers are read as such.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/vec3.h"
#include "lights_formats.h"
#include "number_text.h"

enum { DIGITS = 12, NAME_MAX_BYTES = 64 };

static bool number(const json_t *value, double *out)
{
  const char *text = json_string_value(value);
  if (text)
    return hl_number_parse(text, strlen(text), out);
  *out = json_number_value(value);
  return json_is_number(value);
}

static hl_status three(hl_json_source source, const char *where, const json_t *light,
                       const char *member, double out[3])
{
  const json_t *list = json_object_get(light, member);
  const size_t n = json_array_size(list);
  for (size_t k = 0; k < n && k < 3; k++)
    if (!number(json_array_get(list, k), &out[k]))
      return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s: %s[%zu] is no number; a number is needed",
                     source.path, where, member, k);
  if (n != 3)
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: %s: %s has %zu numbers; 3, as a directional light has, are needed",
                   source.path, where, member, n);
  return HL_OK;
}

/* The light's name: `file` where we wrote it, else its id, else its key. */
static char *name_of(const json_t *light, const char *key, size_t i)
{
  static const char *const ids[] = {"viewId", "lightId"};
  const char *file = json_string_value(json_object_get(light, "file"));
  if (file || key)
    return strdup(file ? file : key);
  char name[NAME_MAX_BYTES];
  snprintf(name, sizeof name, "%02zu", i + 1);
  for (int k = 0; k < 2; k++) {
    const json_t *id = json_object_get(light, ids[k]);
    if (json_is_string(id) && json_string_length(id) > 0)
      return strdup(json_string_value(id));
    if (json_is_integer(id)) {
      snprintf(name, sizeof name, "%" JSON_INTEGER_FORMAT, json_integer_value(id));
      break;
    }
  }
  return strdup(name);
}

static hl_status read_light(hl_json_source source, const json_t *entry, const char *key, size_t i,
                            hl_rig_light *out)
{
  char where[NAME_MAX_BYTES];
  double d[3] = {0}, intensity[3];
  snprintf(where, sizeof where, "lights[%zu]", i);
  out->frame = (int)i;
  out->file = name_of(entry, key, i);
  out->label = strdup("");
  if (!out->file || !out->label)
    return hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for the lights", source.path);
  hl_status st = three(source, where, entry, "direction", d);
  if (st == HL_OK)
    st = three(source, where, entry, "intensity", intensity);
  if (st == HL_OK)
    st = hl_lights_set(source, where, d, 1, out);
  if (st == HL_OK)
    memcpy(out->intensity, intensity, sizeof intensity);
  return st;
}

hl_status hl_lights_alicevision_members(hl_json_source source, const json_t *root, hl_lights *out)
{
  json_t *list = json_object_get(root, "lights");
  const bool keyed = json_is_object(list); /* an older form, by the pictures' names */
  if (!keyed && !json_is_array(list))
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: lights is no list; a list is needed",
                   source.path);
  const size_t n = keyed ? json_object_size(list) : json_array_size(list);
  void *at = keyed ? json_object_iter(list) : NULL;
  hl_status st = hl_lights_room(source, n, out);
  for (size_t i = 0; i < n && st == HL_OK; i++) {
    out->n = (int)i + 1; /* what it has is released with the rest */
    st = read_light(source, keyed ? json_object_iter_value(at) : json_array_get(list, i),
                    keyed ? json_object_iter_key(at) : NULL, i, &out->light[i]);
    at = keyed ? json_object_iter_next(list, at) : NULL;
  }
  return st;
}

static void put_three(hl_text *out, const char *member, const double *value)
{
  hl_text_add(out, ", \"");
  hl_text_add(out, member);
  hl_text_add(out, "\": [");
  for (int k = 0; k < 3; k++) {
    hl_text_add(out, k > 0 ? ", " : "");
    hl_text_number(out, value[k], DIGITS);
  }
  hl_text_add(out, "]");
}

void hl_lights_alicevision_put(const hl_lights *lights, hl_text *out)
{
  int n = 0;
  hl_text_add(out, "{\n  \"lights\": [");
  for (int i = 0; i < lights->n; i++) {
    const hl_rig_light *light = &lights->light[i];
    if (!light->found)
      continue;
    hl_text_add(out, n > 0 ? ",\n    {\"lightId\": " : "\n    {\"lightId\": ");
    hl_text_number(out, n++, DIGITS);
    hl_text_add(out, ", \"file\": ");
    hl_lights_quote(out, light->file);
    hl_text_add(out, ", \"type\": \"directional\"");
    put_three(out, "direction", light->direction);
    put_three(out, "intensity", light->intensity);
    hl_text_add(out, "}");
  }
  hl_text_add(out, "\n  ]\n}\n");
}
