/* Frame and surface brought together: which pixels, in which units, with which weights. */
#include "files.h"
#include "light_data.h"

/* A surface of n pixels in a frame of 10 x 10, pixel 2 i + 1. */
typedef struct small {
  int pixel[40];
  double normal[120], view[120], footprint[40];
  float radiance[300];
  uint8_t state[300];
  hl_surface surface;
  hl_frame frame;
  hl_light_work *work;
} small;

static small *small_of(int n, int channels)
{
  small *s = calloc(1, sizeof *s);
  if (!s || hl_light_work_new(NULL, 40, channels, &s->work) != HL_OK)
    abort();
  for (int i = 0; i < n; i++) {
    s->pixel[i] = 2 * i + 1;
    s->footprint[i] = 0.01 + i;
    for (int k = 0; k < 3; k++) {
      s->normal[3 * i + k] = 100 * i + k;
      s->view[3 * i + k] = -100 * i - k;
    }
  }
  for (int i = 0; i < 100 * channels; i++)
    s->radiance[i] = (float)(i + 1);
  s->surface = (hl_surface){.n = n,
                            .width = 10,
                            .height = 10,
                            .pixel = s->pixel,
                            .normal = s->normal,
                            .view = s->view,
                            .footprint = s->footprint};
  s->frame = (hl_frame){.width = 10,
                        .height = 10,
                        .channels = channels,
                        .bits = 32,
                        .radiance = s->radiance,
                        .state = s->state};
  return s;
}

static void small_free(small *s)
{
  hl_light_work_free(s->work);
  free(s);
}

static void test_every_pixel_comes_with_its_geometry(void **state)
{
  (void)state;
  small *s = small_of(40, 3);
  assert_int_equal(hl_light_gather(NULL, s->work, &s->frame, &s->surface, 0), HL_OK);
  const hl_light_data *all = &s->work->all, *grey = &s->work->grey;
  const double level = s->work->brightness.level;
  assert_int_equal(all->n, 40);
  assert_int_equal(grey->n, 40);
  assert_int_equal(all->channels, 3);
  assert_int_equal(grey->channels, 1);
  for (int i = 0; i < 40; i++) {
    assert_int_equal(s->work->index[i], i);
    assert_near(all->footprint[i], 0.01 + i, 0);
    for (int k = 0; k < 3; k++) {
      assert_near(all->normal[k][i], 100 * i + k, 0);
      assert_near(all->view[k][i], -100 * i - k, 0);
      assert_near(all->value[k][i] * level, 3 * (2 * i + 1) + k + 1, 1e-12 * level);
    }
    assert_near(grey->value[0][i] * level, 3 * (2 * i + 1) + 2, 1e-12 * level);
  }
  small_free(s);
}

static void test_a_pixel_with_an_unusable_channel_is_left_out(void **state)
{
  (void)state;
  small *s = small_of(40, 3);
  s->state[3 * 5 + 1] = HL_SAMPLE_UNUSABLE;  /* entry 2 */
  s->state[3 * 79 + 0] = HL_SAMPLE_UNUSABLE; /* entry 39 */
  s->state[3 * 2] = HL_SAMPLE_UNUSABLE;      /* beside the surface */
  assert_int_equal(hl_light_gather(NULL, s->work, &s->frame, &s->surface, 0), HL_OK);
  assert_int_equal(s->work->all.n, 38);
  assert_int_equal(s->work->grey.n, 38);
  for (int p = 0; p < 38; p++) {
    assert_int_equal(s->work->index[p], p < 2 ? p : p + 1);
    assert_near(s->work->all.footprint[p], 0.01 + s->work->index[p], 0);
  }
  small_free(s);
}

static void test_clipped_channels_are_marked_one_by_one(void **state)
{
  (void)state;
  small *s = small_of(40, 3);
  s->state[3 * 1 + 2] = HL_SAMPLE_CLIPPED;
  s->state[3 * 3 + 0] = HL_SAMPLE_CLIPPED;
  s->state[3 * 3 + 1] = HL_SAMPLE_CLIPPED;
  assert_int_equal(hl_light_gather(NULL, s->work, &s->frame, &s->surface, 0), HL_OK);
  assert_int_equal(s->work->all.clipped[0], 4);
  assert_int_equal(s->work->all.clipped[1], 3);
  assert_int_equal(s->work->all.clipped[2], 0);
  assert_int_equal(s->work->grey.clipped[1], 1);
  assert_int_equal(s->work->grey.clipped[2], 0);
  assert_int_equal(s->work->brightness.clipped, 2);
  /* and a frame without leaves no mark of the last */
  memset(s->state, 0, sizeof s->state);
  assert_int_equal(hl_light_gather(NULL, s->work, &s->frame, &s->surface, 0), HL_OK);
  assert_int_equal(s->work->all.clipped[0], 0);
  assert_int_equal(s->work->brightness.clipped, 0);
  small_free(s);
}

/* By hand: radiances 2, 4 .. 80; all above 2 % of the 90th percentile; median about 41. */
static void test_level_is_the_median_of_the_lit(void **state)
{
  (void)state;
  small *s = small_of(40, 1);
  assert_int_equal(hl_light_gather(NULL, s->work, &s->frame, &s->surface, 0), HL_OK);
  const hl_light_brightness *b = &s->work->brightness;
  assert_near(b->level, 41, 2);
  assert_near(b->p50 * b->level, 41, 2);
  assert_near(b->p98 * b->level, 79, 2);
  assert_near(b->p2 * b->level, 3, 2);
  assert_true(b->p2 < b->p50 && b->p50 < b->p98);
  /* darkness does not count: with half of the pixels in shadow the level is the lit half's */
  for (int i = 0; i < 20; i++)
    s->radiance[s->pixel[i]] = 0;
  assert_int_equal(hl_light_gather(NULL, s->work, &s->frame, &s->surface, 0), HL_OK);
  assert_int_equal(b->lit, 20);
  assert_near(b->level, 61, 2);
  for (int i = 1; i < 40; i++)
    assert_true(s->work->ranked[i].key <= s->work->ranked[i - 1].key);
  small_free(s);
}

