/* Lights of two sessions matched: by label where every light has one of its own, else by file name
 * where that finds any, else by order. A light that both do not know well is named and left out. */
#include "rig_match.h"

#include <stdbool.h>
#include <string.h>

#include "halflight/notes.h"

typedef const char *(*key_of)(const hl_rig_light *light);

static const char *label_of(const hl_rig_light *light)
{
  return light->label ? light->label : "";
}

static const char *file_of(const hl_rig_light *light)
{
  return light->file ? light->file : "";
}

static int find(const hl_lights *in, key_of key, const char *text)
{
  for (int i = 0; i < in->n; i++)
    if (strcmp(key(&in->light[i]), text) == 0)
      return i;
  return -1;
}

static bool all_own(const hl_lights *lights, key_of key)
{
  for (int i = 0; i < lights->n; i++) {
    const char *text = key(&lights->light[i]);
    if (!*text || find(lights, key, text) != i)
      return false;
  }
  return true;
}

static bool serves(const hl_lights *a, const hl_lights *b, key_of key)
{
  if (!all_own(a, key) || !all_own(b, key))
    return false;
  for (int i = 0; i < a->n; i++)
    if (find(b, key, key(&a->light[i])) >= 0)
      return true;
  return false;
}

static const char *name_of(const hl_rig_light *light)
{
  return *label_of(light) ? label_of(light) : file_of(light);
}

static bool sound(const hl_rig_light *light)
{
  return light->found && light->trusted;
}

static void note_extra(const hl_lights *reference, const hl_lights *current, key_of key,
                       hl_notes *notes)
{
  for (int i = 0; i < current->n; i++) {
    const hl_rig_light *light = &current->light[i];
    if (key ? find(reference, key, key(light)) < 0 : i >= reference->n)
      hl_notes_add(notes, "light", "%.60s is in the current session only", name_of(light));
  }
}

int hl_rig_match(const hl_lights *reference, const hl_lights *current, hl_rig_pair *pair,
                 hl_notes *notes)
{
  const key_of key = serves(reference, current, label_of)  ? label_of
                     : serves(reference, current, file_of) ? file_of
                                                           : NULL;
  int n = 0;
  hl_notes_add(notes, "matched", "lights are matched by %s",
               key == label_of  ? "label"
               : key == file_of ? "file"
                                : "their order, since neither labels nor files tell them apart");
  for (int i = 0; i < reference->n; i++) {
    const hl_rig_light *light = &reference->light[i];
    const int at = key ? find(current, key, key(light)) : i < current->n ? i : -1;
    if (at < 0)
      hl_notes_add(notes, "light", "%.60s is in the reference session only", name_of(light));
    else if (!sound(light) || !sound(&current->light[at]))
      hl_notes_add(notes, "light",
                   "%.60s is not compared: it is not to be trusted in the %s session",
                   name_of(light), sound(light) ? "current" : "reference");
    else
      pair[n++] = (hl_rig_pair){i, at, name_of(light)};
  }
  note_extra(reference, current, key, notes);
  return n;
}
