/* Drawn targets: every pixel of a PNG, the size of PDF and SVG, and what AprilTag sees. */
#include <stdio.h>
#include <string.h>

#include "../src/cli/target_sheet.h"
#include "files.h"
#include "near.h"

typedef struct picture {
  cairo_surface_t *surface;
  int width, height, stride;
  const unsigned char *bytes;
} picture;

static int grey(const picture *p, int x, int y)
{
  return p->bytes[y * p->stride + 4 * x];
}

static hl_sheet planned(const char *spec, hl_picture_kind kind, hl_sheet_settings settings)
{
  hl_ctx ctx = {0};
  hl_target t;
  hl_sheet s;
  assert_int_equal(hl_target_parse(NULL, spec, &t), HL_OK);
  if (hl_sheet_plan(&ctx, &t, kind, &settings, &s) != HL_OK)
    fail_msg("%s: %s", spec, ctx.msg);
  return s;
}

static void draw(const hl_sheet *s, const char *path)
{
  hl_ctx ctx = {0};
  if (hl_draw_target(&ctx, s, path) != HL_OK)
    fail_msg("%s: %s", path, ctx.msg);
}

/* The whole file as text, NULs and all. */
static char *read_all(const char *path, size_t *n)
{
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  char *bytes = malloc(1 << 20);
  *n = fread(bytes, 1, (1 << 20) - 1, file);
  bytes[*n] = '\0';
  fclose(file);
  return bytes;
}

static picture drawn(void **state, const hl_sheet *s)
{
  char path[TEST_PATH_MAX];
  snprintf(path, sizeof path, "%s/target.png", (const char *)*state);
  draw(s, path);
  picture p = {.surface = cairo_image_surface_create_from_png(path)};
  assert_int_equal(cairo_surface_status(p.surface), CAIRO_STATUS_SUCCESS);
  assert_int_equal(cairo_image_surface_get_format(p.surface), CAIRO_FORMAT_RGB24);
  p.width = cairo_image_surface_get_width(p.surface);
  p.height = cairo_image_surface_get_height(p.surface);
  p.stride = cairo_image_surface_get_stride(p.surface);
  p.bytes = cairo_image_surface_get_data(p.surface);
  return p;
}

/* analytic: squares of 8 pixels, black where row + column is even, white all around */
static void test_chessboard_pixels(void **state)
{
  const hl_sheet s =
      planned("chessboard:5x4:0.008", HL_PICTURE_PNG, (hl_sheet_settings){0, HL_PAGE_FIT, 25.4});
  const picture p = drawn(state, &s);
  assert_int_equal(p.width, 64);
  assert_int_equal(p.height, 5 * 8 + 2 * 8 + 26);
  const int caption = 5 * 8 + 2 * 8;
  for (int y = 0; y < caption; y++)
    for (int x = 0; x < p.width; x++) {
      const int column = (x + 8) / 8 - 2;
      const int row = (y + 8) / 8 - 2;
      const bool on = column >= 0 && column < 6 && row >= 0 && row < 5;
      assert_int_equal(grey(&p, x, y), on && (column + row) % 2 == 0 ? 0 : 255);
    }
  cairo_surface_destroy(p.surface);
}

/* A length in PDF or SVG that follows `word`, any number of them. */
static void numbers_after(const char *bytes, size_t n, const char *word, int count, double *out)
{
  const size_t length = strlen(word);
  const char *at = NULL;
  for (size_t i = 0; i + length < n && !at; i++)
    if (memcmp(bytes + i, word, length) == 0)
      at = bytes + i + length;
  assert_non_null(at);
  for (int i = 0; i < count; i++) {
    char *end;
    out[i] = strtod(at, &end);
    assert_ptr_not_equal(end, at);
    at = end;
  }
}

static void check_pdf(void **state, hl_page page, double width_mm, double height_mm)
{
  char path[TEST_PATH_MAX];
  double box[4];
  size_t n;
  snprintf(path, sizeof path, "%s/target.pdf", (const char *)*state);
  const hl_sheet s =
      planned("chessboard:7x5:0.02", HL_PICTURE_PDF, (hl_sheet_settings){0, (int)page, 0});
  draw(&s, path);
  char *bytes = read_all(path, &n);
  numbers_after(bytes, n, "/MediaBox [", 4, box);
  assert_near(box[0], 0, 0);
  assert_near(box[1], 0, 0);
  /* cairo writes six decimals */
  assert_near(box[2], width_mm / 25.4 * 72, 1e-6);
  assert_near(box[3], height_mm / 25.4 * 72, 1e-6);
  free(bytes);
}

