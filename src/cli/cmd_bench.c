/* bench: light error against run time, and how the estimate bears extreme scenes. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench_measure.h"
#include "bench_stability.h"
#include "commands.h"
#include "evidence_charts.h"
#include "options.h"
#include "outputs.h"

typedef struct bench_args {
  hl_words folders;
  bool stability, fast, json;
  int repeats;
  const char *out, *plot;
} bench_args;

#define AT(member) offsetof(bench_args, member)

static const hl_operand operands[] = {
    {"FOLDER", "recorded frames with truth.json (default: all in fixtures/)", AT(folders),
     HL_OPERAND_MANY},
};

static const hl_field_table *repeat_fields(void)
{
  static const hl_field fields[] = {
      {"repeats", HL_FIELD_INT, 0, 1, HL_BENCH_REPEATS_MAX, "",
       "runs of each method on each scene, whose median time counts", NULL},
  };
  static const hl_field_table table = {"bench", fields, 1};
  return &table;
}

static void defaults(void *args)
{
  ((bench_args *)args)->repeats = 5;
}

static const hl_option options[] = {
    {"stability", NULL, "What is run",
     "extreme scenes drawn in memory: error, condition, iterations and status of each",
     AT(stability), 0, 0},
    {"fast", NULL, NULL, "with --stability: leave out balls above 100 px radius", AT(fast), 0, 0},
    {"repeats", "N", NULL, NULL, AT(repeats), repeat_fields, 0},
    {"out", "DIR", "Output", "write bench.json and evidence.json, or stability.md, there", AT(out),
     0, 0},
    {"json", NULL, NULL, "print every scene and method as JSON and nothing else", AT(json), 0, 0},
    {"plot", "FILE", NULL, "error against time: .png, .svg or .pdf", AT(plot), 0, 0},
};

static hl_status write_table(hl_ctx *ctx, const char *path, const hl_stability *cases, int n)
{
  FILE *f = fopen(path, "w");
  if (!f)
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot be written", path);
  hl_stability_print(f, cases, n);
  const bool failed = ferror(f) != 0;
  return fclose(f) != 0 || failed ? hl_fail(ctx, HL_ERR_IO, "%s: cannot be written", path) : HL_OK;
}

static hl_status report(hl_ctx *ctx, const bench_args *a, const hl_stability *cases, int n)
{
  hl_outputs outputs = {0};
  int at = -1;
  hl_status st = HL_OK;
  if (a->out) {
    st = hl_outputs_folder(ctx, &outputs, a->out);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, &outputs, a->out, "stability.md", &at);
    if (st == HL_OK)
      st = hl_outputs_begin(ctx, &outputs);
    if (st == HL_OK)
      st = write_table(ctx, outputs.stage[at], cases, n);
  }
  if (st == HL_OK)
    hl_stability_print(stdout, cases, n);
  if (st == HL_OK)
    st = hl_outputs_print(ctx);
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, &outputs);
  hl_outputs_end(ctx, &outputs);
  return st;
}

enum { FOLDERS_MAX = 256, FOLDER_BYTES = 512 };

typedef struct folder_list {
  int n;
  char text[FOLDERS_MAX][FOLDER_BYTES];
  const char *path[FOLDERS_MAX];
} folder_list;

static int by_name(const void *a, const void *b)
{
  return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* Those of fixtures/ that hold a ball and the truth of its light. */
static void find_folders(folder_list *list)
{
  DIR *dir = opendir("fixtures");
  const struct dirent *e;
  while (dir && list->n < FOLDERS_MAX && (e = readdir(dir))) {
    char truth[FOLDER_BYTES + 16], ball[FOLDER_BYTES + 16];
    snprintf(list->text[list->n], FOLDER_BYTES, "fixtures/%s", e->d_name);
    snprintf(truth, sizeof truth, "%s/truth.json", list->text[list->n]);
    snprintf(ball, sizeof ball, "%s/sphere.json", list->text[list->n]);
    if (e->d_name[0] == '.' || access(truth, R_OK) != 0 || access(ball, R_OK) != 0)
      continue;
    list->path[list->n] = list->text[list->n];
    list->n++;
  }
  if (dir)
    closedir(dir);
  qsort(list->path, (size_t)list->n, sizeof *list->path, by_name);
}

static hl_status write_json(hl_ctx *ctx, const char *path, const char *text)
{
  FILE *f = fopen(path, "w");
  const bool failed = !f || fputs(text, f) < 0 || fputc('\n', f) == EOF;
  return (f && fclose(f) != 0) || failed ? hl_fail(ctx, HL_ERR_IO, "%s: cannot be written", path)
                                         : HL_OK;
}

