/* Edits of a reflectance from the words of a command line. */
#include "relight_edits.h"

#include <string.h>

#include "options.h"

/* `TERM=rest` as the next edit; *rest is what follows the sign. */
static hl_status begin(hl_ctx *ctx, const char *option, const char *text, hl_relight_edits *edits,
                       const char **rest)
{
  const size_t length = strcspn(text, "=");
  if (edits->n == HL_RELIGHT_EDITS_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "--%s '%.40s' is edit number %d; up to %d are accepted", option,
                   text, edits->n + 1, HL_RELIGHT_EDITS_MAX);
  if (length == 0 || length >= HL_TERM_NAME_MAX || text[length] != '=' || !text[length + 1])
    return hl_fail(ctx, HL_ERR_ARG, "--%s '%.40s': a term, = and its value are needed", option,
                   text);
  memcpy(edits->list[edits->n].term, text, length);
  edits->list[edits->n].term[length] = '\0';
  *rest = text + length + 1;
  return HL_OK;
}

static hl_status append(hl_ctx *ctx, const char *option, const char *text,
                        hl_relight_edit_kind kind, void *member)
{
  hl_relight_edits edits;
  const char *rest = NULL;
  memcpy(&edits, member, sizeof edits);
  hl_status st = begin(ctx, option, text, &edits, &rest);
  if (st != HL_OK)
    return st;
  hl_relight_edit *edit = &edits.list[edits.n++];
  edit->kind = kind;
  if (kind == HL_RELIGHT_REPLACE)
    edit->path = rest;
  else
    st = hl_options_numbers(ctx, option, rest, kind == HL_RELIGHT_AIM ? 2 : 1, edit->number);
  if (st == HL_OK)
    memcpy(member, &edits, sizeof edits);
  return st;
}

hl_status hl_relight_edits_scale(hl_ctx *ctx, const char *text, void *member)
{
  return append(ctx, "scale", text, HL_RELIGHT_SCALE, member);
}

hl_status hl_relight_edits_aim(hl_ctx *ctx, const char *text, void *member)
{
  return append(ctx, "aim", text, HL_RELIGHT_AIM, member);
}

hl_status hl_relight_edits_replace(hl_ctx *ctx, const char *text, void *member)
{
  return append(ctx, "replace", text, HL_RELIGHT_REPLACE, member);
}

hl_status hl_relight_edits_apply(hl_ctx *ctx, const hl_relight_edits *edits,
                                 hl_reflectance *reflectance)
{
  hl_status st = HL_OK;
  for (int i = 0; st == HL_OK && i < edits->n; i++) {
    const hl_relight_edit *e = &edits->list[i];
    if (e->kind == HL_RELIGHT_SCALE)
      st = hl_reflectance_scale(ctx, reflectance, e->term, e->number[0]);
    else if (e->kind == HL_RELIGHT_AIM)
      st = hl_reflectance_aim(ctx, reflectance, e->term, e->number[0], e->number[1]);
    else
      st = hl_reflectance_replace(ctx, reflectance, e->term, e->path);
  }
  return st;
}
