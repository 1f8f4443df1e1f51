/**
 * A recorded session: a folder with a list of frames and what was locked while they were taken.
 *
 * SESSION/session.json, written whole or not at all, grows frame by frame:
 *
 *   {"format":"halflight-session","version":1,"camera"?:"camera.json","sphere"?:"sphere.json"|null,
 *    "radius_m"?:R,"circle_px"?:[x,y,r],"balls"?:[{"sphere"?,"radius_m"?,"circle_px"?}],
 *    "transfer"?,"gamma"?,"black"?,"saturation"?,"device"?,"pixels"?,"size_px"?:[w,h],"locked"?:{...},
 *    "frames":[{"file","label"?,"timestamp_ns"?,"exposure_us"?,"gain"?,"digital_gain"?,
 *               "white_balance"?:[r,b],"sha256"?,"untrusted"?}],
 *    "faults"?:[{"frame","kind"}]}
 *
 * All paths are relative to the folder and stay within it, links followed. src/doc/session.md
 * explains every member.
 */
#ifndef HALFLIGHT_SESSION_H
#define HALFLIGHT_SESSION_H

#include <stdint.h>

#include "halflight/frame.h"
#include "halflight/sphere.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { HL_BALLS_MAX = 8 };

/** One frame as the session states it. The texts are owned by the session. */
typedef struct hl_session_frame {
  char *file;  /* relative to the folder, never NULL */
  char *label; /* of the light that was on; "" where there is none */
  int64_t timestamp_ns;
  double exposure_us, gain; /* 0 = not stated */
  double white_balance[2];  /* gains of red and blue; 0 = not stated */
  char sha256[65];          /* of the file's bytes, lower-case hex; "" = not stated */
  double digital_gain;      /* 0 = not stated */
  char *untrusted;          /* why its settings are not known to hold; NULL or "" = they do */
} hl_session_frame;

/** One ball of the session. */
typedef struct hl_session_ball {
  char *sphere;        /* SPHERE.json, relative; NULL: to be found with radius_m */
  double radius_m;     /* 0 = not stated: `sphere` says it, or nobody does */
  double circle_px[3]; /* x, y, r near which to look; r 0 = anywhere */
} hl_session_ball;

/** What was locked while the frames were taken; 0 = not stated. */
typedef struct hl_session_locked {
  double exposure_us, gain, white_balance[2], frame_duration_us;
  double focus_dioptre; /* 0 is infinity, so below 0 = not stated */
} hl_session_locked;

/** What the pixels of the frames are. */
typedef enum hl_session_pixels {
  HL_PIXELS_UNSTATED,
  HL_PIXELS_RAW_GREEN, /* "raw-green": mean of the two green samples of each 2 x 2 Bayer cell */
  HL_PIXELS_RAW_DEMOSAICED, /* "raw-demosaiced": linear, one colour a pixel of the sensor */
  HL_PIXELS_PROCESSED       /* "processed": as the camera's own pipeline had them */
} hl_session_pixels;

/** A fault for a recorded session to play (halflight/capture.h). */
typedef enum hl_session_fault_kind {
  HL_FAULT_DROPPED,      /* "dropped": the frame never arrives, the count goes on */
  HL_FAULT_EXPOSURE,     /* "exposure": its metadata shows another exposure */
  HL_FAULT_FAILED_READ,  /* "failed-read": it arrives but cannot be read */
  HL_FAULT_VANISH,       /* "vanish": the camera is gone from here on */
  HL_FAULT_DIGITAL_GAIN, /* "digital-gain": its metadata shows a digital gain of 1.5 */
  HL_FAULT_SLOW_LOCK /* "slow-lock": after the start, `frame` frames still show other settings */
} hl_session_fault_kind;

/** What a recorded camera does wrong at one frame. */
typedef struct hl_session_fault {
  int frame; /* from 0 */
  hl_session_fault_kind kind;
} hl_session_fault;

/** Owner of everything in it; hl_session_free releases. */
typedef struct hl_session {
  char *folder; /* as given */
  char *camera; /* CAMERA file, relative to folder; "" = not stated; malloc's */
  int n_balls;  /* at least 1; "sphere" and "radius_m" of the file are ball 0 */
  hl_session_ball ball[HL_BALLS_MAX];
  hl_frame_settings frame_settings; /* how codes become radiance; defaults where not stated */
  int n, capacity;
  hl_session_frame *frame;
  char *device; /* the camera's name at the driver; "" = not stated; malloc's */
  hl_session_pixels pixels;
  int size_px[2]; /* width, height; 0 = not stated */
  hl_session_locked locked;
  int n_faults;
  hl_session_fault *fault;
} hl_session;

/**
 * Read and check SESSION/session.json. Frames are not opened; whether paths stay within the folder
 * is looked up on the disk, links followed.
 * @return HL_OK; HL_ERR_IO (no such folder or file); HL_ERR_FORMAT (malformed, newer version, a path
 *         that leaves the folder, a frame listed twice; a session without frames is accepted: n = 0);
 *         HL_ERR_MEMORY. O(n log n).
 */
HL_API hl_status hl_session_read(hl_ctx *ctx, const char *folder, hl_session *out);

/** Start an empty session in memory; nothing is written yet, and the folder need not exist.
 * HL_ERR_MEMORY. */
HL_API hl_status hl_session_new(hl_ctx *ctx, const char *folder, hl_session *out);

/**
 * Append a frame in memory; its texts are copied, NULL for "" where a text may be "".
 * @return HL_OK; HL_ERR_ARG (no plain relative path, a file listed before, a text that is not UTF-8,
 *         a value that hl_session_read would refuse); HL_ERR_MEMORY. O(n).
 */
HL_API hl_status hl_session_append(hl_ctx *ctx, hl_session *session, const hl_session_frame *frame);

/** Session.json as text; *out is the caller's, release it with free(). HL_ERR_MEMORY. */
HL_API hl_status hl_session_json(hl_ctx *ctx, const hl_session *session, char **out);

/** Write session.json, whole or not at all. HL_ERR_IO leaves what was there. */
HL_API hl_status hl_session_write(hl_ctx *ctx, const hl_session *session);

/**
 * Path of a file of the session, checked on the disk to stay within the folder; the caller releases
 * it with free(). The file need not exist.
 * @return HL_OK; HL_ERR_FORMAT (leaves the folder); HL_ERR_IO (no such folder); HL_ERR_MEMORY
 */
HL_API hl_status hl_session_path(hl_ctx *ctx, const hl_session *session, const char *file,
                                 char **out);

/** SHA-256 (FIPS 180-4) of a file as 64 hex digits and a zero. HL_ERR_IO. */
HL_API hl_status hl_file_sha256(hl_ctx *ctx, const char *path, char out[65]);

/** "raw-green", "exposure" and so on; "" outside the lists. */
HL_API const char *hl_session_pixels_text(hl_session_pixels pixels);
/** The name of a fault in session.json; "" outside the list. */
HL_API const char *hl_session_fault_text(hl_session_fault_kind kind);

/** Release what the session holds and zero it; NULL and zeroed sessions are accepted. */
HL_API void hl_session_free(hl_session *session);

#ifdef __cplusplus
}
#endif
#endif
