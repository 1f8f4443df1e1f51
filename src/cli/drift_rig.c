/* drift of two replayed sessions: read, compared, written. */
#include "drift_rig.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "evidence_charts.h"

enum { PATH_ROOM = 4200 };

typedef struct rig_command {
  const hl_drift_rig_args *args;
  hl_lights reference, current;
  hl_rig_drift drift;
  hl_outputs outputs;
} rig_command;

static bool is_folder(const char *path)
{
  struct stat about;
  return stat(path, &about) == 0 && S_ISDIR(about.st_mode);
}

static bool exists(const char *path)
{
  struct stat about;
  return stat(path, &about) == 0;
}

bool hl_drift_rig_is(const char *path)
{
  const char *slash = strrchr(path, '/');
  return is_folder(path) || strcmp(slash ? slash + 1 : path, "lights.json") == 0;
}

static hl_status read_lights(hl_ctx *ctx, const char *path, hl_lights *out)
{
  char name[PATH_ROOM];
  if (!is_folder(path))
    return hl_lights_read(ctx, path, out);
  if (strlen(path) > 4096)
    return hl_fail(ctx, HL_ERR_IO, "%.40s...: a path of over 4096 bytes", path);
  snprintf(name, sizeof name, "%s/session.json", path);
  const bool session = exists(name);
  snprintf(name, sizeof name, "%s/lights.json", path);
  if (exists(name) || !session)
    return hl_lights_read(ctx, name, out);
  return hl_fail(
      ctx, HL_ERR_FORMAT,
      "%s is a recorded session without lights.json; replay it first (halflight replay %s "
      "--out %.*s-lights), and compare the folders that replay wrote",
      path, path, (int)(strlen(path) - (path[strlen(path) - 1] == '/')), path);
}

/* Exit status 3 says drifted and nothing else; what could not be compared is a failure. */
static hl_status as_failure(hl_ctx *ctx, hl_status status)
{
  char text[HL_MESSAGE_MAX];
  if (hl_status_exit(status) != hl_status_exit(HL_ERR_RESIDUAL))
    return status;
  snprintf(text, sizeof text, "%s", ctx->msg);
  return hl_fail(ctx, HL_ERR_FORMAT, "%s", text);
}

static hl_status print_result(hl_ctx *ctx, const rig_command *c)
{
  char *text = NULL;
  if (!c->args->json) {
    hl_summary_rig_drift(stdout, &c->drift);
    return HL_OK;
  }
  const hl_status st = hl_rig_drift_json(ctx, &c->drift, &text);
  if (st == HL_OK)
    fputs(text, stdout);
  free(text);
  return st;
}

static hl_status write_document(hl_ctx *ctx, const rig_command *c, const char *path)
{
  char *text = NULL;
  hl_status st = hl_rig_drift_json(ctx, &c->drift, &text);
  if (st == HL_OK)
    st = hl_file_write(ctx, path, text, strlen(text));
  free(text);
  return st;
}

hl_status hl_drift_plan(hl_ctx *ctx, hl_outputs *outputs, const char *folder, int *document,
                        int *evidence)
{
  hl_status st = hl_outputs_folder(ctx, outputs, folder);
  if (st == HL_OK)
    st = hl_outputs_add(ctx, outputs, folder, "drift.json", document);
  return st == HL_OK ? hl_outputs_add(ctx, outputs, folder, "evidence.json", evidence) : st;
}

static hl_status write_and_print(hl_ctx *ctx, rig_command *c)
{
  hl_outputs *o = &c->outputs;
  hl_picture_kind kind = HL_PICTURE_PNG;
  char verdict[HL_MESSAGE_MAX];
  int at = -1, document_at = -1, evidence_at = -1;
  hl_summary_rig_verdict(&c->drift, verdict, sizeof verdict);
  hl_status st = HL_OK;
  if (c->args->picture) {
    st = hl_picture_kind_of(ctx, "picture", c->args->picture, &kind);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, o, NULL, c->args->picture, &at);
  }
  if (st == HL_OK && c->args->out)
    st = hl_drift_plan(ctx, o, c->args->out, &document_at, &evidence_at);
  if (st == HL_OK)
    st = hl_outputs_begin(ctx, o);
  if (st == HL_OK && document_at >= 0)
    st = write_document(ctx, c, o->stage[document_at]);
  if (st == HL_OK && evidence_at >= 0)
    st = hl_evidence_of_rig_drift(ctx, o->stage[evidence_at], &c->drift, &c->reference, verdict);
  if (st == HL_OK && at >= 0)
    st = hl_draw_rig_drift(ctx, kind, o->stage[at], &c->drift, &c->reference, verdict);
  if (st == HL_OK)
    st = print_result(ctx, c);
  if (st == HL_OK)
    st = hl_outputs_print(ctx);
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, o);
  hl_outputs_end(ctx, o);
  return st == HL_OK && c->drift.drifted ? hl_fail(ctx, HL_ERR_RESIDUAL, "%s", verdict) : st;
}

hl_status hl_drift_rig_run(hl_ctx *ctx, const hl_drift_rig_args *args)
{
  rig_command *c = calloc(1, sizeof *c);
  if (!c)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  c->args = args;
  hl_status st = read_lights(ctx, args->reference, &c->reference);
  if (st == HL_OK)
    st = read_lights(ctx, args->current, &c->current);
  if (st == HL_OK)
    st = hl_drift_rig(ctx, &c->reference, &c->current, &args->settings, &c->drift);
  st = as_failure(ctx, st);
  if (st == HL_OK)
    st = write_and_print(ctx, c);
  hl_rig_drift_free(&c->drift);
  hl_lights_free(&c->current);
  hl_lights_free(&c->reference);
  free(c);
  return st;
}
