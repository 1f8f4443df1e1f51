/* How much work an estimate is, within a time where one is given. Private. */
#ifndef HL_LIGHT_BUDGET_H
#define HL_LIGHT_BUDGET_H

#include "light_work.h"

typedef struct hl_light_plan {
  int coarse, directions, candidates; /* to look around with */
  int cells;                          /* at most, to settle on; `pixels`: all of them */
  int surface;                        /* pixels there are */
  int gathered;                       /* at most so many of them; 0 = all */
  int pixels;                         /* gathered */
  bool finish;                        /* on all pixels */

  double budget_ms; /* 0: no clock is looked at */
  double started_ms, looked_ms;
  double pass_ms;   /* over one sample */
  unsigned without; /* terms that the budget leaves out */
  bool thinned;     /* samples were left out */
  bool hurried;     /* no bends at all, and what is refined is refined once */
} hl_light_plan;

/* First: `gathered`. */
void hl_light_plan_start(const hl_light_settings *settings, int pixels, hl_light_plan *plan);
/* Before looking around. */
void hl_light_plan_look(const hl_light_settings *settings, int pixels, hl_light_plan *plan);
/* After `passes` over the coarse samples: cells, and what of `own` is not to be tried. */
void hl_light_plan_settle(int passes, int channels, hl_light_plan *plan, hl_light_settings *own);
/* Once on cells: terms that the samples are too few for. */
void hl_light_plan_terms(const hl_light_data *data, hl_light_plan *plan, hl_light_settings *own);
/* After settling: whether to go over all pixels. */
bool hl_light_plan_finish(hl_light_plan *plan);
/* What was left out for want of time or pixels. */
void hl_light_plan_notes(const hl_light_plan *plan, int samples, hl_light *out);
/* Last: whether the budget was held. */
void hl_light_plan_end(const hl_light_plan *plan, hl_light *out);

#endif
