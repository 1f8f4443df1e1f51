/* A session replayed: the common pose, all frames in parallel, then what they say together. */
#include "halflight/replay.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/notes.h"
#include "replay_work.h"

#ifdef _OPENMP
#include <omp.h>
#endif

static const double min_cos_view = 0.1;

enum { JOBS_MAX = 256, POSE_FRAMES = 64, NAMED_MAX = 6, REPLAY_PIXELS = 1000 };

hl_replay_settings hl_replay_defaults(void)
{
  hl_replay_settings s = {.pose_frames = POSE_FRAMES, .light = hl_light_defaults()};
  /* in one frame either looks like a ball that is a little off, and would hide what all of them say */
  s.light.pixels = REPLAY_PIXELS;
  s.light.without = 1u << HL_LIGHT_NEAR | 1u << HL_LIGHT_BACKSCATTER;
  return s;
}

const hl_field_table *hl_replay_fields(void)
{
  static const hl_field fields[] = {
      {"jobs", HL_FIELD_INT, offsetof(hl_replay_settings, jobs), 0, JOBS_MAX, "",
       "frames worked on at once, 0 for as many as the machine has; the result does not depend on "
       "it",
       NULL},
      {"pose_frames", HL_FIELD_INT, offsetof(hl_replay_settings, pose_frames), 1, 100000, "",
       "outlines read for the common pose, at most", NULL},
  };
  static const hl_field_table table = {"replay settings", fields, sizeof fields / sizeof *fields};
  return &table;
}

static hl_status prepare(hl_ctx *ctx, hl_replay_run *run)
{
  const hl_session *s = run->session;
  char *path = NULL;
  hl_status st = hl_fields_check(ctx, hl_replay_fields(), &run->settings);
  if (st == HL_OK)
    st = hl_fields_check(ctx, hl_light_fields(), &run->settings.light);
  if (st != HL_OK)
    return st;
  if (s->n < 1)
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: the session has no frames; at least 1 is needed",
                   s->folder);
  if (!s->camera || !s->camera[0])
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "%s: the session names no camera; \"camera\" in session.json is needed",
                   s->folder);
  run->settings.light.threads = 1;
  run->settings.light.budget_ms = 0; /* a result that depends on the clock does not repeat */
  run->n_balls = s->n_balls;
  run->frame = calloc((size_t)s->n, sizeof *run->frame);
  run->seen = calloc((size_t)s->n * (size_t)s->n_balls, sizeof *run->seen);
  if (!run->frame || !run->seen)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d frames", s->n);
  for (int i = 0; i < s->n; i++)
    run->frame[i].seen = run->seen + (ptrdiff_t)i * s->n_balls;
#ifdef _OPENMP
  run->jobs = run->settings.jobs > 0 ? run->settings.jobs : omp_get_max_threads();
#else
  run->jobs = 1;
#endif
  st = hl_session_path(ctx, s, s->camera, &path);
  if (st == HL_OK)
    st = hl_camera_read(ctx, path, &run->camera);
  free(path);
  return st;
}

static hl_status make_surfaces(hl_ctx *ctx, hl_replay_run *run)
{
  hl_status st = HL_OK;
  for (int b = 0; b < run->n_balls && st == HL_OK; b++)
    st = hl_surface_of_sphere(ctx, &run->camera, &run->ball[b].pose, min_cos_view,
                              &run->ball[b].surface);
  return st;
}

/* Under the lock: whether to go on. */
static bool account(hl_replay_run *run, const hl_ctx *fault, hl_status st, bool reused, bool failed)
{
  if (st != HL_OK) {
    run->fault = *fault;
    run->fault.status = st;
  }
  run->done++;
  run->reused += reused;
  run->failed += failed;
  if (run->watch && run->watch->progress)
    run->watch->progress(run->watch->user, run->done, run->session->n);
  return true;
}

static bool may_begin(hl_replay_run *run)
{
  if (!run->stopped && run->watch && run->watch->stop && run->watch->stop(run->watch->user))
    run->stopped = true;
  return !run->stopped && run->fault.status == HL_OK;
}

static void work_through(hl_replay_run *run, hl_replay_job *job)
{
#pragma omp for schedule(dynamic)
  for (int i = 0; i < run->session->n; i++) {
    bool go, reused = false;
    hl_ctx ctx = {0};
    pthread_mutex_lock(&run->guard);
    go = may_begin(run);
    pthread_mutex_unlock(&run->guard);
    if (!go)
      continue;
    const hl_status st = job ? hl_replay_one(&ctx, job, run, i, &reused)
                             : hl_fail(&ctx, HL_ERR_MEMORY, "no memory for a job of the replay");
    pthread_mutex_lock(&run->guard);
    account(run, &ctx, st, reused, !run->frame[i].light.found);
    pthread_mutex_unlock(&run->guard);
  }
}

static hl_status all_frames(hl_ctx *ctx, hl_replay_run *run)
{
#pragma omp parallel num_threads(run->jobs)
  {
    hl_replay_job *job = hl_replay_job_new();
    work_through(run, job);
    hl_replay_job_free(job);
  }
  return run->fault.status == HL_OK ? HL_OK : hl_fail(ctx, run->fault.status, "%s", run->fault.msg);
}

static hl_status copy_texts(hl_ctx *ctx, const hl_session_frame *f, hl_rig_light *out)
{
  out->file = strdup(f->file);
  out->label = strdup(f->label ? f->label : "");
  return out->file && out->label ? HL_OK : hl_fail(ctx, HL_ERR_MEMORY, "no memory for a name");
}

