/**
 * Frames from a camera into a session, with everything locked that would change them.
 *
 * A source is a camera behind one C interface: libcamera's, or a recorded session that plays as a
 * camera, with its timing and its faults. hl_capture_run locks exposure, gain, white balance, frame
 * duration and focus, lets frames pass until their metadata shows the values, and then writes frame
 * by frame: the picture first, session.json after it, each whole or not at all, so that a session
 * that is interrupted at any moment is whole up to its last frame, and the same call takes the rest.
 */
#ifndef HALFLIGHT_CAPTURE_H
#define HALFLIGHT_CAPTURE_H

#include <stdbool.h>
#include <stdint.h>

#include "halflight/session.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Controls that a driver may lack. */
enum {
  HL_LACKS_EXPOSURE = 1,
  HL_LACKS_GAIN = 2,
  HL_LACKS_WHITE_BALANCE = 4,
  HL_LACKS_FRAME_DURATION = 8,
  HL_LACKS_FOCUS = 16
};

/** A camera that a source found. */
typedef struct hl_capture_camera {
  char id[256];    /* what --camera-id takes */
  char model[128]; /* "" = not stated */
} hl_capture_camera;

/** One frame as the source hands it over. Pixels belong to the source, until its next call. */
typedef struct hl_capture_frame {
  bool readable;     /* false: it was taken, but its pixels did not arrive; `why` says more */
  int place;         /* in the recorded session, from 0; -1: a live camera has none */
  int64_t count;     /* of the frames the sensor took; a gap is a dropped frame */
  const void *codes; /* shape (height, width, channels), uint16_t (bits 16) or float (bits 32) */
  int width, height, channels, bits;
  hl_frame_settings codes_mean; /* how the codes become radiance */
  int64_t timestamp_ns;
  hl_session_locked shown; /* what the metadata shows; 0, focus below 0: it does not */
  double digital_gain;     /* 0 = the metadata does not show it */
  char why[HL_MESSAGE_MAX];
} hl_capture_frame;

/**
 * A camera. Calls come in this order: list (at any time), open, lock, start, next ..., stop, close.
 * Each returns HL_OK or what hl_fail returned. hl_capture_run makes all of them but list and close;
 * whoever made the source closes it once, which releases `state`.
 */
typedef struct hl_capture_source {
  const char *name; /* "libcamera", "recorded" */
  void *state;
  /** *cameras is the caller's (free). None is HL_OK with *n = 0. */
  hl_status (*list)(hl_ctx *ctx, void *state, hl_capture_camera **cameras, int *n);
  /** `id` "" is the first camera; *pixels is what the frames should hold, unstated for the source's
   * own choice, and receives what they do. *opened names the camera. */
  hl_status (*open)(hl_ctx *ctx, void *state, const char *id, hl_session_pixels *pixels,
                    hl_capture_camera *opened);
  /** Values to hold from the start on; *lacks has a bit for each that the driver cannot. */
  hl_status (*lock)(hl_ctx *ctx, void *state, const hl_session_locked *locked, unsigned *lacks);
  /** `first` is the place a recorded session starts from; a live camera ignores it. */
  hl_status (*start)(hl_ctx *ctx, void *state, int first);
  /** Wait for a frame. HL_ERR_IO: the camera is gone. */
  hl_status (*next)(hl_ctx *ctx, void *state, hl_capture_frame *frame);
  void (*stop)(void *state);
  void (*close)(void *state);
} hl_capture_source;

/** libcamera's cameras. HL_ERR_UNAVAILABLE in a build without it; HL_ERR_IO; HL_ERR_MEMORY. */
HL_API hl_status hl_capture_libcamera(hl_ctx *ctx, hl_capture_source *out);

/**
 * A session folder as a camera: its frames in their order, `faults` of session.json played.
 * @param full_speed frames follow each other at once; else as their timestamps do
 * @return HL_OK, or as hl_session_read
 */
HL_API hl_status hl_capture_recorded(hl_ctx *ctx, const char *folder, bool full_speed,
                                     hl_capture_source *out);

/** What to record. */
typedef struct hl_capture_plan {
  const char *folder; /* the session; it is made where it does not exist */
  int n_frames;       /* it is to hold, those of earlier calls included */
  hl_session_pixels pixels;
  const char *const *labels; /* n_frames of them, of the lights; NULL: none */
  const char *camera_id;     /* "" or NULL: the first camera */
  hl_session_locked locked;  /* exposure and gain always; white balance unless the pixels are raw */
  const hl_camera *camera;   /* calibrated; its file is put beside the frames. NULL: none */
  double radius_m;           /* of the ball; 0 = not stated */
  int settle_frames;         /* so many may pass before the values show; 0 = 60 */
  bool (*go_on)(void *user, int done, int total); /* after each frame; false ends. May be NULL */
  void *user;
} hl_capture_plan;

/** What became of it; meaningful however hl_capture_run ended. */
typedef struct hl_capture_result {
  int recorded;     /* frames, by this call */
  int held;         /* frames of the plan that the session holds now */
  int refused;      /* frames that came but were not recorded */
  bool stopped;     /* by go_on */
  unsigned lacks;   /* HL_LACKS_... among what the plan locks: the frames are marked untrusted */
  char device[256]; /* id of the camera */
} hl_capture_result;

/**
 * Record. Where the folder holds a session already, the frames that it lacks are taken, provided
 * that camera, pixels, size, labels and locked values are the same.
 *
 * A frame is refused, and its place in the session left free, where it was dropped by the camera,
 * cannot be read, has another size than the first, shows other settings than were locked or a
 * digital gain that is not 1.
 *
 * @return HL_OK; HL_ERR_ARG (the plan; a session that does not agree with it); HL_ERR_IO (no camera,
 *         it is gone, the values never show, the disk is full, another capture is at work there, a
 *         frame was refused); HL_ERR_FORMAT (a damaged session); HL_ERR_UNAVAILABLE; HL_ERR_MEMORY.
 *         Whatever it returns, the folder's session is whole and holds what was recorded.
 */
HL_API hl_status hl_capture_run(hl_ctx *ctx, const hl_capture_source *source,
                                const hl_capture_plan *plan, hl_capture_result *result);

#ifdef __cplusplus
}
#endif
#endif
