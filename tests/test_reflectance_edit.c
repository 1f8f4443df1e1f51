/* Edits of a reflectance: what they change, what they note, what they refuse. */
#include "files.h"
#include "halflight/relight.h"

static hl_reflectance two_terms(void)
{
  hl_reflectance r = {.channels = 1, .n_terms = 2};
  for (int k = 0; k < 2; k++) {
    hl_lobe_term *t = &r.term[k];
    snprintf(t->name, sizeof t->name, "%s", k == 0 ? "diffuse" : "specular");
    t->cs = 1;
    t->cv = k;
    t->n = 3;
    for (int i = 0; i < 3; i++) {
      t->t[i] = 0.5 * i;
      for (int c = 0; c < HL_CHANNELS_MAX; c++)
        t->value[c][i] = i * (k + 1);
    }
  }
  return r;
}

static void test_scale(void **state)
{
  (void)state;
  hl_reflectance r = two_terms();
  assert_int_equal(hl_reflectance_scale(NULL, &r, "specular", 2.5), HL_OK);
  assert_near(r.term[1].value[2][2], 10, 1e-15);
  assert_near(r.term[0].value[2][2], 2, 0);
  assert_int_equal(r.notes.n, 0);
  assert_int_equal(hl_reflectance_scale(NULL, &r, "diffuse", -1), HL_OK);
  assert_int_equal(r.notes.n, 1);
  assert_string_equal(r.notes.note[0].what, "not physical");
}

/* Of a product a factor is scaled: its log grows by log F. */
static void test_scale_in_the_log_domain(void **state)
{
  (void)state;
  hl_reflectance r = two_terms();
  hl_ctx ctx = {0};
  r.log_domain = true;
  assert_int_equal(hl_reflectance_scale(NULL, &r, "specular", 3), HL_OK);
  assert_near(r.term[1].value[0][0], log(3), 1e-15);
  assert_near(r.term[1].value[0][2], 4 + log(3), 1e-15);
  assert_int_equal(hl_reflectance_scale(&ctx, &r, "specular", 0), HL_ERR_ARG);
  assert_says(ctx.msg, "above 0");
}

static void test_aim(void **state)
{
  (void)state;
  hl_reflectance r = two_terms();
  r.term[1].fixed_axis = true;
  assert_int_equal(hl_reflectance_aim(NULL, &r, "specular", 2, 2), HL_OK);
  assert_false(r.term[1].fixed_axis);
  assert_int_equal(hl_reflectance_aim(NULL, &r, "diffuse", 1, 0), HL_OK);
  assert_int_equal(r.notes.n, 0); /* both reciprocal */
  assert_int_equal(hl_reflectance_aim(NULL, &r, "specular", 1, 0.3), HL_OK);
  assert_near(r.term[1].cv, 0.3, 0);
  assert_int_equal(r.notes.n, 1);
  assert_non_null(strstr(r.notes.note[0].why, "reciprocal"));
}

static void replace(void **state, const char *text, hl_status due, const char *message,
                    hl_reflectance *r)
{
  char path[TEST_PATH_MAX];
  hl_ctx ctx = {0};
  path_in(state, "curve.csv", path);
  put_file(path, text, strlen(text));
  assert_int_equal(hl_reflectance_replace(&ctx, r, "specular", path), due);
  if (message) {
    assert_non_null(strstr(ctx.msg, "curve.csv"));
    assert_non_null(strstr(ctx.msg, message));
  }
}

static void test_replace(void **state)
{
  hl_reflectance r = two_terms();
  replace(state, "t,value\n0,0\n0.25,1\n1,5\n", HL_OK, NULL, &r);
  assert_int_equal(r.term[1].n, 3);
  assert_near(r.term[1].t[1], 0.25, 0);
  assert_near(r.term[1].value[0][2], 5, 0);
  assert_near(r.term[1].value[2][2], 5, 0);
  assert_int_equal(r.notes.n, 0);
  replace(state, "0,0,0,0\r\n1,1,2,3\r\n", HL_OK, NULL, &r);
  assert_near(r.term[1].value[2][1], 3, 0);
  replace(state, "0,1\n1,-1\n", HL_OK, NULL, &r);
  assert_int_equal(r.notes.n, 2); /* negative, and falling */
  hl_reflectance product = two_terms();
  product.log_domain = true; /* the sign of a logarithm says nothing */
  replace(state, "0,-2\n1,-1\n", HL_OK, NULL, &product);
  assert_int_equal(product.notes.n, 0);
}

static void test_refusals_leave_it_as_it_is(void **state)
{
  hl_reflectance r = two_terms();
  const hl_reflectance before = two_terms();
  hl_ctx ctx = {0};
  assert_int_equal(hl_reflectance_scale(&ctx, &r, "sheen", 1), HL_ERR_ARG);
  assert_non_null(strstr(ctx.msg, "diffuse, specular"));
  assert_int_equal(hl_reflectance_scale(&ctx, &r, "specular", NAN), HL_ERR_ARG);
  assert_int_equal(hl_reflectance_aim(&ctx, &r, "specular", 0, 0), HL_ERR_ARG);
  assert_int_equal(hl_reflectance_aim(&ctx, &r, "specular", INFINITY, 0), HL_ERR_ARG);
  assert_int_equal(hl_reflectance_replace(&ctx, &r, "specular", "/nowhere.csv"), HL_ERR_IO);
  replace(state, "0,0\n0.5,nan\n", HL_ERR_FORMAT, ":2", &r);
  replace(state, "0,0\n0,1\n", HL_ERR_FORMAT, "ascending", &r);
  replace(state, "0,0\n2,1\n", HL_ERR_FORMAT, "[-1, 1]", &r);
  replace(state, "0,0\n0.5,1,2\n", HL_ERR_FORMAT, "no row", &r);
  replace(state, "0,0\n0.5,1,2,3\n", HL_ERR_FORMAT, "no row", &r);
  replace(state, "0,0\n", HL_ERR_FORMAT, "at least 2", &r);
  assert_memory_equal(&r, &before, sizeof r);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_scale),
      cmocka_unit_test(test_scale_in_the_log_domain),
      cmocka_unit_test(test_aim),
      cmocka_unit_test(test_replace),
      cmocka_unit_test(test_refusals_leave_it_as_it_is),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