static hl_status write_results(hl_ctx *ctx, const bench_args *a, const hl_bench_table *table,
                               hl_outputs *outputs, const int at[3], hl_picture_kind kind)
{
  char *text = NULL;
  hl_status st = hl_bench_json(ctx, table, &text);
  if (st == HL_OK)
    st = hl_outputs_begin(ctx, outputs);
  if (st == HL_OK && at[0] >= 0)
    st = write_json(ctx, outputs->stage[at[0]], text);
  if (st == HL_OK && at[1] >= 0)
    st = hl_draw_bench(ctx, kind, outputs->stage[at[1]], table);
  if (st == HL_OK && at[2] >= 0)
    st = hl_evidence_of_bench(ctx, outputs->stage[at[2]], table);
  if (st == HL_OK && a->json)
    puts(text);
  else if (st == HL_OK)
    hl_bench_print(stdout, table);
  free(text);
  if (st == HL_OK)
    st = hl_outputs_print(ctx);
  return st == HL_OK ? hl_outputs_commit(ctx, outputs) : st;
}

/* Outputs are planned first: what could not be written is said before the work. */
static hl_status compare(hl_ctx *ctx, const bench_args *a, const char *const *folders, int n)
{
  hl_outputs outputs = {0};
  hl_bench_table table = {0};
  hl_picture_kind kind = HL_PICTURE_PNG;
  int at[3] = {-1, -1, -1};
  hl_status st = a->plot ? hl_picture_kind_of(ctx, "plot", a->plot, &kind) : HL_OK;
  if (st == HL_OK && a->out)
    st = hl_outputs_folder(ctx, &outputs, a->out);
  if (st == HL_OK && a->out)
    st = hl_outputs_add(ctx, &outputs, a->out, "bench.json", &at[0]);
  if (st == HL_OK && a->out)
    st = hl_outputs_add(ctx, &outputs, a->out, "evidence.json", &at[2]);
  if (st == HL_OK && a->plot)
    st = hl_outputs_add(ctx, &outputs, NULL, a->plot, &at[1]);
  if (st == HL_OK)
    st = hl_bench_measure(ctx, folders, n, a->repeats, &table);
  if (st == HL_OK)
    st = write_results(ctx, a, &table, &outputs, at, kind);
  hl_outputs_end(ctx, &outputs);
  hl_bench_table_free(&table);
  return st;
}

static hl_status run_comparison(hl_ctx *ctx, const bench_args *a)
{
  if (a->folders.n > 0)
    return compare(ctx, a, a->folders.word, a->folders.n);
  folder_list *list = calloc(1, sizeof *list);
  if (!list)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the folders");
  find_folders(list);
  const hl_status st =
      list->n > 0 ? compare(ctx, a, list->path, list->n)
                  : hl_fail(ctx, HL_ERR_ARG,
                            "no FOLDER given, and ./fixtures holds none with a truth.json; name "
                            "folders of recorded frames, or use --stability");
  free(list);
  return st;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  const bench_args *a = args;
  if (!a->stability)
    return a->fast ? hl_fail(ctx, HL_ERR_ARG, "--fast goes with --stability only")
                   : run_comparison(ctx, a);
  if (a->folders.n > 0 || a->json || a->plot)
    return hl_fail(ctx, HL_ERR_ARG,
                   "--stability draws its own scenes; FOLDER, --json and --plot "
                   "belong to the comparison");
  hl_stability *cases = calloc(HL_STABILITY_MAX, sizeof *cases);
  int n = 0;
  hl_status st = cases ? hl_stability_run(ctx, a->fast, cases, &n)
                       : hl_fail(ctx, HL_ERR_MEMORY, "no memory for the cases");
  if (st == HL_OK)
    st = report(ctx, a, cases, n);
  if (st == HL_OK)
    st = hl_stability_check(ctx, cases, n);
  free(cases);
  return st;
}

const hl_command hl_command_bench = {
    .name = "bench",
    .sentence = "Measure light error against run time, and extreme scenes.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes =
        "Exit status: 0 done, 1 failed, 2 wrong usage, 3 a case is wrong and called ok, or too "
        "few are.",
    .example = "  $ halflight bench ball\n"
               "  1 scene; error of the light [deg], processor time ...\n"
               "  ...",
    .size = sizeof(bench_args),
    .defaults = defaults,
    .run = run,
};
