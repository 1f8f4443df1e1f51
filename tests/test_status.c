/* Statuses, messages and the trace. */
#include <stdio.h>
#include <string.h>

#include "halflight/status.h"
#include "near.h"

/* The command's exit statuses: 0 done, 1 failed, 2 usage, 3 not to be trusted. */
static void test_exits(void **state)
{
  (void)state;
  assert_int_equal(hl_status_exit(HL_OK), 0);
  assert_int_equal(hl_status_exit(HL_ERR_ARG), 2);
  assert_int_equal(hl_status_exit(HL_ERR_MEMORY), 1);
  assert_int_equal(hl_status_exit(HL_ERR_IO), 1);
  assert_int_equal(hl_status_exit(HL_ERR_FORMAT), 1);
  assert_int_equal(hl_status_exit(HL_ERR_UNAVAILABLE), 1);
  assert_int_equal(hl_status_exit(HL_ERR_DEGENERATE), 3);
  assert_int_equal(hl_status_exit(HL_ERR_RESIDUAL), 3);
  assert_int_equal(hl_status_exit(HL_ERR_NOT_CONVERGED), 3);
  assert_int_equal(hl_status_exit((hl_status)1000), 1);
}

/* The values are ABI. */
static void test_values(void **state)
{
  (void)state;
  assert_int_equal(HL_OK, 0);
  assert_int_equal(HL_ERR_ARG, 1);
  assert_int_equal(HL_ERR_MEMORY, 2);
  assert_int_equal(HL_ERR_IO, 3);
  assert_int_equal(HL_ERR_FORMAT, 4);
  assert_int_equal(HL_ERR_UNAVAILABLE, 5);
  assert_int_equal(HL_ERR_DEGENERATE, 6);
  assert_int_equal(HL_ERR_RESIDUAL, 7);
  assert_int_equal(HL_ERR_NOT_CONVERGED, 8);
}

static void test_texts_differ(void **state)
{
  (void)state;
  for (int i = 0; i < HL_STATUS_COUNT; i++)
    for (int k = 0; k < i; k++)
      assert_string_not_equal(hl_status_text((hl_status)i), hl_status_text((hl_status)k));
  assert_string_equal(hl_status_text(HL_STATUS_COUNT), "unknown status");
  assert_string_equal(hl_status_text((hl_status)-1), "unknown status");
}

static void test_fail_records_and_returns(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  assert_int_equal(hl_fail(&ctx, HL_ERR_IO, "a = %d", 7), HL_ERR_IO);
  assert_int_equal(ctx.status, HL_ERR_IO);
  assert_string_equal(ctx.msg, "a = 7");
  assert_int_equal(hl_fail(NULL, HL_ERR_IO, "a = %d", 7), HL_ERR_IO);
}

static void test_fail_cuts_what_is_too_long(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  hl_fail(&ctx, HL_ERR_IO, "%1000s|", "x");
  assert_int_equal(strlen(ctx.msg), HL_MESSAGE_MAX - 1);
}

static void test_fail_is_one_line(void **state)
{
  (void)state;
  hl_ctx ctx = {0};
  hl_fail(&ctx, HL_ERR_FORMAT, "a\nb\tc\x7f\x1b[31m \xc3\xa9");
  assert_string_equal(ctx.msg, "a?b?c??[31m \xc3\xa9");
}

static void keep(void *user, const char *line)
{
  snprintf(user, 40, "%s", line);
}

static void test_trace(void **state)
{
  (void)state;
  char kept[40] = "";
  hl_ctx ctx = {.trace = keep, .trace_user = kept};
  hl_trace(&ctx, "step %d", 3);
  assert_string_equal(kept, "step 3");
  ctx.trace = NULL;
  hl_trace(&ctx, "step %d", 4);
  hl_trace(NULL, "step %d", 5);
  assert_string_equal(kept, "step 3");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_exits),
      cmocka_unit_test(test_values),
      cmocka_unit_test(test_texts_differ),
      cmocka_unit_test(test_fail_records_and_returns),
      cmocka_unit_test(test_fail_cuts_what_is_too_long),
      cmocka_unit_test(test_fail_is_one_line),
      cmocka_unit_test(test_trace),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
