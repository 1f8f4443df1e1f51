/*
 * Tags through AprilTag's detector: no decimation, one thread, so that the order of what it finds is
 * its own.
 *
 * Kalibr prints the codes of tag36h11 with a black border of two bits. To the detector that is one
 * more family: the same codes, every bit one cell further in, of 10 + 2 cells. Both look at the
 * same quads, which are nearly all of the work.
 *
 * Where is pixel (0,0)? AprilTag 3.3.0 puts a pixel's centre at +0.5, later releases may not, under
 * the same name of the shared library; no function tells the version, and the one of the headers
 * at build time need not be the one that runs. So it is measured for every finder, on a tag drawn
 * here whose centre is known: a millisecond.
 */
#include "tags.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "hush.h"

enum {
  BITS_CORRECTED = 2, /* of 36; the codes differ in 11 */
  CELL = 6,           /* pixels, of the tag drawn for measuring */
  BORDERS = 2
};

struct hl_tag_finder {
  apriltag_family_t *family[BORDERS]; /* border of 1 and of 2 bits */
  apriltag_detector_t *detector;
  double origin; /* what AprilTag adds to x and y */
};

static void widen(apriltag_family_t *family)
{
  family->width_at_border += 2;
  family->total_width += 2;
  for (uint32_t i = 0; i < family->nbits; i++) {
    family->bit_x[i]++;
    family->bit_y[i]++;
  }
}

/* The families after the detector, which still looks at them. */
void hl_tag_finder_free(hl_tag_finder *f)
{
  if (!f)
    return;
  if (f->detector)
    apriltag_detector_destroy(f->detector);
  for (int i = 0; i < BORDERS; i++)
    if (f->family[i])
      tag36h11_destroy(f->family[i]);
  free(f);
}

static bool prepare(hl_tag_finder *f)
{
  f->detector = apriltag_detector_create();
  if (!f->detector)
    return false;
  f->detector->nthreads = 1;
  f->detector->quad_decimate = 1;
  f->detector->refine_edges = true;
  for (int i = 0; i < BORDERS; i++) {
    f->family[i] = tag36h11_create();
    if (!f->family[i])
      return false;
    if (i == 1)
      widen(f->family[i]);
    apriltag_detector_add_family_bits(f->detector, f->family[i], BITS_CORRECTED);
  }
  return true;
}

static zarray_t *detect(const hl_tag_finder *f, int width, int height, int stride,
                        uint8_t *pixel) // NOLINT(readability-non-const-parameter)
{
  image_u8_t view = {width, height, stride, pixel};
  hl_hush hush;
  hl_hush_begin(&hush);
  zarray_t *found = apriltag_detector_detect(f->detector, &view);
  hl_hush_end(&hush, NULL, 0);
  return found;
}

static const apriltag_detection_t *detection(const zarray_t *found, int i)
{
  apriltag_detection_t *d = NULL;
  zarray_get(found, i, &d);
  return d;
}

/* Tag 0 with a border of one bit, on white; (0,0) is the first pixel of its border. */
static void draw_tag(const apriltag_family_t *family, uint8_t *pixel, size_t stride)
{
  const size_t side = (size_t)family->width_at_border * CELL;
  for (size_t y = 0; y < side; y++)
    memset(pixel + y * stride, 0, side);
  for (uint32_t i = 0; i < family->nbits; i++) {
    const bool white = family->codes[0] >> (family->nbits - 1 - i) & 1;
    uint8_t *cell = pixel + family->bit_y[i] * CELL * stride + family->bit_x[i] * CELL;
    for (size_t y = 0; white && y < CELL; y++)
      memset(cell + y * stride, 255, CELL);
  }
}

static double measure_origin(const hl_tag_finder *f)
{
  enum { SIDE = HL_GREY_SIDE_MIN };
  uint8_t pixel[SIDE * SIDE];
  const int side = f->family[0]->width_at_border * CELL;
  const int at = (SIDE - side) / 2;
  const double center = at + 0.5 * side - 0.5;
  double shift = 0;
  memset(pixel, 255, sizeof pixel);
  draw_tag(f->family[0], pixel + at * SIDE + at, SIDE);
  zarray_t *found = detect(f, SIDE, SIDE, SIDE, pixel);
  for (int i = 0; i < zarray_size(found); i++) {
    const apriltag_detection_t *d = detection(found, i);
    for (int k = 0; d->family == f->family[0] && k < 4; k++)
      shift += (d->p[k][0] - center + d->p[k][1] - center) / 8;
  }
  apriltag_detections_destroy(found);
  return rint(2 * shift) / 2; /* there is no third convention */
}

/* Tags of one border. AprilTag goes round from the bottom left, and the image's y is down: bottom
 * left, bottom right, top right, top left. */
static void take(const zarray_t *found, const apriltag_family_t *family, double origin,
                 hl_tags *tags)
{
  for (int i = 0; i < zarray_size(found); i++) {
    const apriltag_detection_t *d = detection(found, i);
    if (d->family != family)
      continue;
    hl_tag *tag = &tags->tag[tags->n++];
    tag->id = d->id;
    tag->left_out = false;
    for (int k = 0; k < 4; k++)
      for (int axis = 0; axis < 2; axis++)
        tag->corner[k][axis] = d->p[3 - k][axis] - origin;
  }
  qsort(tags->tag, (size_t)tags->n, sizeof *tags->tag, hl_tag_order);
}

/* A tag of two bits may pass for one of one bit, by luck where the bits are sampled, and then with
 * wrong ones among them; not the other way round. */
static int better_border(const hl_tag_finder *f, const zarray_t *found)
{
  int good[BORDERS] = {0};
  for (int i = 0; i < zarray_size(found); i++) {
    const apriltag_detection_t *d = detection(found, i);
    good[d->family == f->family[1]] += BITS_CORRECTED + 1 - d->hamming;
  }
  return good[1] > 0 && good[1] >= good[0];
}

static hl_status gather(hl_ctx *ctx, const hl_tag_finder *f, const zarray_t *found, hl_tags *out)
{
  const int n = zarray_size(found);
  hl_tags tags = {.tag = malloc(((size_t)n + 1) * sizeof *tags.tag)};
  if (!tags.tag)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d tags", n);
  const int border = better_border(f, found);
  take(found, f->family[border], f->origin, &tags);
  tags.border_bits = tags.n > 0 ? border + 1 : 0;
  *out = tags;
  return HL_OK;
}

hl_status hl_tag_finder_new(hl_ctx *ctx, hl_tag_finder **out)
{
  hl_tag_finder *f = calloc(1, sizeof *f);
  if (!f || !prepare(f)) {
    hl_tag_finder_free(f);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for AprilTag's detector");
  }
  f->origin = measure_origin(f);
  *out = f;
  return HL_OK;
}

hl_status hl_tags_find(hl_ctx *ctx, hl_tag_finder *finder, const hl_grey *grey, hl_tag_edges edges,
                       hl_tags *out)
{
  if (grey->stride > HL_TAGS_SIDE_MAX || grey->rows > HL_TAGS_SIDE_MAX)
    return hl_fail(ctx, HL_ERR_FORMAT, "frame of %d x %d pixels; AprilTag takes up to %d a side",
                   grey->width, grey->height, HL_TAGS_SIDE_MAX);
  finder->detector->refine_edges = edges == HL_TAG_EDGES_REFINED;
  zarray_t *found = detect(finder, grey->stride, grey->rows, grey->stride, grey->code);
  const hl_status st = gather(ctx, finder, found, out);
  apriltag_detections_destroy(found);
  return st;
}