/* Exposure times a power of two: not a bit of what is estimated from changes. */
static void test_exposure_changes_no_bit(void **state)
{
  (void)state;
  small *one = small_of(40, 3), *other = small_of(40, 3);
  static const int powers[] = {-100, -3, 7, 100};
  assert_int_equal(hl_light_gather(NULL, one->work, &one->frame, &one->surface, 0), HL_OK);
  for (int p = 0; p < 4; p++) {
    for (int i = 0; i < 300; i++)
      other->radiance[i] = ldexpf(one->radiance[i], powers[p]);
    assert_int_equal(hl_light_gather(NULL, other->work, &other->frame, &other->surface, 0), HL_OK);
    for (int c = 0; c < 3; c++)
      assert_memory_equal(one->work->all.value[c], other->work->all.value[c], 40 * sizeof(double));
    assert_memory_equal(one->work->grey.value[0], other->work->grey.value[0], 40 * sizeof(double));
    assert_near(other->work->brightness.level, ldexp(one->work->brightness.level, powers[p]), 0);
  }
  small_free(one);
  small_free(other);
}

static void test_black_and_below_have_no_level(void **state)
{
  (void)state;
  static const float dark[] = {0, -1e-3f};
  for (int k = 0; k < 2; k++) {
    small *s = small_of(40, 1);
    for (int i = 0; i < 100; i++)
      s->radiance[i] = dark[k];
    assert_int_equal(hl_light_gather(NULL, s->work, &s->frame, &s->surface, 0), HL_OK);
    assert_false(s->work->brightness.level > 0);
    small_free(s);
  }
}

static void test_no_usable_pixel_is_no_fault_here(void **state)
{
  (void)state;
  small *s = small_of(40, 1);
  memset(s->state, HL_SAMPLE_UNUSABLE, sizeof s->state);
  assert_int_equal(hl_light_gather(NULL, s->work, &s->frame, &s->surface, 0), HL_OK);
  assert_int_equal(s->work->all.n, 0);
  assert_near(s->work->brightness.level, 0, 0);
  small_free(s);
}

/* 1 / ((relative y)^2 + absolute^2), and 0 for outliers. */
static void test_weights_are_the_inverse_variance(void **state)
{
  (void)state;
  small *s = small_of(40, 3);
  const hl_light_noise noise = {0.03, 0.2};
  uint8_t outlier[40] = {0};
  outlier[7] = 1;
  assert_int_equal(hl_light_gather(NULL, s->work, &s->frame, &s->surface, 0), HL_OK);
  hl_light_weigh(&s->work->all, noise, NULL);
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < 40; i++) {
      const double y = s->work->all.value[c][i];
      assert_near(s->work->all.weight[c][i] * (0.0009 * y * y + 0.04), 1, 1e-12);
    }
  hl_light_weigh(&s->work->all, noise, outlier);
  for (int c = 0; c < 3; c++) {
    assert_near(s->work->all.weight[c][7], 0, 0);
    assert_true(s->work->all.weight[c][8] > 0);
  }
  small_free(s);
}

static void test_what_does_not_belong_together_is_refused(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  small *s = small_of(40, 3);
  s->frame.width = 11;
  assert_int_equal(hl_light_gather(&ctx, s->work, &s->frame, &s->surface, 0), HL_ERR_ARG);
  assert_says(ctx.msg, "frame is 11 x 10, but the surface is of a frame of 10 x 10");
  s->frame.width = 10;
  s->surface.height = 9;
  assert_int_equal(hl_light_gather(&ctx, s->work, &s->frame, &s->surface, 0), HL_ERR_ARG);
  assert_says(ctx.msg, "10 x 9");
  s->surface.height = 10;
  s->frame.channels = 1;
  assert_int_equal(hl_light_gather(&ctx, s->work, &s->frame, &s->surface, 0), HL_ERR_ARG);
  assert_says(ctx.msg, "frame has 1 channel");
  assert_says(ctx.msg, "3");
  s->frame.channels = 3;
  s->surface.n = 41;
  assert_int_equal(hl_light_gather(&ctx, s->work, &s->frame, &s->surface, 0), HL_ERR_ARG);
  assert_says(ctx.msg, "surface has 41 pixels, but the workspace is for 40");
  assert_int_equal(hl_light_gather(NULL, s->work, &s->frame, &s->surface, 0), HL_ERR_ARG);
  small_free(s);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_every_pixel_comes_with_its_geometry),
      cmocka_unit_test(test_a_pixel_with_an_unusable_channel_is_left_out),
      cmocka_unit_test(test_clipped_channels_are_marked_one_by_one),
      cmocka_unit_test(test_level_is_the_median_of_the_lit),
      cmocka_unit_test(test_exposure_changes_no_bit),
      cmocka_unit_test(test_black_and_below_have_no_level),
      cmocka_unit_test(test_no_usable_pixel_is_no_fault_here),
      cmocka_unit_test(test_weights_are_the_inverse_variance),
      cmocka_unit_test(test_what_does_not_belong_together_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
