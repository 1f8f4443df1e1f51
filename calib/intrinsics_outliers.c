/*
 * What stands out is left out, and the rest is solved again.
 *
 * A corner stands out against the noise of all corners and against that of its own view, both from
 * medians: of N points in the plane with deviation s along each axis, half lie within s sqrt(2 ln 2).
 * A view stands out by the rms of what is left of it against the median rms of the views. In each
 * round the corners are judged anew, so that one that only suffered from its neighbour comes back;
 * views do not come back. Nothing leaves that would leave too little.
 */
#include <math.h>
#include <stdlib.h>

#include "intrinsics.h"

enum { ROUNDS_MAX = 8, CORNERS_ALONE = 2, CORNERS_LEFT_MIN = 8 };

static const double median_radius = 1.1774100225154747; /* sqrt(2 ln 2) */

static const double finest_px = 1e-4; /* no noise is less */

static int compare(const void *a, const void *b)
{
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double median(double *values, int n)
{
  qsort(values, (size_t)n, sizeof *values, compare);
  return n > 0 ? (values[(n - 1) / 2] + values[n / 2]) / 2 : 0;
}

/* Size of every residual of a view, used or not; returns how many. */
static int sizes(const hl_intrinsics *p, const hl_intrinsics_view *view, double *out)
{
  for (int c = 0; c < view->n; c++) {
    double r[2];
    out[c] = hl_sighting_residual(&p->camera, &view->pose, &view->sighting[c], r)
                 ? hypot(r[0], r[1])
                 : HUGE_VAL;
  }
  return view->n;
}

/* Deviation of the noise along one axis, over all used views. `room` holds every corner. */
static double noise(const hl_intrinsics *p, double *room)
{
  int n = 0;
  for (int i = 0; i < p->n_views; i++)
    if (p->view[i].used)
      n += sizes(p, &p->view[i], room + n);
  return median(room, n) / median_radius;
}

/* Judge a view's corners; true where one changed sides. */
static bool sift_corners(const hl_intrinsics *p, hl_intrinsics_view *view, double all, double *room)
{
  const int n = sizes(p, view, room);
  const double own = median(room, n) / median_radius;
  const double limit = p->settings->outlier_sigmas * fmax(fmax(all, own), finest_px);
  bool changed = false;
  int left = 0;
  sizes(p, view, room); /* the median has sorted them */
  for (int c = 0; c < n; c++)
    left += room[c] <= limit;
  if (left < CORNERS_LEFT_MIN)
    return false;
  for (int c = 0; c < n; c++) {
    const bool used = room[c] <= limit;
    changed = changed || used != view->sighting[c].used;
    view->sighting[c].used = used;
  }
  return changed;
}

static double view_rms(const hl_intrinsics *p, const hl_intrinsics_view *view)
{
  return sqrt(hl_sightings_cost(&p->camera, &view->pose, view->sighting, view->n) /
              hl_sightings_used(view->sighting, view->n));
}

/* The view that stands out most, NULL where none does. */
static hl_intrinsics_view *worst_view(const hl_intrinsics *p, double limit)
{
  hl_intrinsics_view *worst = NULL;
  for (int i = 0; i < p->n_views; i++) {
    hl_intrinsics_view *view = &p->view[i];
    if (view->used && view_rms(p, view) > (worst ? view_rms(p, worst) : limit))
      worst = view;
  }
  return worst;
}

/* True where a view left. */
static bool sift_views(hl_intrinsics *p, double *room)
{
  int used = 0;
  bool changed = false;
  for (int i = 0; i < p->n_views; i++)
    if (p->view[i].used)
      room[used++] = view_rms(p, &p->view[i]);
  const double middle = fmax(median(room, used), finest_px);
  for (; used > p->settings->min_views; used--) {
    hl_intrinsics_view *view = worst_view(p, p->settings->view_ratio * middle);
    if (!view)
      break;
    hl_intrinsics_leave_out(view, "rms %.3g px, %.2g times the median", view_rms(p, view),
                            view_rms(p, view) / middle);
    changed = true;
  }
  return changed;
}

hl_status hl_intrinsics_sift(hl_ctx *ctx, hl_intrinsics *p)
{
  int corners = 0;
  for (int i = 0; i < p->n_views; i++)
    corners += p->view[i].n;
  double *room = malloc((size_t)(corners + p->n_views) * sizeof *room);
  hl_status st = HL_OK;
  if (!room)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d corners", corners);
  for (int round = 0; round < ROUNDS_MAX && st == HL_OK; round++) {
    bool changed = false;
    const double all = noise(p, room);
    for (int i = 0; i < p->n_views && p->settings->outlier_sigmas > 0; i++)
      if (p->view[i].used && sift_corners(p, &p->view[i], all, room))
        changed = true;
    /* first the corners alone: a single one far off spoils its view */
    if ((!changed || round >= CORNERS_ALONE) && p->settings->view_ratio > 0 && sift_views(p, room))
      changed = true;
    if (!changed)
      break;
    st = hl_intrinsics_solve(ctx, p);
  }
  free(room);
  return st;
}
