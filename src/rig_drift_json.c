/* What `drift --json` prints of two sessions: what moved as `causes`, the rest as `unmoved`. */
#include <stdbool.h>

#include "halflight/rig_drift.h"
#include "json_notes.h"
#include "json_write.h"

static json_t *cause_of(const hl_rig_cause *c)
{
  static const char *const quantity[] = {"rotation",  "focal length", "position",
                                         "direction", "intensity",    "exposure"};
  static const int numbers[] = {3, 2, 3, 3, 1, 1};
  return json_pack("{s:s,s:s,s:s,s:i,s:b,s:o,s:o,s:s,s:o,s:o}", "what", c->what, "name", c->name,
                   "quantity", quantity[c->part], "place", c->reference, "moved", (int)c->moved,
                   "figure", hl_json_real(c->figure), "threshold", hl_json_real(c->threshold),
                   "unit", c->unit, "significance", hl_json_real(c->significance), "change",
                   hl_json_reals(c->change, numbers[c->part]));
}

static json_t *causes_of(const hl_rig_drift *d, bool moved)
{
  json_t *list = json_array();
  for (int i = 0; i < d->n_causes; i++)
    if (d->cause[i].moved == moved && json_array_append_new(list, cause_of(&d->cause[i])) != 0) {
      json_decref(list);
      return NULL;
    }
  return list;
}

hl_status hl_rig_drift_json(hl_ctx *ctx, const hl_rig_drift *drift, char **out)
{
  json_t *root = json_pack("{s:s,s:i,s:s,s:o,s:o,s:i,s:i,s:o,s:o,s:o}", "format", "halflight-drift",
                           "version", 1, "verdict", drift->drifted ? "drifted" : "same",
                           "significance", hl_json_real(drift->significance), "false_alarm",
                           hl_json_real(drift->false_alarm), "lights", drift->n_matched, "tests",
                           drift->n_tests, "causes", causes_of(drift, true), "unmoved",
                           causes_of(drift, false), "notes", hl_json_notes(&drift->notes));
  return hl_json_text(ctx, root, out);
}
