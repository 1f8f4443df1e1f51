/* Fewer samples than pixels: cells, the means of square blocks where shading is straight.
 *
 * The mean of a straight piece of shading is its value in the middle, with the noise of all its pixels
 * averaged, so that next to nothing is lost. Cells are blocks of 2, 4, 8 or 16 pixels a side, aligned to
 * multiples of their side; which ones is decided by how much the quarters of a block differ in units of
 * the fit's own weights, and so highlights and their flanks stay single pixels. In Morton's order
 * (x and y interleaved bit by bit) an aligned block is a run of consecutive keys, which is how whole
 * blocks are found.
 *
 * A sample of k^2 pixels weighs as much as they do. What its pixels cost about their mean no model can
 * change; it is taken from the two diagonals' difference in every 2 x 2 of them, in which slopes cancel,
 *
 *   scatter = mean of (a - b - c + d)^2 / 4,   apart = sum of w1 (k^2 - 1) scatter,
 *
 * and added to the cost, which then means the same at any number of samples.
 *
 * Where even the largest blocks that are straight enough leave too many samples, some are left out: the
 * sharpest pixels, up to a third of what there may be, stay, as do the largest cells, up to another; of the
 * others a regular share is kept, and its weights are raised.
 */
#include <math.h>
#include <string.h>

#include "light_work.h"

enum { DIGIT_BITS = 8, DIGITS = 4, RADIX = 1 << DIGIT_BITS, ALIGNED = 1 << HL_CELL_LEVELS };
static const double least_log_bend = -4,
                    most_log_bend = 2; /* of two, in deviations of the weights */
static const double sharpest_log_bend = 14;
enum { BISECTIONS = 12 };
static const double widest_rad = 0.1; /* of the normals across a cell */
static const float inherited = 0.5F;  /* share of a quarter's bend that its block has at least */

static uint32_t every_other(uint32_t v)
{
  v = (v | v << 8) & 0x00ff00ffU;
  v = (v | v << 4) & 0x0f0f0f0fU;
  v = (v | v << 2) & 0x33333333U;
  return (v | v << 1) & 0x55555555U;
}

static uint32_t key_of(uint64_t place)
{
  return (uint32_t)(place >> 32);
}

static int pixel_of(uint64_t place)
{
  return (int)(place & 0xffffffffU);
}

/* Byte by byte from the lowest; a byte that is the same in all is passed over. */
void hl_light_sort_places(uint64_t *place, uint64_t *scratch, int n)
{
  for (int digit = 0; digit < DIGITS; digit++) {
    const int shift = 32 + digit * DIGIT_BITS;
    int first[RADIX] = {0}, sum = 0;
    for (int i = 0; i < n; i++)
      first[place[i] >> shift & (RADIX - 1)]++;
    if (n == 0 || first[place[0] >> shift & (RADIX - 1)] == n)
      continue;
    for (int d = 0; d < RADIX; d++) {
      const int count = first[d];
      first[d] = sum;
      sum += count;
    }
    for (int i = 0; i < n; i++)
      scratch[first[place[i] >> shift & (RADIX - 1)]++] = place[i];
    memcpy(place, scratch, sizeof *place * (size_t)n);
  }
}

/* False where the surface spreads over more than Morton's keys reach. */
static bool place_pixels(struct hl_light_work *work, const hl_surface *surface)
{
  const hl_light_box *box = &work->box;
  const int n = work->all.n, width = surface->width;
  const int x0 = box->x0 - box->x0 % ALIGNED, y0 = box->y0 - box->y0 % ALIGNED;
  if (box->x1 - x0 > 0xffff || box->y1 - y0 > 0xffff) {
    for (int p = 0; p < n; p++)
      work->place[p] = (uint32_t)p;
    return false;
  }
  int row = 0, start = 0;
  for (int p = 0; p < n; p++) {
    const int pixel = surface->pixel[work->index[p]];
    if (pixel - start >= width) {
      row = pixel / width;
      start = row * width;
    }
    const uint32_t key =
        every_other((uint32_t)(pixel - start - x0)) | every_other((uint32_t)(row - y0)) << 1;
    work->place[p] = (uint64_t)key << 32 | (uint32_t)p;
  }
  hl_light_sort_places(work->place, work->place + work->max_pixels, n);
  return true;
}

/* Bend of a block from its quarters, which lie `quarter` places apart; infinite where one of them is. */
static float bend_of(const struct hl_light_work *work, int at, int level, int quarter, float *mean)
{
  float low = INFINITY, high = -INFINITY, sum = 0, bend = 0;
  for (int j = 0; j < 4; j++) {
    const int i = at + j * quarter, p = pixel_of(work->place[i]);
    if (level == 0 && work->all.clipped[p])
      return INFINITY;
    const float value = level == 0 ? (float)work->grey.value[0][p] : work->mean[i];
    if (level > 0)
      bend = fmaxf(bend, inherited * work->bend[i][level - 1]);
    low = fminf(low, value);
    high = fmaxf(high, value);
    sum += value;
  }
  *mean = 0.25F * sum;
  const float unit =
      (float)hl_light_final_noise.relative * fabsf(*mean) + (float)hl_light_final_noise.absolute;
  return fmaxf(bend, (high - low) / unit);
}

