/* A session: the input is its session.json. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "readers.h"

static char folder[] = "/tmp/halflight-fuzz-XXXXXX";
static char document[64];

static void remove_folder(void)
{
  unlink(document);
  rmdir(folder);
}

/* session.json of the folder is a link to `target`, so that nothing is written to a disk. */
static void point_to(const char *target)
{
  if (!document[0]) {
    fuzz_demand(mkdtemp(folder) != NULL, "a folder can be made", folder);
    snprintf(document, sizeof document, "%s/session.json", folder);
    atexit(remove_folder);
  }
  unlink(document);
  fuzz_demand(symlink(target, document) == 0, "a link can be made", document);
}

hl_status fuzz_session(hl_ctx *ctx, const fuzz_input *input)
{
  hl_session session = {0};
  point_to(input->path);
  const hl_status st = hl_session_read(ctx, folder, &session);
  if (st != HL_OK)
    return st;
  hl_ctx inner = {0};
  char *text = NULL;
  hl_session again = {0};
  fuzz_demand(hl_session_json(&inner, &session, &text) == HL_OK, "what was read can be written",
              inner.msg);
  point_to(fuzz_again(text, strlen(text)));
  fuzz_demand(hl_session_read(&inner, folder, &again) == HL_OK, "what was written can be read",
              inner.msg);
  fuzz_demand(again.n == session.n && again.n_balls == session.n_balls, "nothing is lost", "");
  free(text);
  hl_session_free(&again);
  hl_session_free(&session);
  return HL_OK;
}
