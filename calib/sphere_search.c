/*
 * Circles among edge points.
 *
 * In the stereographic picture X = 2 f (ux, uy) / (1 + uz) of the rays u, every cone is a circle
 * and the edge's normal points at (or away from) the circle's centre, for any lens and any place
 * in the frame. So: every edge point votes for the centres along its normal; the best centres get
 * a histogram of radii; the best (centre, radius) are refined on the points near them, ever
 * nearer. Both polarities vote: a rim may be brighter than the background here and darker there.
 *
 * Score: coverage^1.5 x radius. The outline is the largest circle of the ball: a highlight's edge
 * is smaller, the edge of its attached shadow covers less.
 */
#include "sphere_search.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/vec3.h"
#include "sphere_stereo.h"

enum { CELL = 4, PEAKS = 32, RADII = 3, RADIUS_BIN = 3, RADIUS_BINS = 400, ARC_BINS = 160 };

static const float aligned = 0.94f; /* |cos| between an edge's normal and the radius: 20 degrees */

/* Edge points in the stereographic picture, search pixels. */
typedef struct point {
  float x, y, nx, ny;
} point;

typedef struct accumulator {
  int width, height;
  float x0, y0;
  uint16_t *votes, *sums;
} accumulator;

typedef struct work {
  point *p;
  int n;
  double focal;   /* search pixels */
  double density; /* edge points kept per search pixel of outline */
  float min_radius, max_radius;
  int *near; /* scratch, n */
} work;

static int clamp_int(int v, int low, int high)
{
  return v < low ? low : v > high ? high : v;
}

static void to_points(const hl_edges *edges, const hl_stereo *g, work *w)
{
  for (int i = 0; i < edges->n; i++) {
    const hl_edge *e = &edges->edge[i];
    double at[2], j[2][2];
    hl_stereo_at(g, e->x, e->y, at, j);
    /* the edge's tangent is carried over, and turned back to a normal there */
    const double tx = -j[0][0] * e->gy + j[0][1] * e->gx;
    const double ty = -j[1][0] * e->gy + j[1][1] * e->gx;
    const double k = 1 / hypot(tx, ty);
    w->p[i] = (point){(float)at[0], (float)at[1], (float)(ty * k), (float)(-tx * k)};
  }
  w->n = edges->n;
}

static bool accumulator_make(const work *w, accumulator *a)
{
  float x0 = w->p[0].x, x1 = x0, y0 = w->p[0].y, y1 = y0;
  for (int i = 1; i < w->n; i++) {
    x0 = fminf(x0, w->p[i].x);
    x1 = fmaxf(x1, w->p[i].x);
    y0 = fminf(y0, w->p[i].y);
    y1 = fmaxf(y1, w->p[i].y);
  }
  /* a ball cut by the frame has its centre up to some way outside */
  const float margin = 0.2f * fmaxf(x1 - x0, y1 - y0) + 2 * CELL;
  a->x0 = x0 - margin;
  a->y0 = y0 - margin;
  a->width = (int)((x1 - x0 + 2 * margin) / CELL) + 3;
  a->height = (int)((y1 - y0 + 2 * margin) / CELL) + 3;
  const size_t n = (size_t)a->width * (size_t)a->height;
  a->votes = calloc(2 * n, sizeof *a->votes);
  a->sums = a->votes ? a->votes + n : NULL;
  return a->votes != NULL;
}

