/*
 * The folder of a session that grows.
 *
 * Frame k of the plan is frames/kkkk.png, so a session knows which of its frames it lacks, whatever
 * interrupted it. A picture that was written but not listed when the process died is written again.
 * Two captures into one folder would overwrite each other's list: the folder is locked (flock), and
 * a lock ends with its process.
 */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <fnmatch.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "capture_work.h"

enum { FILE_NAME_MAX = 32, PATH_ROOM = 4096 };
static const char frames_folder[] = "frames/";

/* Place of a frame that a capture wrote; -1 for any other file. */
static int place_of(const char *file)
{
  const size_t n = sizeof frames_folder - 1;
  char *end = NULL;
  if (strncmp(file, frames_folder, n) != 0 || file[n] < '0' || file[n] > '9')
    return -1;
  const long place = strtol(file + n, &end, 10);
  const bool picture = strcmp(end, ".png") == 0 || strcmp(end, ".pfm") == 0;
  return picture && place <= 999999 ? (int)place : -1;
}

int hl_capture_folder_free_place(const hl_capture_folder *folder, const hl_capture_plan *plan)
{
  int place = 0;
  while (place < plan->n_frames && folder->filled[place])
    place++;
  return place;
}

static hl_status make_folder(hl_ctx *ctx, const char *path, bool *made)
{
  struct stat at;
  *made = mkdir(path, 0777) == 0;
  if (!*made && errno != EEXIST)
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot make the folder: %s", path, strerror(errno));
  if (stat(path, &at) != 0 || !S_ISDIR(at.st_mode))
    return hl_fail(ctx, HL_ERR_IO, "%s: is no folder; a session is a folder", path);
  return HL_OK;
}

static hl_status take_lock(hl_ctx *ctx, const char *path, int *lock)
{
  const int folder = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0)
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
  if (flock(folder, LOCK_EX | LOCK_NB) != 0) {
    const int error = errno;
    close(folder);
    if (error == EWOULDBLOCK)
      return hl_fail(ctx, HL_ERR_IO, "%s: another capture is at work in this folder", path);
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot lock: %s", path, strerror(error));
  }
  *lock = folder;
  return HL_OK;
}

/* Beginnings of files that a killed capture left; nobody else writes here now. */
static void remove_left_over(const char *folder, const char *pattern)
{
  DIR *entries = opendir(folder);
  for (struct dirent *e; entries && (e = readdir(entries));)
    if (fnmatch(pattern, e->d_name, 0) == 0)
      unlinkat(dirfd(entries), e->d_name, 0);
  if (entries)
    closedir(entries);
}

static hl_status disagree(hl_ctx *ctx, const hl_session *s, const char *what, double has,
                          double asked)
{
  return hl_fail(ctx, HL_ERR_ARG,
                 "%s: the session has %s %.6g, %.6g is asked for; the same, or another folder, is "
                 "needed",
                 s->folder, what, has, asked);
}

static hl_status check_locked(hl_ctx *ctx, const hl_session *s, const hl_capture_plan *plan)
{
  const hl_session_locked *a = &s->locked, *b = &plan->locked;
  const struct {
    const char *what;
    double has, asked;
  } all[] = {{"exposure_us", a->exposure_us, b->exposure_us},
             {"gain", a->gain, b->gain},
             {"red gain", a->white_balance[0], b->white_balance[0]},
             {"blue gain", a->white_balance[1], b->white_balance[1]},
             {"frame_duration_us", a->frame_duration_us, b->frame_duration_us},
             {"focus_dioptre", a->focus_dioptre, b->focus_dioptre < 0 ? -1 : b->focus_dioptre}};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    if (all[i].has != all[i].asked)
      return disagree(ctx, s, all[i].what, all[i].has, all[i].asked);
  if (plan->radius_m > 0 && s->ball[0].radius_m != plan->radius_m)
    return disagree(ctx, s, "radius_m", s->ball[0].radius_m, plan->radius_m);
  return HL_OK;
}

