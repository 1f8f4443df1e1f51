/*
 * A session folder as a camera.
 *
 * Frames come in the session's order, at the times between them that their timestamps state, with
 * the settings that the session states for each. Faults that session.json lists are played where a
 * camera would have them: in what arrives, and in what the metadata then shows. A picture that is
 * missing, damaged or of another hash than the session states is a frame that cannot be read.
 */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "halflight/capture.h"

#define NS_PER_S INT64_C(1000000000)
#define FAULTY_DIGITAL_GAIN 1.5
#define FULL_16 65535.0

typedef struct recorded {
  hl_session session;
  bool full_speed, timed;
  int next;      /* place */
  int slow_left; /* frames that still show other settings */
  int64_t count;
  int64_t started_ns, first_ns; /* of this machine's clock; of the session */
  void *codes;
} recorded;

static bool has_fault(const recorded *r, int place, hl_session_fault_kind kind)
{
  for (int i = 0; i < r->session.n_faults; i++)
    if (r->session.fault[i].frame == place && r->session.fault[i].kind == kind)
      return true;
  return false;
}

static void name_camera(const recorded *r, hl_capture_camera *camera)
{
  *camera = (hl_capture_camera){0};
  snprintf(camera->id, sizeof camera->id, "%s",
           r->session.device[0] ? r->session.device : "recorded");
  snprintf(camera->model, sizeof camera->model, "%s", "recorded session");
}

static hl_status list(hl_ctx *ctx, void *state, hl_capture_camera **cameras, int *n)
{
  hl_capture_camera *one = malloc(sizeof *one);
  if (!one)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the list of cameras");
  name_camera(state, one);
  *cameras = one;
  *n = 1;
  return HL_OK;
}

static hl_status open_camera(hl_ctx *ctx, void *state, const char *id, hl_session_pixels *pixels,
                             hl_capture_camera *opened)
{
  const recorded *r = state;
  name_camera(r, opened);
  if (id[0] && strcmp(id, opened->id) != 0)
    return hl_fail(ctx, HL_ERR_IO, "no camera '%.100s'; the recorded session is of '%.100s'", id,
                   opened->id);
  if (*pixels != HL_PIXELS_UNSTATED && r->session.pixels != HL_PIXELS_UNSTATED &&
      *pixels != r->session.pixels)
    return hl_fail(ctx, HL_ERR_ARG, "%s: its frames are %s; %s cannot be had from it",
                   r->session.folder, hl_session_pixels_text(r->session.pixels),
                   hl_session_pixels_text(*pixels));
  if (r->session.pixels != HL_PIXELS_UNSTATED)
    *pixels = r->session.pixels;
  return HL_OK;
}

/* What no frame states cannot be shown by any. */
static hl_status lock_settings(hl_ctx *ctx, void *state, const hl_session_locked *locked,
                               unsigned *lacks)
{
  const hl_session *s = &((const recorded *)state)->session;
  (void)ctx;
  (void)locked;
  bool exposure = false;
  bool gain = false;
  bool balance = false;
  for (int i = 0; i < s->n; i++) {
    exposure = exposure || s->frame[i].exposure_us > 0;
    gain = gain || s->frame[i].gain > 0;
    balance = balance || s->frame[i].white_balance[0] > 0;
  }
  *lacks = (exposure ? 0u : HL_LACKS_EXPOSURE) | (gain ? 0u : HL_LACKS_GAIN) |
           (balance ? 0u : HL_LACKS_WHITE_BALANCE) |
           (s->locked.frame_duration_us > 0 ? 0u : HL_LACKS_FRAME_DURATION) |
           (s->locked.focus_dioptre >= 0 ? 0u : HL_LACKS_FOCUS);
  return HL_OK;
}

static hl_status start(hl_ctx *ctx, void *state, int first)
{
  recorded *r = state;
  (void)ctx;
  r->next = first;
  r->count = first;
  r->timed = false;
  r->slow_left = 0;
  for (int i = 0; i < r->session.n_faults; i++)
    if (r->session.fault[i].kind == HL_FAULT_SLOW_LOCK)
      r->slow_left = r->session.fault[i].frame;
  return HL_OK;
}

static int64_t now_ns(void)
{
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (int64_t)t.tv_sec * NS_PER_S + t.tv_nsec;
}

/* A signal ends the wait early, so that whoever sent it need not wait. */
static void wait_for(recorded *r, int64_t timestamp_ns)
{
  if (r->full_speed)
    return;
  if (!r->timed) {
    r->timed = true;
    r->first_ns = timestamp_ns;
    r->started_ns = now_ns();
    return;
  }
  const int64_t left = (timestamp_ns - r->first_ns) - (now_ns() - r->started_ns);
  const struct timespec pause = {.tv_sec = (time_t)(left / NS_PER_S), .tv_nsec = left % NS_PER_S};
  if (left > 0)
    nanosleep(&pause, NULL);
}