static void vote(const work *w, accumulator *a)
{
  const int steps = (int)floorf((w->max_radius - w->min_radius) / CELL);
  for (int i = 0; i < w->n; i++) {
    const point *p = &w->p[i];
    for (int side = -1; side <= 1; side += 2) {
      const float dx = (float)side * p->nx / CELL, dy = (float)side * p->ny / CELL;
      const float px = (p->x - a->x0) / CELL, py = (p->y - a->y0) / CELL;
      for (int k = 0; k <= steps; k++) {
        const float r = w->min_radius + (float)k * CELL;
        const float x = px + r * dx, y = py + r * dy;
        if (!(x >= 1 && y >= 1 && x < (float)(a->width - 1) && y < (float)(a->height - 1)))
          break;
        uint16_t *v = &a->votes[(size_t)(int)y * (size_t)a->width + (size_t)(int)x];
        *v = (uint16_t)(*v + (*v < 7000)); /* nine of them still fit */
      }
    }
  }
  const size_t s = (size_t)a->width;
  for (size_t y = 1; y + 1 < (size_t)a->height; y++)
    for (size_t x = 1; x + 1 < s; x++) {
      const uint16_t *v = &a->votes[y * s + x];
      a->sums[y * s + x] = (uint16_t)(v[0] + v[1] + (v - s)[0] + (v - s)[1] + v[s] + v[s + 1] +
                                      (v - 1)[0] + (v - s - 1)[0] + v[s - 1]);
    }
}

typedef struct peak {
  float x, y;
  int votes;
} peak;

/* The PEAKS largest local maxima, largest first; ties in reading order. */
static int find_peaks(const accumulator *a, peak out[PEAKS])
{
  const size_t s = (size_t)a->width;
  int n = 0;
  for (int y = 1; y + 1 < a->height; y++) {
    for (int x = 1; x + 1 < a->width; x++) {
      const uint16_t *v = &a->sums[(size_t)y * s + (size_t)x];
      const int here = v[0];
      if (here < 8 || (n == PEAKS && here <= out[PEAKS - 1].votes))
        continue;
      if (!(here > (v - s)[0] && here > (v - 1)[0] && here > (v - s - 1)[0] && here > (v - s)[1] &&
            here >= v[1] && here >= v[s] && here >= v[s + 1] && here >= v[s - 1]))
        continue;
      int at = n < PEAKS ? n++ : PEAKS - 1;
      while (at > 0 && out[at - 1].votes < here) {
        out[at] = out[at - 1];
        at--;
      }
      out[at] = (peak){a->x0 + ((float)x + 0.5f) * CELL, a->y0 + ((float)y + 0.5f) * CELL, here};
    }
  }
  return n;
}

typedef struct circle {
  float x, y, radius, score;
} circle;

/* The best radii about one centre, by count^2 / radius. */
static int find_radii(const work *w, const peak *c, circle out[RADII])
{
  float count[RADIUS_BINS + 2] = {0};
  for (int i = 0; i < w->n; i++) {
    const point *p = &w->p[i];
    const float dx = p->x - c->x, dy = p->y - c->y;
    const float d2 = dx * dx + dy * dy, along = dx * p->nx + dy * p->ny;
    if (!(along * along > aligned * aligned * d2))
      continue;
    const int bin = (int)(sqrtf(d2) * (1.0f / RADIUS_BIN));
    if (bin < RADIUS_BINS)
      count[bin + 1] += 1;
  }
  int n = 0;
  for (int b = 1; b <= RADIUS_BINS; b++) {
    const float r = ((float)b - 0.5f) * RADIUS_BIN;
    const float sum = count[b - 1] + count[b] + count[b + 1];
    if (!(r >= w->min_radius && r <= w->max_radius) || sum < 8)
      continue;
    const circle found = {c->x, c->y, r, sum * sum / r};
    int at = n;
    if (n > 0 && fabsf(out[n - 1].radius - r) < 2.5f * RADIUS_BIN) { /* one bump, one entry */
      if (!(found.score > out[n - 1].score))
        continue;
      at = n - 1;
    } else if (n == RADII) {
      at = 0;
      for (int i = 1; i < RADII; i++)
        if (out[i].score < out[at].score)
          at = i;
      if (!(found.score > out[at].score))
        continue;
    } else {
      n++;
    }
    out[at] = found;
  }
  return n;
}

/* Indices of points within `reach` of the circle whose normal agrees. */
static int select_near(const work *w, const circle *c, float reach, const int *from, int n_from,
                       int *to)
{
  int n = 0;
  for (int k = 0; k < n_from; k++) {
    const int i = from ? from[k] : k;
    const point *p = &w->p[i];
    const float dx = p->x - c->x, dy = p->y - c->y;
    const float d = sqrtf(dx * dx + dy * dy), along = dx * p->nx + dy * p->ny;
    if (fabsf(d - c->radius) <= reach && fabsf(along) > aligned * d)
      to[n++] = i;
  }
  return n;
}