void hl_light_find_blocks(struct hl_light_work *work, const hl_surface *surface)
{
  const int n = work->all.n;
  work->blocks = place_pixels(work, surface);
  for (int i = 0; i < n; i++)
    for (int level = 0; level < HL_CELL_LEVELS; level++)
      work->bend[i][level] = INFINITY;
  for (int level = 0; work->blocks && level < HL_CELL_LEVELS; level++) {
    const int quarter = 1 << 2 * level, area = 4 * quarter;
    for (int i = 0; i + area <= n;) {
      const uint32_t key = key_of(work->place[i]);
      if (key % (uint32_t)area != 0 ||
          key_of(work->place[i + area - 1]) != key + (uint32_t)area - 1) {
        i++;
        continue;
      }
      float mean = 0;
      const double wide = (2 << level) * work->all.footprint[pixel_of(work->place[i])];
      if (wide < widest_rad) {
        work->bend[i][level] = bend_of(work, i, level, quarter, &mean);
        work->mean[i] = mean;
      }
      i += area;
    }
  }
}

/* Level of the cell that begins at place i: the largest straight block, or 0, the pixel itself. */
static int level_at(const struct hl_light_work *work, int i, float most_bend)
{
  for (int level = HL_CELL_LEVELS; level > 0; level--)
    if (work->bend[i][level - 1] <= most_bend)
      return level;
  return 0;
}

/* Cells there are; stops where there are more than `enough`. */
static int count_cells(const struct hl_light_work *work, float most_bend, int enough)
{
  int count = 0;
  for (int i = 0; i < work->all.n && count <= enough; count++)
    i += 1 << 2 * level_at(work, i, most_bend);
  return count;
}

/* The least bend that leaves no more than `most` cells, if one does. */
static float settle_bend(const struct hl_light_work *work, int most)
{
  double low = least_log_bend, high = most_log_bend;
  if (count_cells(work, (float)exp2(high), most) > most)
    return (float)exp2(high);
  for (int i = 0; i < BISECTIONS; i++) {
    const double log_bend = 0.5 * (low + high);
    if (count_cells(work, (float)exp2(log_bend), most) > most)
      low = log_bend;
    else
      high = log_bend;
  }
  return (float)exp2(high);
}

/* Mean and scatter of one channel of the pixels in a run of places. */
static void mean_of(const double *value, const uint64_t *place, int area, double *mean,
                    double *scatter)
{
  double sum = 0, square = 0;
  for (int i = 0; i < area; i += 4) {
    const double a = value[pixel_of(place[i])], b = value[pixel_of(place[i + 1])];
    const double c = value[pixel_of(place[i + 2])], d = value[pixel_of(place[i + 3])];
    const double twist = a - b - c + d;
    sum += a + b + c + d;
    square += twist * twist;
  }
  *mean = sum / area;
  *scatter = square / area;
}

/* Normal and view in the middle: those of the four pixels about it. */
static void middle_of(const hl_light_data *full, const uint64_t *place, int area,
                      hl_light_data *out, int t)
{
  const int quarter = area / 4;
  double length[2] = {0};
  int about
      [4]; /* last place of the first quarter, and so on: the corners that meet in the middle */
  for (int j = 0; j < 4; j++) {
    int within = 0; /* of quarter j, the corner opposite to j */
    for (int bit = 1; bit < quarter; bit *= 4)
      within += (3 - j) * bit;
    about[j] = pixel_of(place[j * quarter + within]);
  }
  for (int k = 0; k < 3; k++) {
    out->normal[k][t] = out->view[k][t] = 0;
    for (int j = 0; j < 4; j++) {
      out->normal[k][t] += full->normal[k][about[j]];
      out->view[k][t] += full->view[k][about[j]];
    }
    length[0] += out->normal[k][t] * out->normal[k][t];
    length[1] += out->view[k][t] * out->view[k][t];
  }
  for (int k = 0; k < 3; k++) {
    out->normal[k][t] /= sqrt(length[0]);
    out->view[k][t] /= sqrt(length[1]);
  }
  out->footprint[t] = 0;
  for (int j = 0; j < 4; j++)
    out->footprint[t] += 0.25 * full->footprint[about[j]];
}

