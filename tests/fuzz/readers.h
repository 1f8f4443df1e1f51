/* What reads text or bytes from outside. A new reader is a line here and a function of that name,
 * called fuzz_NAME, in the file of its family. */
#ifndef HL_FUZZ_READERS_H
#define HL_FUZZ_READERS_H

#include <stdint.h>

#include "halflight/halflight.h"

#define HL_FUZZ_READERS(X)                                                                         \
  X(board_pose)                                                                                    \
  X(calibration)                                                                                   \
  X(camera)                                                                                        \
  X(corners)                                                                                       \
  X(fit)                                                                                           \
  X(frame)                                                                                         \
  X(lights)                                                                                        \
  X(lights_import)                                                                                 \
  X(merl)                                                                                          \
  X(options)                                                                                       \
  X(pfm)                                                                                           \
  X(python)                                                                                        \
  X(reflectance)                                                                                   \
  X(samples)                                                                                       \
  X(session)                                                                                       \
  X(sight)                                                                                         \
  X(sphere)                                                                                        \
  X(target)                                                                                        \
  X(term_curve)                                                                                    \
  X(yaml)

/* One input: the bytes, a zero byte after them, and a file that holds them. The status and message go
 * to fuzz.c, which checks them. */
typedef struct fuzz_input {
  const uint8_t *bytes;
  size_t n;
  const char *path;
} fuzz_input;

#define HL_FUZZ_DECLARE(name) hl_status fuzz_##name(hl_ctx *ctx, const fuzz_input *input);
HL_FUZZ_READERS(HL_FUZZ_DECLARE)
#undef HL_FUZZ_DECLARE

/* Stop with a report: `holds` is something that every input must leave true. */
void fuzz_demand(int holds, const char *what, const char *msg);

/* A second file, rewritten with each call; its path. */
const char *fuzz_again(const void *bytes, size_t n);

#endif
