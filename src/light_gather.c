/* Pixels of a frame and a surface, brought together as the estimate wants them.
 *
 * Radiance is divided by the median of the lit pixels, so that nothing after depends on exposure:
 * a frame times 1e12 gives the same bits as the frame, as far as floats reach.
 *
 * Where the time is short only some of the pixels are gathered: runs of three neighbours, two thirds of
 * what there may be, at a steady pace over the surface, and the brightest that are not clipped, where the
 * highlight and its flank are. Their values' bits, sign and exponent and three of the fraction, are counted
 * in one pass to find how bright that is.
 */
#include <math.h>
#include <string.h>

#include "light_work.h"

static const double lit_share = 0.02; /* of the 90th percentile: darker pixels are in shadow */
static const double least_level_in_noise = 4;

/* Bits that descend as the number ascends, to a float's precision. */
static uint32_t descending_bits(double x)
{
  const float f = (float)x;
  uint32_t bits;
  memcpy(&bits, &f, sizeof bits);
  return bits >> 31 ? bits : ~(bits | 1U << 31);
}

/* By eleven bits at a time from the lowest, because qsort may allocate. */
void hl_light_sort(hl_ranked *ranked, hl_ranked *scratch, int n)
{
  enum { BITS = 11, DIGITS = 3, RADIX = 1 << BITS };
  hl_ranked *from = ranked, *to = scratch;
  int first[DIGITS][RADIX] = {{0}};
  for (int i = 0; i < n; i++) {
    const uint32_t bits = descending_bits(ranked[i].key);
    for (int digit = 0; digit < DIGITS; digit++)
      first[digit][bits >> digit * BITS & (RADIX - 1)]++;
  }
  for (int digit = 0; digit < DIGITS; digit++) {
    int sum = 0;
    for (int d = 0; d < RADIX; d++) {
      const int count = first[digit][d];
      first[digit][d] = sum;
      sum += count;
    }
    for (int i = 0; i < n; i++)
      to[first[digit][descending_bits(from[i].key) >> digit * BITS & (RADIX - 1)]++] = from[i];
    hl_ranked *swap = from;
    from = to;
    to = swap;
  }
  memcpy(ranked, from, (size_t)n * sizeof *ranked);
}

/* The surface's pixels in the frame's order, so that no answer depends on how a caller lists them: false
 * where they are; else pixel and place are in work->place, ascending. */
static bool order_by_pixel(struct hl_light_work *work, const hl_surface *surface)
{
  bool ascending = true;
  for (int i = 1; i < surface->n && ascending; i++)
    ascending = surface->pixel[i] > surface->pixel[i - 1];
  if (ascending)
    return false;
  for (int i = 0; i < surface->n; i++)
    work->place[i] = (uint64_t)surface->pixel[i] << 32 | (uint32_t)i;
  hl_light_sort_places(work->place, work->place + work->max_pixels, surface->n);
  return true;
}

/* Where the pixels lie in the frame. They ascend, so that the row is found by counting. */
static void find_box(struct hl_light_work *work, const hl_surface *surface)
{
  hl_light_box *box = &work->box;
  int row = 0, start = 0;
  *box = (hl_light_box){surface->width, 0, surface->height, 0};
  for (int p = 0; p < work->all.n; p++) {
    const int pixel = surface->pixel[work->index[p]];
    if (pixel - start >= surface->width) {
      row = pixel / surface->width;
      start = row * surface->width;
    }
    const int column = pixel - start;
    box->x0 = column < box->x0 ? column : box->x0;
    box->x1 = column > box->x1 ? column : box->x1;
    box->y0 = row < box->y0 ? row : box->y0;
    box->y1 = row > box->y1 ? row : box->y1;
  }
}

/* Which pixels are gathered: of `runs` runs of three neighbours `kept`, and values from bin `bright` on. */
typedef struct glance {
  int runs, kept;
  uint32_t bright;
} glance;

enum { BIN_SHIFT = 20, BINS = 1 << 11 /* of positive floats */, RUN = 3 };