static hl_status check_camera(hl_ctx *ctx, const hl_session *s, const hl_capture_plan *plan)
{
  hl_camera camera;
  char *has = NULL;
  char *asked = NULL;
  char *path = NULL;
  if (!plan->camera)
    return HL_OK;
  if (!s->camera[0])
    return hl_fail(
        ctx, HL_ERR_ARG,
        "%s: the session was begun without a calibrated camera; another folder is needed",
        s->folder);
  hl_status st = hl_session_path(ctx, s, s->camera, &path);
  if (st == HL_OK)
    st = hl_camera_read(ctx, path, &camera);
  if (st == HL_OK)
    st = hl_camera_json(ctx, &camera, &has);
  if (st == HL_OK)
    st = hl_camera_json(ctx, plan->camera, &asked);
  if (st == HL_OK && strcmp(has, asked) != 0)
    st = hl_fail(ctx, HL_ERR_ARG,
                 "%s: is another calibrated camera than the one that is asked for; the same, or "
                 "another folder, is needed",
                 path);
  free(has);
  free(asked);
  free(path);
  return st;
}

/* Frames on the list are there, and carry the labels of the plan. */
static hl_status take_stock(hl_ctx *ctx, hl_capture_folder *f, const hl_capture_plan *plan)
{
  const hl_session *s = &f->session;
  for (int i = 0; i < s->n; i++) {
    const int place = place_of(s->frame[i].file);
    char *path = NULL;
    const hl_status st = hl_session_path(ctx, s, s->frame[i].file, &path);
    if (st != HL_OK)
      return st;
    const bool there = access(path, F_OK) == 0;
    free(path);
    if (!there)
      return hl_fail(ctx, HL_ERR_IO,
                     "%s: frame %d, \"%.80s\", is on the list but not in the folder", s->folder, i,
                     s->frame[i].file);
    if (place < 0 || place >= plan->n_frames)
      continue;
    if (plan->labels && strcmp(plan->labels[place], s->frame[i].label) != 0)
      return hl_fail(ctx, HL_ERR_ARG,
                     "%s: frame %d has label '%.60s', '%.60s' is asked for; the same, or another "
                     "folder, is needed",
                     s->folder, place, s->frame[i].label, plan->labels[place]);
    f->held += !f->filled[place];
    f->filled[place] = true;
  }
  return HL_OK;
}

static hl_status take_up(hl_ctx *ctx, const hl_capture_plan *plan, const char *device,
                         hl_session_pixels pixels, hl_capture_folder *f)
{
  hl_status st = hl_session_read(ctx, plan->folder, &f->session);
  if (st != HL_OK)
    return st;
  const hl_session *s = &f->session;
  if (strcmp(s->device, device) != 0)
    return hl_fail(
        ctx, HL_ERR_ARG,
        "%s: the session is of camera '%.90s', not '%.90s'; the same, or another folder, "
        "is needed",
        s->folder, s->device, device);
  if (s->pixels != pixels)
    return hl_fail(ctx, HL_ERR_ARG, "%s: its frames are '%s', '%s' is asked for", s->folder,
                   hl_session_pixels_text(s->pixels), hl_session_pixels_text(pixels));
  st = check_locked(ctx, s, plan);
  if (st == HL_OK)
    st = check_camera(ctx, s, plan);
  return st == HL_OK ? take_stock(ctx, f, plan) : st;
}

static hl_status begin(hl_ctx *ctx, const hl_capture_plan *plan, const char *device,
                       hl_session_pixels pixels, hl_capture_folder *f)
{
  hl_status st = hl_session_new(ctx, plan->folder, &f->session);
  if (st != HL_OK)
    return st;
  hl_session *s = &f->session;
  s->pixels = pixels;
  s->locked = plan->locked;
  if (s->locked.focus_dioptre < 0)
    s->locked.focus_dioptre = -1;
  s->ball[0].radius_m = plan->radius_m;
  free(s->device);
  s->device = strdup(device);
  if (plan->camera) {
    free(s->camera);
    s->camera = strdup("camera.json");
  }
  if (!s->device || !s->camera)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for a session", plan->folder);
  f->fresh = true;
  char *path = NULL;
  if (plan->camera)
    st = hl_session_path(ctx, s, s->camera, &path);
  if (st == HL_OK && path)
    st = hl_camera_write(ctx, path, plan->camera);
  free(path);
  return st == HL_OK ? hl_session_write(ctx, s) : st;
}

