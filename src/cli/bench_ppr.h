/* R's projection pursuit regression on the same balls: the tool of Chandraker & Ramamoorthi 2011. */
#ifndef HL_CLI_BENCH_PPR_H
#define HL_CLI_BENCH_PPR_H

#include "bench_scene.h"

typedef struct hl_ppr hl_ppr;

typedef struct hl_ppr_answer {
  bool found;
  double light[3], truth[3], time_ms; /* of the fit alone, reading aside */
} hl_ppr_answer;

/* NULL where there is no memory or no temporary file; the others then do nothing. */
hl_ppr *hl_ppr_new(void);
/* The lit pixels of a scene; copied. */
void hl_ppr_add(hl_ppr *ppr, const hl_bench_scene *scene);
/* One process of Rscript over all scenes added; false: it is not there, or failed. `out` is of shape
 * (scenes). */
bool hl_ppr_run(hl_ppr *ppr, hl_ppr_answer *out);
void hl_ppr_free(hl_ppr *ppr);

#endif
