/*
 * Frames from a camera into a session: open, lock, wait for the settings, record, end.
 *
 * The lights step on whether a frame arrives or not, so a frame that is dropped or refused takes its
 * place with it: frame k of the stream is light k, counted by the sensor from the first frame that
 * shows what was locked, or told by a recorded session itself.
 */
#include "halflight/capture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "capture_work.h"

enum { SETTLE_FRAMES = 60, FRAMES_MAX = 1000000, WHY_MAX = 200 };

typedef struct capture_run {
  const hl_capture_source *source;
  const hl_capture_plan *plan;
  hl_capture_result *result;
  hl_capture_folder folder;
  hl_session_pixels pixels;
  char untrusted[WHY_MAX];
  bool settled;
  int passed;        /* frames before that */
  int64_t base;      /* count of place 0, of a live camera */
  int expected;      /* place of the next frame */
  int refused_place; /* of the first that was refused */
  char refused_why[WHY_MAX];
} capture_run;

static hl_status check_plan(hl_ctx *ctx, const hl_capture_plan *p)
{
  const hl_session_locked *l = &p->locked;
  if (!p->folder || !p->folder[0])
    return hl_fail(ctx, HL_ERR_ARG, "no folder for the session; one is needed");
  if (p->n_frames < 1 || p->n_frames > FRAMES_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "%d frames; 1 to %d are accepted", p->n_frames, FRAMES_MAX);
  if (!(l->exposure_us > 0 && isfinite(l->exposure_us)))
    return hl_fail(ctx, HL_ERR_ARG, "exposure = %g us; one above 0 is needed", l->exposure_us);
  if (!(l->gain > 0 && isfinite(l->gain)))
    return hl_fail(ctx, HL_ERR_ARG, "gain = %g; one above 0 is needed", l->gain);
  const bool balanced = l->white_balance[0] > 0 && l->white_balance[1] > 0 &&
                        isfinite(l->white_balance[0]) && isfinite(l->white_balance[1]);
  if (p->pixels == HL_PIXELS_PROCESSED && !balanced)
    return hl_fail(ctx, HL_ERR_ARG,
                   "white balance = %g, %g; two gains above 0 are needed for processed frames",
                   l->white_balance[0], l->white_balance[1]);
  return HL_OK;
}

static hl_status open_camera(hl_ctx *ctx, capture_run *r)
{
  const hl_capture_source *source = r->source;
  hl_capture_camera camera = {0};
  char names[WHY_MAX / 2];
  unsigned lacks = 0;
  r->pixels = r->plan->pixels;
  hl_status st = source->open(ctx, source->state, r->plan->camera_id ? r->plan->camera_id : "",
                              &r->pixels, &camera);
  if (st == HL_OK)
    st = source->lock(ctx, source->state, &r->plan->locked, &lacks);
  if (st != HL_OK)
    return st;
  memcpy(r->result->device, camera.id, sizeof camera.id);
  r->result->lacks = lacks & hl_capture_needed(r->plan);
  hl_capture_lacks_text(r->result->lacks, names, sizeof names);
  if (names[0])
    snprintf(r->untrusted, sizeof r->untrusted, "the driver has no control of %s", names);
  return HL_OK;
}

static void refuse(capture_run *r, int place, const char *why)
{
  if (r->result->refused++ == 0) {
    r->refused_place = place;
    snprintf(r->refused_why, sizeof r->refused_why, "%s", why);
  }
}

/* Frames that never came. */
static void note_dropped(capture_run *r, int place)
{
  for (; r->expected < place && r->expected < r->plan->n_frames; r->expected++)
    if (!r->folder.filled[r->expected])
      refuse(r, r->expected, "it was dropped by the camera");
  r->expected = place + 1;
}

static hl_status never_settles(hl_ctx *ctx, const capture_run *r, const char *why)
{
  return hl_fail(ctx, HL_ERR_IO,
                 "%.100s: after %d frames the camera is not as it was locked: of the last, %s",
                 r->result->device, r->passed, why);
}

static hl_status check_size(hl_ctx *ctx, const capture_run *r, const hl_capture_frame *f)
{
  const hl_camera *camera = r->plan->camera;
  if (camera && (camera->width != f->width || camera->height != f->height))
    return hl_fail(ctx, HL_ERR_ARG,
                   "frames of %d x %d pixels, and a calibrated camera of %d x %d; one of the "
                   "frames' size is needed",
                   f->width, f->height, camera->width, camera->height);
  return HL_OK;
}

