/* session.json: read, checked, written. src/doc/session.md explains its members. */
#include <float.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/export.h"
#include "halflight/session.h"
#include "json_read.h"
#include "json_write.h"
#include "session_files.h"

#define FARTHEST_M 1e6
#define FARTHEST_PX 1e6
enum { WHERE_MAX = 4096 + 64, FRAMES_MAX = 1000000, SIZE_MAX_PX = 1 << 20, N_FAULT_KINDS = 6 };

static const char manifest[] = "session.json";
static const char *const transfers[] = {"auto", "linear", "srgb", "gamma"};

/* "PATH: list[i]", so that the messages of json_read.h say which element. */
static hl_json_source element(hl_json_source source, const char *list, size_t i,
                              char where[WHERE_MAX])
{
  snprintf(where, WHERE_MAX, "%.4096s: %s[%zu]", source.path, list, i);
  return (hl_json_source){source.ctx, where};
}

static hl_status optional_number(hl_json_source source, const json_t *object, const char *member,
                                 double min, double max, double *out)
{
  return hl_json_has(object, member) ? hl_json_number(source, object, member, min, max, out)
                                     : HL_OK;
}

/* A copy in *out, which is replaced; untouched where it is not stated. */
static hl_status optional_text(hl_json_source source, const json_t *object, const char *member,
                               char **out)
{
  const char *text = NULL;
  if (!hl_json_has(object, member))
    return HL_OK;
  const hl_status st = hl_json_string(source, object, member, &text);
  if (st != HL_OK)
    return st;
  char *copy = strdup(text);
  if (!copy)
    return hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for %s", source.path, member);
  free(*out);
  *out = copy;
  return HL_OK;
}

static hl_status inside(hl_json_source source, const char *member, const hl_session *s,
                        const char *file)
{
  char what[WHERE_MAX + 32];
  snprintf(what, sizeof what, "%s: %s", source.path, member);
  return hl_session_inside(source.ctx, what, s->folder, file);
}

/* One of n texts; untouched where it is not stated. */
static hl_status optional_choice(hl_json_source source, const json_t *object, const char *member,
                                 const char *const *texts, int n, int *out)
{
  const char *text = NULL;
  if (!hl_json_has(object, member))
    return HL_OK;
  const hl_status st = hl_json_string(source, object, member, &text);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < n; i++)
    if (strcmp(text, texts[i]) == 0) {
      *out = i;
      return HL_OK;
    }
  char all[160] = "";
  for (int i = 0; i < n; i++) {
    strncat(all, all[0] ? ", " : "", sizeof all - strlen(all) - 1);
    strncat(all, texts[i], sizeof all - strlen(all) - 1);
  }
  return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s = \"%.40s\"; one of %s is needed", source.path,
                 member, text, all);
}

/* n numbers in [0, FLT_MAX]. */
static hl_status optional_gains(hl_json_source source, const json_t *object, const char *member,
                                double out[2])
{
  double gains[2] = {0, 0};
  if (!hl_json_has(object, member))
    return HL_OK;
  const hl_status st = hl_json_numbers(source, object, member, 2, gains);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < 2; i++)
    if (!(gains[i] >= 0 && gains[i] <= FLT_MAX))
      return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s[%d] = %g; a number from 0 is needed",
                     source.path, member, i, gains[i]);
  memcpy(out, gains, sizeof gains);
  return HL_OK;
}

static hl_status read_ball(hl_json_source source, const json_t *object, const hl_session *s,
                           hl_session_ball *ball)
{
  hl_status st = optional_text(source, object, "sphere", &ball->sphere);
  if (st == HL_OK && ball->sphere)
    st = inside(source, "sphere", s, ball->sphere);
  if (st == HL_OK)
    st = optional_number(source, object, "radius_m", 1e-9, FARTHEST_M, &ball->radius_m);
  if (st == HL_OK && hl_json_has(object, "circle_px"))
    st = hl_json_numbers(source, object, "circle_px", 3, ball->circle_px);
  for (int i = 0; i < 3 && st == HL_OK; i++)
    if (!(ball->circle_px[i] >= (i < 2 ? -FARTHEST_PX : 0) && ball->circle_px[i] <= FARTHEST_PX))
      st = hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: circle_px[%d] = %g; a place in the frame and a radius from 0 are needed",
                   source.path, i, ball->circle_px[i]);
  return st;
}

static hl_status read_balls(hl_json_source source, const json_t *root, hl_session *s)
{
  char where[WHERE_MAX];
  const json_t *list = json_object_get(root, "balls");
  hl_status st = read_ball(source, root, s, &s->ball[0]);
  if (st != HL_OK || !hl_json_has(root, "balls"))
    return st;
  if (!json_is_array(list) || json_array_size(list) >= HL_BALLS_MAX)
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: balls is no list of up to %d balls beside the first", source.path,
                   HL_BALLS_MAX - 1);
  for (size_t i = 0; i < json_array_size(list) && st == HL_OK; i++) {
    s->n_balls++; /* before it is read, so that it is freed */
    st = read_ball(element(source, "balls", i, where), json_array_get(list, i), s, &s->ball[i + 1]);
  }
  return st;
}

