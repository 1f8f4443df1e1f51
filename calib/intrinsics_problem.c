/*
 * What a calibration starts from: the corners of every view, and which views can be used at all.
 *
 * A view needs corners that span its plane, and the board's front. The affine map L that fits best
 * from board to pixels, L = M_pb M_bb^-1 with M the centred second moments, keeps the sense of
 * rotation of a board seen from the front: det L > 0. One that reverses it shows a mirrored board,
 * or corners that were counted in another order; as it fits a board seen from behind without any
 * residual, nothing later would notice.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/vec3.h"
#include "intrinsics.h"

enum { VIEW_CORNERS_MIN = 8, CELLS = 10 };

static const double degrees = 180 / 3.14159265358979323846;

static const double flat = 1e-6;         /* of a square's determinant: corners in a row */
static const double beyond_frame = 0.02; /* of the frame's longer side */

void hl_intrinsics_leave_out(hl_intrinsics_view *view, const char *format, ...)
{
  va_list args;
  va_start(args, format);
  vsnprintf(view->why, sizeof view->why, format, args);
  va_end(args);
  view->used = false;
}

int hl_intrinsics_views_used(const hl_intrinsics *problem)
{
  int n = 0;
  for (int i = 0; i < problem->n_views; i++)
    n += problem->view[i].used;
  return n;
}

int hl_intrinsics_corners_used(const hl_intrinsics *problem)
{
  int n = 0;
  for (int i = 0; i < problem->n_views; i++)
    if (problem->view[i].used)
      n += hl_sightings_used(problem->view[i].sighting, problem->view[i].n);
  return n;
}

int hl_intrinsics_freedom(const hl_intrinsics *problem)
{
  return 2 * hl_intrinsics_corners_used(problem) - hl_camera_intrinsics_count(&problem->camera) -
         HL_POSE_SIZE * hl_intrinsics_views_used(problem);
}

double hl_intrinsics_coverage(const hl_intrinsics *p)
{
  bool seen[CELLS][CELLS] = {{false}};
  int cells = 0;
  for (int i = 0; i < p->n_views; i++)
    for (int c = 0; p->view[i].used && c < p->view[i].n; c++) {
      const hl_sighting *s = &p->view[i].sighting[c];
      const int x = (int)floor(CELLS * (s->pixel[0] + 0.5) / p->camera.width);
      const int y = (int)floor(CELLS * (s->pixel[1] + 0.5) / p->camera.height);
      if (!s->used || x < 0 || x >= CELLS || y < 0 || y >= CELLS || seen[y][x])
        continue;
      seen[y][x] = true;
      cells++;
    }
  return (double)cells / (CELLS * CELLS);
}

static void normal_of(const hl_intrinsics_view *view, double out[3])
{
  double r[3][3];
  hl_pose_matrix(&view->pose, r);
  for (int i = 0; i < 3; i++)
    out[i] = r[i][2];
}

double hl_intrinsics_tilt_deg(const hl_intrinsics *p)
{
  double widest = 0;
  for (int i = 0; i < p->n_views; i++)
    for (int k = 0; k < i; k++) {
      double a[3], b[3];
      if (!p->view[i].used || !p->view[k].used)
        continue;
      normal_of(&p->view[i], a);
      normal_of(&p->view[k], b);
      widest = fmax(widest, hl_angle(a, b) * degrees);
    }
  return widest;
}

typedef struct moments {
  double board[2][2], across[2][2]; /* board by board, pixel by board */
} moments;

static moments moments_of(const hl_intrinsics_view *view)
{
  moments m = {0};
  double board[2] = {0}, pixel[2] = {0};
  for (int c = 0; c < view->n; c++)
    for (int i = 0; i < 2; i++) {
      board[i] += view->sighting[c].board_m[i] / view->n;
      pixel[i] += view->sighting[c].pixel[i] / view->n;
    }
  for (int c = 0; c < view->n; c++)
    for (int i = 0; i < 2; i++)
      for (int k = 0; k < 2; k++) {
        const double b = view->sighting[c].board_m[k] - board[k];
        m.board[i][k] += (view->sighting[c].board_m[i] - board[i]) * b;
        m.across[i][k] += (view->sighting[c].pixel[i] - pixel[i]) * b;
      }
  return m;
}

static double determinant(double m[2][2])
{
  return m[0][0] * m[1][1] - m[0][1] * m[1][0];
}

static void look_at(hl_intrinsics_view *view)
{
  if (!view->source->used) {
    const char *why = view->source->why;
    hl_intrinsics_leave_out(view, "%s", why[0] ? why : "left out");
    return;
  }
  if (view->n == 0) {
    hl_intrinsics_leave_out(view, "no corner is seen");
    return;
  }
  if (view->n < VIEW_CORNERS_MIN) {
    hl_intrinsics_leave_out(view, "only %d corners; at least %d are needed", view->n,
                            VIEW_CORNERS_MIN);
    return;
  }
  moments m = moments_of(view);
  const double half_trace = (m.board[0][0] + m.board[1][1]) / 2;
  if (!(determinant(m.board) > flat * half_trace * half_trace))
    hl_intrinsics_leave_out(view, "its %d corners lie in a row, which says nothing about a plane",
                            view->n);
  else if (!(determinant(m.across) > 0))
    hl_intrinsics_leave_out(view, "the board is seen mirrored, or its corners are counted in "
                                  "another order than row by row from the top left");
}

