/* session.json as text. Members that say nothing are left out. */
#include <jansson.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/export.h"
#include "halflight/session.h"
#include "json_write.h"
#include "session_files.h"

static bool set_text(json_t *object, const char *key, const char *text)
{
  return !text || !text[0] || hl_json_set(object, key, json_string(text));
}

static bool set_positive(json_t *object, const char *key, double value)
{
  return !(value > 0) || hl_json_set(object, key, json_real(value));
}

static bool set_gains(json_t *object, const double gains[2])
{
  return !(gains[0] > 0 || gains[1] > 0) ||
         hl_json_set(object, "white_balance", hl_json_reals(gains, 2));
}

static bool set_ball(json_t *object, const hl_session_ball *ball)
{
  return set_text(object, "sphere", ball->sphere) &&
         set_positive(object, "radius_m", ball->radius_m) &&
         (!(ball->circle_px[2] > 0) ||
          hl_json_set(object, "circle_px", hl_json_reals(ball->circle_px, 3)));
}

static bool set_settings(json_t *root, const hl_frame_settings *f)
{
  static const char *const transfers[] = {"auto", "linear", "srgb", "gamma"};
  const unsigned transfer = (unsigned)f->transfer;
  return (transfer == HL_TRANSFER_AUTO || transfer > HL_TRANSFER_GAMMA ||
          hl_json_set(root, "transfer", json_string(transfers[transfer]))) &&
         (transfer != HL_TRANSFER_GAMMA || hl_json_set(root, "gamma", json_real(f->gamma))) &&
         set_positive(root, "black", f->black) && set_positive(root, "saturation", f->saturation);
}

static json_t *locked_of(const hl_session_locked *l)
{
  json_t *object = json_object();
  if (set_positive(object, "exposure_us", l->exposure_us) &&
      set_positive(object, "gain", l->gain) && set_gains(object, l->white_balance) &&
      set_positive(object, "frame_duration_us", l->frame_duration_us) &&
      (!(l->focus_dioptre >= 0) ||
       hl_json_set(object, "focus_dioptre", json_real(l->focus_dioptre))))
    return object;
  json_decref(object);
  return NULL;
}

static json_t *frame_of(const void *user, int i)
{
  const hl_session_frame *f = &((const hl_session *)user)->frame[i];
  json_t *object = json_object();
  if (hl_json_set(object, "file", json_string(f->file)) &&
      hl_json_set(object, "label", json_string(f->label)) &&
      hl_json_set(object, "timestamp_ns", json_integer((json_int_t)f->timestamp_ns)) &&
      set_positive(object, "exposure_us", f->exposure_us) &&
      set_positive(object, "gain", f->gain) &&
      set_positive(object, "digital_gain", f->digital_gain) &&
      set_gains(object, f->white_balance) && set_text(object, "sha256", f->sha256) &&
      set_text(object, "untrusted", f->untrusted))
    return object;
  json_decref(object);
  return NULL;
}

static bool set_lists(json_t *root, const hl_session *s)
{
  json_t *balls = json_array();
  json_t *faults = json_array();
  bool good = balls && faults;
  for (int i = 1; i < s->n_balls && good; i++) {
    json_t *ball = json_object();
    good = set_ball(ball, &s->ball[i]) && json_array_append(balls, ball) == 0;
    json_decref(ball);
  }
  for (int i = 0; i < s->n_faults && good; i++)
    good = json_array_append_new(faults, json_pack("{s:i,s:s}", "frame", s->fault[i].frame, "kind",
                                                   hl_session_fault_text(s->fault[i].kind))) == 0;
  good = good && (s->n_balls < 2 || json_object_set(root, "balls", balls) == 0) &&
         hl_json_set(root, "frames", json_null()) &&
         (s->n_faults < 1 || json_object_set(root, "faults", faults) == 0);
  json_decref(balls);
  json_decref(faults);
  return good;
}

/* NULL without memory. All but the frames, of which there may be thousands, and a capture writes them anew for each. */
static json_t *document(const hl_session *s)
{
  const hl_session_locked *l = &s->locked;
  const bool locked = l->exposure_us > 0 || l->gain > 0 || l->white_balance[0] > 0 ||
                      l->white_balance[1] > 0 || l->frame_duration_us > 0 || l->focus_dioptre >= 0;
  json_t *root = json_pack("{s:s,s:i}", "format", "halflight-session", "version", 1);
  const bool good =
      root && set_text(root, "camera", s->camera) && set_ball(root, &s->ball[0]) &&
      set_settings(root, &s->frame_settings) && set_text(root, "device", s->device) &&
      set_text(root, "pixels", hl_session_pixels_text(s->pixels)) &&
      (s->size_px[0] < 1 ||
       hl_json_set(root, "size_px", json_pack("[i,i]", s->size_px[0], s->size_px[1]))) &&
      (!locked || hl_json_set(root, "locked", locked_of(l))) && set_lists(root, s);
  if (good)
    return root;
  json_decref(root);
  return NULL;
}

static hl_json_long frame_list(const hl_session *s)
{
  return (hl_json_long){"frames", s->n, frame_of, s};
}

hl_status hl_session_json(hl_ctx *ctx, const hl_session *session, char **out)
{
  const hl_json_long list = frame_list(session);
  return hl_json_long_text(ctx, document(session), &list, out);
}

hl_status hl_session_write(hl_ctx *ctx, const hl_session *session)
{
  const hl_json_long list = frame_list(session);
  char *path = hl_session_join(session->folder, "session.json");
  const hl_status st =
      path ? hl_json_long_write(ctx, document(session), &list, path)
           : hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for a path", session->folder);
  free(path);
  return st;
}