/* Bin of a pixel's sum over the channels; 0 where it is no brighter than black, clipped or unusable. */
static uint32_t bin_of(const hl_frame *frame, int pixel)
{
  const size_t at = (size_t)pixel * (size_t)frame->channels;
  float sum = 0;
  uint32_t bits;
  for (int c = 0; c < frame->channels; c++) {
    if (frame->state[at + (size_t)c] != HL_SAMPLE_OK)
      return 0;
    sum += frame->radiance[at + (size_t)c];
  }
  memcpy(&bits, &sum, sizeof bits);
  return bits >> 31 ? 0 : bits >> BIN_SHIFT;
}

/* At most so many. */
static glance glance_of(const hl_frame *frame, const hl_surface *surface, int most)
{
  glance out = {.runs = (surface->n + RUN - 1) / RUN, .bright = BINS};
  int count[BINS] = {0}, brightest = 0;
  out.kept = most > 0 && most < surface->n ? most * 2 / 3 / RUN : out.runs;
  if (out.kept == out.runs)
    return out;
  for (int i = 0; i < surface->n; i++)
    count[bin_of(frame, surface->pixel[i])]++;
  while (out.bright > 1 && brightest + count[out.bright - 1] <= most / 3)
    brightest += count[--out.bright];
  return out;
}

static int place_of(const struct hl_light_work *work, bool sorted, int i)
{
  return sorted ? (int)(work->place[i] & 0xffffffffU) : i;
}

static void gather_pixel(struct hl_light_work *work, const hl_frame *frame,
                         const hl_surface *surface, int i)
{
  hl_light_data *all = &work->all;
  const int p = all->n;
  const size_t at = (size_t)surface->pixel[i] * (size_t)frame->channels;
  double sum = 0;
  all->clipped[p] = 0;
  for (int c = 0; c < frame->channels; c++) {
    if (frame->state[at + (size_t)c] == HL_SAMPLE_UNUSABLE)
      return;
    if (frame->state[at + (size_t)c] == HL_SAMPLE_CLIPPED)
      all->clipped[p] |= (uint8_t)(1 << c);
    all->value[c][p] = (double)frame->radiance[at + (size_t)c];
    work->area[c][p] = 0;
    sum += all->value[c][p];
  }
  for (int k = 0; k < 3; k++) {
    all->normal[k][p] = surface->normal[3 * i + k];
    all->view[k][p] = surface->view[3 * i + k];
  }
  all->footprint[p] = surface->footprint[i];
  work->grey.value[0][p] = sum / frame->channels;
  work->grey.clipped[p] = all->clipped[p] != 0;
  work->outlier[p] = 0;
  work->index[p] = i;
  all->n++;
}

/* Noise of the grey values: second differences along the frame's rows, large ones capped. */
static double noise_of(const struct hl_light_work *work, const hl_surface *surface)
{
  const hl_light_data *grey = &work->grey;
  double *bend2 = work->grey.weight[0], cap = HUGE_VAL, mean = 0; /* no weights yet */
  int used = 0;
  for (int i = 1; i + 1 < grey->n; i++)
    if (hl_light_in_a_row(work, surface, i)) {
      const double bend = grey->value[0][i - 1] - 2 * grey->value[0][i] + grey->value[0][i + 1];
      bend2[used++] = bend * bend / 6;
    }
  for (int round = 0; round < 6; round++) {
    double sum = 0;
    for (int i = 0; i < used; i++)
      sum += bend2[i] < cap ? bend2[i] : cap;
    mean = used > 0 ? sum / used : 0;
    cap = 6 * mean;
  }
  return sqrt(mean);
}

/* Lit pixels are those above lit_share of the n / part-th brightest; their median is the level. */
static void find_level(struct hl_light_work *work, int part)
{
  const int n = work->all.n;
  hl_light_brightness *b = &work->brightness;
  b->lit = 0;
  while (b->lit < n && work->ranked[b->lit].key > lit_share * work->ranked[n / part].key)
    b->lit++;
  b->level = b->lit > 0 ? work->ranked[b->lit / 2].key : 0;
}

