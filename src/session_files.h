/* Paths of a session stay within its folder. */
#ifndef HL_SESSION_FILES_H
#define HL_SESSION_FILES_H

#include <stdbool.h>

#include "halflight/status.h"

/* Relative, and every component a name: not "", "." or "..". */
bool hl_session_plain(const char *file);

/* Does folder/file, links followed, lie within `folder`? What does not exist lies where the part of
 * its path that exists does. `what` (never NULL) goes before the message.
 * HL_ERR_FORMAT; HL_ERR_IO (the folder itself); HL_ERR_MEMORY. */
hl_status hl_session_inside(hl_ctx *ctx, const char *what, const char *folder, const char *file);

/* "folder/file"; NULL without memory. The caller's. */
char *hl_session_join(const char *folder, const char *file);

#endif
