/* A frame's result on the disk: a LIGHT.json with a member `replay`.
 *
 * `key` is the SHA-256 of all that the result depends on: the frame file's bytes, camera, poses,
 * settings and version. A result whose key is another's is made anew; one that cannot be read too. */
#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>

#include <sha2.h>

#include "halflight/export.h"
#include "halflight/info.h"
#include "halflight/notes.h"
#include "json_notes.h"
#include "json_read.h"
#include "json_write.h"
#include "light_json.h"
#include "lights_json.h"
#include "replay_work.h"
#include "text.h"

enum { PATH_ROOM = 4096 };

static void digest(const char *text, char out[HL_REPLAY_KEY])
{
  SHA256Data((const uint8_t *)text, strlen(text), out);
}

static void add_number(hl_text *text, double value)
{
  hl_text_number(text, value, 17);
  hl_text_add(text, " ");
}

static void add_settings(const hl_replay_run *run, hl_text *text)
{
  const hl_light_settings *l = &run->settings.light;
  const hl_frame_settings *f = &run->session->frame_settings;
  const double values[] = {run->settings.no_joint,
                           run->settings.frame_by_frame,
                           l->lobe,
                           l->with,
                           l->without,
                           l->pixels,
                           l->model_error,
                           l->outlier_sigmas,
                           l->widest_deg,
                           l->intervals,
                           f->transfer,
                           f->gamma,
                           f->black,
                           f->saturation,
                           run->session->n};
  hl_text_add(text, hl_version());
  hl_text_add(text, " ");
  for (size_t i = 0; i < sizeof values / sizeof *values; i++)
    add_number(text, values[i]);
}

hl_status hl_replay_conditions(hl_ctx *ctx, hl_replay_run *run)
{
  hl_text text = {0};
  char *part = NULL;
  add_settings(run, &text);
  hl_status st = hl_camera_json(ctx, &run->camera, &part);
  if (st == HL_OK)
    hl_text_add(&text, part);
  free(part);
  for (int b = 0; b < run->n_balls && st == HL_OK; b++) {
    part = NULL;
    st = hl_sphere_json(ctx, &run->ball[b].pose, NULL, &part);
    if (st == HL_OK)
      hl_text_add(&text, part);
    free(part);
    add_number(&text, run->ball[b].excess);
    add_number(&text, run->ball[b].blur_px);
    add_number(&text, run->ball[b].light.lobe);
    add_number(&text, run->ball[b].light.without);
  }
  if (st == HL_OK && text.failed)
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for the conditions of a replay");
  if (st == HL_OK) {
    run->conditions = malloc(HL_REPLAY_KEY);
    if (!run->conditions)
      st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for the conditions of a replay");
    else
      digest(text.bytes, run->conditions);
  }
  free(text.bytes);
  return st;
}

static hl_status make_folder(hl_ctx *ctx, const char *path)
{
  struct stat at;
  if (mkdir(path, 0777) == 0 || (errno == EEXIST && stat(path, &at) == 0 && S_ISDIR(at.st_mode)))
    return HL_OK;
  return hl_fail(ctx, HL_ERR_IO, "%s: cannot make the folder: %s", path, strerror(errno));
}

hl_status hl_replay_folder(hl_ctx *ctx, const hl_replay_run *run)
{
  char path[PATH_ROOM];
  if (strlen(run->folder) + 32 > sizeof path)
    return hl_fail(ctx, HL_ERR_ARG, "%.80s...: the name is longer than %d bytes", run->folder,
                   PATH_ROOM - 32);
  snprintf(path, sizeof path, "%s/frames", run->folder);
  const hl_status st = make_folder(ctx, run->folder);
  return st == HL_OK ? make_folder(ctx, path) : st;
}

hl_status hl_replay_key(hl_ctx *ctx, const hl_replay_run *run, int i, char key[HL_REPLAY_KEY])
{
  const hl_session_frame *f = &run->session->frame[i];
  char file[65], both[2 * HL_REPLAY_KEY + 64];
  char *path = NULL;
  hl_status st = hl_session_path(ctx, run->session, f->file, &path);
  if (st == HL_OK)
    st = hl_file_sha256(ctx, path, file);
  if (st == HL_OK && f->sha256[0] && strcmp(f->sha256, file) != 0)
    st = hl_fail(ctx, HL_ERR_FORMAT,
                 "%s: its SHA-256 begins %.12s, that of the session %.12s; the recorded file is "
                 "needed",
                 path, file, f->sha256);
  free(path);
  if (st != HL_OK)
    return st;
  snprintf(both, sizeof both, "%s %s", run->conditions, file);
  digest(both, key);
  return HL_OK;
}

static void path_of(const hl_replay_run *run, int i, char path[PATH_ROOM])
{
  snprintf(path, PATH_ROOM, "%.*s/frames/%05d.json", PATH_ROOM - 32, run->folder, i);
}

