/* Comparing numbers in tests; NaN is never near anything. */
#ifndef HL_TEST_NEAR_H
#define HL_TEST_NEAR_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static inline int is_near(double got, double want, double tolerance)
{
  return !!(fabs(got - want) <= tolerance);
}

#define assert_near(got, want, tolerance)                                                          \
  do {                                                                                             \
    const double near_got = (got), near_want = (want), near_tolerance = (tolerance);               \
    if (!is_near(near_got, near_want, near_tolerance)) {                                           \
      print_error("%s = %.17g, wanted %.17g to %.3g (off by %.3g)\n", #got, near_got, near_want,   \
                  near_tolerance, near_got - near_want);                                           \
      fail();                                                                                      \
    }                                                                                              \
  } while (0)

/* A small generator of one's own (xorshift64*), so that a seed means the same everywhere. */
typedef struct test_random {
  uint64_t state; /* not 0 */
} test_random;

static inline double random_uniform(test_random *r)
{
  r->state ^= r->state >> 12;
  r->state ^= r->state << 25;
  r->state ^= r->state >> 27;
  return (double)((r->state * 2685821657736338717u) >> 11) / 9007199254740992.0;
}

static inline double random_between(test_random *r, double low, double high)
{
  return low + (high - low) * random_uniform(r);
}

/* Standard normal (Box and Muller). */
static inline double random_normal(test_random *r)
{
  const double u = 1 - random_uniform(r);
  const double v = random_uniform(r);
  return sqrt(-2 * log(u)) * cos(6.283185307179586 * v);
}

#endif