/* Integer codes as they were: float holds 16 bits exactly, and 255 x 257 = 65535. */
static hl_status keep_codes(hl_ctx *ctx, recorded *r, hl_frame *frame, hl_capture_frame *out)
{
  const size_t n = (size_t)frame->width * (size_t)frame->height * (size_t)frame->channels;
  out->width = frame->width;
  out->height = frame->height;
  out->channels = frame->channels;
  out->bits = frame->bits == 32 ? 32 : 16;
  out->codes_mean = r->session.frame_settings;
  if (out->codes_mean.transfer == HL_TRANSFER_AUTO)
    out->codes_mean.transfer = frame->bits == 8 ? HL_TRANSFER_SRGB : HL_TRANSFER_LINEAR;
  if (out->bits == 32) {
    r->codes = frame->radiance;
    frame->radiance = NULL;
  } else {
    uint16_t *codes = malloc(n * sizeof *codes);
    if (!codes)
      return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a frame of %d x %d", frame->width,
                     frame->height);
    for (size_t i = 0; i < n; i++)
      codes[i] = (uint16_t)lround(frame->radiance[i] * FULL_16);
    r->codes = codes;
  }
  out->codes = r->codes;
  return HL_OK;
}

static hl_status check_hash(hl_ctx *ctx, const char *path, const char *stated)
{
  char found[65];
  if (!stated[0])
    return HL_OK;
  const hl_status st = hl_file_sha256(ctx, path, found);
  if (st == HL_OK && strcmp(found, stated) != 0)
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: its SHA-256 is not the one that the session states",
                   path);
  return st;
}

static hl_status load(hl_ctx *ctx, recorded *r, int place, hl_capture_frame *out)
{
  hl_frame_settings linear = hl_frame_defaults();
  linear.transfer = HL_TRANSFER_LINEAR;
  hl_frame frame = {0};
  char *path = NULL;
  hl_status st = hl_session_path(ctx, &r->session, r->session.frame[place].file, &path);
  if (st == HL_OK)
    st = check_hash(ctx, path, r->session.frame[place].sha256);
  if (st == HL_OK)
    st = hl_frame_read(ctx, path, &linear, &frame);
  if (st == HL_OK)
    st = keep_codes(ctx, r, &frame, out);
  hl_frame_free(&frame);
  free(path);
  return st;
}

static void show_metadata(const recorded *r, int place, hl_capture_frame *out)
{
  const hl_session_frame *f = &r->session.frame[place];
  out->timestamp_ns = f->timestamp_ns;
  out->shown = r->session.locked; /* duration and focus */
  out->shown.exposure_us = f->exposure_us * (has_fault(r, place, HL_FAULT_EXPOSURE) ? 2 : 1);
  out->shown.gain = f->gain;
  memcpy(out->shown.white_balance, f->white_balance, sizeof f->white_balance);
  out->digital_gain =
      has_fault(r, place, HL_FAULT_DIGITAL_GAIN) ? FAULTY_DIGITAL_GAIN : f->digital_gain;
}

static hl_status next(hl_ctx *ctx, void *state, hl_capture_frame *out)
{
  recorded *r = state;
  const hl_session *s = &r->session;
  while (r->next < s->n && !has_fault(r, r->next, HL_FAULT_VANISH) &&
         has_fault(r, r->next, HL_FAULT_DROPPED)) {
    r->next++;
    r->count++;
  }
  const int place = r->next;
  if (place >= s->n)
    return hl_fail(ctx, HL_ERR_IO, "%s: the recorded session ends after its %d frames", s->folder,
                   s->n);
  if (has_fault(r, place, HL_FAULT_VANISH))
    return hl_fail(ctx, HL_ERR_IO, "%s: the camera vanished at frame %d", s->folder, place);
  free(r->codes);
  r->codes = NULL;
  *out = (hl_capture_frame){.readable = true, .place = place, .count = r->count++};
  show_metadata(r, place, out);
  if (r->slow_left > 0) {
    r->slow_left--;
    out->place = -1;
    out->shown.exposure_us *= 0.5;
    out->shown.gain *= 0.5;
    return HL_OK;
  }
  r->next++;
  wait_for(r, out->timestamp_ns);
  hl_ctx inner = {0};
  hl_status st = has_fault(r, place, HL_FAULT_FAILED_READ)
                     ? hl_fail(&inner, HL_ERR_IO, "its buffer came back with an error")
                     : load(&inner, r, place, out);
  if (st == HL_ERR_MEMORY)
    return hl_fail(ctx, st, "%s", inner.msg);
  if (st != HL_OK) {
    out->readable = false;
    memcpy(out->why, inner.msg, sizeof out->why);
  }
  return HL_OK;
}

static void stop(void *state)
{
  (void)state;
}

static void close_camera(void *state)
{
  recorded *r = state;
  hl_session_free(&r->session);
  free(r->codes);
  free(r);
}

hl_status hl_capture_recorded(hl_ctx *ctx, const char *folder, bool full_speed,
                              hl_capture_source *out)
{
  recorded *r = calloc(1, sizeof *r);
  if (!r)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for a source", folder);
  const hl_status st = hl_session_read(ctx, folder, &r->session);
  if (st != HL_OK) {
    free(r);
    return st;
  }
  r->full_speed = full_speed;
  *out = (hl_capture_source){"recorded", r,    list, open_camera, lock_settings,
                             start,      next, stop, close_camera};
  return HL_OK;
}