/* Frames of another size than stated. */
static hl_status check_inside(hl_ctx *ctx, const hl_corners *corners,
                              const hl_intrinsics_view *view)
{
  const double margin = beyond_frame * fmax(corners->width, corners->height);
  for (int i = 0; i < view->n; i++) {
    const hl_sighting *s = &view->sighting[i];
    const bool inside = s->pixel[0] >= -margin && s->pixel[0] <= corners->width - 1 + margin &&
                        s->pixel[1] >= -margin && s->pixel[1] <= corners->height - 1 + margin;
    if (!inside)
      return hl_fail(ctx, HL_ERR_FORMAT,
                     "%.80s: corner %d at (%.1f, %.1f) px is outside the frame of %d x %d px; the "
                     "size of the frames it was seen in is needed",
                     view->source->name, s->index, s->pixel[0], s->pixel[1], corners->width,
                     corners->height);
  }
  return HL_OK;
}

static hl_status allocate(hl_ctx *ctx, const hl_corners *corners, hl_intrinsics *p)
{
  const size_t views = (size_t)(corners->n_views > 0 ? corners->n_views : 1);
  size_t seen = 1;
  for (int i = 0; i < corners->n_views; i++)
    seen += (size_t)corners->view[i].seen;
  p->view = calloc(views, sizeof *p->view);
  p->block = calloc(views, sizeof *p->block);
  p->active = calloc(views, sizeof(void *));
  p->trial = calloc(views, sizeof *p->trial);
  p->sighting = calloc(seen, sizeof *p->sighting);
  p->n_sightings = (int)seen - 1;
  if (p->view && p->block && p->active && p->trial && p->sighting)
    return HL_OK;
  hl_intrinsics_free(p);
  return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d views", corners->n_views);
}

hl_status hl_intrinsics_new(hl_ctx *ctx, const hl_corners *corners,
                            const hl_calibration_settings *settings, hl_intrinsics *out)
{
  hl_intrinsics p = {.corners = corners, .settings = settings, .n_views = corners->n_views};
  hl_status st = allocate(ctx, corners, &p);
  if (st != HL_OK)
    return st;
  hl_sighting *next = p.sighting;
  for (int i = 0; i < p.n_views && st == HL_OK; i++) {
    hl_intrinsics_view *view = &p.view[i];
    view->source = &corners->view[i];
    view->sighting = next;
    view->n = hl_sightings_of(&corners->target, view->source, next);
    view->used = true;
    next += view->n;
    look_at(view);
    st = view->used ? check_inside(ctx, corners, view) : HL_OK;
  }
  if (st != HL_OK) {
    hl_intrinsics_free(&p);
    return st;
  }
  p.camera.width = corners->width;
  p.camera.height = corners->height;
  *out = p;
  return HL_OK;
}

void hl_intrinsics_free(hl_intrinsics *problem)
{
  free(problem->view);
  free(problem->block);
  free(problem->active);
  free(problem->trial);
  free(problem->sighting);
  *problem = (hl_intrinsics){0};
}

hl_status hl_intrinsics_state_new(hl_ctx *ctx, const hl_intrinsics *problem,
                                  hl_intrinsics_state *out)
{
  hl_intrinsics_state s = {
      .view = calloc((size_t)problem->n_views + 1, sizeof *s.view),
      .sighting = calloc((size_t)problem->n_sightings + 1, sizeof *s.sighting),
  };
  if (!s.view || !s.sighting) {
    hl_intrinsics_state_free(&s);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d views", problem->n_views);
  }
  *out = s;
  return HL_OK;
}

void hl_intrinsics_state_free(hl_intrinsics_state *state)
{
  free(state->view);
  free(state->sighting);
  *state = (hl_intrinsics_state){0};
}

void hl_intrinsics_save(const hl_intrinsics *p, hl_intrinsics_state *state)
{
  state->camera = p->camera;
  state->cost = p->cost;
  state->opencv = p->opencv;
  state->opencv_off = p->opencv_off;
  state->prior = p->prior;
  state->farthest = p->farthest;
  state->stationarity = p->stationarity;
  memcpy(state->view, p->view, (size_t)p->n_views * sizeof *state->view);
  memcpy(state->sighting, p->sighting, (size_t)p->n_sightings * sizeof *state->sighting);
}

void hl_intrinsics_restore(hl_intrinsics *p, const hl_intrinsics_state *state)
{
  p->camera = state->camera;
  p->cost = state->cost;
  p->opencv = state->opencv;
  p->opencv_off = state->opencv_off;
  p->prior = state->prior;
  p->farthest = state->farthest;
  p->stationarity = state->stationarity;
  memcpy(p->view, state->view, (size_t)p->n_views * sizeof *state->view);
  memcpy(p->sighting, state->sighting, (size_t)p->n_sightings * sizeof *state->sighting);
}
