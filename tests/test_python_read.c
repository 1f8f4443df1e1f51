/* Python literals as the JSON of the same shape, and what is refused of them. */
#include "../src/python_read.h"
#include "files.h"

static void reads(const char *text, const char *as_json)
{
  hl_ctx ctx = {0};
  json_t *root = NULL;
  if (hl_python_parse((hl_json_source){&ctx, "f"}, text, strlen(text), &root) != HL_OK)
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
  reads("{}", "{}");
  reads("{'a': 1, \"b\": [2., -.5, 3e1,], 'c': (4,), 'd': None, 'e': True, 'f': False}",
        "{\"a\":1,\"b\":[2.0,-0.5,30.0],\"c\":[4],\"d\":null,\"e\":true,\"f\":false}");
  reads("# first\n{ # more\n 'a' : # and\n 1 , # more\n}\n# last", "{\"a\":1}");
  reads("[ [ [] ], {'x': {}}, () ]", "[[[]],{\"x\":{}},[]]");
  reads("'it\\'s'", "\"it's\"");
  reads("\"a\\\"b\\\\c\\n\"", "\"a\\\"b\\\\c\\\\n\"");
  reads("b'0r#$%&()*+-;<=>?@^_`{|}~'", "\"0r#$%&()*+-;<=>?@^_`{|}~\"");
  reads("{'# no comment': 'x # y'}", "{\"# no comment\":\"x # y\"}");
}

static void refused(const char *text, const char *part)
{
  hl_ctx ctx = {0};
  json_t *root = NULL;
  assert_int_equal(hl_python_parse((hl_json_source){&ctx, "f"}, text, strlen(text), &root),
                   HL_ERR_FORMAT);
  assert_says(ctx.msg, part);
  assert_says(ctx.msg, "f: line ");
  assert_null(root);
}

static void test_refusals(void **state)
{
  (void)state;
  refused("{'a': 1",
          "line 1: no Python dictionary: ',' or '}' is needed, the end of the file found");
  refused("{'a': 1\n'b': 2}", "line 2: no Python dictionary: ',' or '}' is needed, ''b':' found");
  refused("{'a' 1}", "':' after a key is needed, '1}' found");
  refused("{1: 2}", "a text in quotes is needed, '1:' found");
  refused("{'a': }", "a number, a text, a list or a dictionary is needed, '}' found");
  refused("{'a': nan}", "is needed, 'nan}' found");
  refused("{'a': [1 2]}", "',' or ']' is needed, '2]}' found");
  refused("{'a': (1 2)}", "',' or ')' is needed");
  refused("{'a': 1,, 'b': 2}", "a text in quotes is needed, ',' found");
  refused("{'a': 1} x", "the end of the file is needed, 'x' found");
  refused("{\n'a': 'b\n'}", "line 2: no Python dictionary: a text that ends on its line is needed");
  refused("{'a': 'b", "a text that ends on its line is needed, ''b' found");
  refused("{'a': 1,\n\n 'a': 2}", "line 3: a is given twice");
  refused("{'a': '\xff'}", "a text that is no UTF-8");
  refused("{'\xff': 1}", "no UTF-8");
  refused("{'a': f(1)}", "is needed, 'f(1)}' found");
  refused("{'a': 1 + 1}", "',' or '}' is needed, '+' found");
  refused("", "is needed, the end of the file found");
  refused("# nothing", "is needed, the end of the file found");
}

static void test_a_zero_byte_is_no_end(void **state)
{
  (void)state;
  static const char text[] = "{'a': 1}\0{";
  hl_ctx ctx = {0};
  json_t *root = NULL;
  assert_int_equal(hl_python_parse((hl_json_source){&ctx, "f"}, text, sizeof text - 1, &root),
                   HL_ERR_FORMAT);
  assert_says(ctx.msg, "the end of the file is needed");
  static const char inside[] = "{'a\0b': 1}";
  assert_int_equal(hl_python_parse((hl_json_source){&ctx, "f"}, inside, sizeof inside - 1, &root),
                   HL_ERR_FORMAT);
}

static void test_depth_is_limited(void **state)
{
  (void)state;
  enum { DEEP = 1000000 };
  char *text = malloc(DEEP + 1);
  assert_non_null(text);
  memset(text, '[', DEEP);
  text[DEEP] = '\0';
  refused(text, "line 1: nested too deep for a camera file");
  free(text);
  reads("[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]", "[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]"); /* 16 */
  refused("[[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]]", "nested too deep");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_values),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_a_zero_byte_is_no_end),
      cmocka_unit_test(test_depth_is_limited),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