static json_t *seen_document(const hl_replay_seen *s)
{
  return json_pack("{s:b,s:b,s:f,s:b,s:o,s:o,s:o,s:o,s:o}", "outlined", (int)s->outlined, "moved",
                   (int)s->moved, "moved_px", s->moved_px, "scored", (int)s->scored, "gradient",
                   hl_json_reals(s->pose.gradient, 3), "information",
                   hl_json_rows(s->pose.information[0], 3, 3, 3), "by_center",
                   hl_json_rows(s->pose.by_center[0], 2, 3, 3), "profile",
                   hl_json_rows(s->profile[0], 3, HL_REPLAY_KNOTS, HL_REPLAY_KNOTS), "open",
                   hl_json_rows(s->open[0], 3, HL_REPLAY_PAIRS, HL_REPLAY_PAIRS));
}

static json_t *replay_document(const hl_replay_run *run, const char *key,
                               const hl_replay_frame *frame)
{
  hl_rig_light light = frame->light;
  light.file = light.label = "";
  json_t *balls = json_array();
  bool good = balls != NULL;
  for (int b = 0; b < run->n_balls && good; b++)
    good = json_array_append_new(balls, seen_document(&frame->seen[b])) == 0;
  if (!good) {
    json_decref(balls);
    return NULL;
  }
  return json_pack("{s:s,s:o,s:o}", "key", key, "light",
                   hl_rig_light_document(&light, hl_camera_intrinsics_count(&run->camera)), "balls",
                   balls);
}

hl_status hl_replay_keep(hl_ctx *ctx, const hl_replay_run *run, int i, const char *key,
                         const hl_light *light, const hl_replay_frame *frame)
{
  char path[PATH_ROOM];
  char *text = NULL;
  json_t *root = hl_light_json_document(light, NULL);
  path_of(run, i, path);
  if (root && json_object_set_new(root, "replay", replay_document(run, key, frame)) != 0) {
    json_decref(root);
    root = NULL;
  }
  hl_status st = hl_json_text(ctx, root, &text);
  if (st == HL_OK)
    st = hl_file_write(ctx, path, text, strlen(text));
  free(text);
  return st;
}

static bool flag(const json_t *object, const char *member)
{
  return json_is_true(json_object_get(object, member));
}

static bool recall_seen(hl_json_source s, const json_t *o, hl_replay_seen *out)
{
  out->outlined = flag(o, "outlined");
  out->moved = flag(o, "moved");
  out->scored = flag(o, "scored");
  return hl_json_number(s, o, "moved_px", 0, 1e9, &out->moved_px) == HL_OK &&
         hl_json_numbers(s, o, "gradient", 3, out->pose.gradient) == HL_OK &&
         hl_json_matrix(s, o, "information", 3, 3, out->pose.information[0]) == HL_OK &&
         hl_json_matrix(s, o, "by_center", 2, 3, out->pose.by_center[0]) == HL_OK &&
         hl_json_matrix(s, o, "profile", 3, HL_REPLAY_KNOTS, out->profile[0]) == HL_OK &&
         hl_json_matrix(s, o, "open", 3, HL_REPLAY_PAIRS, out->open[0]) == HL_OK;
}

bool hl_replay_recall(const hl_replay_run *run, int i, const char *key, hl_replay_frame *out)
{
  char path[PATH_ROOM];
  path_of(run, i, path);
  const hl_json_source source = {NULL, path};
  json_t *root = NULL;
  const char *found = "";
  if (hl_json_open(source, "halflight-light", 1, &root) != HL_OK)
    return false;
  const json_t *replay = json_object_get(root, "replay");
  const json_t *balls = json_object_get(replay, "balls");
  bool good = json_is_object(replay) && hl_json_string(source, replay, "key", &found) == HL_OK &&
              strcmp(found, key) == 0 && json_array_size(balls) == (size_t)run->n_balls;
  hl_replay_seen seen[HL_BALLS_MAX];
  hl_rig_light light;
  memset(&light, 0, sizeof light);
  memset(seen, 0, sizeof seen);
  good = good && hl_rig_light_members(source, json_object_get(replay, "light"), run->n_balls,
                                      hl_camera_intrinsics_count(&run->camera), &light) == HL_OK;
  for (int b = 0; b < run->n_balls && good; b++)
    good = recall_seen(source, json_array_get(balls, (size_t)b), &seen[b]);
  free(light.file);
  free(light.label);
  light.file = light.label = NULL;
  json_decref(root);
  if (good) {
    out->light = light;
    memcpy(out->seen, seen, (size_t)run->n_balls * sizeof *seen);
  } else {
    hl_note_list_free(&light.reasons);
  }
  return good;
}
