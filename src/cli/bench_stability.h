/* How the estimate of the light behaves at the ends of what a scene can be. */
#ifndef HL_CLI_BENCH_STABILITY_H
#define HL_CLI_BENCH_STABILITY_H

#include <stdio.h>

#include "bench_ball.h"

typedef enum hl_verdict { HL_VERDICT_OK, HL_VERDICT_UNTRUSTED, HL_VERDICT_REFUSED } hl_verdict;

typedef struct hl_stability {
  hl_bench_ball ball;
  uint64_t seed; /* the case's own, with or without the others */
  hl_status status;
  hl_verdict verdict;
  bool broken; /* a number that is none */
  double error_deg, deviations, condition;
  int iterations;
  char reason[HL_NOTE_TEXT_MAX];
} hl_stability;

enum { HL_STABILITY_MAX = 128 };

/* Run every case, or those of a ball below 100 px only; *n of them go to `out`, of shape
 * (HL_STABILITY_MAX). HL_ERR_MEMORY. */
hl_status hl_stability_run(hl_ctx *ctx, bool fast, hl_stability *out, int *n);

/* The table in Markdown, a summary line above it. */
void hl_stability_print(FILE *out, const hl_stability *cases, int n);

/* HL_ERR_RESIDUAL where a number is none, an answer called ok is off by more than five of its own
 * deviations plus 0.2 deg, or fewer than 80 % of the determinable cases are called ok. */
hl_status hl_stability_check(hl_ctx *ctx, const hl_stability *cases, int n);

#endif
