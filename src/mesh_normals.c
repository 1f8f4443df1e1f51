/*
 * Normals of a mesh in an orthographic drawing.
 *
 * With (X, Y) a vertex along right and down and Z along the view, all scaled to pixels, a face covers
 * the pixel centres inside its triangle; barycentric weights interpolate Z, which the z-buffer
 * compares, and the vertices' normals. A centre on an edge shared by two faces belongs to the nearer
 * one, or to the first.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/relight.h"
#include "halflight/vec3.h"

enum { SIDE_MAX = 16384 };

static const double margin = 0.02;
static const double least_facing = 1e-3; /* n.v of a normal turned to the silhouette */

void hl_mesh_free(hl_mesh *mesh)
{
  if (!mesh)
    return;
  free(mesh->position);
  free(mesh->normal);
  free(mesh->face);
  *mesh = (hl_mesh){0};
}

/* Pixels from positions: x = scale X + x0, y = scale Y + y0. */
typedef struct fitting {
  double scale, x0, y0;
} fitting;

static fitting fit_into(const hl_mesh *mesh, const hl_viewing *viewing, int width, int height)
{
  double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
  for (int f = 0; f < 3 * mesh->n_faces; f++) {
    const double *p = mesh->position + 3 * (size_t)mesh->face[f];
    const double at[2] = {hl_dot(p, viewing->right), hl_dot(p, viewing->down)};
    for (int i = 0; i < 2; i++) {
      low[i] = fmin(low[i], at[i]);
      high[i] = fmax(high[i], at[i]);
    }
  }
  const double room = 1 - 2 * margin;
  const double wide = fmax(high[0] - low[0], DBL_MIN), tall = fmax(high[1] - low[1], DBL_MIN);
  fitting f = {.scale = fmin(room * width / wide, room * height / tall)};
  f.x0 = 0.5 * (width - 1) - f.scale * 0.5 * (low[0] + high[0]);
  f.y0 = 0.5 * (height - 1) - f.scale * 0.5 * (low[1] + high[1]);
  return f;
}

typedef struct corner {
  double x, y, z;
  const double *normal;
} corner;

static double edge(const corner *a, const corner *b, double x, double y)
{
  return (b->x - a->x) * (y - a->y) - (b->y - a->y) * (x - a->x);
}

static int clamped(double at, int high)
{
  return at < 0 ? 0 : at > high ? high : (int)at;
}

/* A normal that faces the viewer, if only just. */
static void facing(const double view[3], double n[3])
{
  hl_unit(n, n);
  const double towards = hl_dot(n, view);
  if (towards < least_facing) {
    hl_add_scaled(n, least_facing - towards, view, n);
    hl_unit(n, n);
  }
}

static void draw_face(const corner c[3], const double view[3], double *depth, hl_frame *out)
{
  const double area = edge(&c[0], &c[1], c[2].x, c[2].y);
  if (!(fabs(area) > 0))
    return;
  const double x_low = fmin(fmin(c[0].x, c[1].x), c[2].x),
               x_high = fmax(fmax(c[0].x, c[1].x), c[2].x);
  const double y_low = fmin(fmin(c[0].y, c[1].y), c[2].y),
               y_high = fmax(fmax(c[0].y, c[1].y), c[2].y);
  const int x1 = clamped(x_high, out->width - 1), y1 = clamped(y_high, out->height - 1);
  for (int y = clamped(ceil(y_low), out->height - 1); y <= y1; y++)
    for (int x = clamped(ceil(x_low), out->width - 1); x <= x1; x++) {
      double w[3], z = 0, n[3] = {0};
      for (int k = 0; k < 3; k++)
        w[k] = edge(&c[(k + 1) % 3], &c[(k + 2) % 3], x, y) / area;
      if (!(w[0] >= 0 && w[1] >= 0 && w[2] >= 0))
        continue;
      for (int k = 0; k < 3; k++) {
        z += w[k] * c[k].z;
        hl_add_scaled(n, w[k], c[k].normal, n);
      }
      const size_t at = (size_t)y * (size_t)out->width + (size_t)x;
      if (!(z > depth[at]))
        continue;
      depth[at] = z;
      facing(view, n);
      for (int i = 0; i < 3; i++)
        out->radiance[3 * at + (size_t)i] = (float)n[i];
    }
}

static bool draw(const hl_mesh *mesh, const hl_viewing *viewing, double *depth, hl_frame *out)
{
  const fitting f = fit_into(mesh, viewing, out->width, out->height);
  const size_t pixels = (size_t)out->width * (size_t)out->height;
  bool seen = false;
  for (size_t i = 0; i < pixels; i++)
    depth[i] = -HUGE_VAL;
  for (int k = 0; k < mesh->n_faces; k++) {
    corner c[3];
    for (int i = 0; i < 3; i++) {
      const size_t at = 3 * (size_t)mesh->face[3 * (size_t)k + (size_t)i];
      const double *p = mesh->position + at;
      c[i] = (corner){f.x0 + f.scale * hl_dot(p, viewing->right),
                      f.y0 + f.scale * hl_dot(p, viewing->down), hl_dot(p, viewing->view),
                      mesh->normal + at};
    }
    draw_face(c, viewing->view, depth, out);
  }
  for (size_t i = 0; i < pixels && !seen; i++)
    seen = depth[i] > -HUGE_VAL;
  return seen;
}

hl_status hl_normals_of_mesh(hl_ctx *ctx, const hl_mesh *mesh, const hl_viewing *viewing, int width,
                             int height, hl_frame *out)
{
  if (width < 1 || width > SIDE_MAX || height < 1 || height > SIDE_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "%d x %d px is outside [1, %d]", width, height, SIDE_MAX);
  const size_t pixels = (size_t)width * (size_t)height;
  hl_frame f = {.width = width, .height = height, .channels = 3, .bits = 32};
  f.radiance = calloc(3 * pixels, sizeof *f.radiance);
  f.state = calloc(3 * pixels, sizeof *f.state);
  double *depth = malloc(pixels * sizeof *depth);
  hl_status st = HL_OK;
  if (!f.radiance || !f.state || !depth)
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for an image of %d x %d pixels", width, height);
  else if (!draw(mesh, viewing, depth, &f))
    st = hl_fail(ctx, HL_ERR_DEGENERATE,
                 "no face of the mesh covers the centre of a pixel; a surface that is seen is "
                 "needed");
  free(depth);
  if (st == HL_OK)
    *out = f;
  else
    hl_frame_free(&f);
  return st;
}