/* A line of `reasons` that counts frames and names the first few. */
static void name_frames(const hl_replay_run *run, hl_lights *out, const char *what, const char *why,
                        bool (*is)(const hl_replay_run *, const hl_rig_light *))
{
  char names[96] = "";
  int n = 0, named = 0;
  for (int i = 0; i < run->session->n; i++) {
    if (!is(run, &out->light[i]))
      continue;
    const size_t at = strlen(names);
    const char *file = run->session->frame[i].file;
    n++;
    if (named < NAMED_MAX && at + strlen(file) + 3 < sizeof names) {
      snprintf(names + at, sizeof names - at, "%s%s", at > 0 ? ", " : "", file);
      named++;
    }
  }
  if (n > 0)
    hl_notes_add(&out->reasons, what, "%d of %d frames %s: %s%s", n, run->session->n, why, names,
                 n == named  ? ""
                 : named > 0 ? ", ..."
                             : "...");
}

static bool is_without(const hl_replay_run *run, const hl_rig_light *l)
{
  (void)run;
  return !l->found;
}

static bool is_moved(const hl_replay_run *run, const hl_rig_light *l)
{
  for (int b = 0; b < run->n_balls; b++)
    if (run->frame[l->frame].seen[b].moved)
      return true;
  return false;
}

static bool is_untrusted(const hl_replay_run *run, const hl_rig_light *l)
{
  return l->found && !l->trusted && !is_moved(run, l);
}

static void describe(const hl_replay_run *run, hl_lights *out)
{
  name_frames(run, out, "frames", "gave no light", is_without);
  name_frames(run, out, "moved", "show the ball or the camera elsewhere", is_moved);
  name_frames(run, out, "lights", "are not to be trusted", is_untrusted);
  out->trusted = out->reasons.n == 0;
  for (int b = 0; b < run->n_balls; b++) {
    if (run->ball[b].given)
      hl_notes_add(&out->used, "pose", "ball %d: as its file states it", b);
    else if (run->settings.frame_by_frame)
      hl_notes_add(&out->used, "pose", "ball %d: of each frame's own outline", b);
    else
      hl_notes_add(&out->used, "pose", "ball %d: from the outlines of %d frames", b,
                   run->ball[b].n_outlines);
  }
}

static hl_status gather(hl_ctx *ctx, hl_replay_run *run, hl_lights *out)
{
  const hl_session *s = run->session;
  out->camera = run->camera;
  out->n_balls = run->n_balls;
  for (int b = 0; b < run->n_balls; b++)
    out->ball[b] = run->ball[b].pose;
  out->light = calloc((size_t)s->n, sizeof *out->light);
  if (!out->light)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d lights", s->n);
  hl_status st = HL_OK;
  for (int i = 0; i < s->n && st == HL_OK; i++) {
    out->n = i + 1;
    out->light[i] = run->frame[i].light;
    run->frame[i].light.reasons = (hl_note_list){0}; /* moved */
    out->light[i].frame = i;
    out->light[i].exposure_us = s->frame[i].exposure_us;
    out->light[i].gain = s->frame[i].gain;
    st = copy_texts(ctx, &s->frame[i], &out->light[i]);
  }
  if (st != HL_OK)
    return st;
  hl_replay_joint(run, out);
  st = hl_replay_intensity(ctx, run, out);
  if (st != HL_OK)
    return st;
  describe(run, out);
  for (int i = 0; i < out->n; i++)
    if (out->light[i].found && run->frame[i].seen[out->light[i].ball].scored)
      hl_replay_add_parts(out, &out->light[i]);
  return hl_lights_find_dome(ctx, out);
}

static void end(hl_replay_run *run)
{
  for (int b = 0; b < run->n_balls; b++)
    hl_surface_free(&run->ball[b].surface);
  for (int i = 0; run->frame && i < run->session->n; i++)
    hl_note_list_free(&run->frame[i].light.reasons);
  free(run->frame);
  free(run->seen);
  free(run->conditions);
  pthread_mutex_destroy(&run->guard);
  free(run);
}

hl_status hl_replay(hl_ctx *ctx, const hl_session *session, const char *folder,
                    const hl_replay_settings *settings, const hl_replay_watch *watch,
                    hl_replay_summary *summary, hl_lights *out)
{
  hl_replay_run *run = calloc(1, sizeof *run);
  if (!run)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a replay");
  if (pthread_mutex_init(&run->guard, NULL) != 0) {
    free(run);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a lock");
  }
  run->session = session;
  run->settings = settings ? *settings : hl_replay_defaults();
  run->watch = watch;
  run->folder = folder;
  memset(out, 0, sizeof *out);
  hl_status st = prepare(ctx, run);
  if (st == HL_OK && folder)
    st = hl_replay_folder(ctx, run);
  if (st == HL_OK)
    st = hl_replay_pose(ctx, run);
  if (st == HL_OK && !run->stopped)
    st = make_surfaces(ctx, run);
  if (st == HL_OK && !run->stopped)
    st = hl_replay_kind(ctx, run);
  if (st == HL_OK && !run->stopped)
    st = hl_replay_conditions(ctx, run);
  if (st == HL_OK && !run->stopped)
    st = all_frames(ctx, run);
  if (st == HL_OK && !run->stopped)
    st = gather(ctx, run, out);
  if (st != HL_OK)
    hl_lights_free(out);
  if (summary)
    *summary = (hl_replay_summary){session->n, run->reused, run->failed, run->stopped};
  end(run);
  return st;
}
