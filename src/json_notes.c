/* Lines of `reasons`, `used` and `left_out`, and matrices, in JSON documents. */
#include "json_notes.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "halflight/notes.h"
#include "json_write.h"

json_t *hl_json_reasons(const hl_notes *notes)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < notes->n && good; i++) {
    const hl_note *note = &notes->note[i];
    const char *between = note->what[0] && note->why[0] ? ": " : "";
    good = json_array_append_new(list, json_sprintf("%s%s%s", note->what, between, note->why)) == 0;
  }
  return hl_json_kept(list, good);
}

static json_t *note_lines(const hl_note *note, int n)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < n && good; i++) {
    json_t *line = json_pack("{s:s,s:s}", "what", note[i].what, "why", note[i].why);
    good = json_array_append_new(list, line) == 0;
  }
  return hl_json_kept(list, good);
}

json_t *hl_json_notes(const hl_notes *notes)
{
  return note_lines(notes->note, notes->n);
}

json_t *hl_json_note_list(const hl_note_list *list)
{
  return note_lines(list->note, list->n);
}

json_t *hl_json_rows(const double *rows, int n, int m, int stride)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < n && good; i++)
    good = json_array_append_new(list, hl_json_reals(rows + (ptrdiff_t)i * stride, m)) == 0;
  return hl_json_kept(list, good);
}

hl_status hl_json_notes_read(hl_json_source source, const json_t *object, const char *member,
                             hl_notes *out)
{
  const json_t *list = json_object_get(object, member);
  if (!json_is_array(list))
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s is no list; a list of notes is needed",
                   source.path, member);
  memset(out, 0, sizeof *out);
  for (size_t i = 0; i < json_array_size(list) && i < HL_NOTES_MAX; i++) {
    const char *what, *why;
    hl_status st = hl_json_string(source, json_array_get(list, i), "what", &what);
    if (st == HL_OK)
      st = hl_json_string(source, json_array_get(list, i), "why", &why);
    if (st != HL_OK)
      return st;
    hl_note *note = &out->note[out->n++];
    snprintf(note->what, sizeof note->what, "%.*s", (int)sizeof note->what - 1, what);
    snprintf(note->why, sizeof note->why, "%.*s", (int)sizeof note->why - 1, why);
  }
  return HL_OK;
}

hl_status hl_json_note_list_read(hl_json_source source, const json_t *object, const char *member,
                                 hl_note_list *out)
{
  hl_notes notes;
  const hl_status st = hl_json_notes_read(source, object, member, &notes);
  if (st == HL_OK && !hl_note_list_set(out, &notes))
    return hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for %s", source.path, member);
  return st;
}
