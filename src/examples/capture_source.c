/* A camera of one's own behind hl_capture_source, here one that invents its frames:
 * `capture_source SESSION` records four of them there; a second run finds them. */
#include <halflight/halflight.h>
#include <stdio.h>
#include <string.h>

enum { SIDE = 32 };

typedef struct invented {
  float codes[SIDE * SIDE]; /* the frame that was last handed over */
  hl_session_locked locked;
  int64_t taken;
} invented;

static hl_status open_it(hl_ctx *ctx, void *state, const char *id, hl_session_pixels *pixels,
                         hl_capture_camera *opened)
{
  (void)ctx, (void)state, (void)id;
  *pixels = HL_PIXELS_RAW_GREEN;
  *opened = (hl_capture_camera){.id = "invented", .model = "none"};
  return HL_OK;
}

static hl_status lock(hl_ctx *ctx, void *state, const hl_session_locked *locked, unsigned *lacks)
{
  (void)ctx;
  ((invented *)state)->locked = *locked; /* a driver would set its controls here */
  *lacks = HL_LACKS_FOCUS;
  return HL_OK;
}

static hl_status start(hl_ctx *ctx, void *state, int first)
{
  (void)ctx, (void)state, (void)first;
  return HL_OK;
}

static hl_status next(hl_ctx *ctx, void *state, hl_capture_frame *frame)
{
  invented *it = state;
  (void)ctx;
  for (int i = 0; i < SIDE * SIDE; i++)
    it->codes[i] = (float)(it->taken + i) / (SIDE * SIDE);
  memset(frame, 0, sizeof *frame);
  frame->readable = true;
  frame->place = -1; /* a recorded session would say which of its frames this is */
  frame->count = it->taken;
  frame->codes = it->codes;
  frame->width = frame->height = SIDE;
  frame->channels = 1, frame->bits = 32;
  frame->timestamp_ns = 40000000 * it->taken++;
  frame->shown = it->locked;
  frame->digital_gain = 1;
  return HL_OK;
}

static void nothing(void *state)
{
  (void)state;
}

int main(int argc, char **argv)
{
  static invented camera;
  const hl_capture_source source = {"invented", &camera, NULL,    open_it, lock,
                                    start,      next,    nothing, nothing};
  const hl_capture_plan plan = {.folder = argc == 2 ? argv[1] : "",
                                .n_frames = 4,
                                .locked = {.exposure_us = 8000, .gain = 1, .focus_dioptre = -1}};
  hl_ctx ctx = {0};
  hl_capture_result result = {0};
  const hl_status st = hl_capture_run(&ctx, &source, &plan, &result);
  source.close(source.state);
  if (st != HL_OK)
    fprintf(stderr, "capture_source: %s\n", ctx.msg);
  printf("%d of %d frames from %s, %d of them now\n", result.held, plan.n_frames, result.device,
         result.recorded);
  return hl_status_exit(st);
}
