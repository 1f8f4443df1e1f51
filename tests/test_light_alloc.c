/* hl_light_estimate allocates nothing, nor do the C library and OpenMP's on its behalf. */
#define _GNU_SOURCE
#include "light_scene.h"

static int allocations;

#if LIT_SANITIZED
/* of sanitizer/allocator_interface.h, which Debian's gcc does not have */
int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void *, size_t),
                                              void (*on_free)(const volatile void *));

static void on_malloc(const volatile void *at, size_t size)
{
  (void)at;
  (void)size;
  allocations++;
}

static void on_free(const volatile void *at)
{
  (void)at;
}

static void start_counting(void)
{
  static int installed;
  if (!installed)
    installed = __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);
  assert_true(installed > 0);
  allocations = 0;
}
#else
/* These take the place of the C library's own, also for calls from inside it. */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *at, size_t size);
#define VISIBLE __attribute__((visibility("default"))) /* or only this program's calls count */
VISIBLE void *malloc(size_t size);
VISIBLE void *calloc(size_t count, size_t size);
VISIBLE void *realloc(void *at, size_t size);

void *malloc(size_t size)
{
  __atomic_add_fetch(&allocations, 1, __ATOMIC_RELAXED);
  return __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
  __atomic_add_fetch(&allocations, 1, __ATOMIC_RELAXED);
  return __libc_calloc(count, size);
}

void *realloc(void *at, size_t size)
{
  __atomic_add_fetch(&allocations, 1, __ATOMIC_RELAXED);
  return __libc_realloc(at, size);
}

static void start_counting(void)
{
  allocations = 0;
}
#endif

static int allocations_of(const lit_scene *s, bool uncertain)
{
  hl_surface surface = lit_surface(s);
  hl_frame frame = lit_frame(s, &surface, NULL);
  surface.is_ball = true;
  surface.ball.has_covariance = surface.camera.has_covariance = uncertain;
  for (int i = 0; i < 3; i++)
    surface.ball.covariance_m2[i][i] = 1e-10;
  const int n = hl_camera_intrinsics_count(&surface.camera);
  for (int i = 0; i < n; i++)
    surface.camera.covariance[i * n + i] = 1e-6;
  hl_light_work *work = NULL;
  hl_light light;
  hl_ctx ctx = {0};
  assert_int_equal(hl_light_work_new(&ctx, surface.n, s->channels, &work), HL_OK);
  start_counting();
  const hl_status st = hl_light_estimate(&ctx, work, &frame, &surface, NULL, &light);
  const int counted = allocations;
  assert_int_equal(st, HL_OK);
  hl_light_work_free(work);
  lit_frame_free(&frame);
  hl_surface_free(&surface);
  return counted;
}

/* That the counter counts at all. */
static void test_an_allocation_is_counted(void **state)
{
  (void)state;
#if LIT_SANITIZED && !defined(__clang__)
  skip(); /* gcc's sanitizer runtime does not call the hooks: the other builds count */
#endif
  start_counting();
  void *volatile a = malloc(10);
  void *volatile b = calloc(3, 10);
  a = realloc(a, 5000);
  char *volatile c = strdup("from inside the C library");
  assert_true(allocations >= 4);
  free(c);
  free(a);
  free(b);
}

static void test_an_estimate_allocates_nothing(void **state)
{
  (void)state;
#if LIT_SANITIZED && !defined(__clang__)
  skip();
#endif
  lit_scene s = lit_glossy();
  assert_int_equal(allocations_of(&s, false), 0);
  s.channels = 3;
  s.saturation = 0.6;
  assert_int_equal(allocations_of(&s, true), 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_an_allocation_is_counted),
      cmocka_unit_test(test_an_estimate_allocates_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
