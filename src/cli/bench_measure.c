/* Times are of the step from a frame in memory to a direction, on one thread. */
#include "bench_measure.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "halflight/vec3.h"
#include "inputs.h"
#include "progress.h"

enum { REPEATS = 5 };

static const double LONG_MS = 150; /* repeats end once they have taken this long */

static const double NO_ANSWER_DEG = 90;
static const double DEGREES = 180 / 3.14159265358979323846;

static int ascending(const void *a, const void *b)
{
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static hl_bench_result measure(const hl_bench_scene *scene, const hl_bench_method *method)
{
  hl_bench_result out = {.trusted = true};
  double light[3] = {0}, times[REPEATS] = {0}, cross[3];
  double spent = 0;
  int n = 0;
  for (int k = -1; k < REPEATS && (n == 0 || spent < LONG_MS); k++) {
    const double start = hl_inputs_clock_ms();
    out.found = method->run(scene, method, light, &out.trusted);
    if (k < 0)
      continue;
    times[n] = hl_inputs_clock_ms() - start;
    spent += times[n++];
  }
  qsort(times, (size_t)n, sizeof *times, ascending);
  out.time_ms = times[n / 2];
  hl_cross(light, scene->light, cross);
  out.error_deg =
      out.found ? atan2(hl_norm(cross), hl_dot(light, scene->light)) * DEGREES : NO_ANSWER_DEG;
  return out;
}

/* `share` of the sorted values lie at or below. */
static double quantile(const double *sorted, int n, double share)
{
  const int at = (int)ceil(share * n) - 1;
  return sorted[at < 0 ? 0 : at];
}

static void summarize(const hl_bench_table *t, int m, double *errors, double *times)
{
  hl_bench_row *row = t->row + m;
  *row = (hl_bench_row){.method = hl_bench_methods + m};
  for (int i = 0; i < t->n_scenes; i++) {
    const hl_bench_result *r = t->result + (size_t)m * (size_t)t->n_scenes + i;
    errors[i] = r->error_deg;
    times[i] = r->time_ms;
    row->found += r->found;
  }
  qsort(errors, (size_t)t->n_scenes, sizeof *errors, ascending);
  qsort(times, (size_t)t->n_scenes, sizeof *times, ascending);
  row->median_deg = quantile(errors, t->n_scenes, 0.5);
  row->high_deg = quantile(errors, t->n_scenes, 0.9);
  row->worst_deg = errors[t->n_scenes - 1];
  row->time_ms = quantile(times, t->n_scenes, 0.5);
}

static void mark_front(hl_bench_row *row)
{
  for (int i = 0; i < hl_bench_methods_count; i++) {
    row[i].front = true;
    for (int k = 0; k < hl_bench_methods_count; k++)
      if (row[k].time_ms < row[i].time_ms && row[k].median_deg <= row[i].median_deg)
        row[i].front = false;
  }
}

hl_status hl_bench_measure(hl_ctx *ctx, const char *const *folders, int n, hl_bench_table *out)
{
  const size_t scenes = (size_t)n, methods = (size_t)hl_bench_methods_count;
  *out = (hl_bench_table){.n_scenes = n};
  out->scene = calloc(scenes, sizeof *out->scene);
  out->result = calloc(scenes * methods, sizeof *out->result);
  out->row = calloc(methods, sizeof *out->row);
  double *sorted = calloc(2 * scenes, sizeof *sorted);
  hl_status st = HL_OK;
  if (!out->scene || !out->result || !out->row || !sorted)
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d scenes", n);
  for (int i = 0; i < n && st == HL_OK; i++) {
    hl_bench_scene scene;
    st = hl_bench_scene_open(ctx, folders[i], &scene);
    /* NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): the status says there is memory */
    memcpy(out->scene[i], scene.name, sizeof scene.name);
    for (int m = 0; m < hl_bench_methods_count && st == HL_OK; m++) {
      hl_progress(i * hl_bench_methods_count + m, n * hl_bench_methods_count, "runs");
      /* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): the status says there is memory */
      out->result[(size_t)m * scenes + (size_t)i] = measure(&scene, hl_bench_methods + m);
    }
    hl_bench_scene_close(&scene);
  }
  hl_progress(1, 1, "runs");
  for (int m = 0; m < hl_bench_methods_count && st == HL_OK; m++)
    summarize(out, m, sorted, sorted + n);
  if (st == HL_OK)
    mark_front(out->row);
  free(sorted);
  return st;
}

void hl_bench_table_free(hl_bench_table *table)
{
  free(table->scene);
  free(table->result);
  free(table->row);
  *table = (hl_bench_table){0};
}

void hl_bench_print(FILE *out, const hl_bench_table *t)
{
  fprintf(out, "%d scenes; error of the light [deg], time of the estimate on one thread [ms]\n\n",
          t->n_scenes);
  fprintf(out, "%-30s %9s %9s %9s %10s %6s %s\n", "method", "median", "90 %", "worst", "time",
          "found", "front");
  for (int m = 0; m < hl_bench_methods_count; m++) {
    const hl_bench_row *r = t->row + m;
    fprintf(out, "%-30s %9.3f %9.3f %9.3f %10.3f %6d %s\n", r->method->name, r->median_deg,
            r->high_deg, r->worst_deg, r->time_ms, r->found, r->front ? "*" : "");
  }
}

static json_t *machine(void)
{
  struct utsname u;
  if (uname(&u) != 0)
    return json_object();
  return json_pack("{s:s, s:s, s:s, s:i}", "system", u.sysname, "release", u.release, "processor",
                   u.machine, "processors", (int)sysconf(_SC_NPROCESSORS_ONLN));
}

hl_status hl_bench_json(hl_ctx *ctx, const hl_bench_table *t, char **text)
{
  json_t *runs = json_array();
  for (int m = 0; m < hl_bench_methods_count; m++)
    for (int i = 0; i < t->n_scenes; i++) {
      const hl_bench_result *r = t->result + m * t->n_scenes + i;
      json_t *error = r->found ? json_real(r->error_deg) : json_null();
      json_array_append_new(runs, json_pack("{s:s, s:s, s:b, s:b, s:o, s:f}", "method",
                                            hl_bench_methods[m].name, "scene", t->scene[i], "found",
                                            r->found, "trusted", r->found && r->trusted,
                                            "error_deg", error, "time_ms", r->time_ms));
    }
  json_t *root = json_pack("{s:s, s:i, s:s, s:o, s:o}", "format", "halflight-bench", "version", 1,
                           "halflight", hl_version(), "machine", machine(), "runs", runs);
  *text = root ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(9)) : NULL;
  json_decref(root);
  return *text ? HL_OK : hl_fail(ctx, HL_ERR_MEMORY, "no memory for a document");
}
