/* A session in memory: a list of frames that grows, and what was locked while they were taken. */
#include "halflight/session.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "session_files.h"

enum { SHOWN_MAX = 80, HEX_DIGITS = 64 };

const char *hl_session_pixels_text(hl_session_pixels pixels)
{
  static const char *const texts[] = {"", "raw-green", "raw-demosaiced", "processed"};
  return (unsigned)pixels < sizeof texts / sizeof texts[0] ? texts[pixels] : "";
}

const char *hl_session_fault_text(hl_session_fault_kind kind)
{
  static const char *const texts[] = {"dropped", "exposure",     "failed-read",
                                      "vanish",  "digital-gain", "slow-lock"};
  return (unsigned)kind < sizeof texts / sizeof texts[0] ? texts[kind] : "";
}

static void free_frame(hl_session_frame *frame)
{
  free(frame->file);
  free(frame->label);
  free(frame->untrusted);
}

void hl_session_free(hl_session *session)
{
  if (!session)
    return;
  for (int i = 0; i < session->n; i++)
    free_frame(&session->frame[i]);
  for (int i = 0; i < session->n_balls; i++)
    free(session->ball[i].sphere);
  free(session->frame);
  free(session->fault);
  free(session->folder);
  free(session->camera);
  free(session->device);
  *session = (hl_session){0};
}

/* hl_session_join puts one slash, so none is kept. */
static char *without_last_slashes(const char *folder)
{
  size_t n = strlen(folder);
  while (n > 1 && folder[n - 1] == '/')
    n--;
  return strndup(folder, n);
}

hl_status hl_session_new(hl_ctx *ctx, const char *folder, hl_session *out)
{
  hl_session session = {.folder = without_last_slashes(folder),
                        .camera = strdup(""),
                        .n_balls = 1,
                        .frame_settings = hl_frame_defaults(),
                        .device = strdup(""),
                        .locked = {.focus_dioptre = -1}};
  if (!session.folder || !session.camera || !session.device) {
    hl_session_free(&session);
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for a session", folder);
  }
  *out = session;
  return HL_OK;
}

static bool is_utf8(const char *text)
{
  json_t *value = json_string(text);
  json_decref(value);
  return value != NULL;
}

static bool is_hex(const char *sha256)
{
  return sha256[0] == '\0' ||
         (strspn(sha256, "0123456789abcdef") == HEX_DIGITS && sha256[HEX_DIGITS] == '\0');
}

static hl_status check_frame(hl_ctx *ctx, const hl_session *session, const hl_session_frame *frame)
{
  const double values[] = {frame->exposure_us, frame->gain, frame->digital_gain,
                           frame->white_balance[0], frame->white_balance[1]};
  static const char *const names[] = {"exposure_us", "gain", "digital_gain", "white_balance[0]",
                                      "white_balance[1]"};
  if (!frame->file || !hl_session_plain(frame->file))
    return hl_fail(ctx, HL_ERR_ARG,
                   "frame \"%.*s\" is no plain path within the session's folder; a relative path "
                   "is needed",
                   SHOWN_MAX, frame->file ? frame->file : "");
  errno = 0;
  if (!is_utf8(frame->file) || (frame->label && !is_utf8(frame->label)) ||
      (frame->untrusted && !is_utf8(frame->untrusted)))
    return errno == ENOMEM ? hl_fail(ctx, HL_ERR_MEMORY, "no memory for a frame")
                           : hl_fail(ctx, HL_ERR_ARG, "frame \"%.*s\": its texts are not all UTF-8",
                                     SHOWN_MAX, frame->file);
  for (size_t i = 0; i < sizeof values / sizeof values[0]; i++)
    if (!(values[i] >= 0 && isfinite(values[i])))
      return hl_fail(ctx, HL_ERR_ARG, "frame \"%.*s\": %s = %g; a number from 0 is needed",
                     SHOWN_MAX, frame->file, names[i], values[i]);
  if (!is_hex(frame->sha256))
    return hl_fail(ctx, HL_ERR_ARG,
                   "frame \"%.*s\": its sha256 is none; 64 lower-case hex digits are needed",
                   SHOWN_MAX, frame->file);
  for (int i = 0; i < session->n; i++)
    if (strcmp(session->frame[i].file, frame->file) == 0)
      return hl_fail(ctx, HL_ERR_ARG, "frame \"%.*s\" is in the session already, as frame %d",
                     SHOWN_MAX, frame->file, i);
  return HL_OK;
}

static bool grow(hl_session *session)
{
  if (session->n < session->capacity)
    return true;
  const int capacity = session->capacity > 0 ? 2 * session->capacity : 16;
  hl_session_frame *frame = realloc(session->frame, (size_t)capacity * sizeof *frame);
  if (!frame)
    return false;
  session->frame = frame;
  session->capacity = capacity;
  return true;
}

hl_status hl_session_append(hl_ctx *ctx, hl_session *session, const hl_session_frame *frame)
{
  const hl_status st = check_frame(ctx, session, frame);
  if (st != HL_OK)
    return st;
  hl_session_frame copy = *frame;
  copy.file = strdup(frame->file);
  copy.label = strdup(frame->label ? frame->label : "");
  copy.untrusted = frame->untrusted && frame->untrusted[0] ? strdup(frame->untrusted) : NULL;
  const bool whole =
      copy.file && copy.label && (copy.untrusted || !frame->untrusted || !frame->untrusted[0]);
  if (!whole || !grow(session)) {
    free_frame(&copy);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for frame \"%.*s\"", SHOWN_MAX, frame->file);
  }
  session->frame[session->n++] = copy;
  return HL_OK;
}

hl_status hl_session_path(hl_ctx *ctx, const hl_session *session, const char *file, char **out)
{
  hl_status st = hl_session_inside(ctx, session->folder, session->folder, file);
  if (st != HL_OK)
    return st;
  char *path = hl_session_join(session->folder, file);
  if (!path)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for a path", session->folder);
  *out = path;
  return HL_OK;
}
