/* Settings as data: bounds, parsing, and the tables of every struct. */
#include <stdio.h>
#include <string.h>

#include "halflight/frame.h"
#include "halflight/light.h"
#include "halflight/settings.h"
#include "halflight/sphere.h"
#include "near.h"

typedef struct things {
  double share;
  int count;
  int kind;
} things;

static const char *const kinds[] = {"auto", "plain", NULL};
static const hl_field fields[] = {
    {"share", HL_FIELD_DOUBLE, offsetof(things, share), 0, 0.5, "rad", "a share", NULL},
    {"count", HL_FIELD_INT, offsetof(things, count), -3, 12, "", "a count", NULL},
    {"kind", HL_FIELD_CHOICE, offsetof(things, kind), 0, 1, "", "a kind", kinds},
};
static const hl_field_table table = {"things", fields, 3};

static void check_refuses(things t, const char *message)
{
  hl_ctx ctx = {0};
  assert_int_equal(hl_fields_check(&ctx, &table, &t), HL_ERR_ARG);
  assert_string_equal(ctx.msg, message);
}

static void test_check(void **state)
{
  (void)state;
  const things low = {0, -3, 0}, high = {0.5, 12, 1};
  assert_int_equal(hl_fields_check(NULL, &table, &low), HL_OK);
  assert_int_equal(hl_fields_check(NULL, &table, &high), HL_OK);
  check_refuses((things){nextafter(0, -1), 0, 0}, "share = -4.94066e-324 rad is outside [0, 0.5]");
  check_refuses((things){0.6, 0, 0}, "share = 0.6 rad is outside [0, 0.5]");
  check_refuses((things){NAN, 0, 0}, "share = nan rad is outside [0, 0.5]");
  check_refuses((things){0, 13, 0}, "count = 13 is outside [-3, 12]");
  check_refuses((things){0, 0, 2}, "kind = 2 is outside [0, 1]");
}

static things parsed(int field, const char *text)
{
  things t = {0.25, 7, 1};
  assert_int_equal(hl_field_parse(NULL, &fields[field], text, &t), HL_OK);
  return t;
}

static void test_parse(void **state)
{
  (void)state;
  assert_near(parsed(0, "0.5").share, 0.5, 0);
  assert_near(parsed(0, "1e-3").share, 1e-3, 0);
  assert_int_equal(parsed(1, "-3").count, -3);
  assert_int_equal(parsed(1, "1e1").count, 10);
  assert_int_equal(parsed(2, "auto").kind, 0);
  assert_int_equal(parsed(2, "plain").kind, 1);
}

static void parse_refuses(int field, const char *text, const char *part)
{
  things t = {0.25, 7, 1};
  hl_ctx ctx = {0};
  assert_int_equal(hl_field_parse(&ctx, &fields[field], text, &t), HL_ERR_ARG);
  if (!strstr(ctx.msg, part))
    fail_msg("'%s' does not say '%s'", ctx.msg, part);
  assert_near(t.share, 0.25, 0);
  assert_int_equal(t.count, 7);
  assert_int_equal(t.kind, 1);
}

static void test_parse_refuses(void **state)
{
  (void)state;
  parse_refuses(0, "", "share = '' is not a number; one in [0, 0.5] is needed");
  parse_refuses(0, "x", "share = 'x' is not a number");
  parse_refuses(0, "0.1x", "share = '0.1x' is not a number");
  parse_refuses(0, "nan", "share = nan rad is outside");
  parse_refuses(0, "inf", "share = inf rad is outside");
  parse_refuses(0, "1", "share = 1 rad is outside [0, 0.5]");
  parse_refuses(1, "1.5", "count = 1.5 is not a whole number");
  parse_refuses(1, "1e30", "count = 1e+30 is outside [-3, 12]");
  parse_refuses(2, "plai", "kind = 'plai' is none of auto, plain");
  parse_refuses(2, "0", "kind = '0' is none of auto, plain");
}

/* Just outside each bound the check fails and names the field; inside, defaults pass. */
static void table_is_sound(const hl_field_table *t, const void *defaults, void *copy, size_t size)
{
  assert_int_equal(hl_fields_check(NULL, t, defaults), HL_OK);
  for (int i = 0; i < t->n; i++) {
    const hl_field *f = &t->fields[i];
    assert_non_null(f->unit);
    assert_true(f->help && f->help[0] && f->help[strlen(f->help) - 1] != '.');
    assert_true(f->min < f->max);
    for (int side = 0; side < 2; side++) {
      hl_ctx ctx = {0};
      memcpy(copy, defaults, size);
      const double bound = side ? f->max : f->min;
      if (f->kind == HL_FIELD_DOUBLE) {
        const double outside = nextafter(bound, side ? INFINITY : -INFINITY);
        memcpy((char *)copy + f->offset, &outside, sizeof outside);
      } else {
        const int outside = (int)bound + (side ? 1 : -1);
        memcpy((char *)copy + f->offset, &outside, sizeof outside);
      }
      assert_int_equal(hl_fields_check(&ctx, t, copy), HL_ERR_ARG);
      assert_true(strncmp(ctx.msg, f->name, strlen(f->name)) == 0);
    }
  }
}

static void test_tables_of_the_library(void **state)
{
  (void)state;
  const hl_frame_settings frame = hl_frame_defaults();
  const hl_sphere_settings sphere = hl_sphere_defaults();
  const hl_light_settings light = hl_light_defaults();
  hl_frame_settings frame_copy;
  hl_sphere_settings sphere_copy;
  hl_light_settings light_copy;
  table_is_sound(hl_frame_fields(), &frame, &frame_copy, sizeof frame);
  table_is_sound(hl_sphere_fields(), &sphere, &sphere_copy, sizeof sphere);
  table_is_sound(hl_light_fields(), &light, &light_copy, sizeof light);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_check),
      cmocka_unit_test(test_parse),
      cmocka_unit_test(test_parse_refuses),
      cmocka_unit_test(test_tables_of_the_library),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
