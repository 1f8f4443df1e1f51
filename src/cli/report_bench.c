/* The report of a benchmark, from BENCH.json: each method over the scenes, by the rules of its table:
 * a scene without an answer counts as 90 degrees. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "report.h"

typedef struct method_row {
  const char *name;
  int n, found;
  double *error_deg, *time_ms; /* shape (n) */
} method_row;

static int compare(const void *a, const void *b)
{
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double median(double *values, int n)
{
  qsort(values, (size_t)n, sizeof *values, compare);
  return n == 0 ? NAN : values[(n - 1) / 2]; /* as in the table that bench prints */
}

/* All runs of the method that the run at `first` names. */
static void gather(const json_t *runs, size_t first, method_row *row)
{
  row->name = hl_json_text_of(json_array_get(runs, first), "method");
  row->n = row->found = 0;
  for (size_t i = first; i < json_array_size(runs); i++) {
    const json_t *run = json_array_get(runs, i);
    if (strcmp(hl_json_text_of(run, "method"), row->name) != 0)
      continue;
    const double error = hl_json_double(run, "error_deg"), ms = hl_json_double(run, "time_ms");
    const bool found = hl_json_is_true(run, "found") && isfinite(error);
    row->error_deg[row->n] = found ? error : 90;
    row->time_ms[row->n] = isfinite(ms) ? ms : 0;
    row->found += found;
    row->n++;
  }
}

static bool is_first(const json_t *runs, size_t place)
{
  const char *name = hl_json_text_of(json_array_get(runs, place), "method");
  for (size_t i = 0; i < place; i++)
    if (strcmp(hl_json_text_of(json_array_get(runs, i), "method"), name) == 0)
      return false;
  return true;
}

static void put_methods(hl_page *page, const json_t *runs, method_row *row)
{
  static const char *const columns[] = {"Method", "Found", "Median error [deg]", "Worst [deg]",
                                        "Median time [ms]"};
  hl_page_heading(page, "Methods");
  hl_page_table_begin(page, columns, 5, 1);
  for (size_t i = 0; i < json_array_size(runs); i++) {
    if (!is_first(runs, i))
      continue;
    gather(runs, i, row);
    const double middle = median(row->error_deg, row->n);
    hl_page_row_begin(page, false, row->name);
    hl_page_cell(page, "Found", true, "%d of %d", row->found, row->n);
    hl_page_cell(page, "Median error [deg]", true, "%.3f", middle);
    hl_page_cell(page, "Worst [deg]", true, "%.3f", row->error_deg[row->n - 1]);
    hl_page_cell(page, "Median time [ms]", true, "%.3g", median(row->time_ms, row->n));
    hl_page_row_end(page);
  }
  hl_page_table_end(page);
}

hl_status hl_report_bench(hl_ctx *ctx, const hl_report_source *source, hl_page *page)
{
  const json_t *d = source->document, *runs = json_object_get(d, "runs");
  const json_t *machine = json_object_get(d, "machine");
  if (!json_is_array(runs))
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: runs is no list", source->path);
  const size_t room = json_array_size(runs) + 1;
  method_row row = {.error_deg = calloc(room, sizeof(double)),
                    .time_ms = calloc(room, sizeof(double))};
  hl_status st = HL_OK;
  if (row.error_deg && row.time_ms) {
    hl_page_element(page, "h1", NULL, "Benchmark");
    hl_page_element(
        page, "p", NULL,
        "Error of the light against the run time of its estimate, on recorded frames of "
        "known light. A scene without an answer counts as 90 degrees.");
    hl_page_picture(page, "bench");
    hl_page_no_pictures(page, "halflight bench --out DIR");
    put_methods(page, runs, &row);
    hl_page_heading(page, "Where it ran");
    hl_page_facts_begin(page);
    hl_page_fact(page, "halflight", "%s", hl_json_text_of(d, "halflight"));
    hl_page_fact(page, "System", "%s %s, %s, %.0f processors", hl_json_text_of(machine, "system"),
                 hl_json_text_of(machine, "release"), hl_json_text_of(machine, "processor"),
                 hl_json_double(machine, "processors"));
    hl_page_facts_end(page);
  } else {
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d runs", (int)room);
  }
  free(row.error_deg);
  free(row.time_ms);
  return st;
}
