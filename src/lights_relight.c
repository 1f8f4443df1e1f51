/*
 * relight's .dome (CNR-ISTI VCLab, src/dome.cpp): JSON with a list `directions` of {x, y, z}, in the
 * order of the pictures, which are not named. x right, y up, z towards the camera; a picture without
 * a highlight has zeros. Positions would need the picture's width in their unit and are left empty.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/vec3.h"
#include "lights_formats.h"

enum { DIGITS = 12, NAME_MAX_BYTES = 32 };

static hl_status read_light(hl_json_source source, const json_t *entry, size_t i, hl_rig_light *out)
{
  char where[64];
  double d[3];
  snprintf(where, sizeof where, "directions[%zu]", i);
  static const char *const axes[] = {"x", "y", "z"};
  for (int k = 0; k < 3; k++) {
    const json_t *number = json_object_get(entry, axes[k]);
    if (!json_is_number(number))
      return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s: %s is no number; x, y and z are needed",
                     source.path, where, axes[k]);
    d[k] = json_number_value(number);
  }
  out->frame = (int)i;
  out->file = malloc(NAME_MAX_BYTES);
  out->label = strdup("");
  if (!out->file || !out->label)
    return hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for the lights", source.path);
  snprintf(out->file, NAME_MAX_BYTES, "%02zu", i + 1);
  return d[0] == 0 && d[1] == 0 && d[2] == 0 ? HL_OK : hl_lights_set(source, where, d, -1, out);
}

hl_status hl_lights_dome_members(hl_json_source source, const json_t *root, hl_lights *out)
{
  const json_t *list = json_object_get(root, "directions");
  if (!json_is_array(list))
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: directions is no list; a list is needed",
                   source.path);
  const size_t n = json_array_size(list);
  hl_status st = hl_lights_room(source, n, out);
  for (size_t i = 0; i < n && st == HL_OK; i++) {
    out->n = (int)i + 1; /* what it has is released with the rest */
    st = read_light(source, json_array_get(list, i), i, &out->light[i]);
  }
  return st;
}

void hl_lights_dome_put(const hl_lights *lights, hl_text *out)
{
  hl_text_add(out, "{\n  \"label\": \"halflight\",\n  \"notes\": \"\",\n  \"imageWidth\": 0,\n"
                   "  \"domeDiameter\": 0,\n  \"verticalOffset\": 0,\n"
                   "  \"lightConfiguration\": \"directional\",\n  \"lightSource\": \"from_lp\",\n"
                   "  \"directions\": [");
  static const char *const axes[] = {"{\"x\": ", ", \"y\": ", ", \"z\": "};
  for (int i = 0; i < lights->n; i++) {
    const double *d = lights->light[i].direction;
    const double there[3] = {d[0], 0 - d[1], 0 - d[2]};
    hl_text_add(out, i > 0 ? ",\n    " : "\n    ");
    for (int k = 0; k < 3; k++) {
      hl_text_add(out, axes[k]);
      hl_text_number(out, lights->light[i].found ? there[k] : 0, DIGITS);
    }
    hl_text_add(out, "}");
  }
  hl_text_add(out, "\n  ],\n  \"positionsSphere\": [],\n  \"positions3d\": [],\n"
                   "  \"ledAdjust\": []\n}\n");
}
