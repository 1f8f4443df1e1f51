/* JSON documents: headers, members, and messages that name the place. */
#include "../src/json_read.h"
#include "files.h"

static hl_status open_bytes(void **state, hl_ctx *ctx, const char *bytes, size_t n, json_t **root)
{
  char path[TEST_PATH_MAX];
  path_in(state, "t.json", path);
  put_file(path, bytes, n);
  return hl_json_open((hl_json_source){ctx, path}, "some-thing", 3, root);
}

static void refused_bytes(void **state, const char *bytes, size_t n, const char *part)
{
  hl_ctx ctx = {0};
  json_t *root = NULL;
  assert_int_equal(open_bytes(state, &ctx, bytes, n, &root), HL_ERR_FORMAT);
  assert_null(root);
  assert_says(ctx.msg, "t.json: ");
  assert_says(ctx.msg, part);
}

static void refused(void **state, const char *text, const char *part)
{
  refused_bytes(state, text, strlen(text), part);
}

#define HEAD "{\"format\":\"some-thing\",\"version\":1"

static void test_open_accepts_versions_up_to_the_newest(void **state)
{
  for (int version = 1; version <= 3; version++) {
    char text[80];
    snprintf(text, sizeof text, "{\"format\":\"some-thing\",\"version\":%d}", version);
    json_t *root = NULL;
    assert_int_equal(open_bytes(state, NULL, text, strlen(text), &root), HL_OK);
    json_decref(root);
  }
}

static void test_open_refuses_headers(void **state)
{
  refused(state, "{\"format\":\"some-thing\",\"version\":99}",
          "version = 99 is newer than this program; up to 3 is accepted");
  refused(state, "{\"format\":\"some-thing\",\"version\":0}", "version = 0; a whole number");
  refused(state, "{\"format\":\"some-thing\",\"version\":\"1\"}", "version = \"1\"");
  refused(state, "{\"format\":\"some-thing\"}", "version is missing");
  refused(state, "{\"format\":\"another\",\"version\":1}",
          "format = 'another'; 'some-thing' is needed");
  refused(state, "{\"version\":1}", "format is missing; a text is needed");
  refused(state, "[1,2]", "not a JSON object");
  refused(state, "7", "not a JSON object");
}

static void test_open_refuses_what_is_not_json(void **state)
{
  refused(state, "", "the file is empty");
  refused(state, "PF\n640 480\n", "line 1: not JSON");
  refused(state, HEAD ",\n\"a\":1", "line 2: not JSON");
  refused(state, HEAD ",\"a\":1,\"a\":2}", "duplicate");
  refused(state, HEAD "} x", "not JSON");
  refused_bytes(state, HEAD ",\"a\":\"\xff\xfe\"}", sizeof HEAD + 9, "not JSON");
  refused_bytes(state, "{\0}", 3, "not JSON");
}

/* As Python's json module writes them. */
static void test_open_names_what_is_no_number(void **state)
{
  refused(state, HEAD ",\n\n\"a\": NaN}", "line 3: NaN is not JSON; a finite number is needed");
  refused(state, HEAD ",\"a\": Infinity}", "line 1: Infinity is not JSON");
  refused(state, HEAD ",\"a\": [1, -Infinity]}", "line 1: -Infinity is not JSON");
  refused(state, HEAD ",\"a\": 1e999}", "not JSON");
}

static void test_open_survives_deep_nesting(void **state)
{
  char *text = malloc(200001);
  assert_non_null(text);
  memset(text, '[', 200000);
  text[200000] = '\0';
  refused(state, text, "not JSON");
  free(text);
}

/* Every beginning of a good document is refused with one line. */
static void test_open_refuses_every_beginning(void **state)
{
  const char text[] = HEAD ",\"a\":[1.5e3,true,null,\"\\u00e9\"],\"b\":{\"c\":-2}}";
  for (size_t n = 0; n < sizeof text - 1; n++) {
    hl_ctx ctx = {0};
    json_t *root = NULL;
    assert_int_equal(open_bytes(state, &ctx, text, n, &root), HL_ERR_FORMAT);
    assert_null(strchr(ctx.msg, '\n'));
  }
}

static const hl_json_source source = {NULL, "t.json"};

static hl_json_source with(hl_ctx *ctx)
{
  return (hl_json_source){ctx, "t.json"};
}

static void test_number(void **state)
{
  (void)state;
  json_t *root =
      json_pack("{s:f,s:i,s:s,s:n,s:b}", "real", 0.5, "whole", 3, "text", "1", "null", "bool", 1);
  hl_ctx ctx = {0};
  double out = -7;
  assert_int_equal(hl_json_number(source, root, "real", 0, 1, &out), HL_OK);
  assert_near(out, 0.5, 0);
  assert_int_equal(hl_json_number(source, root, "whole", 0, 3, &out), HL_OK);
  assert_near(out, 3, 0);
  assert_int_equal(hl_json_number(with(&ctx), root, "whole", 0, 2.5, &out), HL_ERR_FORMAT);
  assert_says(ctx.msg, "t.json: whole = 3; a number in [0, 2.5] is needed");
  assert_int_equal(hl_json_number(with(&ctx), root, "text", 0, 2, &out), HL_ERR_FORMAT);
  assert_says(ctx.msg, "text = \"1\"; a number in [0, 2] is needed");
  assert_int_equal(hl_json_number(with(&ctx), root, "null", 0, 2, &out), HL_ERR_FORMAT);
  assert_says(ctx.msg, "null = null; a number");
  assert_int_equal(hl_json_number(with(&ctx), root, "bool", 0, 2, &out), HL_ERR_FORMAT);
  assert_says(ctx.msg, "bool = true; a number");
  assert_int_equal(hl_json_number(with(&ctx), root, "gone", 0, 2, &out), HL_ERR_FORMAT);
  assert_says(ctx.msg, "gone is missing; a number in [0, 2] is needed");
  assert_near(out, 3, 0);
  json_decref(root);
}