/* *over: no later frame has a place. */
static hl_status take(hl_ctx *ctx, capture_run *r, const hl_capture_frame *f, bool *over)
{
  const hl_capture_plan *plan = r->plan;
  const int limit = plan->settle_frames > 0 ? plan->settle_frames : SETTLE_FRAMES;
  char why[WHY_MAX];
  const bool good =
      hl_capture_accepts(plan, r->result->lacks, &r->folder.session, f, why, sizeof why);
  if (!good && !r->settled && ++r->passed >= limit)
    return never_settles(ctx, r, why);
  if (f->place < 0 && !r->settled) {
    if (!good)
      return HL_OK;
    r->base = f->count - r->expected;
  }
  r->settled = r->settled || good;
  const int64_t counted = f->count - r->base;
  const int place = f->place >= 0              ? f->place
                    : counted < plan->n_frames ? (int)counted
                                               : plan->n_frames;
  if (place >= r->expected)
    note_dropped(r, place);
  *over = place >= plan->n_frames - 1;
  if (place < 0 || place >= plan->n_frames || r->folder.filled[place])
    return HL_OK;
  if (!good) {
    refuse(r, place, why);
    return HL_OK;
  }
  hl_status st = check_size(ctx, r, f);
  if (st == HL_OK)
    st = hl_capture_folder_add(ctx, &r->folder, plan, f, place, r->untrusted);
  r->result->recorded += st == HL_OK;
  return st;
}

static bool goes_on(capture_run *r)
{
  const hl_capture_plan *p = r->plan;
  if (p->go_on && !p->go_on(p->user, r->folder.held, p->n_frames))
    r->result->stopped = true;
  return !r->result->stopped;
}

static hl_status gone(hl_ctx *ctx, const capture_run *r, hl_status st, const char *msg)
{
  return hl_fail(ctx, st, "%.200s; %d of %d frames are in the session", msg, r->folder.held,
                 r->plan->n_frames);
}

static hl_status stream(hl_ctx *ctx, capture_run *r)
{
  const hl_capture_source *source = r->source;
  bool over = false;
  while (!over && r->folder.held < r->plan->n_frames && goes_on(r)) {
    hl_capture_frame frame = {.place = -1};
    hl_ctx inner = {0};
    hl_status st = source->next(&inner, source->state, &frame);
    if (st != HL_OK)
      return gone(ctx, r, st, inner.msg);
    st = take(ctx, r, &frame, &over);
    if (st != HL_OK)
      return st;
  }
  return HL_OK;
}

/* Frames that the session still lacks though the stream went by. */
static hl_status conclude(hl_ctx *ctx, const capture_run *r)
{
  const hl_capture_plan *p = r->plan;
  const char *label = p->labels ? p->labels[r->refused_place] : "";
  const int missing = p->n_frames - r->folder.held;
  if (missing == 0 || r->result->stopped)
    return HL_OK;
  return hl_fail(ctx, HL_ERR_IO,
                 "%.80s: %d of %d frames are missing; the first is %d%s%.40s: %.120s; the same "
                 "command tries them again",
                 p->folder, missing, p->n_frames, r->refused_place, label[0] ? ", " : "", label,
                 r->refused_why);
}

static hl_status record(hl_ctx *ctx, capture_run *r)
{
  const hl_capture_source *source = r->source;
  const int first = hl_capture_folder_free_place(&r->folder, r->plan);
  if (first >= r->plan->n_frames)
    return HL_OK;
  hl_status st = source->start(ctx, source->state, first);
  if (st != HL_OK)
    return st;
  r->expected = first;
  st = stream(ctx, r);
  source->stop(source->state);
  goes_on(r);
  return st == HL_OK ? conclude(ctx, r) : st;
}

hl_status hl_capture_run(hl_ctx *ctx, const hl_capture_source *source, const hl_capture_plan *plan,
                         hl_capture_result *result)
{
  capture_run r = {.source = source, .plan = plan, .result = result, .folder = {.lock = -1}};
  *result = (hl_capture_result){0};
  hl_status st = check_plan(ctx, plan);
  if (st == HL_OK)
    st = open_camera(ctx, &r);
  if (st == HL_OK)
    st = hl_capture_folder_open(ctx, plan, result->device, r.pixels, &r.folder);
  if (st != HL_OK)
    return st;
  st = record(ctx, &r);
  result->held = r.folder.held;
  hl_capture_folder_close(&r.folder);
  return st;
}
