/* Transfer functions against the standard's own figures. */
#include "../src/transfer.h"
#include "near.h"

/* IEC 61966-2-1: 0.04045 -> 0.0031308, 1 -> 1; code 188 of 255 is half light to 0.3 % (0.50289). */
static void test_srgb(void **state)
{
  (void)state;
  assert_near(hl_transfer_linear(HL_TRANSFER_SRGB, 0, 0), 0, 0);
  assert_near(hl_transfer_linear(HL_TRANSFER_SRGB, 0, 1), 1, 1e-15);
  assert_near(hl_transfer_linear(HL_TRANSFER_SRGB, 0, 0.04045), 0.0031308, 1e-7);
  assert_near(hl_transfer_linear(HL_TRANSFER_SRGB, 0, 188.0 / 255), 0.50289, 1e-5);
}

/* Both branches meet at the knee to the standard's own rounding. */
static void test_srgb_has_no_step(void **state)
{
  (void)state;
  const double below = hl_transfer_linear(HL_TRANSFER_SRGB, 0, 0.04045);
  const double above = hl_transfer_linear(HL_TRANSFER_SRGB, 0, 0.0404500001);
  assert_near(above, below, 1e-8);
}

static void test_gamma_and_linear(void **state)
{
  (void)state;
  assert_near(hl_transfer_linear(HL_TRANSFER_GAMMA, 2, 0.5), 0.25, 1e-15);
  assert_near(hl_transfer_linear(HL_TRANSFER_GAMMA, 1, 0.3), 0.3, 1e-15);
  assert_near(hl_transfer_linear(HL_TRANSFER_LINEAR, 2, 0.5), 0.5, 0);
  assert_near(hl_transfer_linear(HL_TRANSFER_LINEAR, 2, 1e12), 1e12, 0);
}

static void test_all_are_odd_and_rising(void **state)
{
  (void)state;
  const hl_transfer all[] = {HL_TRANSFER_LINEAR, HL_TRANSFER_SRGB, HL_TRANSFER_GAMMA};
  for (int t = 0; t < 3; t++) {
    double last = -1;
    for (int i = -1000; i <= 1000; i++) {
      const double x = i / 1000.0;
      const double y = hl_transfer_linear(all[t], 2.2, x);
      assert_near(hl_transfer_linear(all[t], 2.2, -x), -y, 0);
      assert_true(i == -1000 || y > last);
      last = y;
    }
  }
}

static void test_not_a_number_stays_one(void **state)
{
  (void)state;
  assert_true(isnan(hl_transfer_linear(HL_TRANSFER_LINEAR, 1, NAN)));
  assert_true(isnan(hl_transfer_linear(HL_TRANSFER_SRGB, 1, NAN)));
  assert_true(isnan(hl_transfer_linear(HL_TRANSFER_GAMMA, 2, NAN)));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_srgb),
      cmocka_unit_test(test_srgb_has_no_step),
      cmocka_unit_test(test_gamma_and_linear),
      cmocka_unit_test(test_all_are_odd_and_rising),
      cmocka_unit_test(test_not_a_number_stays_one),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