static void test_pdf_size(void **state)
{
  check_pdf(state, HL_PAGE_FIT, 8 * 20 + 2 * 20, 6 * 20 + 2 * 20 + 26);
  check_pdf(state, HL_PAGE_A4, 210, 297);
  check_pdf(state, HL_PAGE_A3, 297, 420);
  check_pdf(state, HL_PAGE_LETTER, 215.9, 279.4);
}

/* The same target gives the same bytes, without a date. */
static void test_pdf_repeats(void **state)
{
  char path[2][TEST_PATH_MAX];
  char *bytes[2];
  size_t n[2];
  const hl_sheet s =
      planned("chessboard:7x5:0.02", HL_PICTURE_PDF, (hl_sheet_settings){0, HL_PAGE_FIT, 0});
  for (int i = 0; i < 2; i++) {
    snprintf(path[i], sizeof path[i], "%s/repeat%d.pdf", (const char *)*state, i);
    draw(&s, path[i]);
    bytes[i] = read_all(path[i], &n[i]);
  }
  assert_int_equal(n[0], n[1]);
  assert_memory_equal(bytes[0], bytes[1], n[0]);
  free(bytes[0]);
  free(bytes[1]);
}

/* Millimetres, one to the user unit. */
static void test_svg_size(void **state)
{
  char path[TEST_PATH_MAX];
  size_t n;
  double size;
  double box[4];
  snprintf(path, sizeof path, "%s/target.svg", (const char *)*state);
  const hl_sheet s =
      planned("chessboard:7x5:0.02", HL_PICTURE_SVG, (hl_sheet_settings){0, HL_PAGE_FIT, 0});
  draw(&s, path);
  char *bytes = read_all(path, &n);
  numbers_after(bytes, n, " width=\"", 1, &size);
  assert_near(size, 200, 1e-6);
  assert_non_null(strstr(bytes, "mm\" height=\""));
  numbers_after(bytes, n, "mm\" height=\"", 1, &size);
  assert_near(size, 186, 1e-6);
  assert_non_null(strstr(bytes, "186mm\""));
  numbers_after(bytes, n, "viewBox=\"", 4, box);
  assert_near(box[2], 200, 1e-6);
  assert_near(box[3], 186, 1e-6);
  /* the pattern's path begins with the first black square, a square's side from the edge */
  numbers_after(bytes, n, "fill:rgb(0%,0%,0%);fill-opacity:1;\" d=\"M ", 2, box);
  assert_near(box[0], 20, 1.0 / 256);
  assert_near(box[1], 20, 1.0 / 256);
  free(bytes);
}

/* analytic: 300 dpi are 11811.02 pixels a metre; the check sum is Python's zlib.crc32 */
static void test_png_states_its_size(void **state)
{
  static const unsigned char chunk[21] = {0,    0, 0, 9,    'p',  'H', 'Y',  's',  0,    0,   0x2e,
                                          0x23, 0, 0, 0x2e, 0x23, 1,   0x78, 0xa5, 0x3f, 0x76};
  char path[TEST_PATH_MAX];
  size_t n;
  snprintf(path, sizeof path, "%s/target.png", (const char *)*state);
  const hl_sheet s =
      planned("chessboard:3x3:0.002", HL_PICTURE_PNG, (hl_sheet_settings){0, HL_PAGE_FIT, 0});
  draw(&s, path);
  char *bytes = read_all(path, &n);
  assert_memory_equal(bytes + 33, chunk, sizeof chunk);
  assert_memory_equal(bytes + n - 8, "IEND", 4);
  free(bytes);
}

static void test_no_such_folder(void **state)
{
  static const hl_picture_kind kinds[] = {HL_PICTURE_PNG, HL_PICTURE_SVG, HL_PICTURE_PDF};
  (void)state;
  for (int i = 0; i < 3; i++) {
    hl_ctx ctx = {0};
    const hl_sheet s =
        planned("chessboard:3x3:0.002", kinds[i], (hl_sheet_settings){0, HL_PAGE_FIT, 0});
    assert_int_equal(hl_draw_target(&ctx, &s, "/nonexistent/target"), HL_ERR_IO);
    assert_non_null(strstr(ctx.msg, "/nonexistent/target: the picture cannot be written"));
  }
}

