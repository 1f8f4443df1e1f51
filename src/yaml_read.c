/* libyaml's events, put together on a stack of open lists and mappings. */
#include "yaml_read.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#include "number_json.h"

enum { DEPTH_MAX = 16, VALUES_MAX = 1000000, SHOWN_MAX = 40 };

/* A list or a mapping that is not closed yet; owned by the one around it, the outermost by `root`. */
typedef struct level {
  json_t *container;
  char *key; /* of a mapping, waiting for its value */
} level;

typedef struct builder {
  hl_json_source source;
  json_t *root;
  level open[DEPTH_MAX];
  int depth, values;
} builder;

static hl_status refuse(const builder *b, const yaml_event_t *event, const char *what)
{
  return hl_fail(b->source.ctx, HL_ERR_FORMAT, "%s: line %zu: %s", b->source.path,
                 event->start_mark.line + 1, what);
}

static hl_status no_memory(const builder *b)
{
  return hl_fail(b->source.ctx, HL_ERR_MEMORY, "%s: no memory for its values", b->source.path);
}

static bool spells(const yaml_event_t *event, const char *const *words)
{
  for (; *words; words++)
    if (strcmp((const char *)event->data.scalar.value, *words) == 0)
      return true;
  return false;
}

static json_t *scalar_value(const yaml_event_t *event)
{
  static const char *const nulls[] = {"", "~", "null", "Null", "NULL", NULL};
  static const char *const trues[] = {"true", "True", "TRUE", NULL};
  static const char *const falses[] = {"false", "False", "FALSE", NULL};
  const char *text = (const char *)event->data.scalar.value;
  const size_t n = event->data.scalar.length;
  const char *tag = (const char *)event->data.scalar.tag;
  if (event->data.scalar.style == YAML_PLAIN_SCALAR_STYLE &&
      !(tag && strcmp(tag, YAML_STR_TAG) == 0)) {
    if (spells(event, nulls))
      return json_null();
    if (spells(event, trues) || spells(event, falses))
      return json_boolean(spells(event, trues));
    json_t *number = hl_number_json(text, n);
    if (number)
      return number;
  }
  return json_stringn(text, n);
}

/* Take over a value into what is open; one that failed to be made is a failure. */
static hl_status add(builder *b, const yaml_event_t *event, json_t *value)
{
  if (!value)
    return no_memory(b);
  level *in = b->depth > 0 ? &b->open[b->depth - 1] : NULL;
  int bad = 0;
  if (++b->values > VALUES_MAX) {
    json_decref(value);
    return refuse(b, event, "more values than any camera file holds");
  }
  if (!in)
    b->root = value;
  else if (json_is_array(in->container))
    bad = json_array_append_new(in->container, value);
  else
    bad = json_object_set_new(in->container, in->key, value);
  if (in) {
    free(in->key);
    in->key = NULL;
  }
  return bad ? no_memory(b) : HL_OK;
}

static bool key_is_due(const builder *b)
{
  const level *in = b->depth > 0 ? &b->open[b->depth - 1] : NULL;
  return in && json_is_object(in->container) && !in->key;
}

static hl_status add_key(builder *b, const yaml_event_t *event)
{
  level *in = &b->open[b->depth - 1];
  const char *text = (const char *)event->data.scalar.value;
  if (json_object_get(in->container, text))
    return hl_fail(b->source.ctx, HL_ERR_FORMAT, "%s: line %zu: %.*s is given twice",
                   b->source.path, event->start_mark.line + 1, SHOWN_MAX, text);
  in->key = strdup(text);
  return in->key ? HL_OK : no_memory(b);
}

static hl_status open_level(builder *b, const yaml_event_t *event, json_t *container)
{
  hl_status st = add(b, event, container);
  if (st != HL_OK)
    return st;
  if (b->depth == DEPTH_MAX)
    return refuse(b, event, "nested too deep for a camera file");
  b->open[b->depth++] = (level){container, NULL};
  return HL_OK;
}

static hl_status take(builder *b, const yaml_event_t *event)
{
  switch (event->type) {
  case YAML_SCALAR_EVENT:
    return key_is_due(b) ? add_key(b, event) : add(b, event, scalar_value(event));
  case YAML_SEQUENCE_START_EVENT:
  case YAML_MAPPING_START_EVENT:
    if (key_is_due(b))
      return refuse(b, event, "a list or mapping stands where a key is needed");
    return open_level(b, event,
                      event->type == YAML_SEQUENCE_START_EVENT ? json_array() : json_object());
  case YAML_SEQUENCE_END_EVENT:
  case YAML_MAPPING_END_EVENT:
    b->depth--;
    return HL_OK;
  case YAML_ALIAS_EVENT:
    return hl_fail(b->source.ctx, HL_ERR_FORMAT,
                   "%s: line %zu: *%.*s is an alias; the value itself is needed", b->source.path,
                   event->start_mark.line + 1, SHOWN_MAX, (const char *)event->data.alias.anchor);
  case YAML_DOCUMENT_START_EVENT:
    return b->root ? refuse(b, event, "a second document; a file of one is needed") : HL_OK;
  case YAML_NO_EVENT:
  case YAML_STREAM_START_EVENT:
  case YAML_STREAM_END_EVENT:
  case YAML_DOCUMENT_END_EVENT:
    break;
  }
  return HL_OK;
}

static hl_status not_yaml(const builder *b, const yaml_parser_t *parser)
{
  if (parser->error == YAML_MEMORY_ERROR)
    return no_memory(b);
  if (parser->error == YAML_READER_ERROR) /* has no line */
    return hl_fail(b->source.ctx, HL_ERR_FORMAT, "%s: byte %zu: neither JSON nor YAML: %s",
                   b->source.path, parser->problem_offset,
                   parser->problem ? parser->problem : "it does not end");
  return hl_fail(b->source.ctx, HL_ERR_FORMAT, "%s: line %zu: neither JSON nor YAML: %s",
                 b->source.path, parser->problem_mark.line + 1,
                 parser->problem ? parser->problem : "it does not end");
}

static hl_status take_all(builder *b, yaml_parser_t *parser)
{
  hl_status st = HL_OK;
  yaml_event_type_t type = YAML_NO_EVENT;
  while (st == HL_OK && type != YAML_STREAM_END_EVENT) {
    yaml_event_t event;
    if (!yaml_parser_parse(parser, &event))
      return not_yaml(b, parser);
    type = event.type;
    st = take(b, &event);
    yaml_event_delete(&event);
  }
  if (st == HL_OK && !b->root)
    st = hl_fail(b->source.ctx, HL_ERR_FORMAT, "%s: neither JSON nor YAML: nothing is in it",
                 b->source.path);
  return st;
}

hl_status hl_yaml_parse(hl_json_source source, char *bytes, size_t n, json_t **out)
{
  static const char opencv[] = "%YAML:";
  yaml_parser_t parser;
  builder b = {.source = source};
  if (!yaml_parser_initialize(&parser))
    return no_memory(&b);
  if (n > sizeof opencv && memcmp(bytes, opencv, sizeof opencv - 1) == 0)
    bytes[0] = '#';
  yaml_parser_set_input_string(&parser, (const unsigned char *)bytes, n);
  const hl_status st = take_all(&b, &parser);
  yaml_parser_delete(&parser);
  for (int i = 0; i < DEPTH_MAX; i++)
    free(b.open[i].key);
  if (st != HL_OK)
    json_decref(b.root);
  else
    *out = b.root;
  return st;
}
