/* Statuses, their texts, and the one place that writes a message. */
#include "halflight/status.h"

#include <stdarg.h>
#include <stdio.h>

const char *hl_status_text(hl_status status)
{
  switch (status) {
#define TEXT(name, exit_status, text)                                                              \
  case name:                                                                                       \
    return text;
    HL_STATUS_LIST(TEXT)
#undef TEXT
  case HL_STATUS_COUNT:
    break;
  }
  return "unknown status";
}

int hl_status_exit(hl_status status)
{
#define EXIT(name, exit_status, text) exit_status,
  static const int exits[] = {HL_STATUS_LIST(EXIT)};
#undef EXIT
  return (unsigned)status < HL_STATUS_COUNT ? exits[status] : 1;
}

hl_status hl_fail(hl_ctx *ctx, hl_status status, const char *format, ...)
{
  if (!ctx)
    return status;
  va_list args;
  va_start(args, format);
  vsnprintf(ctx->msg, sizeof ctx->msg, format, args);
  va_end(args);
  /* one line, whatever the files and names hold that it quotes */
  for (char *c = ctx->msg; *c; c++)
    if ((unsigned char)*c < 0x20 || *c == 0x7f)
      *c = '?';
  ctx->status = status;
  return status;
}

void hl_trace(hl_ctx *ctx, const char *format, ...)
{
  if (!ctx || !ctx->trace)
    return;
  char line[HL_MESSAGE_MAX];
  va_list args;
  va_start(args, format);
  vsnprintf(line, sizeof line, format, args);
  va_end(args);
  ctx->trace(ctx->trace_user, line);
}
