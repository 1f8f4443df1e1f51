/* Which light of one session is which of another. */
#ifndef HL_RIG_MATCH_H
#define HL_RIG_MATCH_H

#include "halflight/lights.h"

typedef struct hl_rig_pair {
  int reference, current; /* places in the sessions */
  const char *name;       /* borrowed from the reference */
} hl_rig_pair;

/* pair: room for reference->n; returns how many are in both and found and trusted in both. */
int hl_rig_match(const hl_lights *reference, const hl_lights *current, hl_rig_pair *pair,
                 hl_notes *notes);

#endif
