/* Camera files for tests: one of each lens, files written and refused. */
#ifndef HALFLIGHT_TESTS_CAMERA_TEXTS_H
#define HALFLIGHT_TESTS_CAMERA_TEXTS_H

#include "files.h"
#include "halflight/camera.h"

/* Numbers whose decimal texts are long. */
static const hl_camera camera_samples[] = {
    {.model = HL_LENS_PINHOLE,
     .width = 640,
     .height = 480,
     .fx = 2e3 / 3,
     .fy = 4.7e3 / 7,
     .cx = 320 + 1e-13,
     .cy = 239.5,
     .n_distortion = 5,
     .distortion = {-0.1 / 3, 1e-3 / 7, 1e-9 / 11, -0.0, 0}},
    {.model = HL_LENS_PINHOLE,
     .width = 4096,
     .height = 3000,
     .fx = 3900.123456789012,
     .fy = 3901.5,
     .cx = 2047.5,
     .cy = 1499.5,
     .n_distortion = 5,
     .distortion = {-0.25, 0.08, 0.001, -0.0008, 0.1 / 49}},
    {.model = HL_LENS_RATIONAL,
     .width = 640,
     .height = 480,
     .fx = 450,
     .fy = 455.1,
     .cx = 322.3,
     .cy = 236.8,
     .n_distortion = 8,
     .distortion = {2.1 + 1e-15, 0.9, -0.0005, 0.0008, 0.03, 2.4, 1.5, 0.2}},
    {.model = HL_LENS_FISHEYE,
     .width = 640,
     .height = 480,
     .fx = 275,
     .fy = 278,
     .cx = 322.3,
     .cy = 236.8,
     .n_distortion = 4,
     .distortion = {0.05, -0.02, 0.006, -1e-3 / 3}},
};

enum {
  SAMPLE_PINHOLE_K3_0,
  SAMPLE_PINHOLE,
  SAMPLE_RATIONAL,
  SAMPLE_FISHEYE,
  N_CAMERA_SAMPLES = sizeof camera_samples / sizeof camera_samples[0]
};

static inline void same_intrinsics(const hl_camera *a, const hl_camera *b)
{
  double x[HL_INTRINSICS_MAX], y[HL_INTRINSICS_MAX];
  assert_int_equal(a->model, b->model);
  assert_int_equal(a->width, b->width);
  assert_int_equal(a->height, b->height);
  assert_int_equal(a->n_distortion, b->n_distortion);
  hl_camera_intrinsics(a, x);
  hl_camera_intrinsics(b, y);
  assert_memory_equal(x, y, (size_t)hl_camera_intrinsics_count(a) * sizeof *x);
}

static inline hl_status read_camera_text(void **state, const char *text, hl_ctx *ctx,
                                         hl_camera *out)
{
  char path[TEST_PATH_MAX];
  path_in(state, "camera", path);
  put_text(path, text);
  return hl_camera_read(ctx, path, out);
}

/* The camera of a text that must be readable. */
static inline hl_camera camera_of_text(void **state, const char *text)
{
  hl_ctx ctx = {0};
  hl_camera c = {0};
  if (read_camera_text(state, text, &ctx, &c) != HL_OK)
    fail_msg("%s", ctx.msg);
  return c;
}

static inline void camera_text_refused(void **state, const char *text, const char *part)
{
  hl_ctx ctx = {0};
  hl_camera c, before;
  memset(&c, 0x5a, sizeof c);
  before = c;
  assert_int_equal(read_camera_text(state, text, &ctx, &c), HL_ERR_FORMAT);
  assert_says(ctx.msg, part);
  assert_says(ctx.msg, "/camera: ");
  assert_memory_equal(&c, &before, sizeof c);
  assert_int_equal(read_camera_text(state, text, NULL, &c), HL_ERR_FORMAT);
}

/* `text` with its first `from` replaced by `to`, refused. */
static inline void changed_text_refused(void **state, const char *text, const char *from,
                                        const char *to, const char *part)
{
  char changed[8192];
  const char *at = strstr(text, from);
  assert_non_null(at);
  assert_true(strlen(text) + strlen(to) < sizeof changed);
  snprintf(changed, sizeof changed, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
  camera_text_refused(state, changed, part);
}

/* Every beginning of the text is refused, or is the whole but for blanks at its end: a file cut short
 * is never another camera. `needed` bytes are the least that say everything. */
static inline void cut_text_refused(void **state, const char *text, size_t needed)
{
  char cut[8192];
  hl_camera c;
  assert_true(strlen(text) < sizeof cut && needed <= strlen(text));
  for (size_t n = 1; n < needed; n++) {
    snprintf(cut, sizeof cut, "%.*s", (int)n, text);
    hl_ctx ctx = {0};
    if (read_camera_text(state, cut, &ctx, &c) != HL_ERR_FORMAT)
      fail_msg("the first %zu bytes are taken for a camera", n);
    assert_says(ctx.msg, "/camera: ");
  }
}

/* Text of a camera that must be writable; free(). */
static inline char *text_of_camera(const hl_camera *c, hl_camera_format format)
{
  hl_ctx ctx = {0};
  char *text = NULL;
  if (hl_camera_text(&ctx, c, format, &text) != HL_OK)
    fail_msg("%s", ctx.msg);
  return text;
}

static inline void camera_round_trip(void **state, const hl_camera *c, hl_camera_format format)
{
  char *text = text_of_camera(c, format);
  const hl_camera back = camera_of_text(state, text);
  char *again = text_of_camera(&back, format);
  same_intrinsics(c, &back);
  assert_string_equal(again, text);
  free(again);
  free(text);
}

static inline void camera_not_written(const hl_camera *c, hl_camera_format format, const char *part)
{
  hl_ctx ctx = {0};
  char *text = NULL;
  assert_int_equal(hl_camera_text(&ctx, c, format, &text), HL_ERR_FORMAT);
  assert_says(ctx.msg, part);
  assert_null(text);
  assert_int_equal(hl_camera_text(NULL, c, format, &text), HL_ERR_FORMAT);
}

#endif