static void test_int(void **state)
{
  (void)state;
  json_t *root =
      json_pack("{s:i,s:f,s:f,s:I}", "a", 5, "b", 5.0, "c", 5.5, "d", (json_int_t)1 << 62);
  hl_ctx ctx = {0};
  int out = -7;
  assert_int_equal(hl_json_int(source, root, "a", 0, 5, &out), HL_OK);
  assert_int_equal(out, 5);
  assert_int_equal(hl_json_int(source, root, "b", 0, 5, &out), HL_OK);
  out = -7;
  assert_int_equal(hl_json_int(with(&ctx), root, "a", 0, 4, &out), HL_ERR_FORMAT);
  assert_says(ctx.msg, "a = 5; a whole number in [0, 4] is needed");
  assert_int_equal(hl_json_int(source, root, "c", 0, 9, &out), HL_ERR_FORMAT);
  assert_int_equal(hl_json_int(source, root, "d", 0, 9, &out), HL_ERR_FORMAT);
  assert_int_equal(out, -7);
  json_decref(root);
}

static void test_arrays(void **state)
{
  (void)state;
  json_t *root = json_pack("{s:[f,i],s:[[i,i],[i,f]],s:[[i],[i,i]],s:[i,n]}", "pair", 0.5, 2,
                           "matrix", 1, 2, 3, 4.5, "ragged", 1, 2, 3, "holed", 1);
  hl_ctx ctx = {0};
  double out[4];
  assert_int_equal(hl_json_numbers(source, root, "pair", 2, out), HL_OK);
  assert_near(out[0], 0.5, 0);
  assert_near(out[1], 2, 0);
  assert_int_equal(hl_json_matrix(source, root, "matrix", 2, 2, out), HL_OK);
  assert_near(out[2], 3, 0);
  assert_near(out[3], 4.5, 0);
  assert_int_equal(hl_json_numbers(with(&ctx), root, "pair", 3, out), HL_ERR_FORMAT);
  assert_says(ctx.msg, "pair = [0.5,2]; an array of 3 numbers is needed");
  assert_int_equal(hl_json_matrix(with(&ctx), root, "ragged", 2, 2, out), HL_ERR_FORMAT);
  assert_says(ctx.msg, "ragged[0] = [1]; an array of 2 numbers is needed");
  assert_int_equal(hl_json_numbers(with(&ctx), root, "holed", 2, out), HL_ERR_FORMAT);
  assert_says(ctx.msg, "holed[1] = null; a finite number is needed");
  assert_int_equal(hl_json_matrix(with(&ctx), root, "gone", 2, 2, out), HL_ERR_FORMAT);
  assert_says(ctx.msg, "gone is missing; 2 rows of 2 numbers is needed");
  json_decref(root);
}

static void test_string_and_has(void **state)
{
  (void)state;
  json_t *root = json_pack("{s:s,s:n,s:i}", "a", "text", "b", "c", 1);
  hl_ctx ctx = {0};
  const char *out = NULL;
  assert_int_equal(hl_json_string(source, root, "a", &out), HL_OK);
  assert_string_equal(out, "text");
  assert_int_equal(hl_json_string(with(&ctx), root, "c", &out), HL_ERR_FORMAT);
  assert_says(ctx.msg, "c = 1; a text is needed");
  assert_true(hl_json_has(root, "a"));
  assert_false(hl_json_has(root, "b"));
  assert_false(hl_json_has(root, "d"));
  json_decref(root);
}

/* However long the value and the member, the message stays whole. */
static void test_long_values_are_cut(void **state)
{
  (void)state;
  char text[5000];
  memset(text, 'x', sizeof text);
  text[sizeof text - 1] = '\0';
  json_t *root = json_pack("{s:s}", "a", text);
  hl_ctx ctx = {0};
  double out;
  assert_int_equal(hl_json_number(with(&ctx), root, "a", 0, 1, &out), HL_ERR_FORMAT);
  assert_says(ctx.msg, "xxx...; a number in [0, 1] is needed");
  assert_true(strlen(ctx.msg) < 120);
  json_decref(root);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_open_accepts_versions_up_to_the_newest),
      cmocka_unit_test(test_open_refuses_headers),
      cmocka_unit_test(test_open_refuses_what_is_not_json),
      cmocka_unit_test(test_open_names_what_is_no_number),
      cmocka_unit_test(test_open_survives_deep_nesting),
      cmocka_unit_test(test_open_refuses_every_beginning),
      cmocka_unit_test(test_number),
      cmocka_unit_test(test_int),
      cmocka_unit_test(test_arrays),
      cmocka_unit_test(test_string_and_has),
      cmocka_unit_test(test_long_values_are_cut),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
