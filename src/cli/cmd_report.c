/* report: what a verb found, as one page to look at. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "commands.h"
#include "halflight/halflight.h"
#include "halflight/info.h"
#include "options.h"
#include "outputs.h"
#include "report.h"
#include "report_template.h"

typedef struct report_args {
  const char *folder, *out;
} report_args;

#define AT(member) offsetof(report_args, member)

static const hl_operand operands[] = {
    {"DIR", "a folder that estimate, replay, fit, calibrate, drift or bench wrote", AT(folder),
     HL_OPERAND_NEEDED},
};

static const hl_option options[] = {
    {"out", "FILE.html", "Output", "the page; always needed", AT(out), 0, 0},
};

/* In the order in which a folder that holds several is searched. */
static const struct kind {
  const char *file, *format, *title;
  int newest;
  hl_report_write *write;
} kinds[] = {
    {"lights.json", "halflight-lights", "Lights of a session", 1, hl_report_session},
    {"light.json", "halflight-light", "Light of one frame", 1, hl_report_frame},
    {"fit.json", "halflight-fit", "Reflectance fit", 1, hl_report_fit},
    {"drift.json", "halflight-drift", "Drift check", 1, hl_report_drift},
    {"bench.json", "halflight-bench", "Benchmark", 1, hl_report_bench},
    {"camera.json", "halflight-camera", "Camera calibration", 1, hl_report_calibration},
};
enum { KINDS = sizeof kinds / sizeof *kinds };

typedef struct report_run {
  const report_args *args;
  const struct kind *kind;
  char path[HL_EVIDENCE_PATH_MAX], evidence_path[HL_EVIDENCE_PATH_MAX];
  json_t *document, *evidence;
  hl_evidence drawn;
  hl_outputs outputs;
  int out_at;
} report_run;

static bool exists(const char *path)
{
  struct stat at;
  return stat(path, &at) == 0;
}

static hl_status find_document(hl_ctx *ctx, report_run *r)
{
  const char *folder = r->args->folder;
  struct stat at;
  if (strlen(folder) > HL_EVIDENCE_PATH_MAX - 64)
    return hl_fail(ctx, HL_ERR_IO, "%.40s...: the name is too long", folder);
  if (stat(folder, &at) != 0)
    return hl_fail(ctx, HL_ERR_IO, "%s: there is no such folder", folder);
  if (!S_ISDIR(at.st_mode))
    return hl_fail(ctx, HL_ERR_IO, "%s: is no folder; the one that holds the result is needed",
                   folder);
  for (int i = 0; i < KINDS; i++) {
    snprintf(r->path, sizeof r->path, "%.4100s/%s", folder, kinds[i].file);
    if (!exists(r->path))
      continue;
    r->kind = kinds + i;
    snprintf(r->evidence_path, sizeof r->evidence_path, "%.4100s/evidence.json", folder);
    return HL_OK;
  }
  return hl_fail(ctx, HL_ERR_FORMAT,
                 "%s: holds none of lights.json, light.json, fit.json, drift.json, bench.json and "
                 "camera.json; a folder that a verb wrote with --out is needed",
                 folder);
}

/* A JSON object of that format, in a version that is known. */
static hl_status read_json(hl_ctx *ctx, const char *path, const char *format, int newest,
                           json_t **out)
{
  json_error_t error;
  json_t *d = json_load_file(path, JSON_REJECT_DUPLICATES, &error);
  hl_status st = HL_OK;
  if (!d && error.line < 0)
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot be read: %s", path, error.text);
  if (!d)
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: line %d is no JSON: %s", path, error.line, error.text);
  const char *is = hl_json_text_of(d, "format");
  const json_t *version = json_object_get(d, "version");
  if (strcmp(is, format) != 0)
    st = hl_fail(ctx, HL_ERR_FORMAT, "%s: format is '%.40s'; '%s' is needed", path, is, format);
  else if (!json_is_integer(version) || json_integer_value(version) < 1)
    st = hl_fail(ctx, HL_ERR_FORMAT, "%s: version is missing; a number from 1 to %d is needed",
                 path, newest);
  else if (json_integer_value(version) > newest)
    st = hl_fail(ctx, HL_ERR_FORMAT, "%s: version is %lld; this halflight reads up to %d", path,
                 (long long)json_integer_value(version), newest);
  if (st == HL_OK)
    *out = d;
  else
    json_decref(d);
  return st;
}

/* Evidence of another document, left there by an earlier run of another verb, is none. */
static hl_status read_evidence(hl_ctx *ctx, report_run *r)
{
  if (!exists(r->evidence_path))
    return HL_OK;
  hl_status st = read_json(ctx, r->evidence_path, "halflight-evidence", 1, &r->evidence);
  if (st == HL_OK)
    st = hl_evidence_check(ctx, r->evidence_path, r->evidence);
  if (st == HL_OK && strcmp(hl_json_text_of(r->evidence, "of"), r->kind->file) != 0) {
    json_decref(r->evidence);
    r->evidence = NULL;
  }
  return st;
}

