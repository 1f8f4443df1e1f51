/* Lines of `reasons`, `used` and `left_out`, and matrices, in JSON documents. */
#include "json_notes.h"

#include <stdbool.h>
#include <stddef.h>

#include "json_write.h"

static json_t *kept(json_t *list, bool good)
{
  if (good)
    return list;
  json_decref(list);
  return NULL;
}

json_t *hl_json_reasons(const hl_notes *notes)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < notes->n && good; i++) {
    const hl_note *note = &notes->note[i];
    const char *between = note->what[0] && note->why[0] ? ": " : "";
    good = json_array_append_new(list, json_sprintf("%s%s%s", note->what, between, note->why)) == 0;
  }
  return kept(list, good);
}

json_t *hl_json_notes(const hl_notes *notes)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < notes->n && good; i++) {
    const hl_note *note = &notes->note[i];
    json_t *line = json_pack("{s:s,s:s}", "what", note->what, "why", note->why);
    good = json_array_append_new(list, line) == 0;
  }
  return kept(list, good);
}

json_t *hl_json_rows(const double *rows, int n, int m, int stride)
{
  json_t *list = json_array();
  bool good = list != NULL;
  for (int i = 0; i < n && good; i++)
    good = json_array_append_new(list, hl_json_reals(rows + (ptrdiff_t)i * stride, m)) == 0;
  return kept(list, good);
}
