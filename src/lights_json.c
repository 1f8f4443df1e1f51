/* lights.json: what all lights share, then a light a frame in the session's order. It holds no times,
 * so that the same frames give the same bytes. */
#include "lights_json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera_json.h"
#include "dome_json.h"
#include "json_notes.h"
#include "json_write.h"
#include "sphere_json.h"

enum { LIGHTS_MAX = 1000000, WHERE_MAX = 4200 };

static json_t *ball_list(const hl_lights *lights)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < lights->n_balls && good; i++)
    good = json_array_append_new(list, hl_sphere_json_document(&lights->ball[i], NULL)) == 0;
  return hl_json_kept(list, good);
}

static json_t *light_of(const void *user, int i)
{
  const hl_lights *lights = user;
  return hl_rig_light_document(&lights->light[i], hl_camera_intrinsics_count(&lights->camera));
}

static hl_json_long light_list(const hl_lights *lights)
{
  return (hl_json_long){"lights", lights->n, light_of, lights};
}

/* All but the lights themselves. */
static json_t *document(const hl_lights *lights)
{
  json_t *root = json_pack("{s:s,s:i}", "format", "halflight-lights", "version", 1);
  const bool good = root && hl_json_set(root, "trusted", json_boolean(lights->trusted)) &&
                    hl_json_set(root, "reasons", hl_json_notes(&lights->reasons)) &&
                    hl_json_set(root, "camera", hl_camera_json_document(&lights->camera)) &&
                    hl_json_set(root, "balls", ball_list(lights)) &&
                    hl_json_set(root, "lights", json_null()) &&
                    hl_json_set(root, "dome", hl_dome_document(lights)) &&
                    hl_json_set(root, "used", hl_json_notes(&lights->used)) &&
                    hl_json_set(root, "left_out", hl_json_notes(&lights->left_out));
  return hl_json_kept(root, good);
}

hl_status hl_lights_json(hl_ctx *ctx, const hl_lights *lights, char **out)
{
  const hl_json_long list = light_list(lights);
  return hl_json_long_text(ctx, document(lights), &list, out);
}

hl_status hl_lights_write(hl_ctx *ctx, const char *path, const hl_lights *lights)
{
  const hl_json_long list = light_list(lights);
  return hl_json_long_write(ctx, document(lights), &list, path);
}

/* "PATH: list[i]", so that a refusal names the element. */
static hl_json_source element(hl_json_source source, const char *list, int i, char where[WHERE_MAX])
{
  snprintf(where, WHERE_MAX, "%.4096s: %s[%d]", source.path, list, i);
  return (hl_json_source){source.ctx, where};
}

static hl_status list_of(hl_json_source source, const json_t *root, const char *member, size_t most,
                         const json_t **out)
{
  *out = json_object_get(root, member);
  if (!json_is_array(*out))
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s is no list; a list is needed", source.path,
                   member);
  if (json_array_size(*out) > most)
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s holds %zu; at most %zu are accepted",
                   source.path, member, json_array_size(*out), most);
  return HL_OK;
}

static hl_status read_balls(hl_json_source source, const json_t *root, hl_lights *out)
{
  const json_t *list;
  char where[WHERE_MAX];
  hl_status st = list_of(source, root, "balls", HL_BALLS_MAX, &list);
  if (st != HL_OK)
    return st;
  out->n_balls = (int)json_array_size(list);
  for (int i = 0; i < out->n_balls && st == HL_OK; i++)
    st = hl_sphere_json_members(element(source, "balls", i, where), json_array_get(list, (size_t)i),
                                &out->ball[i]);
  return st;
}

static hl_status read_lights(hl_json_source source, const json_t *root, hl_lights *out)
{
  const json_t *list;
  char where[WHERE_MAX];
  hl_status st = list_of(source, root, "lights", LIGHTS_MAX, &list);
  if (st != HL_OK)
    return st;
  const size_t n = json_array_size(list);
  out->light = calloc(n > 0 ? n : 1, sizeof *out->light);
  if (!out->light)
    return hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for %zu lights", source.path, n);
  const int columns = hl_camera_intrinsics_count(&out->camera);
  for (size_t i = 0; i < n && st == HL_OK; i++) {
    out->n = (int)i + 1; /* what it has is released with the rest */
    st = hl_rig_light_members(element(source, "lights", (int)i, where), json_array_get(list, i),
                              out->n_balls, columns, &out->light[i]);
  }
  return st;
}

hl_status hl_lights_members(hl_json_source source, const json_t *root, hl_lights *out)
{
  const json_t *trusted = json_object_get(root, "trusted");
  if (!json_is_boolean(trusted))
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: trusted is not true or false; one of them is needed", source.path);
  out->trusted = json_is_true(trusted);
  hl_status st = hl_json_notes_read(source, root, "reasons", &out->reasons);
  if (st == HL_OK)
    st = hl_json_notes_read(source, root, "used", &out->used);
  if (st == HL_OK)
    st = hl_json_notes_read(source, root, "left_out", &out->left_out);
  if (st == HL_OK)
    st = hl_camera_json_members(source, json_object_get(root, "camera"), &out->camera);
  if (st == HL_OK)
    st = read_balls(source, root, out);
  if (st == HL_OK)
    st = read_lights(source, root, out);
  return st == HL_OK ? hl_dome_members(source, root, out) : st;
}
