/* replay: a recorded session to the lights of its rig. */
#define _XOPEN_SOURCE 700 // NOLINT(bugprone-reserved-identifier)
#include <dirent.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"
#include "halflight/halflight.h"
#include "inputs.h"
#include "options.h"
#include "outputs.h"
#include "progress.h"
#include "summary.h"

typedef struct replay_args {
  const char *session, *out;
  bool json;
  hl_replay_settings settings;
} replay_args;

#define AT(member) offsetof(replay_args, member)

static const hl_operand operands[] = {
    {"SESSION", "folder with session.json and its frames", AT(session), HL_OPERAND_NEEDED},
};

static const hl_option options[] = {
    {"jobs", "N", "Work", NULL, AT(settings), hl_replay_fields, 0},
    {"pose-frames", "N", NULL, NULL, AT(settings), hl_replay_fields, 0},
    {"pixels", "N", NULL, NULL, AT(settings.light), hl_light_fields, 0},
    {"no-joint", NULL, NULL, "keep the pose that the outlines give", AT(settings.no_joint), 0, 0},
    {"frame-by-frame", NULL, NULL, "nothing is shared: each frame has its own outline's pose",
     AT(settings.frame_by_frame), 0, 0},
    {"json", NULL, "Output", "print lights.json on stdout and nothing else", AT(json), 0, 0},
    {"out", "DIR", NULL, "frames/, lights.json, lights.csv and lights.lp; always needed", AT(out),
     0, 0},
};

static void defaults(void *args)
{
  replay_args *a = args;
  a->settings = hl_replay_defaults();
}

typedef struct replay_run {
  const replay_args *args;
  hl_session session;
  hl_lights lights;
  hl_replay_summary summary;
  hl_outputs outputs;
  int json_at, csv_at, lp_at;
  double ms;
} replay_run;

static volatile sig_atomic_t interrupted;

static void interrupt(int signal)
{
  (void)signal;
  interrupted = 1;
}

static bool stop(void *user)
{
  (void)user;
  return interrupted != 0;
}

static void progress(void *user, int done, int total)
{
  hl_progress_on(user, done, total, "frames");
}

static hl_status plan_outputs(hl_ctx *ctx, replay_run *r)
{
  const char *out = r->args->out;
  if (!out)
    return hl_fail(ctx, HL_ERR_ARG, "--out is missing; --out DIR is needed");
  hl_outputs *o = &r->outputs;
  hl_status st = hl_outputs_folder(ctx, o, out);
  if (st == HL_OK)
    st = hl_outputs_add(ctx, o, out, "lights.json", &r->json_at);
  if (st == HL_OK)
    st = hl_outputs_add(ctx, o, out, "lights.csv", &r->csv_at);
  if (st == HL_OK)
    st = hl_outputs_add(ctx, o, out, "lights.lp", &r->lp_at);
  return st;
}

/* What a killed run left half written, by the names it gave: NAME.PID-I.tmp and NAME.part-PID. */
static bool is_left_over(const char *name)
{
  const size_t n = strlen(name);
  const char *part = strstr(name, ".part-");
  if (strncmp(name, "lights.", 7) == 0 && part && part[6] &&
      strspn(part + 6, "0123456789-.tmp") == strlen(part + 6))
    return true;
  return n > 10 && strcmp(name + n - 4, ".tmp") == 0 && strspn(name, "0123456789") == 5 &&
         strncmp(name + 5, ".json.", 6) == 0;
}

static void sweep(const char *folder)
{
  char path[2 * HL_OUTPUT_PATH_MAX];
  DIR *d = opendir(folder);
  for (struct dirent *e; d && (e = readdir(d));) {
    if (!is_left_over(e->d_name))
      continue;
    snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
    unlink(path);
  }
  if (d)
    closedir(d);
}

static void sweep_all(const char *folder)
{
  char frames[HL_OUTPUT_PATH_MAX + 8];
  snprintf(frames, sizeof frames, "%s/frames", folder);
  sweep(folder);
  sweep(frames);
}

static hl_status print_result(hl_ctx *ctx, const replay_run *r)
{
  const hl_lights *l = &r->lights;
  if (r->args->json) {
    char *text = NULL;
    const hl_status st = hl_lights_json(ctx, l, &text);
    if (st == HL_OK)
      fputs(text, stdout);
    free(text);
    return st;
  }
  int found = 0, trusted = 0;
  for (int i = 0; i < l->n; i++) {
    found += l->light[i].found;
    trusted += l->light[i].found && l->light[i].trusted;
  }
  printf("lights        %d of %d frames, %d to be trusted\n", found, l->n, trusted);
  hl_summary_dome(stdout, l);
  hl_summary_notes(stdout, "used", &l->used);
  hl_summary_notes(stdout, "left out", &l->left_out);
  printf("time          %.1f s, %.1f frames/s (%d reused)\n", 1e-3 * r->ms,
         r->ms > 0 ? 1e3 * l->n / r->ms : 0, r->summary.n_reused);
  return HL_OK;
}

