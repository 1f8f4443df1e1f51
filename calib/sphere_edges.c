/*
 * Edge points: where the square root of radiance steps by more than its noise explains.
 *
 * The square root brings a dim rim on black and a bright one on grey to one scale and evens shot
 * noise. The noise left is read from the frame itself: the median of |second differences| in bands
 * of equal level. Blur with (1 4 6 4 1)/16 both ways, central differences, maxima across the
 * gradient, sub-pixel by a parabola (Devernay 1995).
 */
#include "sphere_edges.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { LEVELS = 12, BINS = 256, SAMPLES = 4096, SPAN = 3, ROOM = 1 << 16 };

static const double headroom = 0x1p-10; /* differences of the largest floats stay finite */
static const double step_to_noise = 5;  /* Rayleigh: one false maximum in 270 000 */

/* fminf and fmaxf are calls where NaN must be minded; here none is left */
static inline float least(float a, float b)
{
  return a < b ? a : b;
}

static inline float most(float a, float b)
{
  return a > b ? a : b;
}

typedef struct work {
  int width, height, shrink;
  float *root, *smooth, *step; /* root of radiance; blurred; length of its gradient */
} work;

/* Sum and count of the usable samples of one row of a block; clipped ones count as they are. */
static int block_row(const hl_frame *f, size_t at, int n, double *sum)
{
  int used = 0;
  for (size_t i = at; i < at + (size_t)n; i++) {
    const bool usable = f->state[i] != HL_SAMPLE_UNUSABLE;
    *sum += usable ? (double)f->radiance[i] : 0;
    used += usable;
  }
  return used;
}

/* The frame's mean over channels and blocks, times headroom; an unusable block takes its left neighbour's value. */
static void shrink_frame(const hl_frame *f, work *w)
{
  const int ch = f->channels, q = w->shrink;
  const size_t row = (size_t)f->width * (size_t)ch;
  for (int y = 0; y < w->height; y++) {
    float last = 0;
    float *out = w->root + (size_t)y * (size_t)w->width;
    for (int x = 0; x < w->width; x++) {
      const size_t at = (size_t)(y * q) * row + (size_t)(x * q) * (size_t)ch;
      double sum = 0;
      int used = 0;
      for (int k = 0; k < q; k++)
        used += block_row(f, at + (size_t)k * row, q * ch, &sum);
      last = used > 0 ? most((float)(headroom * sum / used), 0) : last;
      out[x] = last;
    }
  }
}

typedef struct sample {
  float value, second;
} sample;

static int by_value(const void *a, const void *b)
{
  const sample *p = a, *q = b;
  if (p->value != q->value)
    return p->value < q->value ? -1 : 1;
  return (p->second > q->second) - (p->second < q->second);
}

static int by_second(const void *a, const void *b)
{
  const float p = ((const sample *)a)->second, q = ((const sample *)b)->second;
  return (p > q) - (p < q);
}

/* Noise of the dark quarter of the frame, in radiance. */
static float dark_noise(const work *w)
{
  sample s[SAMPLES];
  const size_t n = (size_t)w->width * (size_t)w->height;
  const size_t stride = n / SAMPLES + 1;
  int m = 0;
  for (size_t i = 1; i + 1 < n && m < SAMPLES; i += stride) {
    const float *r = w->root + i;
    s[m++] = (sample){r[0], fabsf(r[-1] - 2 * r[0] + r[1])};
  }
  qsort(s, (size_t)m, sizeof *s, by_value);
  qsort(s, (size_t)m / 4, sizeof *s, by_second);
  return s[m / 8].second / (0.6745f * 2.449f);
}

/* The floor keeps the root's slope, and with it the noise, finite in the black. */
static void take_root(work *w)
{
  const size_t n = (size_t)w->width * (size_t)w->height;
  const float floor_level = 6 * dark_noise(w), base = sqrtf(floor_level);
  for (size_t i = 0; i < n; i++)
    w->root[i] = sqrtf(w->root[i] + floor_level) - base;
}

static void blur_rows(const work *w, const float *in, float *out)
{
  for (int y = 0; y < w->height; y++) {
    const float *r = in + (size_t)y * (size_t)w->width;
    float *o = out + (size_t)y * (size_t)w->width;
    o[0] = o[1] = r[0];
    for (int x = 2; x < w->width - 2; x++)
      o[x] = (r[x - 2] + r[x + 2] + 4 * (r[x - 1] + r[x + 1]) + 6 * r[x]) * 0.0625f;
    o[w->width - 2] = o[w->width - 1] = r[w->width - 1];
  }
}