static hl_status read_frame_settings(hl_json_source source, const json_t *root, hl_session *s)
{
  hl_frame_settings *f = &s->frame_settings;
  int transfer = (int)f->transfer;
  hl_status st = optional_choice(source, root, "transfer", transfers, 4, &transfer);
  f->transfer = (hl_transfer)transfer;
  if (st == HL_OK)
    st = optional_number(source, root, "gamma", 0.1, 10, &f->gamma);
  if (st == HL_OK)
    st = optional_number(source, root, "black", 0, FLT_MAX, &f->black);
  if (st == HL_OK)
    st = optional_number(source, root, "saturation", 0, FLT_MAX, &f->saturation);
  return st;
}

static hl_status read_locked(hl_json_source source, const json_t *root, hl_session *s)
{
  char where[WHERE_MAX];
  const json_t *object = json_object_get(root, "locked");
  hl_session_locked *l = &s->locked;
  snprintf(where, sizeof where, "%.4096s: locked", source.path);
  const hl_json_source at = {source.ctx, where};
  if (!hl_json_has(root, "locked"))
    return HL_OK;
  hl_status st = optional_number(at, object, "exposure_us", 0, FLT_MAX, &l->exposure_us);
  if (st == HL_OK)
    st = optional_number(at, object, "gain", 0, FLT_MAX, &l->gain);
  if (st == HL_OK)
    st = optional_gains(at, object, "white_balance", l->white_balance);
  if (st == HL_OK)
    st = optional_number(at, object, "frame_duration_us", 0, FLT_MAX, &l->frame_duration_us);
  if (st == HL_OK)
    st = optional_number(at, object, "focus_dioptre", 0, FLT_MAX, &l->focus_dioptre);
  return st;
}

static hl_status read_size(hl_json_source source, const json_t *root, hl_session *s)
{
  double size[2] = {0, 0};
  if (!hl_json_has(root, "size_px"))
    return HL_OK;
  const hl_status st = hl_json_numbers(source, root, "size_px", 2, size);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < 2; i++) {
    if (!(size[i] >= 1 && size[i] <= SIZE_MAX_PX && size[i] == (int)size[i]))
      return hl_fail(source.ctx, HL_ERR_FORMAT,
                     "%s: size_px[%d] = %g; a whole number from 1 to %d is needed", source.path, i,
                     size[i], SIZE_MAX_PX);
    s->size_px[i] = (int)size[i];
  }
  return HL_OK;
}

static hl_status read_timestamp(hl_json_source source, const json_t *object, int64_t *out)
{
  const json_t *value = json_object_get(object, "timestamp_ns");
  if (!hl_json_has(object, "timestamp_ns"))
    return HL_OK;
  if (!json_is_integer(value))
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: timestamp_ns is no whole number; nanoseconds are needed", source.path);
  *out = (int64_t)json_integer_value(value);
  return HL_OK;
}

static hl_status read_sha256(hl_json_source source, const json_t *object, char out[65])
{
  const char *text = NULL;
  if (!hl_json_has(object, "sha256"))
    return HL_OK;
  const hl_status st = hl_json_string(source, object, "sha256", &text);
  if (st != HL_OK)
    return st;
  if (strlen(text) != 64 || strspn(text, "0123456789abcdef") != 64)
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: sha256 = \"%.70s\"; 64 lower-case hex digits are needed", source.path,
                   text);
  memcpy(out, text, 65);
  return HL_OK;
}

static hl_status read_frame(hl_json_source source, const json_t *object, const hl_session *s,
                            hl_session_frame *f)
{
  const char *file = NULL;
  hl_status st = hl_json_string(source, object, "file", &file);
  if (st == HL_OK)
    st = inside(source, "file", s, file);
  if (st == HL_OK)
    st = optional_text(source, object, "file", &f->file);
  if (st == HL_OK)
    st = optional_text(source, object, "label", &f->label);
  if (st == HL_OK && !f->label) {
    f->label = strdup("");
    if (!f->label)
      st = hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory", source.path);
  }
  if (st == HL_OK)
    st = read_timestamp(source, object, &f->timestamp_ns);
  if (st == HL_OK)
    st = optional_number(source, object, "exposure_us", 0, FLT_MAX, &f->exposure_us);
  if (st == HL_OK)
    st = optional_number(source, object, "gain", 0, FLT_MAX, &f->gain);
  if (st == HL_OK)
    st = optional_number(source, object, "digital_gain", 0, FLT_MAX, &f->digital_gain);
  if (st == HL_OK)
    st = optional_gains(source, object, "white_balance", f->white_balance);
  if (st == HL_OK)
    st = read_sha256(source, object, f->sha256);
  if (st == HL_OK)
    st = optional_text(source, object, "untrusted", &f->untrusted);
  return st;
}

typedef struct listed {
  const char *file;
  int at;
} listed;

