/**
 * A recorded session replayed: every frame's light, all of them with one pose of the ball.
 *
 * 1. The pose of each ball from the outlines of up to `pose_frames` frames, spread evenly over the
 *    session: they are lit from many sides and show the whole rim between them.
 * 2. Frame by frame, in parallel: the outline against that pose (a moved ball or camera), the light,
 *    and what the shading says about the pose (src/light_pose.c).
 * 3. The pose once more, from the shading of all frames together with the outlines; kept only where
 *    frames that had no part in it are then explained better.
 *
 * What is found does not depend on the number of jobs, nor on whether a run was interrupted.
 */
#ifndef HALFLIGHT_REPLAY_H
#define HALFLIGHT_REPLAY_H

#include "halflight/lights.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How to replay. */
typedef struct hl_replay_settings {
  int jobs;            /* frames worked on at once; 0 = as many as the machine has */
  bool no_joint;       /* the pose of the outlines is kept */
  bool frame_by_frame; /* each frame has the pose of its own outline; nothing is shared */
  int pose_frames;     /* outlines read for the common pose, at most */
  hl_light_settings light;
} hl_replay_settings;

/** The defaults; they pass their own check. */
HL_API hl_replay_settings hl_replay_defaults(void);
/** Name, unit, bounds and text of every setting. */
HL_API const hl_field_table *hl_replay_fields(void);

/** What a caller may watch and stop. Both are called by one thread at a time; NULL members are not. */
typedef struct hl_replay_watch {
  void (*progress)(void *user, int done, int total);
  bool (*stop)(void *user); /* true: finish the frames begun and return */
  void *user;
} hl_replay_watch;

/** What a run did, which the next one may do otherwise; nothing of it is in the results. */
typedef struct hl_replay_summary {
  int n_frames, n_reused, n_failed; /* frames; results found from an earlier run; without a light */
  bool stopped; /* by the caller: `out` is empty, what was done is in the folder */
} hl_replay_summary;

/**
 * @param folder where FRAME's results go, "frames/00000.json" and on, each whole or not at all, and
 *        where those of an earlier run are looked for; made where it is missing. Each is a LIGHT.json
 *        of its frame at the outlines' pose, with a member `replay` that says from what it was made. NULL
 *        keeps nothing.
 * @param settings NULL means hl_replay_defaults(); `watch` and `summary` may be NULL
 * @param out      on HL_OK the caller's, hl_lights_free
 * @return HL_OK, also where lights are not to be trusted (out->trusted) or the run was stopped
 *         (summary->stopped, out empty); HL_ERR_ARG; HL_ERR_IO (folder, camera); HL_ERR_FORMAT (camera,
 *         ball, no frames); HL_ERR_DEGENERATE (no frame shows the ball); HL_ERR_MEMORY.
 *         A frame that is missing, broken, of another size or without a light is no failure: its
 *         reasons say what was wrong.
 * Memory: one frame and one workspace a job, and some kilobytes a frame of results.
 */
HL_API hl_status hl_replay(hl_ctx *ctx, const hl_session *session, const char *folder,
                           const hl_replay_settings *settings, const hl_replay_watch *watch,
                           hl_replay_summary *summary, hl_lights *out);

#ifdef __cplusplus
}
#endif
#endif