static void scale_to_level(struct hl_light_work *work, const hl_surface *surface)
{
  const int n = work->all.n;
  hl_light_brightness *b = &work->brightness;
  memset(b, 0, sizeof *b);
  for (int i = 0; i < n; i++) {
    work->ranked[i].key = work->grey.value[0][i];
    work->ranked[i].index = i;
    b->clipped += work->all.clipped[i] != 0;
  }
  const double noise = noise_of(work, surface);
  hl_light_sort(work->ranked, work->ranked + work->max_pixels, n);
  /* a tenth of the ball is lit, or less: a crescent, whose level must not be that of the dark's noise */
  find_level(work, 10);
  for (int part = 50; part <= 250 && b->level < least_level_in_noise * noise; part *= 5)
    find_level(work, part);
  if (!(b->level > 0))
    return;
  const double unit = 1 / b->level;
  b->p98 = unit * work->ranked[n / 50].key;
  b->p50 = unit * work->ranked[n / 2].key;
  b->p2 = unit * work->ranked[n - 1 - n / 50].key;
  for (int i = 0; i < n; i++) {
    work->ranked[i].key *= unit;
    work->grey.value[0][i] *= unit;
    for (int c = 0; c < work->all.channels; c++)
      work->all.value[c][i] *= unit;
  }
}

hl_status hl_light_gather(hl_ctx *ctx, struct hl_light_work *work, const hl_frame *frame,
                          const hl_surface *surface, int most)
{
  if (frame->width != surface->width || frame->height != surface->height)
    return hl_fail(ctx, HL_ERR_ARG, "frame is %d x %d, but the surface is of a frame of %d x %d",
                   frame->width, frame->height, surface->width, surface->height);
  if (frame->channels != work->channels)
    return hl_fail(ctx, HL_ERR_ARG, "frame has %d channels, but the workspace is for %d",
                   frame->channels, work->channels);
  if (surface->n > work->max_pixels)
    return hl_fail(ctx, HL_ERR_ARG, "surface has %d pixels, but the workspace is for %d",
                   surface->n, work->max_pixels);
  if (work->on_cells)
    hl_light_exchange(work);
  work->all.n = 0;
  work->all.channels = frame->channels;
  const bool sorted = order_by_pixel(work, surface);
  const glance some = glance_of(frame, surface, most);
  long long due = 0; /* reaches `runs` where a run is kept */
  for (int i = 0; i < surface->n; i += RUN) {
    const bool kept = (due += some.kept) >= some.runs;
    due -= kept ? some.runs : 0;
    for (int j = i; j < i + RUN && j < surface->n; j++) {
      const int at = place_of(work, sorted, j);
      if (kept || bin_of(frame, surface->pixel[at]) >= some.bright)
        gather_pixel(work, frame, surface, at);
    }
  }
  find_box(work, surface);
  const int n = work->all.n;
  work->grey.n = n;
  work->grey.channels = 1;
  memset(&work->brightness, 0, sizeof work->brightness);
  if (n > 0)
    scale_to_level(work, surface);
  return HL_OK;
}

void hl_light_weigh(hl_light_data *data, hl_light_noise noise, const uint8_t *outlier)
{
  const double absolute2 = noise.absolute * noise.absolute;
  data->apart = 0;
  for (int c = 0; c < data->channels; c++)
    for (int i = 0; i < data->n; i++) {
      const double y = noise.relative * data->value[c][i];
      data->weight[c][i] = outlier && outlier[i] ? 0 : 1 / (y * y + absolute2);
    }
  for (int c = 0; data->side && c < data->channels; c++)
    for (int i = 0; i < data->n; i++) {
      const int area = hl_light_area(data, i);
      data->weight[c][i] *= (double)data->stretch[i] * area;
      data->apart += data->weight[c][i] * data->scatter[c][i] * (area - 1) / area;
    }
}