static int by_file(const void *a, const void *b)
{
  const listed *x = a, *y = b;
  const int order = strcmp(x->file, y->file);
  return order != 0 ? order : x->at - y->at;
}

static hl_status check_doubled(hl_json_source source, const hl_session *s)
{
  listed *sorted = malloc(((size_t)s->n + 1) * sizeof *sorted);
  if (!sorted)
    return hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for %d frames", source.path, s->n);
  for (int i = 0; i < s->n; i++)
    sorted[i] = (listed){s->frame[i].file, i};
  qsort(sorted, (size_t)s->n, sizeof *sorted, by_file);
  hl_status st = HL_OK;
  for (int i = 1; i < s->n && st == HL_OK; i++)
    if (strcmp(sorted[i - 1].file, sorted[i].file) == 0)
      st = hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: frames %d and %d are the same file, \"%.80s\"; each is listed once",
                   source.path, sorted[i - 1].at, sorted[i].at, sorted[i].file);
  free(sorted);
  return st;
}

static hl_status read_frames(hl_json_source source, const json_t *root, hl_session *s)
{
  char where[WHERE_MAX];
  const json_t *list = json_object_get(root, "frames");
  const size_t n = json_array_size(list);
  if (!json_is_array(list) || n > FRAMES_MAX)
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: frames is no list; one of up to %d is needed",
                   source.path, FRAMES_MAX);
  s->frame = calloc(n + 1, sizeof *s->frame);
  if (!s->frame)
    return hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for %zu frames", source.path, n);
  s->capacity = (int)n + 1;
  hl_status st = HL_OK;
  for (size_t i = 0; i < n && st == HL_OK; i++) {
    s->n++; /* before it is read, so that it is freed */
    st = read_frame(element(source, "frames", i, where), json_array_get(list, i), s, &s->frame[i]);
  }
  return st == HL_OK ? check_doubled(source, s) : st;
}

static hl_status read_faults(hl_json_source source, const json_t *root, hl_session *s)
{
  char where[WHERE_MAX];
  const char *kinds[N_FAULT_KINDS];
  const json_t *list = json_object_get(root, "faults");
  const size_t n = json_array_size(list);
  for (int i = 0; i < N_FAULT_KINDS; i++)
    kinds[i] = hl_session_fault_text((hl_session_fault_kind)i);
  if (!hl_json_has(root, "faults"))
    return HL_OK;
  if (!json_is_array(list) || n > FRAMES_MAX)
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: faults is no list; one of up to %d is needed",
                   source.path, FRAMES_MAX);
  s->fault = calloc(n + 1, sizeof *s->fault);
  if (!s->fault)
    return hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for %zu faults", source.path, n);
  for (size_t i = 0; i < n; i++) {
    const hl_json_source at = element(source, "faults", i, where);
    const json_t *object = json_array_get(list, i);
    const char *needed = NULL;
    int kind = 0;
    hl_status st = hl_json_int(at, object, "frame", 0, FRAMES_MAX, &s->fault[i].frame);
    if (st == HL_OK)
      st = hl_json_string(at, object, "kind", &needed);
    if (st == HL_OK)
      st = optional_choice(at, object, "kind", kinds, N_FAULT_KINDS, &kind);
    if (st != HL_OK)
      return st;
    s->fault[i].kind = (hl_session_fault_kind)kind;
    s->n_faults++;
  }
  return HL_OK;
}

static hl_status read_members(hl_json_source source, const json_t *root, hl_session *s)
{
  const char *const pixels[] = {"raw-green", "raw-demosaiced", "processed"};
  int kind = -1;
  hl_status st = optional_text(source, root, "camera", &s->camera);
  if (st == HL_OK && s->camera[0])
    st = inside(source, "camera", s, s->camera);
  if (st == HL_OK)
    st = read_balls(source, root, s);
  if (st == HL_OK)
    st = read_frame_settings(source, root, s);
  if (st == HL_OK)
    st = optional_text(source, root, "device", &s->device);
  if (st == HL_OK)
    st = optional_choice(source, root, "pixels", pixels, 3, &kind);
  s->pixels = (hl_session_pixels)(kind + 1);
  if (st == HL_OK)
    st = read_size(source, root, s);
  if (st == HL_OK)
    st = read_locked(source, root, s);
  if (st == HL_OK)
    st = read_frames(source, root, s);
  if (st == HL_OK)
    st = read_faults(source, root, s);
  return st;
}

hl_status hl_session_read(hl_ctx *ctx, const char *folder, hl_session *out)
{
  hl_session session = {0};
  json_t *root = NULL;
  hl_status st = hl_session_new(ctx, folder, &session);
  if (st != HL_OK)
    return st;
  char *path = hl_session_join(session.folder, manifest);
  const hl_json_source source = {ctx, path};
  if (!path)
    st = hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for a path", folder);
  if (st == HL_OK)
    st = hl_json_open(source, "halflight-session", 1, &root);
  if (st == HL_OK)
    st = read_members(source, root, &session);
  json_decref(root);
  free(path);
  if (st == HL_OK)
    *out = session;
  else
    hl_session_free(&session);
  return st;
}