static void take_cell(const hl_light_data *full, const uint64_t *place, int level,
                      hl_light_data *out, int t)
{
  const int area = 1 << 2 * level, p = pixel_of(*place);
  out->side[t] = (uint8_t)(1 << level);
  out->clipped[t] = full->clipped[p];
  if (level > 0) {
    middle_of(full, place, area, out, t);
    out->footprint[t] *= 1 << level;
    for (int c = 0; c < full->channels; c++)
      mean_of(full->value[c], place, area, &out->value[c][t], &out->scatter[c][t]);
    return;
  }
  for (int k = 0; k < 3; k++) {
    out->normal[k][t] = full->normal[k][p];
    out->view[k][t] = full->view[k][p];
  }
  out->footprint[t] = full->footprint[p];
  for (int c = 0; c < full->channels; c++) {
    out->value[c][t] = full->value[c][p];
    out->scatter[c][t] = 0;
  }
}

/* Where each cell's middle pixel is, in the frame's order, its first place and level; others 0. */
static int mark_cells(struct hl_light_work *work, float most_bend)
{
  uint64_t *mark = work->place + work->max_pixels;
  int cells = 0;
  memset(mark, 0, sizeof *mark * (size_t)work->all.n);
  for (int i = 0; i < work->all.n; cells++) {
    const int level = level_at(work, i, most_bend), area = 1 << 2 * level;
    mark[pixel_of(work->place[i + area - 1 - (area - 1) / 4])] =
        (uint64_t)i << 8 | (uint64_t)(level + 1);
    i += area;
  }
  return cells;
}

/* What is never left out, and the share of the others. */
typedef struct thinning {
  int level;   /* cells of this and larger */
  float sharp; /* single pixels whose block bends by more */
  int others, taken;
} thinning;

static bool stays(const struct hl_light_work *work, const thinning *by, int i, int level)
{
  const int start = i - (int)(key_of(work->place[i]) & 3U);
  if (level >= by->level)
    return true;
  return level == 0 && start >= 0 && isfinite(work->bend[start][0]) &&
         work->bend[start][0] > by->sharp;
}

static int count_staying(const struct hl_light_work *work, const thinning *by)
{
  const uint64_t *mark = work->place + work->max_pixels;
  int count = 0;
  for (int p = 0; p < work->all.n; p++)
    if (mark[p] != 0)
      count += stays(work, by, (int)(mark[p] >> 8), (int)(mark[p] & 0xff) - 1);
  return count;
}

static thinning thinning_of(const struct hl_light_work *work, int cells, int most)
{
  thinning by = {HL_CELL_LEVELS + 1, INFINITY, 0, 0};
  if (cells <= most)
    return (thinning){0, 0, 0, 0};
  while (by.level > 1) {
    by.level--;
    if (count_staying(work, &by) > most / 3) {
      by.level++;
      break;
    }
  }
  const int large = count_staying(work, &by);
  double low = most_log_bend, high = sharpest_log_bend;
  for (int i = 0; i < BISECTIONS; i++) {
    by.sharp = (float)exp2(0.5 * (low + high));
    if (count_staying(work, &by) - large > most / 3)
      low = 0.5 * (low + high);
    else
      high = 0.5 * (low + high);
  }
  by.sharp = (float)exp2(high);
  int staying = count_staying(work, &by);
  if (staying > most) { /* sharper than can be told apart */
    by.sharp = INFINITY;
    staying = large;
  }
  by.others = cells - staying;
  by.taken = most - staying;
  return by;
}

static void note_owner(struct hl_light_work *work, int first, int level, int cell)
{
  for (int j = 0; j < 1 << 2 * level; j++)
    work->owner[pixel_of(work->place[first + j])] = cell;
}

void hl_light_take_cells(struct hl_light_work *work, int most, const hl_light_data *full,
                         hl_light_data *out, hl_light_samples *samples)
{
  const uint64_t *mark = work->place + work->max_pixels;
  const int cells = mark_cells(work, settle_bend(work, most));
  const thinning by = thinning_of(work, cells, most);
  const float stretch = by.taken > 0 ? (float)by.others / (float)by.taken : 1;
  double pixels = 0, squares = 0;
  long long other = 0;
  out->n = 0;
  out->channels = full->channels;
  for (int p = 0; p < work->all.n; p++) {
    if (mark[p] == 0)
      continue;
    const int first = (int)(mark[p] >> 8), level = (int)(mark[p] & 0xff) - 1;
    bool taken = true;
    out->stretch[out->n] = 1;
    if (!stays(work, &by, first, level)) {
      taken = (other + 1) * by.taken / by.others > other * by.taken / by.others;
      out->stretch[out->n] = stretch;
      other++;
    }
    if (samples)
      note_owner(work, first, level, taken ? out->n : -1);
    if (!taken)
      continue;
    take_cell(full, work->place + first, level, out, out->n);
    if (samples)
      samples->index[out->n] = work->index[p];
    const double stands_for = (double)out->stretch[out->n] * (1 << 2 * level);
    pixels += stands_for;
    squares += (double)out->stretch[out->n] * stands_for;
    out->n++;
  }
  out->pixels = (int)(pixels + 0.5);
  out->effective = squares > 0 ? pixels * pixels / squares : 0;
}
