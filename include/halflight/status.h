/**
 * How a call ends, and the caller-owned place that says why.
 *
 * Every function that can fail returns an hl_status and writes its outputs only on HL_OK; the one
 * exception, stated where it holds, is a result that carries its own verdict (hl_light.trusted).
 * Only the place that finds a fault writes the message; everyone above passes the status on.
 */
#ifndef HALFLIGHT_STATUS_H
#define HALFLIGHT_STATUS_H

#include <stddef.h>

#include "halflight/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/** X(name, exit status of the command, text). Append only: the values are ABI. */
#define HL_STATUS_LIST(X)                                                                          \
  X(HL_OK, 0, "ok")                                                                                \
  X(HL_ERR_ARG, 2, "invalid argument or setting")                                                  \
  X(HL_ERR_MEMORY, 1, "out of memory")                                                             \
  X(HL_ERR_IO, 1, "file or device failed")                                                         \
  X(HL_ERR_FORMAT, 1, "malformed input")                                                           \
  X(HL_ERR_UNAVAILABLE, 1, "feature not in this build")                                            \
  X(HL_ERR_DEGENERATE, 3, "input does not determine the answer")                                   \
  X(HL_ERR_RESIDUAL, 3, "residual above the accepted limit")                                       \
  X(HL_ERR_NOT_CONVERGED, 3, "tolerance not reached")

/** How a function ended. */
typedef enum hl_status {
#define HL_STATUS_ENUM(name, exit_status, text) name,
  HL_STATUS_LIST(HL_STATUS_ENUM)
#undef HL_STATUS_ENUM
      HL_STATUS_COUNT
} hl_status;

enum { HL_MESSAGE_MAX = 320 };

/** Start with `hl_ctx ctx = {0};`, one a thread. Every function accepts NULL instead. */
typedef struct hl_ctx {
  hl_status status;                            /* of the last failure */
  char msg[HL_MESSAGE_MAX];                    /* meaningful only after a call returned non-zero */
  void (*trace)(void *user, const char *line); /* NULL = silent; the library never prints */
  void *trace_user;
} hl_ctx;

/** Constant text of a status; "unknown status" outside the list. Never NULL. */
HL_API const char *hl_status_text(hl_status status);

/** Exit status of the command for a status (design: 0 done, 1 failed, 2 usage, 3 not to be
 * trusted). */
HL_API int hl_status_exit(hl_status status);

/**
 * Record a failure: one line that says what, where, which value and what would be accepted. Control
 * characters in it become '?'.
 * @return `status`, so that the finder of a fault can `return hl_fail(ctx, ...)`
 */
HL_API hl_status hl_fail(hl_ctx *ctx, hl_status status, const char *format, ...) HL_PRINTF(3, 4);

/** Hand one line to the trace callback, if there is one. */
HL_API void hl_trace(hl_ctx *ctx, const char *format, ...) HL_PRINTF(2, 3);

#ifdef __cplusplus
}
#endif
#endif