static void put_foot(hl_page *page, const report_run *r)
{
  fputs("<p class=\"quiet foot\">", page->out);
  hl_page_printf(page, "Made by halflight %s from ", hl_version());
  hl_page_text(page, r->args->folder); /* of any length, and may be called nan */
  hl_page_printf(page, "/%s.", r->kind->file);
  fputs("</p>\n", page->out);
}

static hl_status put_body(hl_ctx *ctx, report_run *r, FILE *out)
{
  hl_page page = {.out = out, .evidence = r->evidence};
  const hl_report_source source = {r->args->folder, r->path, r->document, &r->drawn};
  const hl_status st = r->kind->write(ctx, &source, &page);
  put_foot(&page, r);
  return st;
}

/* The template with its four places filled. */
static hl_status put_page(hl_ctx *ctx, report_run *r, FILE *out)
{
  const char *at = hl_report_html;
  hl_status st = HL_OK;
  while (st == HL_OK && *at) {
    const char *open = strstr(at, "{{");
    if (!open) {
      fputs(at, out);
      break;
    }
    fwrite(at, 1, (size_t)(open - at), out);
    if (strncmp(open, "{{title}}", 9) == 0)
      fprintf(out, "%s - halflight", r->kind->title);
    else if (strncmp(open, "{{css}}", 7) == 0)
      fputs(hl_report_css, out);
    else if (strncmp(open, "{{js}}", 6) == 0)
      fputs(hl_report_js, out);
    else
      st = put_body(ctx, r, out);
    at = strstr(open, "}}") + 2;
  }
  return st;
}

static hl_status write_page(hl_ctx *ctx, report_run *r)
{
  const char *stage = r->outputs.stage[r->out_at];
  FILE *f = fopen(stage, "w");
  if (!f)
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot be written", stage);
  hl_status st = put_page(ctx, r, f);
  const bool failed = ferror(f) != 0;
  if ((fclose(f) != 0 || failed) && st == HL_OK)
    st = hl_fail(ctx, HL_ERR_IO, "%s: cannot be written", stage);
  return st;
}

/* The page must not take the place of what it is made from. */
static hl_status check_out(hl_ctx *ctx, const report_run *r)
{
  const char *const read[] = {r->path, r->evidence_path};
  struct stat out, in;
  if (stat(r->args->out, &out) != 0)
    return HL_OK;
  for (int i = 0; i < 2; i++)
    if (stat(read[i], &in) == 0 && in.st_dev == out.st_dev && in.st_ino == out.st_ino)
      return hl_fail(ctx, HL_ERR_ARG,
                     "--out %.200s: is what the page is made from; another name is needed",
                     r->args->out);
  return HL_OK;
}

static hl_status make(hl_ctx *ctx, report_run *r)
{
  if (!r->args->out)
    return hl_fail(ctx, HL_ERR_ARG, "--out is missing; --out FILE.html is needed");
  hl_status st = hl_outputs_add(ctx, &r->outputs, NULL, r->args->out, &r->out_at);
  if (st == HL_OK)
    st = find_document(ctx, r);
  if (st == HL_OK)
    st = check_out(ctx, r);
  if (st == HL_OK)
    st = read_json(ctx, r->path, r->kind->format, r->kind->newest, &r->document);
  if (st == HL_OK)
    st = read_evidence(ctx, r);
  if (st == HL_OK)
    st = hl_evidence_begin(ctx, &r->drawn, r->kind->file, r->outputs.stage[r->out_at]);
  if (st == HL_OK)
    st = write_page(ctx, r);
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, &r->outputs);
  return st;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  report_run *r = calloc(1, sizeof *r);
  if (!r)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  r->args = args;
  const hl_status st = make(ctx, r);
  hl_outputs_end(ctx, &r->outputs);
  hl_evidence_free(&r->drawn);
  json_decref(r->evidence);
  json_decref(r->document);
  free(r);
  return st;
}

const hl_command hl_command_report = {
    .name = "report",
    .sentence = "Write what a verb found as one page to look at.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "The page holds all it needs and asks no network for anything. It shows what DIR\n"
             "holds: pictures come from evidence.json, which estimate, drift and bench write\n"
             "with --out DIR, and fit and calibrate with --out DIR/ (with the slash).\n"
             "Exit status: 0 done, 1 failed, 2 wrong usage.",
    .example = "  $ halflight estimate frame.pfm --camera camera.json --radius-m 0.02 --out seen\n"
               "  ...\n"
               "  $ halflight report seen --out seen/report.html",
    .size = sizeof(report_args),
    .run = run,
};