#ifdef HL_HAVE_APRILTAG
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

/* Every pixel: border, code cells, squares between the tags, white around them. */
static void check_grid_pixels(void **state, int border)
{
  enum { BIT = 4, COLUMNS = 3, ROWS = 2 };
  const int side = (HL_TARGET_TAG_CELLS + 2 * border) * BIT;
  const double pixel_mm = 30.0 / side;
  const int gap = side / 4; /* ratio 0.25 */
  const hl_sheet s = planned("aprilgrid:3x2:0.03:0.25", HL_PICTURE_PNG,
                             (hl_sheet_settings){border, HL_PAGE_FIT, 25.4 / pixel_mm});
  const picture p = drawn(state, &s);
  assert_true(s.whole_pixels);
  bool white[ROWS * COLUMNS][HL_TARGET_TAG_CELLS][HL_TARGET_TAG_CELLS];
  for (int id = 0; id < ROWS * COLUMNS; id++)
    assert_int_equal(hl_target_tag_cells(NULL, id, white[id]), HL_OK);
  const int left = (int)lround(s.first_mm[0] / pixel_mm) - gap;
  const int top = (int)lround(s.first_mm[1] / pixel_mm) - gap;
  const int step = side + gap;
  for (int y = 0; y < ROWS * step + gap; y++)
    for (int x = 0; x < COLUMNS * step + gap; x++) {
      const int column = x / step, in_x = x % step - gap;
      const int row = y / step, in_y = y % step - gap;
      bool black = (in_x < 0) == (in_y < 0); /* a tag, or a square between */
      const int i = in_x / BIT - border, k = in_y / BIT - border;
      if (in_x >= border * BIT && in_y >= border * BIT && i < HL_TARGET_TAG_CELLS &&
          k < HL_TARGET_TAG_CELLS)
        black = !white[(ROWS - 1 - row) * COLUMNS + column][k][i];
      assert_int_equal(grey(&p, left + x, top + y), black ? 0 : 255);
    }
  for (int y = 0; y < top + ROWS * step + gap; y++)
    for (int x = 0; x < p.width; x++)
      if (y < top || x < left || x >= left + COLUMNS * step + gap)
        assert_int_equal(grey(&p, x, y), 255);
  cairo_surface_destroy(p.surface);
}

static void test_grid_pixels(void **state)
{
  check_grid_pixels(state, 1);
  check_grid_pixels(state, 2);
}

/* A family with `more` bits of border around the same codes. */
static apriltag_family_t *widened(int more)
{
  apriltag_family_t *family = tag36h11_create();
  family->width_at_border += 2 * more;
  family->total_width += 2 * more;
  for (uint32_t i = 0; i < family->nbits; i++) {
    family->bit_x[i] += (uint32_t)more;
    family->bit_y[i] += (uint32_t)more;
  }
  return family;
}

/* `buf` is the caller's. */
static image_u8_t as_image(const picture *p)
{
  image_u8_t image = {p->width, p->height, p->width, malloc((size_t)p->width * (size_t)p->height)};
  assert_non_null(image.buf);
  for (int y = 0; y < p->height; y++)
    for (int x = 0; x < p->width; x++)
      image.buf[y * image.stride + x] = (uint8_t)grey(p, x, y);
  return image;
}

/* AprilTag 3.3 counts from the corner of the first pixel, as millimetres on the sheet do; a tag's
 * corners come anticlockwise from its lower left. Where edges are not blurred it is off by up to
 * 0.27 pixels, measured; the errors are added up. */
static void check_tag(const hl_sheet *s, const apriltag_detection_t *d, double sum[2])
{
  static const int at_x[4] = {0, 1, 1, 0};
  static const int at_y[4] = {1, 1, 0, 0};
  const hl_target *t = &s->target;
  const int columns = hl_target_corner_columns(t);
  assert_in_range(d->id, 0, t->columns * t->rows - 1);
  const int column = d->id % t->columns;
  const int row = t->rows - 1 - d->id / t->columns;
  assert_int_equal(hl_target_tag_id(t, column, row), d->id);
  for (int i = 0; i < 4; i++) {
    double corner[3];
    hl_target_corner(t, (2 * row + at_y[i]) * columns + 2 * column + at_x[i], corner);
    for (int k = 0; k < 2; k++) {
      const double due = (s->first_mm[k] + 1e3 * corner[k]) * s->dpi / 25.4;
      assert_near(d->p[i][k], due, 0.35);
      sum[k] += d->p[i][k] - due;
    }
  }
}

