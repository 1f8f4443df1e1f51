/* Times are of the step from a frame in memory to a direction, on one thread: processor time, which
 * others' work on the machine does not lengthen. */
#include "bench_measure.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <time.h>
#include <unistd.h>

#include "bench_ppr.h"
#include "halflight/vec3.h"
#include "progress.h"

static const double LONG_MS = 150; /* repeats end once they have taken this long */

static const double NO_ANSWER_DEG = 90;
static const double DEGREES = 180 / 3.14159265358979323846;

static int ascending(const void *a, const void *b)
{
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double clock_ms(void)
{
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static double error_of(const double light[3], const double truth[3])
{
  double cross[3];
  hl_cross(light, truth, cross);
  return atan2(hl_norm(cross), hl_dot(light, truth)) * DEGREES;
}

static hl_bench_result measure(const hl_bench_scene *scene, const hl_bench_method *method,
                               int repeats)
{
  hl_bench_result out = {.said = {true, 0}};
  double light[3] = {0}, times[HL_BENCH_REPEATS_MAX] = {0};
  double spent = 0;
  int n = 0;
  for (int k = repeats > 1 ? -1 : 0; k < repeats && (n == 0 || spent < LONG_MS); k++) {
    out.said = (hl_bench_said){true, 0};
    const double start = clock_ms();
    out.found = method->run(scene, method, light, &out.said);
    if (k < 0)
      continue;
    times[n] = clock_ms() - start;
    spent += times[n++];
  }
  qsort(times, (size_t)n, sizeof *times, ascending);
  out.time_ms = times[n / 2];
  out.error_deg = out.found ? error_of(light, scene->light) : NO_ANSWER_DEG;
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

static void mark_front(hl_bench_row *row, int n)
{
  for (int i = 0; i < n; i++) {
    row[i].front = true;
    for (int k = 0; k < n; k++)
      if (row[k].time_ms < row[i].time_ms && row[k].median_deg <= row[i].median_deg)
        row[i].front = false;
  }
}

/* The row of R's ppr, where R is there and answers. */
static void add_ppr(hl_ppr *ppr, hl_bench_table *out)
{
  hl_ppr_answer *answer = calloc((size_t)out->n_scenes, sizeof *answer);
  if (answer && hl_ppr_run(ppr, answer)) {
    hl_bench_result *r = out->result + (size_t)out->n_methods * (size_t)out->n_scenes;
    for (int i = 0; i < out->n_scenes; i++)
      r[i] = (hl_bench_result){.found = answer[i].found,
                               .said = {true, 0},
                               .time_ms = answer[i].time_ms,
                               .error_deg = answer[i].found
                                                ? error_of(answer[i].light, answer[i].truth)
                                                : NO_ANSWER_DEG};
    out->n_methods++;
  }
  free(answer);
}

hl_status hl_bench_measure(hl_ctx *ctx, const char *const *folders, int n, int repeats,
                           hl_bench_table *out)
{
  const size_t scenes = (size_t)n, methods = (size_t)hl_bench_methods_count;
  *out = (hl_bench_table){.n_scenes = n, .n_methods = hl_bench_methods_count - 1};
  out->scene = calloc(scenes, sizeof *out->scene);
  out->result = calloc(scenes * methods, sizeof *out->result);
  out->row = calloc(methods, sizeof *out->row);
  double *sorted = calloc(2 * scenes, sizeof *sorted);
  hl_ppr *ppr = hl_ppr_new();
  hl_status st = HL_OK;
  if (!out->scene || !out->result || !out->row || !sorted)
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d scenes", n);
  for (int i = 0; i < n && st == HL_OK; i++) {
    hl_bench_scene scene;
    st = hl_bench_scene_open(ctx, folders[i], &scene);
    /* NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): the status says there is memory */
    memcpy(out->scene[i], scene.name, sizeof scene.name);
    if (st == HL_OK)
      hl_ppr_add(ppr, &scene);
    for (int m = 0; m < out->n_methods && st == HL_OK; m++) {
      hl_progress(i * out->n_methods + m, n * out->n_methods, "runs");
      /* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): the status says there is memory */
      out->result[(size_t)m * scenes + (size_t)i] = measure(&scene, hl_bench_methods + m, repeats);
    }
    hl_bench_scene_close(&scene);
  }
  hl_progress(1, 1, "runs");
  if (st == HL_OK && n > 0)
    add_ppr(ppr, out);
  hl_ppr_free(ppr);
  for (int m = 0; m < out->n_methods && st == HL_OK; m++)
    summarize(out, m, sorted, sorted + n);
  if (st == HL_OK)
    mark_front(out->row, out->n_methods);
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

/* What a term costs scenes that do not need it: time of the estimate, which is the first method, over
 * that without it. */
static void print_terms(FILE *out, const hl_bench_table *t)
{
  double *ratio = calloc((size_t)t->n_scenes, sizeof *ratio);
  if (!ratio)
    return;
  fprintf(out, "\nterms, on scenes that do not need them\n%-30s %9s %9s\n", "term", "scenes",
          "time [%]");
  for (int m = 0; m < t->n_methods; m++) {
    const hl_bench_method *method = hl_bench_methods + m;
    const hl_bench_result *with = t->result, *without = t->result + m * t->n_scenes;
    int n = 0;
    if (strcmp(method->family, "term") != 0)
      continue;
    for (int i = 0; i < t->n_scenes; i++)
      if (!(with[i].said.used >> (unsigned)method->budget & 1) && without[i].time_ms > 0)
        ratio[n++] = with[i].time_ms / without[i].time_ms;
    qsort(ratio, (size_t)n, sizeof *ratio, ascending);
    if (n > 0)
      fprintf(out, "%-30s %9d %+9.1f\n", hl_light_term_name((hl_light_term)method->budget), n,
              100 * (quantile(ratio, n, 0.5) - 1));
  }
  free(ratio);
}

void hl_bench_print(FILE *out, const hl_bench_table *t)
{
  fprintf(
      out,
      "%d scene%s; error of the light [deg], processor time of the estimate on one thread [ms]; "
      "all in double precision, the only one there is\n\n",
      t->n_scenes, t->n_scenes == 1 ? "" : "s");
  fprintf(out, "%-30s %9s %9s %9s %10s %6s %s\n", "method", "median", "90 %", "worst", "time",
          "found", "front");
  for (int m = 0; m < t->n_methods; m++) {
    const hl_bench_row *r = t->row + m;
    fprintf(out, "%-30s %9.3f %9.3f %9.3f %10.3f %6d %s\n", r->method->name, r->median_deg,
            r->high_deg, r->worst_deg, r->time_ms, r->found, r->front ? "*" : "");
  }
  print_terms(out, t);
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
  for (int m = 0; m < t->n_methods; m++)
    for (int i = 0; i < t->n_scenes; i++) {
      const hl_bench_result *r = t->result + m * t->n_scenes + i;
      json_t *error = r->found ? json_real(r->error_deg) : json_null();
      json_array_append_new(runs, json_pack("{s:s, s:s, s:b, s:b, s:o, s:f}", "method",
                                            hl_bench_methods[m].name, "scene", t->scene[i], "found",
                                            r->found, "trusted", r->found && r->said.trusted,
                                            "error_deg", error, "time_ms", r->time_ms));
    }
  json_t *root = json_pack("{s:s, s:i, s:s, s:o, s:s, s:s, s:o}", "format", "halflight-bench",
                           "version", 1, "halflight", hl_version(), "machine", machine(), "clock",
                           "processor time of one thread", "precision", "double", "runs", runs);
  *text = root ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(9)) : NULL;
  json_decref(root);
  return *text ? HL_OK : hl_fail(ctx, HL_ERR_MEMORY, "no memory for a document");
}
