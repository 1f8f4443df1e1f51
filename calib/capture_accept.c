/*
 * Which frames may be recorded.
 *
 * Sensors count exposure in lines and gain in steps, so what the metadata shows may differ from what
 * was asked by 2 %; from the session's first frame on it must stay the same to 0.1 %, because frames
 * of one session are compared with each other. A digital gain is a factor that some later stage puts
 * on the codes; only 1 is accepted.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "capture_work.h"

#define ASKED_TOLERANCE 0.02
#define SAME_TOLERANCE 0.001
#define FOCUS_TOLERANCE 0.05 /* dioptres */

unsigned hl_capture_needed(const hl_capture_plan *plan)
{
  const hl_session_locked *l = &plan->locked;
  return (l->exposure_us > 0 ? HL_LACKS_EXPOSURE : 0u) | (l->gain > 0 ? HL_LACKS_GAIN : 0u) |
         (l->white_balance[0] > 0 ? HL_LACKS_WHITE_BALANCE : 0u) |
         (l->frame_duration_us > 0 ? HL_LACKS_FRAME_DURATION : 0u) |
         (l->focus_dioptre >= 0 ? HL_LACKS_FOCUS : 0u);
}

void hl_capture_lacks_text(unsigned lacks, char *text, size_t room)
{
  static const char *const names[] = {"exposure", "gain", "white balance", "frame duration",
                                      "focus"};
  size_t n = 0;
  text[0] = '\0';
  for (unsigned i = 0; i < sizeof names / sizeof *names; i++)
    if (lacks >> i & 1u && n < room)
      n += (size_t)snprintf(text + n, room - n, "%s%s", n > 0 ? ", " : "", names[i]);
}

typedef struct comparison {
  unsigned bit;
  const char *name, *unit;
  double shown, asked, first; /* first: of the session; 0 = none yet */
} comparison;

static bool differs(double a, double b, double tolerance)
{
  return !(fabs(a - b) <= tolerance * fabs(b));
}

static bool same(const comparison *c, char *why, size_t room)
{
  if (c->asked <= 0)
    return true;
  if (differs(c->shown, c->asked, ASKED_TOLERANCE)) {
    if (c->shown > 0)
      snprintf(why, room, "its metadata shows %s %.6g%s where %.6g%s is locked", c->name, c->shown,
               c->unit, c->asked, c->unit);
    else
      snprintf(why, room, "its metadata shows no %s", c->name);
    return false;
  }
  if (c->first > 0 && differs(c->shown, c->first, SAME_TOLERANCE)) {
    snprintf(why, room, "its metadata shows %s %.6g%s where the first frame has %.6g%s", c->name,
             c->shown, c->unit, c->first, c->unit);
    return false;
  }
  return true;
}

static bool shows_locked(const hl_capture_plan *plan, unsigned lacks, const hl_session *session,
                         const hl_capture_frame *f, char *why, size_t room)
{
  static const hl_session_frame none = {0};
  const hl_session_frame *first = session->n > 0 ? &session->frame[0] : &none;
  const hl_session_locked *l = &plan->locked;
  const comparison all[] = {
      {HL_LACKS_EXPOSURE, "exposure", " us", f->shown.exposure_us, l->exposure_us,
       first->exposure_us},
      {HL_LACKS_GAIN, "gain", "", f->shown.gain, l->gain, first->gain},
      {HL_LACKS_WHITE_BALANCE, "red gain", "", f->shown.white_balance[0], l->white_balance[0],
       first->white_balance[0]},
      {HL_LACKS_WHITE_BALANCE, "blue gain", "", f->shown.white_balance[1], l->white_balance[1],
       first->white_balance[1]},
      {HL_LACKS_FRAME_DURATION, "frame duration", " us", f->shown.frame_duration_us,
       l->frame_duration_us, 0},
  };
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    if (!(lacks & all[i].bit) && !same(&all[i], why, room))
      return false;
  if (l->focus_dioptre >= 0 && !(lacks & HL_LACKS_FOCUS) &&
      !(fabs(f->shown.focus_dioptre - l->focus_dioptre) <= FOCUS_TOLERANCE)) {
    snprintf(why, room, "its metadata shows focus %.6g dioptres where %.6g is locked",
             f->shown.focus_dioptre, l->focus_dioptre);
    return false;
  }
  return true;
}

bool hl_capture_accepts(const hl_capture_plan *plan, unsigned lacks, const hl_session *session,
                        const hl_capture_frame *frame, char *why, size_t room)
{
  if (!frame->readable) {
    snprintf(why, room, "it cannot be read: %s", frame->why);
    return false;
  }
  if (!shows_locked(plan, lacks, session, frame, why, room))
    return false;
  if (frame->digital_gain > 0 && differs(frame->digital_gain, 1, SAME_TOLERANCE)) {
    snprintf(why, room, "its metadata shows digital gain %.6g where only 1 is accepted",
             frame->digital_gain);
    return false;
  }
  if (session->size_px[0] > 0 &&
      (frame->width != session->size_px[0] || frame->height != session->size_px[1])) {
    snprintf(why, room, "it has %d x %d pixels where the first frame has %d x %d", frame->width,
             frame->height, session->size_px[0], session->size_px[1]);
    return false;
  }
  return true;
}