hl_status hl_capture_folder_open(hl_ctx *ctx, const hl_capture_plan *plan, const char *device,
                                 hl_session_pixels pixels, hl_capture_folder *out)
{
  char path[PATH_ROOM];
  hl_capture_folder f = {.lock = -1};
  bool made_frames = false;
  if (strlen(plan->folder) + FILE_NAME_MAX > sizeof path)
    return hl_fail(ctx, HL_ERR_ARG,
                   "the session's folder has a path of %zu bytes; %zu are accepted",
                   strlen(plan->folder), sizeof path - FILE_NAME_MAX);
  f.filled = calloc((size_t)plan->n_frames, sizeof *f.filled);
  if (!f.filled)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d frames", plan->n_frames);
  hl_status st = make_folder(ctx, plan->folder, &f.made);
  if (st == HL_OK)
    st = take_lock(ctx, plan->folder, &f.lock);
  snprintf(path, sizeof path, "%s/session.json", plan->folder);
  if (st == HL_OK) {
    remove_left_over(plan->folder, "session.json.*-*.tmp");
    st = access(path, F_OK) == 0 ? take_up(ctx, plan, device, pixels, &f)
                                 : begin(ctx, plan, device, pixels, &f);
  }
  snprintf(path, sizeof path, "%s/%s", plan->folder, frames_folder);
  if (st == HL_OK)
    st = make_folder(ctx, path, &made_frames);
  if (st == HL_OK)
    remove_left_over(path, "[0-9]*.p[nf][gm].*-*.tmp");
  *out = f;
  if (st != HL_OK)
    hl_capture_folder_close(out);
  return st;
}

/* From the end of the list to where its place says. */
static void sort_in(hl_session *s)
{
  for (int i = s->n - 1; i > 0 && place_of(s->frame[i].file) < place_of(s->frame[i - 1].file);
       i--) {
    const hl_session_frame earlier = s->frame[i];
    s->frame[i] = s->frame[i - 1];
    s->frame[i - 1] = earlier;
  }
}

static void state_first(hl_session *s, const hl_capture_frame *frame)
{
  if (s->size_px[0] > 0)
    return;
  s->size_px[0] = frame->width;
  s->size_px[1] = frame->height;
  s->frame_settings = frame->codes_mean;
  /* a float file has no full scale of its own */
  if (frame->bits == 16 && strcmp(hl_capture_picture_ending(16), "pfm") == 0 &&
      !(s->frame_settings.saturation > 0))
    s->frame_settings.saturation = 1;
}

hl_status hl_capture_folder_add(hl_ctx *ctx, hl_capture_folder *folder, const hl_capture_plan *plan,
                                const hl_capture_frame *frame, int place, const char *untrusted)
{
  char file[FILE_NAME_MAX];
  char why[HL_MESSAGE_MAX];
  char *path = NULL;
  char *label = plan->labels ? strdup(plan->labels[place]) : NULL;
  snprintf(why, sizeof why, "%s", untrusted);
  snprintf(file, sizeof file, "%s%04d.%s", frames_folder, place,
           hl_capture_picture_ending(frame->bits));
  hl_session_frame f = {.file = file,
                        .label = label,
                        .timestamp_ns = frame->timestamp_ns,
                        .exposure_us = frame->shown.exposure_us,
                        .gain = frame->shown.gain,
                        .digital_gain = frame->digital_gain,
                        .untrusted = why};
  memcpy(f.white_balance, frame->shown.white_balance, sizeof f.white_balance);
  hl_status st = hl_session_path(ctx, &folder->session, file, &path);
  if (st == HL_OK)
    st = hl_capture_picture_write(ctx, path, frame);
  const bool written = st == HL_OK;
  if (st == HL_OK)
    st = hl_file_sha256(ctx, path, f.sha256);
  if (st == HL_OK)
    st = hl_session_append(ctx, &folder->session, &f);
  if (st == HL_OK) {
    sort_in(&folder->session);
    state_first(&folder->session, frame);
    st = hl_session_write(ctx, &folder->session);
  }
  if (st != HL_OK && written)
    unlink(path);
  free(path);
  free(label);
  if (st == HL_OK) {
    folder->filled[place] = true;
    folder->held++;
  }
  return st;
}

void hl_capture_folder_close(hl_capture_folder *folder)
{
  const hl_session *s = &folder->session;
  /* held: frames that are on the disk; a frame that failed is on the list in memory only */
  if (folder->fresh && folder->held == 0) {
    char path[PATH_ROOM];
    snprintf(path, sizeof path, "%.4000s/session.json", s->folder);
    unlink(path);
    snprintf(path, sizeof path, "%.4000s/camera.json", s->folder);
    if (s->camera[0])
      unlink(path);
    snprintf(path, sizeof path, "%.4000s/frames", s->folder);
    rmdir(path);
    if (folder->made)
      rmdir(s->folder);
  }
  if (folder->lock >= 0)
    close(folder->lock);
  hl_session_free(&folder->session);
  free(folder->filled);
  *folder = (hl_capture_folder){.lock = -1};
}