/* One Gauss-Newton step on the points' distances to the circle. */
static bool circle_step(const work *w, const int *near, int n, circle *c)
{
  double a[3][3] = {{0}}, b[3] = {0}, step[3];
  for (int k = 0; k < n; k++) {
    const point *p = &w->p[near[k]];
    const double dx = p->x - c->x, dy = p->y - c->y, d = hypot(dx, dy);
    const double row[3] = {dx / d, dy / d, 1};
    for (int i = 0; i < 3; i++) {
      for (int j = 0; j < 3; j++)
        a[i][j] += row[i] * row[j];
      b[i] += row[i] * (d - c->radius);
    }
  }
  for (int i = 0; i < 3; i++)
    a[i][i] += 1e-3; /* a short arc moves its circle along itself: hold it */
  if (n < 6 || !hl_solve3((const double(*)[3])a, b, step))
    return false;
  c->x += (float)step[0];
  c->y += (float)step[1];
  c->radius += (float)step[2];
  return c->radius > 2;
}

static double coverage(const work *w, const circle *c, const int *near, int n)
{
  const double round = 2 * 3.14159265358979323846;
  const int bins = clamp_int((int)(round * c->radius / 8), 16, ARC_BINS);
  int count[ARC_BINS] = {0}, covered = 0;
  for (int k = 0; k < n; k++) {
    const point *p = &w->p[near[k]];
    const double turn = atan2((double)(p->y - c->y), (double)(p->x - c->x)) / round + 0.5;
    count[clamp_int((int)(turn * bins), 0, bins - 1)]++;
  }
  const double need = fmax(0.4 * w->density * round * c->radius / bins, 1);
  for (int b = 0; b < bins; b++)
    covered += count[b] >= need;
  return (double)covered / bins;
}

static bool refine(work *w, circle *c, float wide, double *covered)
{
  const float last = fmaxf(fminf(1.5f, 0.05f * c->radius), 0.8f);
  const float reach[6] = {wide, 0.5f * wide, 0.25f * wide, 2 * last, last, last};
  int n = select_near(w, c, 1.5f * wide, NULL, w->n, w->near);
  int *inner = w->near + w->n;
  for (int pass = 0; pass < 6; pass++) {
    const int m = select_near(w, c, fmaxf(reach[pass], last), w->near, n, inner);
    if (!circle_step(w, inner, m, c))
      return false;
  }
  const int m = select_near(w, c, last, w->near, n, inner);
  *covered = coverage(w, c, inner, m);
  return c->radius >= w->min_radius && c->radius <= w->max_radius;
}

/* Three points of the circle, back to rays, fix the cone. */
static bool to_cone(const work *w, const circle *c, hl_cone *out)
{
  double rays[9];
  for (int k = 0; k < 3; k++) {
    const double a = 2.0943951023931953 * k;
    const double x = (c->x + c->radius * cos(a)) / w->focal;
    const double y = (c->y + c->radius * sin(a)) / w->focal;
    const double s = x * x + y * y;
    const double u[3] = {4 * x, 4 * y, 4 - s};
    hl_unit(u, rays + 3 * k);
  }
  return hl_cone_from_rays(rays, 3, NULL, out);
}

/* Insert by score; a circle much like a better one is the same one. */
static void insert(const work *w, const circle *c, double covered, hl_candidate *out, int *n)
{
  hl_candidate new = {.x = c->x, .y = c->y, .radius = c->radius, .coverage = covered};
  new.score = pow(covered, 1.5) * c->radius;
  if (!to_cone(w, c, &new.cone))
    return;
  for (int i = 0; i < *n; i++) {
    const double apart = hypot(out[i].x - new.x, out[i].y - new.y);
    if (apart + fabs(out[i].radius - new.radius) > fmax(4, 0.08 * fmax(new.radius, out[i].radius)))
      continue;
    if (out[i].score >= new.score)
      return;
    memmove(&out[i], &out[i + 1], (size_t)(*n - i - 1) * sizeof *out);
    (*n)--;
    i--;
  }
  int at = *n;
  if (at == HL_CANDIDATES_MAX) {
    if (out[at - 1].score >= new.score)
      return;
    at--;
  } else {
    (*n)++;
  }
  while (at > 0 && out[at - 1].score < new.score) {
    out[at] = out[at - 1];
    at--;
  }
  out[at] = new;
}