/* Marks the ids that are seen, none of them twice. */
static void see(const hl_sheet *s, image_u8_t *image, int border, bool seen[HL_TARGET_TAGS_MAX])
{
  apriltag_family_t *family = widened(border - 1);
  apriltag_detector_t *detector = apriltag_detector_create();
  detector->quad_decimate = 1;
  apriltag_detector_add_family(detector, family);
  zarray_t *found = apriltag_detector_detect(detector, image);
  const int n = zarray_size(found);
  bool here[HL_TARGET_TAGS_MAX] = {false};
  double sum[2] = {0, 0};
  for (int i = 0; i < n; i++) {
    apriltag_detection_t *d;
    zarray_get(found, i, &d);
    check_tag(s, d, sum);
    assert_false(here[d->id]);
    here[d->id] = seen[d->id] = true;
  }
  for (int k = 0; k < 2 && n > 0; k++)
    assert_near(sum[k] / (4 * n), 0, 0.1);
  apriltag_detections_destroy(found);
  apriltag_detector_destroy(detector);
  tag36h11_destroy(family);
}

/* The blur of a lens: 1 2 1 along rows and columns, a standard deviation of 0.7 pixels. */
static void blur(image_u8_t *image)
{
  const int step[2] = {1, image->stride};
  const int last = image->stride * (image->height - 1) - 1;
  uint8_t *before = malloc((size_t)last + 1 + (size_t)image->stride);
  assert_non_null(before);
  for (int k = 0; k < 2; k++) {
    memcpy(before, image->buf, (size_t)last + 1 + (size_t)image->stride);
    for (int i = image->stride; i <= last; i++)
      image->buf[i] =
          (uint8_t)((before[i - step[k]] + 2 * before[i] + before[i + step[k]] + 2) / 4);
  }
  free(before);
}

/* Every tag, at its place and upright. AprilTag takes some tags and
 * the squares that touch them for one, others with each scale and blur: of 36 tags up to five. So a
 * few pictures together. */
static void check_seen(void **state, const char *spec, int border)
{
  static const double dpi[] = {60, 75, 84.6, 101.6};
  bool seen[HL_TARGET_TAGS_MAX] = {false};
  int tags = 0;
  for (int i = 0; i < 4; i++) {
    const hl_sheet s =
        planned(spec, HL_PICTURE_PNG, (hl_sheet_settings){border, HL_PAGE_FIT, dpi[i]});
    const picture p = drawn(state, &s);
    image_u8_t image = as_image(&p);
    see(&s, &image, border, seen);
    blur(&image);
    see(&s, &image, border, seen);
    free(image.buf);
    cairo_surface_destroy(p.surface);
    tags = s.target.columns * s.target.rows;
  }
  for (int id = 0; id < HL_TARGET_TAGS_MAX; id++)
    assert_int_equal(seen[id], id < tags);
}

static void test_apriltag_sees(void **state)
{
  check_seen(state, "aprilgrid:6x6:0.03:0.3", 2);
  check_seen(state, "aprilgrid:6x6:0.03:0.3", 1);
  check_seen(state, "aprilgrid:5x3:0.04:0.25", 2);
  check_seen(state, "aprilgrid:2x4:0.04:0.4", 1);
}

#else

static void test_no_tags(void **state)
{
  hl_ctx ctx = {0};
  char path[TEST_PATH_MAX];
  snprintf(path, sizeof path, "%s/none.pdf", (const char *)*state);
  const hl_sheet s =
      planned("aprilgrid:3x2:0.03:0.3", HL_PICTURE_PDF, (hl_sheet_settings){0, HL_PAGE_FIT, 0});
  assert_int_equal(hl_draw_target(&ctx, &s, path), HL_ERR_UNAVAILABLE);
  assert_non_null(strstr(ctx.msg, "not in this build"));
}

#endif

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_chessboard_pixels),   cmocka_unit_test(test_pdf_size),
      cmocka_unit_test(test_pdf_repeats),         cmocka_unit_test(test_svg_size),
      cmocka_unit_test(test_png_states_its_size), cmocka_unit_test(test_no_such_folder),
#ifdef HL_HAVE_APRILTAG
      cmocka_unit_test(test_grid_pixels),         cmocka_unit_test(test_apriltag_sees),
#else
      cmocka_unit_test(test_no_tags),
#endif
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
