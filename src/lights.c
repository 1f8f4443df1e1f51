/* The lights of a rig: released, read, written. */
#include <stdlib.h>
#include <string.h>

#include "halflight/export.h"
#include "halflight/lights.h"
#include "halflight/notes.h"
#include "json_read.h"
#include "lights_json.h"

void hl_lights_free(hl_lights *lights)
{
  if (!lights)
    return;
  for (int i = 0; i < lights->n; i++) {
    free(lights->light[i].file);
    free(lights->light[i].label);
    hl_note_list_free(&lights->light[i].reasons);
  }
  free(lights->light);
  memset(lights, 0, sizeof *lights);
}

hl_status hl_lights_read(hl_ctx *ctx, const char *path, hl_lights *out)
{
  const hl_json_source source = {ctx, path};
  json_t *root = NULL;
  hl_status st = hl_json_open(source, "halflight-lights", 1, &root);
  if (st != HL_OK)
    return st;
  hl_lights *lights = calloc(1, sizeof *lights);
  st = lights ? hl_lights_members(source, root, lights)
              : hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for the lights", path);
  json_decref(root);
  if (st == HL_OK)
    *out = *lights;
  else
    hl_lights_free(lights);
  free(lights);
  return st;
}
