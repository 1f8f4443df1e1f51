/* The parts of a capture: which frames are accepted, the folder that grows, the pictures in it. */
#ifndef HL_CAPTURE_WORK_H
#define HL_CAPTURE_WORK_H

#include "halflight/capture.h"

/* The session that a capture writes to, locked against a second capture. */
typedef struct hl_capture_folder {
  hl_session session;
  int lock;         /* file descriptor of the folder; -1 = none */
  bool made, fresh; /* the folder; the session */
  bool *filled;     /* places of the plan */
  int held;         /* of them */
} hl_capture_folder;

/* Controls that a driver may lack and the plan needs. */
unsigned hl_capture_needed(const hl_capture_plan *plan);

/* "exposure, gain" for HL_LACKS_...; "" for none. */
void hl_capture_lacks_text(unsigned lacks, char *text, size_t room);

/* May the frame be recorded? `why` says what is amiss. `lacks`: what its metadata need not show. */
bool hl_capture_accepts(const hl_capture_plan *plan, unsigned lacks, const hl_session *session,
                        const hl_capture_frame *frame, char *why, size_t room);

/* Make the folder or take up what it holds; session.json is on the disk afterwards. */
hl_status hl_capture_folder_open(hl_ctx *ctx, const hl_capture_plan *plan, const char *device,
                                 hl_session_pixels pixels, hl_capture_folder *out);

/* Write the picture and then session.json. On failure the disk holds what it held before. */
hl_status hl_capture_folder_add(hl_ctx *ctx, hl_capture_folder *folder, const hl_capture_plan *plan,
                                const hl_capture_frame *frame, int place, const char *untrusted);

/* First place that is free; plan->n_frames where none is. */
int hl_capture_folder_free_place(const hl_capture_folder *folder, const hl_capture_plan *plan);

/* Release it; a session that was begun by this capture and got no frame is removed again. */
void hl_capture_folder_close(hl_capture_folder *folder);

/* Ending of the pictures that this build writes for such frames: "png" or "pfm". */
const char *hl_capture_picture_ending(int bits);

/* Write the codes to `path`, whole or not at all, as PNG or PFM by their ending as above. */
hl_status hl_capture_picture_write(hl_ctx *ctx, const char *path, const hl_capture_frame *frame);

#endif