static void blur_columns(const work *w, const float *in, float *out)
{
  const size_t s = (size_t)w->width;
  memcpy(out, in, 2 * s * sizeof *out);
  for (int y = 2; y < w->height - 2; y++) {
    const float *r = in + (size_t)y * s;
    float *o = out + (size_t)y * s;
    for (size_t x = 0; x < s; x++)
      o[x] = ((r - 2 * s)[x] + r[x + 2 * s] + 4 * ((r - s)[x] + r[x + s]) + 6 * r[x]) * 0.0625f;
  }
  memcpy(out + (size_t)(w->height - 2) * s, in + (size_t)(w->height - 2) * s, 2 * s * sizeof *out);
}

/* Standard deviation of one pixel's noise at each of LEVELS levels of the square root. */
static void noise_by_level(const work *w, float top, float noise[LEVELS])
{
  static const float bin_width = 1.0f / 2048; /* of the top */
  int count[LEVELS][BINS] = {{0}}, total[LEVELS] = {0};
  const float k = top > 0 ? 1 / top : 0;
  for (int y = 1; y < w->height - 1; y += 3) {
    const float *r = w->root + (size_t)y * (size_t)w->width;
    for (int x = 1; x < w->width - 1; x++) {
      const int level = (int)least(r[x] * k * LEVELS, LEVELS - 1);
      const float second = fabsf(r[x - 1] - 2 * r[x] + r[x + 1]) * k;
      count[level][(int)least(second / bin_width, BINS - 1)]++;
      total[level]++;
    }
  }
  for (int i = 0; i < LEVELS; i++) {
    int sum = 0, b = 0;
    while (b < BINS - 1 && 2 * (sum + count[i][b]) < total[i])
      sum += count[i][b++];
    /* median of |x| is 0.6745 sigma; a second difference has sqrt(6) of the pixel's */
    const float s = ((float)b + 1) * bin_width / (0.6745f * 2.449f);
    noise[i] = top * most(s, 0.0004f);
  }
}

/* Level at the 99.9th percentile of a sample; a few hot pixels must not set the scale. */
static float top_level(const work *w)
{
  sample s[SAMPLES];
  const size_t n = (size_t)w->width * (size_t)w->height, stride = n / SAMPLES + 1;
  int m = 0;
  for (size_t i = stride / 2; i < n && m < SAMPLES; i += stride)
    s[m++] = (sample){w->root[i], 0};
  qsort(s, (size_t)m, sizeof *s, by_value);
  return m > 0 ? s[m - 1 - m / 1000].value : 0;
}

/* Peak of a parabola through three values, in units of their spacing. */
static float vertex(float before, float here, float after)
{
  const float bend = before - 2 * here + after;
  const float v = bend < 0 ? 0.5f * (before - after) / bend : 0;
  return least(most(v, -0.5f), 0.5f);
}

/* A step is far weaker SPAN pixels to either side; a smooth shade, such as a wide highlight's
 * flank, is not. The limb's own shade leaves some on one side. */
static bool is_sharp(const work *w, size_t i, float m, float gx, float gy)
{
  const float across = gx / m, down = gy / m;
  if (!(fabsf(across) <= 1.01f && fabsf(down) <= 1.01f)) /* m too small a float, or not finite */
    return false;
  const ptrdiff_t dx = (ptrdiff_t)lrintf(SPAN * across), dy = (ptrdiff_t)lrintf(SPAN * down);
  const ptrdiff_t step = dy * w->width + dx;
  const float before = *(w->step + i - step), after = *(w->step + i + step);
  return m > 1.25f * most(before, after) && m > 2 * least(before, after);
}