static int by_score(const void *a, const void *b)
{
  const circle *p = a, *q = b;
  if (p->score != q->score)
    return p->score < q->score ? 1 : -1;
  if (p->y != q->y)
    return p->y < q->y ? -1 : 1;
  return p->x < q->x ? -1 : p->x > q->x;
}

static void search_all(work *w, const accumulator *a, hl_candidate *out, int *n)
{
  peak peaks[PEAKS];
  circle starts[PEAKS * RADII];
  int n_starts = 0;
  const int n_peaks = find_peaks(a, peaks);
  for (int i = 0; i < n_peaks; i++)
    n_starts += find_radii(w, &peaks[i], starts + n_starts);
  qsort(starts, (size_t)n_starts, sizeof *starts, by_score);
  for (int i = 0; i < n_starts && i < HL_CANDIDATES_MAX; i++) {
    double covered;
    if (refine(w, &starts[i], 6 + 0.05f * starts[i].radius, &covered))
      insert(w, &starts[i], covered, out, n);
  }
}

static void search_hint(work *w, const hl_stereo *g, const double hint[3], int shrink,
                        hl_candidate *out, int *n)
{
  double at[2], j[2][2];
  hl_stereo_at(g, hint[0], hint[1], at, j);
  const double scale = sqrt(fabs(j[0][0] * j[1][1] - j[0][1] * j[1][0])) * shrink;
  const double radius = hint[2] / shrink * scale;
  static const float part[5] = {1, 0.95f, 1.05f, 0.9f, 1.1f};
  for (int i = 0; i < 5; i++) {
    circle c = {(float)at[0], (float)at[1], (float)radius * part[i], 0};
    double covered;
    if (refine(w, &c, 4 + 0.08f * (float)radius, &covered) &&
        hypot(c.x - at[0], c.y - at[1]) < 0.3 * radius + 4 &&
        fabs(c.radius - radius) < 0.3 * radius + 4)
      insert(w, &c, covered, out, n);
  }
}

hl_status hl_search_circles(hl_ctx *ctx, const hl_edges *edges, const hl_camera *camera,
                            const hl_search_range *range, hl_candidate *out, int *n)
{
  work w = {0};
  hl_stereo g = {0};
  accumulator a = {0};
  *n = 0;
  if (edges->n < 8)
    return HL_OK;
  w.focal = sqrt(camera->fx * camera->fy) / edges->shrink;
  w.density = 0.8 * edges->n / edges->found;
  w.min_radius = (float)fmax(range->min_radius_px / edges->shrink, 4);
  w.max_radius = (float)fmin(range->max_radius_px / edges->shrink, RADIUS_BIN * RADIUS_BINS);
  hl_status st = hl_stereo_make(ctx, camera, w.focal, &g);
  if (st != HL_OK)
    return st;
  w.p = malloc((size_t)edges->n * sizeof *w.p);
  w.near = malloc(2 * (size_t)edges->n * sizeof *w.near);
  if (!w.p || !w.near) {
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d edge points", edges->n);
    goto done;
  }
  to_points(edges, &g, &w);
  if (range->hint[2] > 0) {
    search_hint(&w, &g, range->hint, edges->shrink, out, n);
    goto done;
  }
  if (!accumulator_make(&w, &a)) {
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for the search of circles");
    goto done;
  }
  vote(&w, &a);
  search_all(&w, &a, out, n);
done:
  hl_stereo_free(&g);
  free(w.p);
  free(w.near);
  free(a.votes);
  return st;
}