static bool any_found(const hl_lights *l)
{
  for (int i = 0; i < l->n; i++)
    if (l->light[i].found)
      return true;
  return false;
}

static hl_status write_and_print(hl_ctx *ctx, replay_run *r)
{
  hl_outputs *o = &r->outputs;
  const char *const *stage = (const char *const *)(const char *[]){
      o->stage[r->json_at], o->stage[r->csv_at], o->stage[r->lp_at]};
  o->folder[0] = '\0'; /* it is there: the frames are in it */
  hl_status st = hl_lights_write(ctx, stage[0], &r->lights);
  if (st == HL_OK)
    st = hl_lights_csv_write(ctx, stage[1], &r->lights);
  if (st == HL_OK)
    st = hl_lights_lp_write(ctx, stage[2], &r->lights);
  if (st == HL_OK)
    st = print_result(ctx, r);
  if (st == HL_OK)
    st = hl_outputs_print(ctx);
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, o);
  hl_outputs_end(ctx, o);
  return st;
}

static hl_status report(hl_ctx *ctx, replay_run *r)
{
  const replay_args *a = r->args;
  char reasons[HL_MESSAGE_MAX];
  if (r->summary.stopped)
    return hl_fail(ctx, HL_ERR_IO,
                   "interrupted; finished frames are in %s/frames: the same command goes on from "
                   "there",
                   a->out);
  hl_summary_reasons(&r->lights.reasons, reasons, sizeof reasons);
  if (!any_found(&r->lights))
    return hl_fail(ctx, HL_ERR_DEGENERATE, "%s: no frame gave a light: %s", a->session, reasons);
  const hl_status st = write_and_print(ctx, r);
  if (st != HL_OK || r->lights.trusted)
    return st;
  return hl_fail(ctx, HL_ERR_RESIDUAL, "%s: not all to be trusted: %s", a->session, reasons);
}

/* Frames of one size come and go: their memory stays with the process rather than being mapped, cleared
 * and unmapped for each. */
static void keep_memory(void)
{
#ifdef __GLIBC__
  enum { LARGEST = 1 << 25 };
  mallopt(M_MMAP_THRESHOLD, LARGEST);
  mallopt(M_TRIM_THRESHOLD, 4 * LARGEST);
#endif
}

static hl_status replay(hl_ctx *ctx, replay_run *r)
{
  /* standard error is held back for as long as some frame is decoded: the bar has its own */
  const int copy = dup(STDERR_FILENO);
  FILE *bar = copy >= 0 ? fdopen(copy, "w") : NULL;
  const hl_replay_watch watch = {progress, stop, bar};
  struct sigaction act, old_int, old_term;
  memset(&act, 0, sizeof act);
  act.sa_handler = interrupt;
  interrupted = 0;
  keep_memory();
  sigaction(SIGINT, &act, &old_int);
  sigaction(SIGTERM, &act, &old_term);
  const double start = hl_inputs_clock_ms();
  const hl_status st = hl_replay(ctx, &r->session, r->args->out, &r->args->settings, &watch,
                                 &r->summary, &r->lights);
  r->ms = hl_inputs_clock_ms() - start;
  hl_progress_on(bar, 1, 1, ""); /* the bar goes */
  if (bar)
    fclose(bar);
  else if (copy >= 0)
    close(copy);
  sigaction(SIGINT, &old_int, NULL);
  sigaction(SIGTERM, &old_term, NULL);
  return st;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  replay_run *r = calloc(1, sizeof *r);
  if (!r)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  r->args = args;
  hl_status st = plan_outputs(ctx, r);
  if (st == HL_OK)
    st = hl_session_read(ctx, r->args->session, &r->session);
  if (st == HL_OK) {
    sweep_all(r->args->out);
    st = replay(ctx, r);
  }
  if (st == HL_OK)
    st = report(ctx, r);
  hl_lights_free(&r->lights);
  hl_session_free(&r->session);
  free(r);
  return st;
}

const hl_command hl_command_replay = {
    .name = "replay",
    .sentence = "Find the lights of a rig from a recorded session.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "A frame that is missing, broken or dark is named and skipped. A run that was "
             "interrupted goes\non with the same command; results do not depend on it, nor on "
             "--jobs.\n"
             "Exit status: 0 every frame gave a light to be trusted, 1 failed or interrupted, 2 "
             "wrong usage,\n3 some frames did not (the others' lights are written).",
    .example = "  $ halflight replay session --out replayed\n"
               "  lights        1 of 1 frames, 1 to be trusted\n"
               "  ...",
    .size = sizeof(replay_args),
    .defaults = defaults,
    .run = run,
};
