/* Light error and run time of every method on every scene. */
#ifndef HL_CLI_BENCH_MEASURE_H
#define HL_CLI_BENCH_MEASURE_H

#include <stdio.h>

#include "bench_scene.h"
#include "draw.h"

typedef struct hl_bench_result {
  bool found;
  hl_bench_said said;
  double error_deg, time_ms; /* median of the repeats */
} hl_bench_result;

/* Over the scenes; a scene without an answer counts as 90 deg. */
typedef struct hl_bench_row {
  const hl_bench_method *method;
  double median_deg, high_deg, worst_deg, time_ms; /* high: 90th percentile; time: median */
  int found;
  bool front; /* no other method is both faster and better in the median */
} hl_bench_row;

typedef struct hl_bench_table {
  int n_scenes, n_methods; /* without ppr where R is not there */
  char (*scene)[64];       /* shape (n_scenes) */
  hl_bench_result *result; /* shape (methods, n_scenes) */
  hl_bench_row *row;       /* shape (methods) */
} hl_bench_table;

enum { HL_BENCH_REPEATS_MAX = 99 };

/* The caller frees it, also after a failure. Each method runs so often, 1 .. HL_BENCH_REPEATS_MAX, on each
 * scene; once more where that is more than one, for the caches. */
hl_status hl_bench_measure(hl_ctx *ctx, const char *const *folders, int n, int repeats,
                           hl_bench_table *out);
void hl_bench_table_free(hl_bench_table *table);

void hl_bench_print(FILE *out, const hl_bench_table *table);

/* "halflight-bench" version 1; *text is the caller's. HL_ERR_MEMORY. */
hl_status hl_bench_json(hl_ctx *ctx, const hl_bench_table *table, char **text);

/* Median error against median time, both logarithmic, the Pareto front marked. HL_ERR_IO. */
hl_status hl_draw_bench(hl_ctx *ctx, hl_picture_kind kind, const char *path,
                        const hl_bench_table *table);

#endif
