/* YAML as the JSON of the same shape, and what is refused of it. */
#include "../src/yaml_read.h"
#include "files.h"

/* libyaml reads the copy. */
static hl_status parse(hl_ctx *ctx, const char *text, size_t n, json_t **out)
{
  char *bytes = malloc(n + 1);
  assert_non_null(bytes);
  memcpy(bytes, text, n);
  bytes[n] = '\0';
  const hl_status st = hl_yaml_parse((hl_json_source){ctx, "f.yml"}, bytes, n, out);
  free(bytes);
  return st;
}

static void reads(const char *text, const char *as_json)
{
  hl_ctx ctx = {0};
  json_t *root = NULL;
  if (parse(&ctx, text, strlen(text), &root) != HL_OK)
    fail_msg("%s", ctx.msg);
  json_t *want = json_loads(as_json, JSON_DECODE_ANY, NULL);
  assert_non_null(want);
  assert_true(json_equal(root, want));
  json_decref(want);
  json_decref(root);
}

static void test_values(void **state)
{
  (void)state;
  reads("a: 1\nb: -2.5\nc: text\nd: [1, 2., 3.e0]\n",
        "{\"a\":1,\"b\":-2.5,\"c\":\"text\",\"d\":[1,2.0,3.0]}");
  reads("a:\n  b:\n  - 1\n  -\n    c: 2\n", "{\"a\":{\"b\":[1,{\"c\":2}]}}");
  reads("{a: true, b: False, c: ~, d: null, e: , f: yes}",
        "{\"a\":true,\"b\":false,\"c\":null,\"d\":null,\"e\":null,\"f\":\"yes\"}");
  reads("a: '1'\nb: \"2\"\nc: !!str 3\nd: !!float 4\n",
        "{\"a\":\"1\",\"b\":\"2\",\"c\":\"3\",\"d\":4}");
  reads("a: .nan\nb: -.inf\nc: 1e999\nd: 0x10\n",
        "{\"a\":\".nan\",\"b\":\"-.inf\",\"c\":\"1e999\",\"d\":\"0x10\"}");
  reads("1: a\n", "{\"1\":\"a\"}");
  reads("a: &b 1\n", "{\"a\":1}"); /* an anchor nobody refers to */
  reads("just text", "\"just text\"");
  reads("[]", "[]");
  reads("%YAML 1.1\n---\na: 1\n...\n", "{\"a\":1}");
}

static void test_opencv_heading(void **state)
{
  (void)state;
  reads("%YAML:1.0\n---\nm: !!opencv-matrix\n   rows: 1\n   data: [ 0., -1. ]\n",
        "{\"m\":{\"rows\":1,\"data\":[0.0,-1.0]}}");
}

static void refused(const char *text, const char *part)
{
  hl_ctx ctx = {0};
  json_t *root = NULL;
  assert_int_equal(parse(&ctx, text, strlen(text), &root), HL_ERR_FORMAT);
  assert_says(ctx.msg, part);
  assert_says(ctx.msg, "f.yml: ");
  assert_null(root);
}

static void test_refusals(void **state)
{
  (void)state;
  refused("a: 1\nb: [1, 2\n",
          "f.yml: line 3: neither JSON nor YAML: did not find expected ',' or ']'");
  refused("a: 1\n b: 2\n", "line 2: neither JSON nor YAML: mapping values are not allowed");
  refused("a: 1\nb: 2\na: 3\n", "f.yml: line 3: a is given twice");
  refused("a: 1\n? [1, 2]\n: 3\n", "line 2: a list or mapping stands where a key is needed");
  refused("a: 1\n---\nb: 2\n", "line 2: a second document; a file of one is needed");
  refused("", "nothing is in it");
  refused("# a comment\n", "nothing is in it");
  refused("%YAML 2.0\n---\na: 1\n",
          "line 1: neither JSON nor YAML: found incompatible YAML document");
  refused("a: \x01\n", "byte 3: neither JSON nor YAML: control characters are not allowed");
  refused("a: \xff\xfe\n", "neither JSON nor YAML: invalid leading UTF-8 octet");
  refused("\x89PNG\r\n", "neither JSON nor YAML");
  refused("a: b: c\n", "line 1: neither JSON nor YAML");
  refused("\"a", "neither JSON nor YAML");
}

/* Nine lists of nine aliases each unfold to 9^9 values. */
static void test_aliases_are_refused(void **state)
{
  (void)state;
  refused("a: &a [1,1,1,1,1,1,1,1,1]\nb: &b [*a,*a,*a,*a,*a,*a,*a,*a,*a]\nc: &c [*b,*b,*b]\n",
          "f.yml: line 2: *a is an alias; the value itself is needed");
  refused("a: &a {x: 1}\nb:\n  <<: *a\n", "line 3: *a is an alias");
  refused("&a a: *a\n", "line 1: *a is an alias");
}

static void test_depth_is_limited(void **state)
{
  (void)state;
  enum { DEEP = 200000 };
  char *text = malloc(DEEP + 1);
  assert_non_null(text);
  memset(text, '[', DEEP);
  text[DEEP] = '\0';
  refused(text, "line 1: nested too deep for a camera file");
  for (int i = 0; i < DEEP; i++)
    text[i] = "- "[i % 2];
  refused(text, "nested too deep for a camera file");
  free(text);
  reads("[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]", "[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]"); /* 16 */
  refused("[[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]]", "nested too deep");
}

static void test_values_are_counted(void **state)
{
  (void)state;
  enum { MANY = 1000001 };
  char *text = malloc(2 * MANY + 3);
  assert_non_null(text);
  text[0] = '[';
  for (int i = 0; i < MANY; i++) {
    text[1 + 2 * i] = '1';
    text[2 + 2 * i] = ',';
  }
  text[1 + 2 * MANY] = ']';
  text[2 + 2 * MANY] = '\0';
  refused(text, "line 1: more values than any camera file holds");
  free(text);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_values),           cmocka_unit_test(test_opencv_heading),
      cmocka_unit_test(test_refusals),         cmocka_unit_test(test_aliases_are_refused),
      cmocka_unit_test(test_depth_is_limited), cmocka_unit_test(test_values_are_counted),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
