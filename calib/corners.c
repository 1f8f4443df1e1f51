/* The corners of a target in a number of views: the set that owns them. */
#include "halflight/corners.h"

#include <stdlib.h>
#include <string.h>

hl_corners hl_corners_of(const hl_target *target)
{
  return (hl_corners){.target = *target};
}

void hl_corners_free(hl_corners *corners)
{
  if (!corners)
    return;
  for (int i = 0; i < corners->n_views; i++)
    free(corners->view[i].corner);
  free(corners->view);
  *corners = (hl_corners){.target = corners->target};
}

static hl_status grow(hl_ctx *ctx, hl_corners *corners)
{
  if (corners->n_views < corners->room)
    return HL_OK;
  const int room = corners->room > 0 ? 2 * corners->room : 16;
  hl_view *view = room <= HL_VIEWS_MAX ? realloc(corners->view, (size_t)room * sizeof *view) : NULL;
  if (!view)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d views; up to %d are kept", room,
                   HL_VIEWS_MAX);
  corners->view = view;
  corners->room = room;
  return HL_OK;
}

hl_status hl_corners_add(hl_ctx *ctx, hl_corners *corners, const char *name, hl_view **out)
{
  const size_t length = name ? strlen(name) : 0;
  if (length == 0 || length >= HL_VIEW_NAME_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "name of view %d has %zu bytes; 1 .. %d are accepted",
                   corners->n_views, length, HL_VIEW_NAME_MAX - 1);
  const hl_status st = grow(ctx, corners);
  if (st != HL_OK)
    return st;
  const int n = hl_target_corners(&corners->target);
  hl_corner *corner = calloc((size_t)n, sizeof *corner);
  if (!corner)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %d corners", name, n);
  hl_view *view = &corners->view[corners->n_views++];
  *view = (hl_view){.corner = corner, .used = true};
  memcpy(view->name, name, length + 1);
  *out = view;
  return HL_OK;
}