/* Is pixel i a maximum of the gradient across the edge? Writes its sub-pixel place. */
static bool is_edge(const work *w, int x, int y, hl_edge *out)
{
  const size_t s = (size_t)w->width, i = (size_t)y * s + (size_t)x;
  const float *b = w->smooth + i;
  const float gx = 0.5f * (b[1] - b[-1]), gy = 0.5f * (b[s] - *(b - s)), m = w->step[i];
  const bool across = fabsf(gx) >= fabsf(gy);
  /* neighbours along the gradient, interpolated between an axis and a diagonal one */
  const float ratio = across ? gy / gx : gx / gy;
  const float f = fabsf(ratio);
  const size_t axis = across ? 1 : s;
  const bool same = ratio > 0;
  const size_t side = across ? s : 1;
  const size_t before = i - axis, after = i + axis;
  const size_t before2 = same ? before - side : before + side;
  const size_t after2 = same ? after + side : after - side;
  const float mb = (1 - f) * w->step[before] + f * w->step[before2];
  const float ma = (1 - f) * w->step[after] + f * w->step[after2];
  if (!(m > mb && m >= ma))
    return false;
  if (!is_sharp(w, i, m, gx, gy))
    return false;
  const float d = vertex(mb, m, ma);
  const float q = (float)w->shrink;
  out->x = q * ((float)x + (across ? d : d * ratio) + 0.5f) - 0.5f;
  out->y = q * ((float)y + (across ? d * ratio : d) + 0.5f) - 0.5f;
  out->gx = gx / m;
  out->gy = gy / m;
  return true;
}

static void gradient_lengths(const work *w)
{
  const size_t s = (size_t)w->width;
  for (int y = 1; y < w->height - 1; y++) {
    const float *b = w->smooth + (size_t)y * s;
    float *o = w->step + (size_t)y * s;
    for (size_t x = 1; x < s - 1; x++) {
      const float gx = b[x + 1] - b[x - 1], gy = b[x + s] - *(b + x - s);
      o[x] = 0.5f * sqrtf(gx * gx + gy * gy);
    }
  }
}

/* Collects up to `room` edge points whose step exceeds the noise; returns how many there are. */
static int collect(const work *w, float top, const float noise[LEVELS], hl_edge *to, int room)
{
  /* of the blurred difference, for white noise of one pixel: sqrt(0.082 x 0.273) */
  const float gain = 0.15f * (float)step_to_noise;
  float limit[LEVELS], lowest = INFINITY;
  for (int i = 0; i < LEVELS; i++) {
    limit[i] = gain * noise[i];
    lowest = least(lowest, limit[i]);
  }
  const float k = top > 0 ? LEVELS / top : 0;
  int n = 0;
  for (int y = 3; y < w->height - 3; y++) {
    for (int x = 3; x < w->width - 3; x++) {
      const size_t i = (size_t)y * (size_t)w->width + (size_t)x;
      const float m = w->step[i];
      if (!(m > lowest) || !(m > limit[(int)least(w->root[i] * k, LEVELS - 1)]))
        continue;
      hl_edge e;
      if (is_edge(w, x, y, &e) && n < room)
        to[n++] = e;
    }
  }
  return n;
}

/* Every stride-th point, so that at most HL_EDGES_MAX are left. */
static void thin(hl_edges *edges)
{
  const int stride = (edges->found + HL_EDGES_MAX - 1) / HL_EDGES_MAX;
  for (int i = 0; i < edges->found; i += stride)
    edges->edge[edges->n++] = edges->edge[i];
}

hl_status hl_edges_find(hl_ctx *ctx, const hl_frame *frame, hl_edges *out)
{
  work w = {0};
  const int longer = frame->width > frame->height ? frame->width : frame->height;
  w.shrink = (longer + HL_SEARCH_SIDE_MAX - 1) / HL_SEARCH_SIDE_MAX;
  w.width = frame->width / w.shrink;
  w.height = frame->height / w.shrink;
  memset(out, 0, sizeof *out);
  out->shrink = w.shrink;
  if (w.width < 8 || w.height < 8)
    return HL_OK;
  const size_t n = (size_t)w.width * (size_t)w.height;
  float *planes = calloc(3 * n, sizeof *planes);
  hl_edge *edge = malloc(ROOM * sizeof *edge);
  if (!planes || !edge) {
    free(planes);
    free(edge);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory to search %d x %d pixels", w.width, w.height);
  }
  w.root = planes;
  w.smooth = planes + n;
  w.step = planes + 2 * n;
  float noise[LEVELS];
  shrink_frame(frame, &w);
  take_root(&w);
  const float top = top_level(&w);
  noise_by_level(&w, top, noise);
  blur_rows(&w, w.root, w.step);
  blur_columns(&w, w.step, w.smooth);
  memset(w.step, 0, n * sizeof *w.step);
  gradient_lengths(&w);
  out->edge = edge;
  out->found = collect(&w, top, noise, edge, ROOM);
  thin(out);
  free(planes);
  return HL_OK;
}

void hl_edges_free(hl_edges *edges)
{
  free(edges->edge);
  edges->edge = NULL;
  edges->n = 0;
}
